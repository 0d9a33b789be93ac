//! A parachute in the air of its canopy: Taylor's shape (no hoop stress, inextensible radials, uniform pressure), the
//! speed of its fall, and the same in a wind.
//!
//! For L/D0 = 1 Taylor's parachute has a skirt of 0.656719 D0: its drag area is that of CD0 on S0 with
//! dCp = CD0 (D0/Ds)^2, for n flat gores over (n/2 pi) sin(2 pi/n).

use crate::claim::Claim;
use crate::common::parachute::Parachute;
use crate::common::run::{case_of, changed, follow, run};
use serde_json::json;
use std::f64::consts::PI;

/// [-] Ds/D0 of Taylor's parachute, L/D0 = 1
const SKIRT: f64 = 0.656719;
/// [-]
const CD0: f64 = 0.75;
/// [m/s^2]
const G: f64 = 9.81;
/// [kg/m^3]
const DENSITY: f64 = 1.225;
/// [kg] payload
const MASS: f64 = 4.0;

fn small(rings: usize) -> Parachute {
    Parachute { gores: 28, rings, line_segments: 2, nominal_diameter: 2.0, line_length: 2.0 }
}

fn dcp(parachute: &Parachute) -> f64 {
    let n = parachute.gores as f64;
    CD0 / SKIRT.powi(2) / (n / (2.0 * PI) * (2.0 * PI / n).sin())
}

/// [m/s] speed of fall, [m] diameter of the skirt, [m/s] wind along x.
fn steady(parachute: &Parachute, sets: &[(&str, &str)]) -> ([f64; 3], f64) {
    let case = parachute.case(dcp(parachute), MASS, 6.0);
    let ran = run(&case_of(&case, sets));
    assert!(ran.is_finite(), "{:?}", ran.outcome);
    let mean = |list: &[[f64; 3]], i: usize| {
        parachute.skirt().iter().map(|&node| list[node][i]).sum::<f64>() / parachute.gores as f64
    };
    let middle = [0, 1, 2].map(|i| mean(&ran.positions, i));
    let skirt = parachute.skirt();
    let radius = skirt.iter().map(|&node| {
        let p = ran.positions[node];
        (0..3).map(|i| (p[i] - middle[i]).powi(2)).sum::<f64>().sqrt()
    });
    let diameter = 2.0 * radius.sum::<f64>() / parachute.gores as f64;
    (ran.velocities[parachute.payload()], diameter)
}

pub fn claims() -> Vec<Claim> {
    let parachute = small(12);
    // Taylor's parachute has no weight.
    let (cloth, lines) = (0.002, 0.0003);
    let light = [("system.network.mass.areal_density", "0.002"), ("system.network.springs.0.linear_density", "0.0003")];
    let (cloth, lines) = (cloth * parachute.area(), lines * parachute.gores as f64 * parachute.line_length);
    let speed = (2.0 * (MASS + cloth + lines) * G / (DENSITY * CD0 * parachute.area())).sqrt();
    let long = [("time.method", "newmark"), ("time.step", "0.01"), ("time.end", "12")];
    let long = [&light[..], &long].concat();
    let (fall, skirt) = steady(&parachute, &long);
    let mut claims = vec![
        Claim::relative("steady fall, sqrt(2 m g/(rho CD0 S0))", -fall[2], speed, 0.01),
        Claim::relative("steady fall, Ds/D0 of Taylor's parachute", skirt / parachute.nominal_diameter, SKIRT, 0.01),
    ];
    let wind = [("system.network.aero.wind", "[3, -2, 1.5]"), ("system.network.initial.velocity", "[3, -2, -4.5]")];
    let (blown, spread) = steady(&parachute, &[&long[..], &wind].concat());
    for (i, (axis, wind)) in ["x", "y", "z"].into_iter().zip([3.0, -2.0, 1.5]).enumerate() {
        claims.push(Claim::absolute(
            format!("steady fall in a wind, velocity along {axis}"),
            blown[i],
            fall[i] + wind,
            1e-5,
        ));
    }
    claims.push(Claim::relative("steady fall in a wind, skirt", spread, skirt, 1e-6));
    claims
}

