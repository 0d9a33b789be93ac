//! Rest lengths that change over time, against closed forms. A winch that reels in a line of rest length L at the rate
//! c moves the point where a mass is at rest: y(t) = -c L (t - sin(w t)/w).

use crate::claim::Claim;
use crate::common::run::{Run, case_of, run, run_with};
use crate::motion::{adaptive, order_of, timed};
use canopy_fem::integrate::registry::{Family, methods};
use serde_json::{Value, json};
use std::f64::consts::PI;

/// [N/m], [kg], [m], [1/s], [s] stiffness, mass, rest length, rate and end of reeling; the run ends at 1 s
const K: f64 = 50.0;
const M: f64 = 2.0;
const LENGTH: f64 = 1.25;
const RATE: f64 = 0.3;
const STOP: f64 = 0.5;
const END: f64 = 1.0;

fn w() -> f64 {
    (K / M).sqrt()
}

/// A mass at rest on a line; its rest length is `LENGTH` times a table.
fn winch(table: Value, slack: bool, time: Value) -> Value {
    let mut spring = json!({"on": "all", "stiffness": K, "rest_length": LENGTH, "rest_scale": {"table": table}});
    if slack {
        spring["slack"] = json!("tension-only");
    }
    json!({
        "name": "winch",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [LENGTH, 0, 0]], "springs": [[0, 1]]}},
            "mass": {"nodal": M},
            "springs": [spring],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}]
        }},
        "time": time
    })
}

fn ramp(time: Value) -> Value {
    winch(json!([[0, 1], [STOP, 1.0 - RATE * STOP]]), false, time)
}

/// [m] of the mass at a time after reeling began, from its start; and [J] its energy with the spring's at the end of
/// it.
fn after(start: f64) -> [f64; 2] {
    let (w, speed, stop) = (w(), RATE * LENGTH, STOP - start);
    let (d, v) = (speed / w * (w * stop).sin(), -speed * (1.0 - (w * stop).cos()));
    let angle = w * (END - STOP);
    [-speed * stop + d * angle.cos() + v / w * angle.sin(), 0.5 * K * d * d + 0.5 * M * v * v]
}

fn x(ran: &Run) -> f64 {
    ran.positions[1][0] - LENGTH
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    for method in methods() {
        let name = method.name;
        let case = case_of(&ramp(timed(name, 5e-4)), &[]);
        let low = case.problem().method.order() == 1 || method.family == Family::MatrixFree;
        let ran = run(&case);
        let tolerance = if low { 3e-3 } else { 2e-6 };
        claims.push(Claim::absolute(format!("{name}: a winch reels in a mass [m]"), x(&ran), after(0.0)[0], tolerance));
        let work = ran.outcome.ledger.external_work;
        let tolerance = if low { 0.03 } else { 2e-5 };
        claims.push(Claim::relative(format!("{name}: work of the winch [J]"), work, after(0.0)[1], tolerance));
    }
    for (name, order, step) in [
        ("explicit-euler", 1.0, 1e-3),
        ("improved-euler-pec", 2.0, 1.0 / 512.0),
        ("velocity-verlet", 2.0, 0.01),
        ("beeman", 3.0, 0.01),
        ("newmark", 2.0, 0.01),
        ("hht", 2.0, 5e-3),
        ("rk4", 4.0, 0.015625),
    ] {
        let found = order_of(&|h| ramp(timed(name, h)), step, &|ran| x(ran) - after(0.0)[0]);
        claims.push(Claim::absolute(format!("{name}: order of a winch"), found, order, 0.15));
    }
    for (name, order, step) in [("improved-euler", 2.0, 1.0 / 128.0), ("rk4", 4.0, 0.015625)] {
        let found = order_of(&|h| ramp(timed(name, h)), step, &|ran| ran.outcome.ledger.external_work - after(0.0)[1]);
        claims.push(Claim::between(format!("{name}: order of the work of a winch"), found, order - 0.2, order + 1.2));
    }
    for (name, bound) in [("newmark", 1e-13), ("rk4", 1e-9), ("dop853", 1e-13), ("velocity-verlet", 2e-5)] {
        let ran = run(&case_of(&ramp(timed(name, 0.002)), &[]));
        claims.push(Claim::below(
            format!("{name}: the ledger closes over a winch [J]"),
            ran.outcome.ledger.numerical,
            bound,
        ));
    }
    for (name, tolerance) in
        [("velocity-verlet", 1e-6), ("newmark", 1e-6), ("dormand-prince", 1e-9), ("dop853", 1e-9), ("kang", 1e-4)]
    {
        let ran = run(&case_of(&ramp(adaptive(name, tolerance)), &[]));
        claims.push(Claim::below(format!("{name}, adaptive: a winch [m]"), x(&ran) - after(0.0)[0], 10.0 * tolerance));
    }
    claims.extend(slack());
    claims.extend(held());
    claims.extend(ring());
    claims
}

