//! Events within a run: supports released, springs cut. All lie within steps, unless it is said otherwise.

use crate::claim::Claim;
use crate::common::run::{Run, case_of, run, run_with};
use canopy_fem::integrate::registry::{Family, methods};
use serde_json::{Value, json};
use std::f64::consts::PI;

/// [m/s^2]
const G: f64 = 9.81;
/// [s] of the release, and the end
const RELEASE: [f64; 2] = [0.2371, 0.9];
/// [N/m], [kg], [m], [s] stiffness, mass, amplitude and time of the cut of an oscillator; it ends at 1 s
const CUT: [f64; 4] = [50.0, 2.0, 0.3, 0.3373];

fn timed(method: &str, step: f64, end: f64) -> Value {
    json!({"end": end, "method": method, "step": step})
}

fn adaptive(method: &str, tolerance: f64, end: f64) -> Value {
    json!({"end": end, "method": method, "tolerance": {"relative": tolerance, "absolute": 0.1 * tolerance}})
}

/// A mass that is held until a time, beside one that is free in z and hangs on a spring.
fn released(time: Value) -> Value {
    json!({
        "name": "released",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0], [1, 0, 1]], "springs": [[1, 2]]}},
            "mass": {"nodal": [1.5, 1.0, 1.0]},
            "springs": [{"on": "all", "stiffness": 100.0}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz", "until": RELEASE[0]},
                         {"on": {"ids": [0]}, "fix": "x"},
                         {"on": {"ids": [1]}, "fix": "xy"}, {"on": {"ids": [2]}, "fix": "xyz"}],
            "gravity": [0, 0, -G]
        }},
        "time": time
    })
}

/// A mass on a spring along x, with amplitude A from its rest length.
fn oscillator(time: Value) -> Value {
    let [k, m, a, cut] = CUT;
    json!({
        "name": "cut",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0]], "springs": [[0, 1]]}},
            "mass": {"nodal": m},
            "springs": [{"on": "all", "stiffness": k, "cut": cut}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "initial": {"displacement": [a, 0, 0]}
        }},
        "time": time
    })
}

/// [m] displacement at the end, and [J] the energy of the spring when it is cut.
fn after_the_cut() -> [f64; 2] {
    let [k, m, a, cut] = CUT;
    let w = (k / m).sqrt();
    let (x, v) = (a * (w * cut).cos(), -a * w * (w * cut).sin());
    [x + v * (1.0 - cut), 0.5 * k * x * x]
}

fn off(ran: &Run) -> f64 {
    (ran.positions[1][0] - 1.0 - after_the_cut()[0]).abs()
}

