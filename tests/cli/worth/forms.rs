//! Scenes whose numbers have closed forms.

use serde_json::{Value, json};
use std::f64::consts::TAU;

/// [m/s^2]
const G: f64 = 9.81;

/// A scene, four steps, and numbers with their closed forms.
pub struct Form {
    pub name: &'static str,
    pub case: Value,
    /// [s]
    pub steps: [f64; 4],
    pub exact: Vec<(String, f64)>,
}

impl Form {
    fn new(name: &'static str, [end, longest]: [f64; 2], system: Value, output: Value, exact: &[(&str, f64)]) -> Self {
        let case = json!({"name": name, "system": system, "time": {"end": end}, "output": output});
        let exact = exact.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        Form { name, case, steps: [1.0, 0.5, 0.25, 0.125].map(|part| part * longest), exact }
    }
}

/// All of them.
pub fn all() -> Vec<Form> {
    vec![oscillator(), falling(), swinging(), hanging(), opening()]
}

/// A mass on a spring, let go from rest at 0.3 m: x = 0.3 cos(w t) with w = 2 pi/s.
pub fn oscillator() -> Form {
    let (w, end, a) = (TAU, 3.2, 0.3);
    let network = json!({
        "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0]], "springs": [[0, 1]]}},
        "mass": {"nodal": 1.0},
        "springs": [{"on": "all", "stiffness": w * w}],
        "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [1]}, "fix": "yz"}],
        "initial": {"displacement": [[0, 0, 0], [a, 0, 0]]}
    });
    let output = json!({
        "frames": {"every": 0.1},
        "probes": [{"name": "bob", "on": {"ids": [1]}}],
        "gauges": [
            {"name": "wall", "on": {"ids": [0]}, "of": "reaction"},
            {"name": "bob", "on": {"ids": [1]}, "of": "speed"}
        ]
    });
    let exact = [
        ("bob.x@1.3", 1.0 + a * (1.3 * w).cos()),
        ("bob.x.last", 1.0 + a * (end * w).cos()),
        ("bob.speed.peak", a * w),
        ("wall.reaction.last", (a * w * w * (end * w).cos()).abs()),
        ("energy.elastic.last", 0.5 * (a * w * (end * w).cos()).powi(2)),
    ];
    Form::new("oscillator", [end, 0.04], json!({"network": network}), output, &exact)
}

/// Two masses of 1 kg that fall with a drag area of 0.2 m^2 in all: v = V tanh(g t/V), z = V^2/g ln cosh(g t/V).
fn falling() -> Form {
    let (end, area, density) = (3.2, 0.2, 1.225);
    let terminal = (2.0 * 2.0 * G / (density * area)).sqrt();
    let network = json!({
        "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0]], "springs": [[0, 1]]}},
        "mass": {"nodal": 1.0},
        "springs": [{"on": "all", "stiffness": 100.0}],
        "gravity": [0, 0, -G],
        "aero": {"atmosphere": {"density": density}, "drag": [{"on": {"ids": [0, 1]}, "drag_area": area}]}
    });
    let output = json!({"frames": {"every": 0.2}, "probes": [{"name": "mass", "on": "all"}]});
    let fallen = |t: f64| terminal * terminal / G * (G * t / terminal).cosh().ln();
    let exact = [
        ("mass.z.last", -fallen(end)),
        ("displacement_end", fallen(end)),
        ("mass.vz.last", -terminal * (G * end / terminal).tanh()),
        ("mass.vz@1.1", -terminal * (G * 1.1 / terminal).tanh()),
        ("mass.vz.mean", -fallen(end) / end),
    ];
    Form::new("falling", [end, 0.2], json!({"network": network}), output, &exact)
}

