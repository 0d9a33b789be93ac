//! The air in a cavity: its pressure in given states against a bisection of its equations, as they are stated, with
//! closed forms of a cone for volume, mouth and cloth; and a canopy that fills, its shape and its speed.

use crate::claim::Claim;
use crate::common::parachute::Parachute;
use crate::common::run::{case_of, follow};
use canopy_fem::case::spec::SystemSpec;
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::model::state::StateRef;
use canopy_fem::model::system::System;
use canopy_fem::scene::build_network;
use serde_json::{Value, json};
use std::f64::consts::PI;

/// [kg/m^3]
const DENSITY: f64 = 1.225;
/// [-] pressure coefficient on the outside
const OUTSIDE: f64 = -0.6;
/// A C-9 in coarse: D0 8.534 m, lines of 0.9 D0.
const C9: Parachute = Parachute { gores: 14, rings: 8, line_segments: 3, nominal_diameter: 8.534, line_length: 7.68 };
/// [kg]
const PAYLOAD: f64 = 90.7;

/// A case of it at line stretch, with the skirt at `skirt` [-] D0.
fn case(skirt: f64, speed: f64, cavity: &Value) -> Value {
    let mut case = C9.case(1.0, PAYLOAD, speed);
    let network = &mut case["system"]["network"];
    network["aero"]["canopy"] =
        json!({"on": "all", "confluence": {"ids": [C9.payload()]}, "cavity": cavity, "apparent_mass": 1.0});
    let start = C9.stretched(0.5 * skirt * C9.nominal_diameter);
    network["initial"]["displacement"] = json!(C9.displaced_to(&start));
    for rule in network["springs"].as_array_mut().expect("rules") {
        (rule["axial_rigidity"], rule["dashpot"]) = (json!(8e3), json!({"axial": {"time": 1e-3}}));
    }
    case["time"] = json!({"end": 4.0, "method": "newmark", "step": 2e-3});
    case
}

/// A cloth: its key in a case, and [Pa s/m, Pa s^2/m^2] the two coefficients of its pressure difference.
fn cloths() -> [(&'static str, Value, Option<[f64; 2]>); 3] {
    let (eps, d, e, density, viscosity) = (0.1_f64, 5e-5_f64, 1e-4, 1.225, 1.81e-5);
    let ergun = [
        150.0 * viscosity * (1.0 - eps).powi(2) / (d.powi(2) * eps.powi(3)) * e,
        1.75 * density * (1.0 - eps) / (d * eps.powi(3)) * e,
    ];
    [
        ("tight cloth", Value::Null, None),
        ("measured cloth", json!({"permeable": {"a": 1.599e6, "b": 4.805e5, "thickness": 1e-4}}), Some([159.9, 48.05])),
        ("Ergun's cloth", json!({"ergun": {"porosity": eps, "pore_diameter": d, "thickness": e}}), Some(ergun)),
    ]
}

/// A cone of flat gores over the skirt's radius [m].
struct Cone {
    /// [m^2] cloth, mouth
    cloth: f64,
    mouth: f64,
    /// [m]
    height: f64,
}

impl Cone {
    fn new(radius: f64) -> Self {
        let (n, slant) = (C9.gores as f64, C9.radius());
        let side = 2.0 * radius * (PI / n).sin();
        Cone {
            cloth: 0.5 * n * side * (slant.powi(2) - 0.25 * side.powi(2)).sqrt(),
            mouth: 0.5 * n * radius.powi(2) * (2.0 * PI / n).sin(),
            height: (slant.powi(2) - radius.powi(2)).sqrt(),
        }
    }

    /// [Pa] dp by bisection, at the speed [m/s] and with the growth of the volume [m^3/s].
    fn pressure(&self, cloth: Option<[f64; 2]>, inflow: f64, speed: f64, growth: f64) -> f64 {
        let q = 0.5 * DENSITY * speed * speed.abs();
        let through = |dp: f64| match cloth {
            None => 0.0,
            Some([a, b]) => dp.signum() * ((a * a + 4.0 * b * dp.abs()).sqrt() - a) / (2.0 * b),
        };
        // eta V A_m x, p_i = q (1 - x|x|); without speed the limit of that.
        let entering = |inside: f64| {
            let x = 1.0 - inside / q;
            let still = (2.0 * inside.abs() / DENSITY).sqrt() * -inside.signum();
            let v = if speed == 0.0 { still } else { speed * x.signum() * x.abs().sqrt() };
            inflow * self.mouth * v
        };
        let (mut low, mut high) = (-1e7, 1e7);
        for _ in 0..200 {
            let dp = 0.5 * (low + high);
            let leaving = growth + self.cloth * through(dp);
            if entering(dp + OUTSIDE * q) > leaving { low = dp } else { high = dp }
        }
        0.5 * (low + high)
    }
}

/// [N] The force of the air along z while the cone widens at a rate [1/s] in a wind along z [m/s]: as the scene has it,
/// and by the pressure `dp` [Pa] less what the motion takes.
fn forces(cavity: &Value, radius: f64, [wind, rate]: [f64; 2], dp: f64) -> [f64; 2] {
    let mut case = case(2.0 * radius / C9.nominal_diameter, 0.0, cavity);
    case["system"]["network"]["aero"]["wind"] = json!([0, 0, wind]);
    case["system"]["network"]["aero"]["canopy"]["apparent_mass"] = Value::Null;
    let case = case_of(&case, &[]);
    let SystemSpec::Network(spec) = &case.problem().system else { return [f64::NAN; 2] };
    let scene = build_network((**spec).clone(), Threads::one()).expect("a sound scene");
    let state = scene.initial_state();
    let mut v = state.x.clone();
    v.chunks_exact_mut(3).for_each(|v| (v[0], v[1], v[2]) = (rate * v[0], rate * v[1], 0.0));
    let mut out = scene.new_forces();
    scene.evaluate(StateRef { t: 0.0, x: &state.x, v: &v }, &mut out);
    let found = out.external.chunks_exact(3).map(|f| f[2]).sum::<f64>();
    let at = C9.stretched(radius);
    let (_, _, triangles) = C9.mesh(0.0);
    let expected = triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|node| at[node]);
        let [s, t] = [b, c].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
        let normal = [s[1] * t[2] - s[2] * t[1], s[2] * t[0] - s[0] * t[2], s[0] * t[1] - s[1] * t[0]];
        let upwards = normal[2].signum();
        let size = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        let outwards = rate / 3.0 * (0..2).map(|i| (a[i] + b[i] + c[i]) * normal[i] / size * upwards).sum::<f64>();
        let met = wind - outwards;
        (dp + 0.5 * DENSITY * (met * met.abs() - wind * wind.abs())) * 0.5 * normal[2].abs()
    });
    [found, expected.sum()]
}