pub fn claims() -> Vec<Claim> {
    let fall = -0.5 * G * (RELEASE[1] - RELEASE[0]).powi(2);
    let [_, energy] = after_the_cut();
    let mut claims = Vec::new();
    for method in methods() {
        let name = method.name;
        let ran = run(&case_of(&released(timed(name, 0.002, RELEASE[1])), &[]));
        let [x, y, z] = ran.positions[0];
        let order = case_of(&released(timed(name, 0.002, RELEASE[1])), &[]).problem().method.order();
        // A method of first order is late or early by a share of a step.
        let tolerance = if order > 1 && method.family != Family::MatrixFree { 1e-9 } else { 0.01 };
        claims.push(Claim::relative(format!("{name}: a mass falls g t^2/2 from its release"), z, fall, tolerance));
        claims.push(Claim::is(format!("{name}: and straight down"), x == 0.0 && y.abs() < 1e-12));
        let ran = run(&case_of(&oscillator(timed(name, 0.0005, 1.0)), &[]));
        let tolerance = if order > 1 { 1e-5 } else { 5e-3 };
        claims.push(Claim::absolute(
            format!("{name}: after a cut the mass keeps its velocity"),
            ran.positions[1][0] - 1.0,
            after_the_cut()[0],
            tolerance,
        ));
        claims.push(Claim::relative(
            format!("{name}: the energy of the cut spring is dissipated"),
            ran.outcome.ledger.dissipated,
            energy,
            if order > 1 { 2e-4 } else { 0.05 },
        ));
        claims.push(Claim::is(format!("{name}: it holds none any more"), ran.outcome.ledger.elastic == 0.0));
    }
    // Steps beside the event are shorter, and differently so for h and h/2: within half an order.
    for (name, steps, order) in [("velocity-verlet", 0.01, 2.0), ("newmark", 0.01, 2.0), ("rk4", 0.04, 4.0)] {
        let [coarse, fine] = [steps, 0.5 * steps].map(|h| off(&run(&case_of(&oscillator(timed(name, h, 1.0)), &[]))));
        let found = (coarse / fine).log2();
        claims.push(Claim::absolute(format!("{name}: order across a cut within a step"), found, order, 0.5));
    }
    for (name, tolerance) in
        [("velocity-verlet", 1e-6), ("newmark", 1e-6), ("hht", 1e-6), ("dormand-prince", 1e-9), ("kang", 1e-4)]
    {
        let ran = run(&case_of(&released(adaptive(name, tolerance, RELEASE[1])), &[]));
        let what = format!("{name}, adaptive: falls from its release");
        claims.push(Claim::relative(what, ran.positions[0][2], fall, 10.0 * tolerance));
        let ran = run(&case_of(&oscillator(adaptive(name, tolerance, 1.0)), &[]));
        claims.push(Claim::absolute(
            format!("{name}, adaptive: goes on after a cut"),
            off(&ran),
            0.0,
            10.0 * tolerance,
        ));
    }
    let ran = run(&case_of(&oscillator(timed("rk4", 0.001, 1.0)), &[]));
    claims.push(Claim::below("rk4: the ledger closes over a cut [J]", ran.outcome.ledger.numerical.abs(), 1e-9));
    let ran = run(&case_of(&released(timed("rk4", 0.001, RELEASE[1])), &[]));
    claims.push(Claim::below("rk4: the ledger closes over a release [J]", ran.outcome.ledger.numerical.abs(), 1e-9));
    claims.extend(ring());
    claims
}

/// A ring in tension by radial forces F, cut at a time: its nodes then move away as r + F/(2m) t^2. The same on two
/// threads.
fn ring() -> Vec<Claim> {
    let (n, force, mass, stiffness, cut, end) = (12, 3.0, 0.5, 1000.0, 0.3137, 0.8);
    let angle = |i: usize| 2.0 * PI * i as f64 / n as f64;
    let chord = 2.0 * (PI / n as f64).sin();
    let rest = chord - force / chord / stiffness;
    let nodes: Vec<[f64; 3]> = (0..n).map(|i| [angle(i).cos(), angle(i).sin(), 0.0]).collect();
    let edges: Vec<[usize; 2]> = (0..n).map(|i| [i, (i + 1) % n]).collect();
    let pull = |i: usize| json!({"on": {"ids": [i]}, "force": [force * angle(i).cos(), force * angle(i).sin(), 0.0]});
    let case = |method: &str| {
        json!({
            "name": "ring",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": nodes, "springs": edges}},
                "mass": {"nodal": mass},
                "springs": [{"on": "all", "stiffness": stiffness, "rest_length": rest, "slack": "tension-only", "cut": cut}],
                "loads": (0..n).map(pull).collect::<Vec<_>>()
            }},
            "time": timed(method, 0.01, end)
        })
    };
    let radius = 1.0 + 0.5 * force / mass * (end - cut).powi(2);
    let mut claims = Vec::new();
    for method in ["velocity-verlet", "newmark"] {
        let [one, two] = [1, 2].map(|threads| run_with(&case_of(&case(method), &[]), threads));
        let farthest =
            one.positions.iter().map(|p| p[0].hypot(p[1]) - radius).fold(0.0, |most: f64, d| most.max(d.abs()));
        claims.push(Claim::below(format!("{method}: a reefing ring opens when it is cut [m]"), farthest, 1e-9));
        claims.push(Claim::is(format!("{method}: on two threads to the bit"), one.positions == two.positions));
    }
    claims
}