/// Falls of a mass with a drag area, against closed forms and quadratures.
pub fn falls() -> Vec<Claim> {
    let body = |aero: &str| {
        case_of(
            &serde_json::json!({
                "name": "fall",
                "system": {"network": {
                    "mesh": {"explicit": {"nodes": [[0, 0, 0]], "springs": [], "triangles": []}},
                    "mass": {"nodal": 100.0},
                    "gravity": [0, 0, -9.81],
                    "aero": serde_json::from_str::<serde_json::Value>(aero).expect("json")
                }},
                "time": {"end": 2.0, "method": "rk4", "step": 0.01}
            }),
            &[],
        )
    };
    let drag = "\"drag\": [{\"on\": \"all\", \"drag_area\": 0.7}]";
    let constant = run(&body(&format!("{{{drag}}}")));
    let mut claims = vec![
        Claim::relative("constant density, v_t tanh(g t/v_t)", -constant.velocities[0][2], 18.5890264, 1e-8),
        Claim::relative("constant density, way", -constant.positions[0][2], 19.0933369, 1e-8),
    ];
    let exponential = format!(
        "{{{drag}, \"altitude\": 30000, \"atmosphere\": {{\"exponential\": {{\"density\": 1.225, \"scale_height\": 8500}}}}}}"
    );
    let heights = [10_000.0, 0.0];
    let seen = speeds(&changed(&body(&exponential), &[("time.end", "400"), ("time.step", "0.02")]), &heights);
    // v^2 = 2 g H exp(-q) [Ei(q) - Ei(q0)], q = rho CdS H/m
    for ((height, v), stated) in heights.into_iter().zip(&seen[1..]).zip([88.2285, 48.1699]) {
        claims.push(Claim::relative(format!("exponential density, speed at {height} m"), *v, stated, 1.5e-6));
    }
    claims.push(Claim::relative("exponential density, largest speed", seen[0], 208.2003, 1e-6));
    claims.extend(standard_fall(|aero| body(aero)));
    claims
}

/// [m/s] The largest speed, and the speeds at some heights [m] above sea level, from 30 km.
fn speeds(case: &canopy_fem::case::Case, heights: &[f64]) -> Vec<f64> {
    let (mut most, mut found, mut last) = (0.0_f64, vec![f64::NAN; heights.len()], [30e3, 0.0]);
    follow(case, |seen| {
        let [height, v] = [30e3 + seen.positions[0][2], -seen.velocities[0][2]];
        most = most.max(v);
        for (found, at) in found.iter_mut().zip(heights) {
            if last[0] >= *at && height < *at {
                let share = (last[0] - at) / (last[0] - height);
                *found = last[1] + share * (v - last[1]);
            }
        }
        last = [height, v];
    });
    [vec![most], found].concat()
}

/// A fall through the standard atmosphere: d(v^2)/dz = -2 g + rho(z) CdS v^2/m downwards, by Runge-Kutta over the
/// height.
fn standard_fall(body: impl Fn(&str) -> canopy_fem::case::Case) -> Vec<Claim> {
    let aero = "{\"drag\": [{\"on\": \"all\", \"drag_area\": 0.7}], \"altitude\": 30000, \"atmosphere\": \"isa\"}";
    let heights = [15_000.0, 5_000.0, 0.0];
    let seen = speeds(&changed(&body(aero), &[("time.end", "400"), ("time.step", "0.02")]), &heights);
    let slope = |z: f64, e: f64| 2.0 * 9.81 - standard_density(z) * 0.7 * e / 100.0;
    let (mut z, mut e, step) = (30e3, 0.0, 0.5);
    let mut expected = Vec::new();
    while z > 0.0 {
        let k1 = slope(z, e);
        let k2 = slope(z - 0.5 * step, e + 0.5 * step * k1);
        let k3 = slope(z - 0.5 * step, e + 0.5 * step * k2);
        let k4 = slope(z - step, e + step * k3);
        e += step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        z -= step;
        if heights.contains(&z) {
            expected.push(e.sqrt());
        }
    }
    let rows = heights.iter().zip(&seen[1..]).zip(expected);
    rows.map(|((height, v), stated)| {
        Claim::relative(format!("standard atmosphere, speed at {height} m"), *v, stated, 1e-6)
    })
    .collect()
}

/// [kg/m^3] at a height [m], by the three lowest layers of the standard atmosphere.
pub fn standard_density(z: f64) -> f64 {
    let h = 6_356_766.0 * z / (6_356_766.0 + z);
    let (r, g) = (287.05287, 9.80665);
    let [p11, p20] = [22632.0400950, 5474.8774243];
    let (t, p) = if h < 11e3 {
        let t = 288.15 - 0.0065 * h;
        (t, 101325.0 * (t / 288.15).powf(g / (r * 0.0065)))
    } else if h < 20e3 {
        (216.65, p11 * (-g * (h - 11e3) / (r * 216.65)).exp())
    } else {
        let t = 216.65 + 0.001 * (h - 20e3);
        (t, p20 * (t / 216.65).powf(-g / (r * 0.001)))
    };
    p / (r * t)
}

