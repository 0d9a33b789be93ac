//! A body that glides, with lift over drag R and b = g/(V sqrt(1 + R^2)):
//!
//! ```text
//! steady: V^2 = 2 m g/(rho CdS sqrt(1 + R^2)),  tan(gamma) = 1/R, whatever the wind, which carries it along
//! near it, in the plane of the heading: w'' + 3 b w' + 2 (g/V)^2 w = 0; across it: w' = -b w
//! ```
//! so a phugoid has Lanchester's frequency sqrt(2) g/V, damped by 3 b/2 (F. W. Lanchester, Aerodonetics, 1908; here the
//! drag grows with V^2). In a steady turn at a rate w about the vertical the forces balance m w x v.

use crate::claim::Claim;
use crate::common::run::{case_of, follow, run, run_with};
use canopy_fem::integrate::registry::methods;
use nalgebra::Vector3;
use serde_json::{Value, json};
use std::f64::consts::{PI, SQRT_2};

type Vector = Vector3<f64>;

/// [m/s^2], [kg/m^3], [kg], [m^2]
const G: f64 = 9.81;
const DENSITY: f64 = 1.225;
const MASS: f64 = 104.0;
const AREA: f64 = 7.3;
/// [deg] heading
const HEADING: f64 = 60.0;

/// [m/s] and [m/s] speed, forward and downward, of a steady glide.
fn steady(ratio: f64) -> [f64; 3] {
    let all = 1.0_f64.hypot(ratio);
    let speed = (2.0 * MASS * G / (DENSITY * AREA * all)).sqrt();
    [speed, speed * ratio / all, speed / all]
}

/// Unit vector of a heading [deg].
fn forward(heading: f64) -> Vector {
    let (sine, cosine) = heading.to_radians().sin_cos();
    Vector::new(sine, cosine, 0.0)
}

/// [m/s] velocity of the steady glide over the ground.
fn velocity(ratio: f64, wind: Vector) -> Vector {
    let [_, along, down] = steady(ratio);
    along * forward(HEADING) - Vector::new(0.0, 0.0, down) + wind
}

fn body(ratio: f64, heading: &Value, wind: Vector, start: Vector, time: &Value) -> Value {
    json!({
        "name": "glide",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0]], "springs": []}},
            "mass": {"nodal": MASS},
            "gravity": [0, 0, -G],
            "aero": {"wind": wind.as_slice(), "drag": [
                {"on": "all", "drag_area": AREA, "glide": {"ratio": ratio, "heading": heading}}
            ]},
            "initial": {"velocity": start.as_slice()}
        }},
        "time": time
    })
}

fn fixed(method: &str, step: f64, end: f64) -> Value {
    json!({"end": end, "method": method, "step": step})
}

fn off(found: [f64; 3], expected: Vector) -> f64 {
    (Vector::from(found) - expected).norm() / expected.norm()
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    let wind = Vector::new(3.0, -1.5, 0.4);
    let v = velocity(2.0, wind);
    for method in methods() {
        let case = body(2.0, &json!(HEADING), wind, v, &fixed(method.name, 0.05, 20.0));
        let ran = run(&case_of(&case, &[]));
        let what = format!("{}: a steady glide in wind, 20 s", method.name);
        claims.push(Claim::below(what, off(ran.positions[0], 20.0 * v), 1e-9));
    }
    for ratio in [0.5, 2.0, 6.0] {
        let wind = Vector::new(-2.0, 4.0, 0.0);
        let time = json!({"end": 120.0, "method": "dop853", "tolerance": {"relative": 1e-10, "absolute": 1e-8}});
        let ran = run(&case_of(&body(ratio, &json!(HEADING), wind, Vector::zeros(), &time), &[]));
        let what = format!("L/D {ratio}: speed and angle that a fall from rest comes to");
        claims.push(Claim::below(what, off(ran.velocities[0], velocity(ratio, wind)), 1e-6));
        claims.push(Claim::below(format!("L/D {ratio}: the ledger closes"), ran.outcome.energy_error, 1e-7));
    }
    claims.extend([2.0, 10.0].into_iter().flat_map(phugoid));
    claims.push(sideslip());
    claims.extend(vertical());
    claims.push(turn());
    claims.push(threads());
    claims
}