/// The pressure by the balance, in a wind from below and above, in still air, with volumes that stay, grow and shrink.
pub fn balance() -> Vec<Claim> {
    let (inflow, radius) = (0.45, 1.9);
    let cone = Cone::new(radius);
    let mut claims = Vec::new();
    for (name, law, coefficients) in cloths() {
        let cavity = json!({"inflow": inflow, "outer_pressure_coefficient": OUTSIDE, "law": law});
        for [wind, rate] in [[12.0, 0.0], [-7.0, 0.0], [9.0, 2.0], [9.0, -1.5], [0.0, 1.2], [60.0, 9.0]] {
            let growth = 2.0 * rate * cone.mouth * cone.height / 3.0;
            let dp = cone.pressure(coefficients, inflow, wind, growth);
            let [found, expected] = forces(&cavity, radius, [wind, rate], dp);
            let what = format!("{name}, wind {wind} m/s, widening {rate} 1/s: force by the balance");
            claims.push(Claim::relative(what, found, expected, 1e-11));
            if rate == 0.0 && coefficients.is_none() {
                let q = 0.5 * DENSITY * wind * wind.abs();
                let what = format!("{name}, wind {wind} m/s: dp (1 - Cp) q on the mouth");
                claims.push(Claim::relative(what, found, (1.0 - OUTSIDE) * q * cone.mouth, 1e-13));
            }
        }
    }
    claims
}

/// What a canopy does that fills.
struct Filling {
    /// [-] filling time over D0/v_s: until the projected diameter is that at the end
    constant: f64,
    /// [-] Dp/D0 at the end
    diameter: f64,
    /// [m/s] speed of the payload at the end
    fall: f64,
}

fn fills(inflow: f64, law: &Value) -> Filling {
    let speed = 60.0;
    let cavity = json!({"inflow": inflow, "outer_pressure_coefficient": OUTSIDE, "law": law});
    let (mut seen, mut fall) = (Vec::new(), f64::NAN);
    let n = C9.gores as f64;
    // A circle with the area of a polygon.
    let circle = (n / (2.0 * PI) * (2.0 * PI / n).sin()).sqrt();
    follow(&case_of(&case(0.05, speed, &cavity), &[]), |state| {
        let cloth = &state.positions[..=C9.rings * C9.gores];
        let radius = cloth.iter().map(|p| p[0].hypot(p[1])).fold(0.0, f64::max);
        seen.push((state.t, 2.0 * circle * radius / C9.nominal_diameter));
        fall = -state.velocities[C9.payload()][2];
    });
    let diameter = seen.last().map_or(f64::NAN, |(_, d)| *d);
    let filled = seen.iter().find(|(_, d)| *d >= diameter).map_or(f64::NAN, |(t, _)| *t);
    Filling { constant: filled * speed / C9.nominal_diameter, diameter, fall }
}

/// A C-9 from line stretch at 60 m/s, the skirt at 0.05 D0: Knacke has n = 8, Dp/D0 0.64 to 0.70 and 5.8 m/s. How long
/// it takes to fill is set by the inflow and the size at the start; the loads are not claimed.
pub fn filling() -> Vec<Claim> {
    let [(_, tight, _), (_, measured, _), _] = cloths();
    let open = json!({"permeable": {"a": 4e5, "b": 1.2e5, "thickness": 1e-4}});
    let (slow, quick) = (fills(0.3, &measured), fills(0.6, &measured));
    let (tight, open) = (fills(0.6, &tight), fills(0.6, &open));
    let mut claims = Vec::new();
    for (inflow, run) in [(0.3, &slow), (0.6, &quick)] {
        let what = |what: &str| format!("{what}, inflow {inflow}");
        claims.push(Claim::between(what("filling constant"), run.constant, 5.0, 11.0));
        claims.push(Claim::between(what("Dp/D0"), run.diameter, 0.60, 0.68));
        claims.push(Claim::between(what("speed of fall, m/s"), run.fall, 5.5, 7.2));
    }
    claims.push(Claim::between(
        "filling constant, inflow 0.3 over inflow 0.6",
        slow.constant / quick.constant,
        1.5,
        2.2,
    ));
    claims.push(Claim::between("speed of fall, measured cloth over tight cloth", quick.fall / tight.fall, 1.001, 1.05));
    claims.push(Claim::between("speed of fall, open cloth over measured cloth", open.fall / quick.fall, 1.01, 1.5));
    claims
}