/// A weightless line in a cross wind, by its normal drag alone: the tension T is constant, and with q = rho Cd d V^2/2
/// x = (T/q)(sqrt(1 + (q s/T)^2) - 1), y = (T/q) asinh(q s/T), x against the wind.
pub fn line() -> Vec<Claim> {
    let (tension, length) = (100.0, 20.0);
    let q = 0.5 * DENSITY * 1.1 * 0.004 * 400.0;
    let turn: f64 = q * length / tension;
    let expected = [tension / q * ((1.0 + turn * turn).sqrt() - 1.0), tension / q * turn.asinh()];
    let pull = [turn, 1.0].map(|part| tension * part / (1.0 + turn * turn).sqrt());
    let off = |segments: usize| {
        let nodes: Vec<[f64; 3]> = (0..=segments).map(|i| [0.0, length * i as f64 / segments as f64, 0.0]).collect();
        let springs: Vec<[usize; 2]> = (0..segments).map(|i| [i, i + 1]).collect();
        let case = serde_json::json!({
            "name": "line",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": nodes, "springs": springs, "triangles": []}},
                "mass": {"nodal": 0.01},
                "springs": [{"on": "all", "axial_rigidity": 1e7, "rest_scale": 1.0 / (1.0 + tension / 1e7)}],
                "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
                "loads": [{"on": {"ids": [segments]}, "force": [pull[0], pull[1], 0]}],
                "damping": {"rayleigh": {"mass": 20.0}},
                "aero": {"wind": [-20, 0, 0], "drag": [{"on": "lines", "diameter": 0.004, "coefficient": 1.1}]}
            }},
            "time": {"end": 60.0, "method": "backward-euler", "step": 0.05}
        });
        let ran = run(&case_of(&case, &[]));
        let end = ran.positions[segments];
        [0, 1].map(|i| end[i] - expected[i])
    };
    let coarse = off(8);
    let fine = off(32);
    let size = |off: [f64; 2]| off[0].hypot(off[1]);
    vec![
        Claim::absolute("end of the line, x", expected[0] + fine[0], 2.1315114, 2e-3),
        Claim::absolute("end of the line, y", expected[1] + fine[1], 19.8482083, 2e-2),
        // Straight segments: an error of the second order.
        Claim::between("error with 8 segments over that with 32", size(coarse) / size(fine), 10.0, 20.0),
    ]
}

/// Opening loads without gravity: with A = 2 m/(rho CdS v_s t_f) and tau = min(1, (j A (j + 1)/(j + 2))^(1/(j + 1)))
/// the largest force is q_s CdS tau^j/(1 + tau^(j + 1)/(A (j + 1)))^2 (Pflanz 1942). The canopy moves along its axis
/// only, and dashpots keep its parts together.
pub fn opening() -> Vec<Claim> {
    let parachute = Parachute { rings: 3, ..small(3) };
    let (speed, area, mass) = (50.0, 2.0, 10.0);
    let cloth = 0.05 * parachute.area() + 0.003 * parachute.gores as f64 * parachute.line_length;
    let largest = 0.5 * DENSITY * speed * speed * area;
    let peak = |a: f64, exponent: f64| {
        let filling_time = 2.0 * mass / (DENSITY * area * speed * a);
        let mut case = parachute.case(1.0, mass - cloth, speed);
        let network = &mut case["system"]["network"];
        network["supports"] = json!([{"on": "all", "fix": "xy"}]);
        network["gravity"] = json!([0, 0, 0]);
        for rule in network["springs"].as_array_mut().expect("rules") {
            rule["dashpot"] = json!({"relative": {"coefficient": 1e3}});
        }
        network["aero"]["canopy"] = json!({
            "on": "all", "confluence": {"ids": [parachute.payload()]},
            "schedule": {"drag_area": area, "filling_constant": filling_time * speed / parachute.nominal_diameter,
                         "exponent": exponent}
        });
        let step = filling_time / 1000.0;
        // The first forces are small beside the rounding of the dashpots.
        case["solver"] = json!({"newton": {"relative": 1e-6}});
        case["time"] = json!({"end": 1.2 * filling_time, "method": "newmark", "step": step});
        let case = case_of(&case, &[]);
        let masses = match &case.problem().system {
            canopy_fem::case::spec::SystemSpec::Network(spec) => spec.mass.clone(),
            canopy_fem::case::spec::SystemSpec::Pendulum(_) => Vec::new(),
        };
        let (mut most, mut last) = (0.0_f64, None);
        follow(&case, |seen| {
            let momentum: f64 = masses.iter().zip(seen.velocities).map(|(m, v)| m * v[2]).sum();
            if let Some((t, before)) = last.replace((seen.t, momentum)) {
                most = most.max((momentum - before) / (seen.t - t));
            }
        });
        most / largest
    };
    let stated = [
        (2.0, [0.125471, 0.260991, 0.562500, 0.810000, 0.936524]),
        (1.0, [0.145237, 0.251558, 0.459279, 0.734694, 0.907029]),
    ];
    let cases = stated.into_iter().flat_map(|(j, factors)| {
        [0.1, 0.3, 1.0, 3.0, 10.0].into_iter().zip(factors).map(move |(a, factor)| (j, a, factor))
    });
    cases
        .map(|(j, a, factor)| {
            Claim::relative(
                format!("largest opening force over q_s CdS, A = {a}, exponent {j}"),
                peak(a, j),
                factor,
                0.02,
            )
        })
        .collect()
}