/// Zeros of a small oscillation about the steady glide, and by how much it decays from one to the next but one.
fn phugoid(ratio: f64) -> Vec<Claim> {
    let small = 1e-4;
    let v = velocity(ratio, Vector::zeros());
    let case = body(ratio, &json!(HEADING), Vector::zeros(), v * (1.0 + small), &fixed("rk4", 0.002, 40.0));
    let (mut last, mut zeros, mut peaks): (Option<(f64, f64)>, Vec<f64>, Vec<f64>) = (None, Vec::new(), vec![0.0]);
    follow(&case_of(&case, &[]), |seen| {
        let w = seen.velocities[0][2] - v.z;
        if let Some((t, before)) = last
            && w * before < 0.0
        {
            zeros.push(t + (seen.t - t) * before / (before - w));
            peaks.push(0.0);
        }
        if let Some(peak) = peaks.last_mut() {
            *peak = w.abs().max(*peak);
        }
        last = Some((seen.t, w));
    });
    let [speed, ..] = steady(ratio);
    let b = G / (speed * 1.0_f64.hypot(ratio));
    let undamped = SQRT_2 * G / speed;
    let damped = (undamped * undamped - 2.25 * b * b).sqrt();
    let period = zeros[2] - zeros[0];
    vec![
        Claim::relative(format!("L/D {ratio}: period of the phugoid [s]"), period, 2.0 * PI / damped, 1e-3),
        Claim::relative(
            format!("L/D {ratio}: its decay over a period"),
            (peaks[1] / peaks[3]).ln(),
            1.5 * b * 2.0 * PI / damped,
            5e-3,
        ),
        Claim::relative(
            format!("L/D {ratio}: its frequency without damping, Lanchester's pi sqrt(2) V/g [s]"),
            2.0 * PI / ((2.0 * PI / period).powi(2) + 2.25 * b * b).sqrt(),
            PI * SQRT_2 * speed / G,
            1e-3,
        ),
    ]
}

/// A small velocity across the heading decays as exp(-b t).
fn sideslip() -> Claim {
    let (ratio, small, t) = (2.0, 1e-4, 1.7);
    let (v, across) = (velocity(ratio, Vector::zeros()), forward(HEADING).cross(&Vector::z()));
    let case = body(ratio, &json!(HEADING), Vector::zeros(), v + small * across, &fixed("rk4", 0.01, t));
    let ran = run(&case_of(&case, &[]));
    let [speed, ..] = steady(ratio);
    let left = Vector::from(ran.velocities[0]).dot(&across) / small;
    Claim::relative(
        "a sideslip decays as exp(-g t/(V sqrt(1 + R^2)))",
        left,
        (-G * t / (speed * 5.0_f64.sqrt())).exp(),
        1e-4,
    )
}

/// In a vertical fall at V the lift is along the heading, R times the drag: by a first step of explicit Euler.
fn vertical() -> Vec<Claim> {
    let (ratio, speed, h) = (2.0, 5.0, 1e-3);
    let start = Vector::new(0.0, 0.0, -speed);
    let case = body(ratio, &json!(HEADING), Vector::zeros(), start, &fixed("explicit-euler", h, h));
    let ran = run(&case_of(&case, &[]));
    let a = (Vector::from(ran.velocities[0]) - start) / h;
    let drag = 0.5 * DENSITY * AREA * speed * speed / MASS;
    let expected = ratio * drag * forward(HEADING) + Vector::new(0.0, 0.0, drag - G);
    vec![Claim::below("in a vertical fall the lift is along the heading", (a - expected).norm() / drag, 1e-9)]
}

/// After ten turns m w x v = m g + F(v), with the force written out again.
fn turn() -> Claim {
    let (ratio, rate) = (2.0, 12.0_f64);
    let end = 300.0;
    let heading = json!({"table": [[0, HEADING], [end, HEADING + rate * end]]});
    let v = velocity(ratio, Vector::zeros());
    let case = body(ratio, &heading, Vector::zeros(), v, &fixed("rk4", 0.01, end));
    let v = Vector::from(run(&case_of(&case, &[])).velocities[0]);
    // A compass turns clockwise, seen from above.
    let turning = Vector::new(0.0, 0.0, -rate.to_radians());
    let n = Vector::z().cross(&forward(HEADING + rate * end));
    let force = 0.5 * DENSITY * AREA * v.norm() * (-v - ratio * n.cross(&v));
    let left = MASS * turning.cross(&v) - force + Vector::new(0.0, 0.0, MASS * G);
    Claim::below("a steady turn: m w x v = m g + F, over the weight", left.norm() / (MASS * G), 1e-6)
}

/// Many nodes that glide, on springs.
fn threads() -> Claim {
    let mut same = true;
    for method in ["velocity-verlet", "newmark"] {
        let case = case_of(
            &json!({
                "name": "cloth",
                "system": {"network": {
                    "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 60, "rows": 60}},
                    "mass": {"nodal": 1e-3},
                    "springs": [{"on": "all", "stiffness": 20.0}],
                    "gravity": [0, 0, -G],
                    "aero": {"wind": [1, 2, 0], "drag": [{"on": "all", "drag_area": 0.5,
                             "glide": {"ratio": 1.5, "heading": {"table": [[0, 0], [1, 300]]}}}]}
                }},
                "time": fixed(method, 1e-3, 0.03)
            }),
            &[],
        );
        let [one, two] = [1, 2].map(|threads| run_with(&case, threads));
        same &= one.state == two.state;
    }
    Claim::is("gliding nodes have the same bits on two threads", same)
}
