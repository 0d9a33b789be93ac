//! Lines over the rounded edge of a table, and onto a scale. A line of the mass w per length on a table with friction
//! mu, its end a depth y below the table, an edge without friction:
//! ```text
//! rest:     y <= mu L_table            with L_table the length that lies; the height alone counts on the edge
//! sliding:  y = y0 cosh(sqrt(g/L) t)    without friction
//! scale:    F = 3 m(t) g               a chain that falls from rest, m(t) of which lies: m g t^2/(2 L)
//! ```

use super::{CREEP, G, ground};
use crate::claim::Claim;
use crate::common::run::{case_of, follow};
use serde_json::{Value, json};
use std::f64::consts::FRAC_PI_2;

/// [m], [kg], [-] a line, and its edges
const LENGTH: f64 = 1.0;
const MASS: f64 = 0.1;
const SEGMENTS: usize = 80;
/// [-] friction on the table
const MU: f64 = 0.3;
/// [m] radius of the table's edge, and gap
const RADIUS: f64 = 0.05;
const GAP: f64 = 1e-3;
/// [m] where weight holds a line in the gap, or nearly so: kappa is far above the weight over the gap
const OFF: f64 = 0.97 * GAP;

/// A point of a line, this length [m] from its lower end: down to the height of the edge's axis, round it, and along
/// the table.
fn place(s: f64, hanging: f64) -> [f64; 3] {
    let r = RADIUS + OFF;
    let beyond = s - hanging;
    if beyond < 0.0 {
        return [r, 0.0, -RADIUS + beyond];
    }
    let angle = beyond / r;
    if angle < FRAC_PI_2 {
        return [r * angle.cos(), 0.0, -RADIUS + r * angle.sin()];
    }
    [-(beyond - r * FRAC_PI_2), 0.0, OFF]
}

/// A line whose end is at the depth `y` [m] below what lies, on a table with the friction `mu`.
fn on_table(y: f64, mu: f64, time: Value) -> Value {
    let step = LENGTH / SEGMENTS as f64;
    let nodes: Vec<[f64; 3]> = (0..=SEGMENTS).map(|i| place(step * i as f64, y - RADIUS - OFF)).collect();
    let springs: Vec<[usize; 2]> = (0..SEGMENTS).map(|i| [i, i + 1]).collect();
    let edge = json!({"cylinder": {"from": [0, -1, -RADIUS], "to": [0, 1, -RADIUS], "radius": RADIUS}});
    let table = json!({"box": {"min": [-2, -1, -1], "max": [0, 1, 0]}});
    json!({
        "name": "table",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
            "springs": [{"on": "all", "axial_rigidity": 100.0, "linear_density": MASS / LENGTH}],
            "gravity": [0, 0, -G],
            "contact": [
                {"between": ["all", table], "gap": GAP, "friction": mu},
                {"between": ["all", edge], "gap": GAP}
            ]
        }},
        "time": time
    })
}

/// [m], [m/s] Depth and speed of the lower end after a time.
fn slide(y: f64, mu: f64, method: &str, [end, step]: [f64; 2]) -> (f64, f64) {
    let mut last = (0.0, 0.0);
    let case = case_of(&on_table(y, mu, json!({"end": end, "method": method, "step": step})), &[]);
    let outcome = follow(&case, |seen| last = (OFF - seen.positions[0][2], -seen.velocities[0][2]));
    assert!(outcome.failure.is_none(), "{outcome:?}");
    last
}

pub fn edges() -> Vec<Claim> {
    let mut claims = Vec::new();
    // The line stretches by 0.1 % and more at its end, and its corners round the edge are 0.1 mm nearer to the axis.
    for (method, step) in [("velocity-verlet", 5e-5), ("hht", 5e-4), ("backward-euler", 1e-3)] {
        claims.push(Claim::absolute(
            format!("{method}: a line slides off a smooth table, depth of its end after 0.5 s [m]"),
            slide(0.1, 0.0, method, [0.5, step]).0,
            0.1 * ((G / LENGTH).sqrt() * 0.5).cosh(),
            1e-3,
        ));
    }
    let round = (FRAC_PI_2 - 1.0) * (RADIUS + OFF);
    let most = MU * (LENGTH - round) / (1.0 + MU);
    for (share, what) in [(0.95, "less"), (1.05, "more")] {
        let speed = slide(share * most, MU, "backward-euler", [0.6, 2e-3]).1;
        let what = format!("mu = 0.3: 5 % {what} than friction holds hangs over the edge, speed after 0.5 s [m/s]");
        claims.push(if share < 1.0 {
            Claim::below(what, speed, CREEP)
        } else {
            Claim::between(what, speed, 0.05, 0.5)
        });
    }
    claims
}

/// Edges of the chain that falls
const LINKS: usize = 100;

/// Times [s], and what the scale has given to a chain until then [N s]: its momentum and that of its weight. The chain
/// falls upright from just above the scale, and pushes never.
fn fall() -> Vec<(f64, f64)> {
    let mass = MASS / (LINKS + 1) as f64;
    let case = json!({
        "name": "scale",
        "system": {"network": {
            "mesh": {"chain": {"from": [0, 0, 2e-4], "to": [0, 0, LENGTH], "segments": LINKS}},
            "mass": {"nodal": mass},
            "springs": [{"on": "all", "stiffness": 2000.0, "slack": "tension-only"}],
            "gravity": [0, 0, -G],
            "contact": [{"between": ["all", ground()], "gap": 1e-4}]
        }},
        "time": {"end": 0.6, "method": "backward-euler", "step": 1e-3}
    });
    let mut given = Vec::new();
    let outcome = follow(&case_of(&case, &[]), |seen| {
        let momentum = mass * seen.velocities.iter().map(|v| v[2]).sum::<f64>();
        given.push((seen.t, momentum + MASS * G * seen.t));
    });
    assert!(outcome.failure.is_none(), "{outcome:?}");
    given
}

pub fn scale() -> Vec<Claim> {
    let given = fall();
    let at = |t: f64| given.iter().find(|(s, _)| *s >= t - 1e-9).map_or(f64::NAN, |(_, given)| *given);
    let mean = |from: f64, to: f64| (at(to) - at(from)) / (to - from) / (MASS * G);
    // The share that lies is g t^2/(2 L); its mean over a time.
    let lies = |from: f64, to: f64| G * (to.powi(3) - from.powi(3)) / (6.0 * LENGTH * (to - from));
    let mut claims = Vec::new();
    for [from, to] in [[0.1, 0.2], [0.2, 0.3], [0.3, 0.4]] {
        claims.push(Claim::absolute(
            format!("chain that falls on a scale, t = {from} .. {to} s, mean force over its weight [-]"),
            mean(from, to),
            3.0 * lies(from, to),
            // One link more or less that has landed, with the speed g t.
            to / (LINKS as f64 * (to - from)),
        ));
    }
    claims.push(Claim::absolute("all of it lies, force over its weight [-]", mean(0.5, 0.6), 1.0, 1e-6));
    claims
}