/// A canopy of four triangles, 2 mm wide, over a payload of 100 kg on a line of 10 m: 10 kg, and air of `air` kg in its
/// volume.
fn small_canopy(air: f64, loads: &serde_json::Value) -> serde_json::Value {
    let (a, height, length) = (1e-3, 1.5e-3, 10.0);
    let volume = 2.0 / 3.0 * a * a * height;
    let skirt = -height / 5.0;
    json!({
        "name": "pendulum",
        "system": {"network": {
            "mesh": {"explicit": {
                "nodes": [[0, 0, skirt + height], [a, 0, skirt], [0, a, skirt], [-a, 0, skirt], [0, -a, skirt], [0, 0, -length]],
                "springs": [[0, 1], [0, 2], [0, 3], [0, 4], [1, 2], [2, 3], [3, 4], [4, 1], [1, 3], [2, 4],
                            [1, 5], [2, 5], [3, 5], [4, 5]],
                "triangles": [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]]
            }},
            "mass": {"nodal": [2, 2, 2, 2, 2, 100]},
            "springs": [{"on": "all", "stiffness": 1e10}],
            "gravity": [0, 0, -G],
            "loads": loads,
            "aero": {"canopy": {
                "on": "all", "table": {"pressure_coefficient": 0}, "confluence": {"ids": [5]},
                "apparent_mass": air / (DENSITY * volume)
            }}
        }},
        "time": {"end": 0.2, "method": "newmark", "step": 0.002}
    })
}

/// The air that a canopy takes along has momentum, but no weight: a fall with the acceleration g m/(m + m_a), and the
/// pendulum of canopy and payload under a vertical drag, w^2 = (g/L)(1 + m_p/(m_c + m_a)).
pub fn apparent_mass() -> Vec<Claim> {
    let mut claims = Vec::new();
    let fall = case_of(&small_canopy(60.0, &json!([])), &[]);
    for method in ["newmark", "hht", "generalized-alpha", "backward-euler"] {
        let ran = run(&changed(&fall, &[("time.method", method)]));
        // The line pulls what is heavier.
        let momentum: f64 = (0..6).map(|i| if i == 5 { 100.0 } else { 2.0 } * ran.velocities[i][2]).sum();
        let canopy: f64 = (0..5).map(|i| ran.velocities[i][2]).sum::<f64>() / 5.0;
        let value = -110.0 * G * 0.2;
        claims.push(Claim::relative(
            format!("{method}: momentum of a falling canopy and its air"),
            momentum + 60.0 * canopy,
            value,
            1e-5,
        ));
    }
    let up = json!([{"on": {"ids": [0, 1, 2, 3, 4]}, "force": [0, 0, 22.0 * G]}]);
    for (air, period) in [(0.0, 1.9127095), (60.0, 4.0707077)] {
        let sets = [
            ("time.end", "13"),
            ("time.step", "0.004"),
            ("system.network.initial.velocity", "[[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0.02,0,0]]"),
        ];
        let mut crossings = Vec::new();
        let mut last: Option<(f64, f64)> = None;
        follow(&case_of(&small_canopy(air, &up), &sets), |seen| {
            let canopy = (0..5).map(|i| seen.positions[i][0]).sum::<f64>() / 5.0;
            let x = seen.positions[5][0] - canopy;
            if let Some((t, before)) = last.replace((seen.t, x))
                && before > 0.0
                && x <= 0.0
            {
                crossings.push(t + (seen.t - t) * before / (before - x));
            }
        });
        let mean = match crossings.as_slice() {
            [first, .., end] => (end - first) / (crossings.len() - 1) as f64,
            _ => f64::NAN,
        };
        claims.push(Claim::relative(format!("period of canopy and payload, {air} kg of air"), mean, period, 1e-4));
    }
    claims
}