/// A slack line that becomes taut while it is reeled in.
fn slack() -> Vec<Claim> {
    let begins = 0.1236;
    let case = |time: Value| winch(json!([[0, 1.0 + RATE * begins], [STOP, 1.0 - RATE * (STOP - begins)]]), true, time);
    let mut claims = Vec::new();
    for (name, tolerance) in [("velocity-verlet", 1e-6), ("newmark", 1e-6), ("dormand-prince", 1e-8)] {
        let ran = run(&case_of(&case(adaptive(name, tolerance)), &[]));
        let what = format!("{name}, adaptive: a slack line becomes taut in a winch [m]");
        claims.push(Claim::below(what, x(&ran) - slack_after(begins), 10.0 * tolerance));
    }
    let ran = run(&case_of(&case(timed("kang", 2.5e-4)), &[]));
    claims.push(Claim::absolute("kang: a slack line becomes taut in a winch [m]", x(&ran), slack_after(begins), 2e-3));
    claims
}

/// The same closed form, as long as the line stays taut; then the mass flies on.
fn slack_after(begins: f64) -> f64 {
    let (w, speed, stop) = (w(), RATE * LENGTH, STOP - begins);
    let (d, v) = (speed / w * (w * stop).sin(), -speed * (1.0 - (w * stop).cos()));
    // e(t) = d cos + v/w sin is 0 at the angle where the line goes slack.
    let mut angle = (-d * w / v).atan();
    if angle <= 0.0 {
        angle += PI;
    }
    let left = END - STOP - angle / w;
    let y = -speed * stop;
    if left <= 0.0 {
        let angle = w * (END - STOP);
        return y + d * angle.cos() + v / w * angle.sin();
    }
    y + left * (v * angle.cos() - d * w * angle.sin())
}

/// Between held ends the tension is linear in s, and so the work is exact.
fn held() -> Vec<Claim> {
    let case = |method: &str, step: f64| {
        json!({
            "name": "held",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0], [5, 0, 0]], "springs": [[0, 1]]}},
                "mass": {"nodal": 1.0},
                "springs": [{"on": "all", "axial_rigidity": 80.0, "rest_length": 0.8,
                             "rest_scale": {"table": [[0.0, 1.0], [0.25, 0.5], [0.5, 1.5]]}}],
                "supports": [{"on": {"ids": [0, 1]}, "fix": "xyz"}]
            }},
            "time": timed(method, step)
        })
    };
    let energy = |s: f64| 0.5 * 100.0 * (1.0 - 0.8 * s) * (1.0 - 0.8 * s);
    let mut claims = Vec::new();
    for name in ["velocity-verlet", "newmark", "rk4", "improved-euler-pec", "explicit-euler"] {
        let ran = run(&case_of(&case(name, 0.0625), &[]));
        let work = energy(1.5) - energy(1.0);
        let name = format!("{name}: work on a bar between held ends [J]");
        claims.push(Claim::absolute(name, ran.outcome.ledger.external_work, work, 1e-12));
    }
    claims
}

/// A ring of n masses is drawn together by its line: its radius is r0 (1 - c (t - sin(w t)/w)), w^2 = 4 k
/// sin^2(pi/n)/m.
fn ring() -> Vec<Claim> {
    let (n, mass, stiffness, rate) = (12, 0.5, 400.0, 0.4);
    let half = (PI / n as f64).sin();
    let angle = |i: usize| 2.0 * PI * i as f64 / n as f64;
    let nodes: Vec<[f64; 3]> = (0..n).map(|i| [angle(i).cos(), angle(i).sin(), 0.0]).collect();
    let edges: Vec<[usize; 2]> = (0..n).map(|i| [i, (i + 1) % n]).collect();
    let case = |method: &str| {
        json!({
            "name": "ring",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": nodes, "springs": edges}},
                "mass": {"nodal": mass},
                "springs": [{"on": "all", "stiffness": stiffness, "rest_scale": {"table": [[0, 1], [2, 1.0 - 2.0 * rate]]}}]
            }},
            "time": timed(method, 5e-4)
        })
    };
    let w = (4.0 * stiffness * half * half / mass).sqrt();
    let radius = 1.0 - rate * (END - (w * END).sin() / w);
    let mut claims = Vec::new();
    for name in ["velocity-verlet", "newmark", "rk4"] {
        let [one, two] = [1, 2].map(|threads| run_with(&case_of(&case(name), &[]), threads));
        let radii = one.positions.iter().map(|p| p[0].hypot(p[1]) - radius);
        let farthest = radii.fold(0.0, |most: f64, off| most.max(off.abs()));
        claims.push(Claim::below(format!("{name}: a reefing line draws a ring together [m]"), farthest, 1e-6));
        claims.push(Claim::is(format!("{name}: on two threads to the bit"), one.state == two.state));
    }
    claims
}
