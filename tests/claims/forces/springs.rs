//! A spring from an anchor at the origin, n = (2, 3, 6)/7 and 7 m long as given, with e = l - l0 and ldot = n . v:
//! tension T = k max(e + c ldot/k, ...) along it, force -T n on its free end.

use super::{H, agrees, forces};
use crate::claim::Claim;
use nalgebra::Vector3;
use serde_json::{Value, json};

/// [m]
const LENGTH: f64 = 7.0;
/// [N/m]
const K: f64 = 40.0;
/// [m] of dead zones and compression limits
const EPS: f64 = 0.25;
const SPEED: Vector3<f64> = Vector3::new(1.3, -0.7, 2.1);

fn n() -> Vector3<f64> {
    Vector3::new(2.0, 3.0, 6.0) / LENGTH
}

/// Where the free end is beyond its place in the mesh, and its speed.
#[derive(Clone, Copy)]
struct Start {
    displacement: Vector3<f64>,
    velocity: Vector3<f64>,
}

impl Start {
    fn still(elongation: f64) -> Self {
        Start { displacement: elongation * n(), velocity: Vector3::zeros() }
    }

    fn moving(elongation: f64, velocity: Vector3<f64>) -> Self {
        Start { displacement: elongation * n(), velocity }
    }
}

/// [N] On the free end. `more` are further keys of the spring's rule or, under `network`, of the scene.
fn on_end(more: &Value, start: Start) -> Vector3<f64> {
    let mut rule = json!({"on": "all", "stiffness": K});
    let mut network = json!({
        "mesh": {"explicit": {"nodes": [[0, 0, 0], [2, 3, 6]], "springs": [[0, 1]]}},
        "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
        "initial": {
            "displacement": [[0, 0, 0], start.displacement.as_slice()],
            "velocity": [[0, 0, 0], start.velocity.as_slice()]
        }
    });
    for (key, value) in more.as_object().expect("keys of a rule") {
        match key.as_str() {
            "network" => value.as_object().expect("keys").iter().for_each(|(k, v)| network[k] = v.clone()),
            "axial_rigidity" => rule = json!({"on": "all", "axial_rigidity": value}),
            _ => rule[key] = value.clone(),
        }
    }
    network["springs"] = json!([rule]);
    forces(network, 1)[0][1]
}

/// e, and T/k by hand.
type Point = (f64, f64);

fn slack(claims: &mut Vec<Claim>) {
    let laws: [(&str, Value, [Point; 4]); 4] = [
        ("spring", json!({}), [(0.5, 0.5), (0.125, 0.125), (-0.125, -0.125), (-0.5, -0.5)]),
        ("tension-only", json!("tension-only"), [(0.5, 0.5), (0.125, 0.125), (-0.125, 0.0), (-0.5, 0.0)]),
        ("dead zone 0.25 m", json!({"dead_zone": EPS}), [(0.5, 0.25), (0.125, 0.0), (-0.125, 0.0), (-0.5, 0.0)]),
        (
            "compression limit 0.25 m",
            json!({"compression_limit": EPS}),
            [(0.5, 0.5), (0.125, 0.125), (-0.125, -0.125), (-0.5, -EPS)],
        ),
    ];
    for (name, law, points) in laws {
        let rule = if name == "spring" { json!({}) } else { json!({"slack": law}) };
        for (e, share) in points {
            let found = on_end(&rule, Start::still(e));
            claims.push(agrees(&format!("{name}, e = {e} m"), found, -K * share * n()));
        }
    }
}

fn lengths_and_stiffnesses(claims: &mut Vec<Claim>) {
    for (what, rule, tension) in [
        ("rest_length 6.5 m, k e", json!({"rest_length": 6.5}), K * 0.75),
        ("rest_scale 0.5, k e", json!({"rest_scale": 0.5}), K * 3.75),
        ("axial_rigidity 280 N, EA/l0 e", json!({"axial_rigidity": 280.0}), 280.0 / LENGTH * 0.25),
        (
            "axial_rigidity 280 N with rest_scale 0.5",
            json!({"axial_rigidity": 280.0, "rest_scale": 0.5}),
            280.0 / 3.5 * 3.75,
        ),
    ] {
        claims.push(agrees(what, on_end(&rule, Start::still(0.25)), -tension * n()));
    }
}

fn dashpots(claims: &mut Vec<Claim>) {
    let c = 6.0;
    let along = n().dot(&SPEED) * n();
    for (key, value, coefficient) in [
        ("coefficient", json!({"coefficient": c}), c),
        ("time", json!({"time": 0.05}), K * 0.05),
        ("per_strain", json!({"per_strain": 21.0}), 21.0 / LENGTH),
        ("step", json!("step"), K * H),
    ] {
        let at = Start::moving(0.0, SPEED);
        let axial = on_end(&json!({"dashpot": {"axial": value}}), at);
        claims.push(agrees(&format!("axial dashpot by {key}, -c (n . v) n"), axial, -coefficient * along));
        let relative = on_end(&json!({"dashpot": {"relative": value}}), at);
        claims.push(agrees(&format!("relative dashpot by {key}, -c v"), relative, -coefficient * SPEED));
    }
    // c ldot = 6 * 2 N out, k e = 2.5 N in
    for (what, ldot, elongation, tension) in [
        ("tension-only, short but pulled by its dashpot: k e + c ldot", 2.0, -0.0625, 6.0 * 2.0 - K * 0.0625),
        ("tension-only, long but let go faster than it pulls: 0", -2.0, 0.0625, 0.0),
    ] {
        let rule = json!({"slack": "tension-only", "dashpot": {"axial": {"coefficient": c}}});
        claims.push(agrees(what, on_end(&rule, Start::moving(elongation, ldot * n())), -tension * n()));
    }
    let rule = json!({"slack": {"compression_limit": EPS}, "dashpot": {"axial": {"coefficient": c}}});
    let pushed = on_end(&rule, Start::moving(-0.125, -2.0 * n()));
    claims.push(agrees("compression limit, pushed past it by its dashpot: -k eps", pushed, K * EPS * n()));
    let rule = json!({"slack": "tension-only", "dashpot": {"relative": {"coefficient": c}}});
    let slack = on_end(&rule, Start::moving(-0.125, SPEED));
    claims.push(agrees("relative dashpot on a slack spring, -c v", slack, -c * SPEED));
}

/// The end stands at (6, 2, 3), where the spring is 7 m long again: it has no tension, and another direction than in
/// the mesh.
fn rayleigh(claims: &mut Vec<Claim>) {
    let turned = Start { displacement: Vector3::new(4.0, -1.0, -3.0), velocity: SPEED };
    let damped = |mass: f64, stiffness: f64| json!({"network": {"damping": {"rayleigh": {"mass": mass, "stiffness": stiffness}}}});
    // of a node of 1 kg
    claims.push(agrees("Rayleigh, -alpha m v", on_end(&damped(0.75, 0.0), turned), -0.75 * SPEED));
    let k0 = -0.05 * K * n().dot(&SPEED) * n();
    claims.push(agrees("Rayleigh, -beta K0 v with K0 of the mesh as given", on_end(&damped(0.0, 0.05), turned), k0));
    let gravity = json!({"network": {"gravity": [1.5, -2.0, -9.81]}});
    claims.push(agrees("gravity, m g", on_end(&gravity, Start::still(0.0)), Vector3::new(1.5, -2.0, -9.81)));
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    slack(&mut claims);
    lengths_and_stiffnesses(&mut claims);
    dashpots(&mut claims);
    rayleigh(&mut claims);
    claims
}
