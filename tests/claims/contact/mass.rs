//! A lone mass on a plane. Its kappa is m g/g0, so that its place in the gap does not depend on the mass:
//! ```text
//! slope of the angle a:   -b'(s) = cos a   at rest across it;   it slides (g/2)(sin a - mu cos a) t^2 along it
//! ```
//! Below the speed eps = 1 mm/s friction is smoothed: it lacks at most what keeps the mass by eps too fast, so that
//! places are off by eps t at most.

use super::{CREEP, G, ground, share_of_gap};
use crate::claim::Claim;
use crate::common::run::{Run, case_of, run};
use serde_json::{Value, json};

/// [m]
const GAP: f64 = 1e-3;
/// Methods and steps [s] on the slope: explicit friction stops a mass within two steps, which is faster than 1 mm/s
/// in longer ones, and the trapezium rule takes half of the first step without friction.
const SLOPE: [(&str, f64); 6] = [
    ("newmark", 4e-4),
    ("hht", 4e-4),
    ("backward-euler", 1e-3),
    ("velocity-verlet", 1e-4),
    ("improved-euler", 1e-4),
    ("rk4", 1e-4),
];

fn lone(start: [f64; 3], velocity: [f64; 3], gravity: [f64; 3], contact: Value, time: Value) -> Value {
    json!({
        "name": "mass",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [start]}},
            "mass": {"nodal": [2.0]},
            "gravity": gravity,
            "contact": contact,
            "initial": {"velocity": [velocity]}
        }},
        "time": time
    })
}

/// A mass on a slope of tan a = 0.5, seen along it, from rest.
fn slope(mu: f64, method: &str, step: f64) -> Run {
    let angle = 0.5_f64.atan();
    let start = [0.0, 0.0, GAP * share_of_gap(angle.cos())];
    let gravity = [G * angle.sin(), 0.0, -G * angle.cos()];
    let contact = json!([{"between": ["all", ground()], "gap": GAP, "friction": mu}]);
    let time = json!({"end": 1.0, "method": method, "step": step});
    run(&case_of(&lone(start, [0.0; 3], gravity, contact, time), &[]))
}

pub fn slopes() -> Vec<Claim> {
    let mut claims = Vec::new();
    let angle = 0.5_f64.atan();
    for (method, step) in SLOPE {
        // The first order of backward Euler, a h t/2, comes on top.
        let allowed = CREEP + if method == "backward-euler" { 0.5 * 1.76 * step } else { 0.0 };
        let way = 0.5 * G * (angle.sin() - 0.3 * angle.cos());
        claims.push(Claim::absolute(
            format!("{method}: tan a = 0.5, mu = 0.3, a mass slides in 1 s [m]"),
            slope(0.3, method, step).positions[0][0],
            way,
            allowed,
        ));
        let v = slope(0.5, method, step).velocities[0];
        let speed = v.iter().map(|v| v * v).sum::<f64>().sqrt();
        claims.push(Claim::below(format!("{method}: mu = 0.5, it rests, but for creep [m/s]"), speed, CREEP));
    }
    claims
}

/// [m/s] At which a mass flies to the ground
const SPEED: f64 = 0.5;

/// A mass that flies slantwise to the ground through nothing, from 2 g0, and bounces off it.
fn bounce(method: &str, step: f64) -> Run {
    let contact = json!([{"between": ["all", ground()], "gap": GAP}]);
    let time = json!({"end": 0.016, "method": method, "step": step});
    run(&case_of(&lone([0.0, 0.0, 2.0 * GAP], [0.3, 0.0, -SPEED], [0.0; 3], contact, time), &[]))
}

/// A bounce on a barrier keeps the energy, to the order of the method at least: a fourth of the step takes the error
/// to a fourth to the power of the order. Two derivatives of the barrier are continuous, so that rk4 reaches 2 here.
pub fn bounces() -> Vec<Claim> {
    let mut claims = Vec::new();
    for (method, order) in
        [("newmark", 2.0), ("backward-euler", 1.0), ("velocity-verlet", 2.0), ("improved-euler", 2.0), ("rk4", 2.0)]
    {
        let steps = [1e-4, 2.5e-5, 6.25e-6];
        let ran = steps.map(|step| bounce(method, step));
        let errors = ran.each_ref().map(|ran| ran.velocities[0][2] / SPEED - 1.0);
        claims.push(Claim::below(
            format!("{method}: a mass bounces off the ground at its speed, h = 6 us [-]"),
            errors[2],
            if order == 1.0 { 2e-2 } else { 1e-6 },
        ));
        let fall = (errors[0] / errors[2]).abs().log2() / 4.0;
        claims.push(Claim::between(
            format!("{method}: and the better, the shorter the steps: order"),
            fall,
            order - 0.1,
            9.0,
        ));
        let along = ran.each_ref().map(|ran| (ran.velocities[0][0] - 0.3).abs()).into_iter().fold(0.0, f64::max);
        claims.push(Claim::below(format!("{method}: and keeps its speed along it [m/s]"), along, 1e-15));
    }
    claims
}
