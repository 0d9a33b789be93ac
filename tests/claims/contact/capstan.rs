//! A line round a fixed cylinder, pulled by one end: T2/T1 = e^(mu phi) while it slides (Euler, Eytelwein).

use super::CREEP;
use crate::claim::Claim;
use crate::common::run::{case_of, follow};
use serde_json::json;
use std::f64::consts::PI;

/// [m], [m] radius and gap
const RADIUS: f64 = 0.1;
const GAP: f64 = 1e-3;
/// [N] tension of the end that is let go, and axial rigidity
const TENSION: f64 = 10.0;
const RIGIDITY: f64 = 1e4;
const MU: f64 = 0.3;
/// [m/s] at which the other end is pulled, a hundred times what friction creeps with
const SPEED: f64 = 100.0 * CREEP;

/// T2/T1 of a line with so many edges round half a turn, mean over the last part of the pull.
fn ratio(edges: usize) -> f64 {
    let r = RADIUS + 0.5 * GAP;
    // Edges touch at their middles, so corners are further out.
    let corner = r / (PI / (2.0 * edges as f64)).cos();
    let edge = PI * corner / edges as f64;
    let tail = edges / 4 + 6;
    let mut nodes: Vec<[f64; 3]> = Vec::new();
    (0..tail).for_each(|i| nodes.push([-corner, 0.0, edge * (i as f64 - tail as f64)]));
    (0..=edges)
        .map(|i| PI * i as f64 / edges as f64)
        .for_each(|a| nodes.push([-corner * a.cos(), 0.0, corner * a.sin()]));
    (1..=tail).for_each(|i| nodes.push([corner, 0.0, -edge * i as f64]));
    let last = nodes.len() - 1;
    let springs: Vec<[usize; 2]> = (0..last).map(|i| [i, i + 1]).collect();
    let way = 3.0 * edge;
    let end = way / SPEED;
    let case = json!({
        "name": "capstan",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
            "mass": {"nodal": 1e-4},
            "springs": [{"on": "all", "axial_rigidity": RIGIDITY}],
            "supports": [{"on": {"ids": [last]}, "fix": "xyz",
                "motion": {"table": [[0, 0, 0, 0], [end, 0, 0, -way]]}}],
            "loads": [{"on": {"ids": [0]}, "force": [0, 0, -TENSION]}],
            "contact": [{"between": ["all", {"cylinder": {"from": [0, -1, 0], "to": [0, 1, 0], "radius": RADIUS}}],
                "gap": GAP, "friction": MU}]
        }},
        "time": {"end": end, "method": "backward-euler", "step": end / 600.0}
    });
    let case = case_of(&case, &[]);
    let (mut sum, mut count) = (0.0, 0.0);
    let tension = |x: &[[f64; 3]], i: usize| {
        let length = |x: &[[f64; 3]]| (0..3).map(|c| (x[i + 1][c] - x[i][c]).powi(2)).sum::<f64>().sqrt();
        let rest = length(&nodes);
        RIGIDITY * (length(x) / rest - 1.0)
    };
    let outcome = follow(&case, |seen| {
        // The middle of three edges that pass.
        if (end / 3.0..2.0 * end / 3.0).contains(&seen.t) {
            sum += tension(seen.positions, last - 1) / TENSION;
            count += 1.0;
        }
    });
    assert!(outcome.failure.is_none(), "{outcome:?}");
    sum / count
}

pub fn claims() -> Vec<Claim> {
    let expected = (MU * PI).exp();
    // Between two edges the line turns by pi/n, and the polygon's error is of its square.
    [(16, 0.01), (32, 0.0025)]
        .map(|(edges, allowed)| {
            let what = format!("tensions of a line round half a turn, mu = 0.3, {edges} edges: ratio");
            Claim::relative(what, ratio(edges), expected, allowed)
        })
        .to_vec()
}