/// A pendulum of 1 m from 0.5 rad: its period is 2 pi sqrt(L/g)/agm(1, cos(a/2)), and it passes its lowest point after
/// a quarter of it. Half of it after the start it rests.
fn swinging() -> Form {
    let angle: f64 = 0.5;
    let (mut a, mut b) = (1.0, (0.5 * angle).cos());
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    let period = TAU / G.sqrt() / a;
    let pendulum = json!({"length": 1.0, "mass": 1.0, "damping": 0.0, "gravity": G, "angle": angle, "rate": 0.0});
    let output = json!({"frames": {"every": 0.1}, "probes": [{"name": "bob", "on": "all"}]});
    let turns = format!("bob.vx@{}", 0.5 * period);
    let exact = [
        ("bob.vx.peak_time", 0.25 * period),
        ("bob.vx.peak", -(2.0 * G * (1.0 - angle.cos())).sqrt()),
        (turns.as_str(), 0.0),
    ];
    Form::new("pendulum", [0.6 * period, period / 40.0], json!({"pendulum": pendulum}), output, &exact)
}

/// The funicular of one weight between two links, brought to rest: no step has an error there but what has not died
/// away. 2 T z/l = m g, T = EA (l/l0 - 1), l^2 = z^2 + 0.5^2.
fn hanging() -> Form {
    let (rigidity, rest) = (1e3, 0.7);
    let (mut low, mut high) = (0.0, 2.0);
    let tension = |z: f64| rigidity * (z.hypot(0.5) / rest - 1.0);
    for _ in 0..200 {
        let z = 0.5 * (low + high);
        *if 2.0 * tension(z) * z / z.hypot(0.5) < G { &mut low } else { &mut high } = z;
    }
    let network = json!({
        "mesh": {"explicit": {"nodes": [[-0.5, 0, 0], [0, 0, -0.6], [0.5, 0, 0]], "springs": [[0, 1], [1, 2]]}},
        "mass": {"nodal": 1.0},
        "springs": [{"on": "all", "axial_rigidity": rigidity, "rest_length": rest}],
        "supports": [{"on": {"ids": [0, 2]}, "fix": "xyz"}],
        "gravity": [0, 0, -G],
        "damping": {"rayleigh": {"mass": 10.0}}
    });
    let output = json!({
        "frames": {"every": 0.1},
        "gauges": [{"name": "link", "on": "all", "of": "tension"}],
        "probes": [{"name": "weight", "on": {"ids": [1]}}]
    });
    let exact = [("link.tension.last", tension(low)), ("weight.z.last", -low)];
    Form::new("funicular", [6.0, 0.02], json!({"network": network}), output, &exact)
}

/// Pflanz's opening without gravity, of a stiff canopy of 10 kg: with A = 2 m/(rho CdS v_s t_f) and tau =
/// min(1, (j A (j + 1)/(j + 2))^(1/(j + 1))) the largest force is q_s CdS tau^j/(1 + tau^(j + 1)/(A (j + 1)))^2.
fn opening() -> Form {
    let (density, speed, area, mass, a, j) = (1.225, 50.0, 2.0, 10.0, 1.0, 2.0_f64);
    let filling = 2.0 * mass / (density * area * speed * a);
    let tau = (j * a * (j + 1.0) / (j + 2.0)).powf(1.0 / (j + 1.0)).min(1.0);
    let factor = tau.powf(j) / (1.0 + tau.powf(j + 1.0) / (a * (j + 1.0))).powi(2);
    let network = json!({
        "mesh": {"explicit": {
            "nodes": [[0, 0, 0.7], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, -3]],
            "springs": [[0, 1], [0, 2], [0, 3], [0, 4], [1, 2], [2, 3], [3, 4], [4, 1], [1, 3], [2, 4],
                        [1, 5], [2, 5], [3, 5], [4, 5]],
            "triangles": [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]]
        }},
        "mass": {"nodal": [2, 2, 2, 2, 1, 1]},
        "springs": [{"on": "all", "stiffness": 1e9}],
        "supports": [{"on": "all", "fix": "xy"}],
        "initial": {"velocity": [0, 0, -speed]},
        "aero": {"atmosphere": {"density": density}, "canopy": {
            "on": "all", "confluence": {"ids": [5]},
            "schedule": {"drag_area": area, "filling_time": filling, "exponent": j}
        }}
    });
    let output = json!({"frames": {"every": 0.1 * filling}});
    let peak = 0.5 * density * speed * speed * area * factor;
    let exact = [("opening_load", peak), ("canopy.drag.peak_time", tau * filling)];
    Form::new("opening", [1.2 * filling, filling / 40.0], json!({"network": network}), output, &exact)
}
