//! A tube of film that does not stretch, between two plates: R = 1 m, H = 1.2 m apart, 100 Pa inside. The film is flat
//! on the plates over the width pi (R - H/2), as its length is 2 pi R, and round between them; the pressure on what is
//! flat presses the plates. It stands off the plates by less than the gap d, which takes pi d from the width at most.

use crate::claim::Claim;
use crate::common::run::{Run, case_of, run};
use serde_json::json;
use std::f64::consts::{PI, TAU};

/// [m] radius, distance of the plates, gap and width of the strip
const RADIUS: f64 = 1.0;
const HEIGHT: f64 = 1.2;
const GAP: f64 = 1e-4;
const WIDTH: f64 = 0.1;
/// [Pa], [N] pressure, and axial rigidity of each of the two rings of edges, which the pressure stretches by 1e-4
const PRESSURE: f64 = 100.0;
const RIGIDITY: f64 = 3e4;
/// Edges of a ring
const EDGES: usize = 256;

/// A point of the film, this length from the middle of its upper flat part, which begins where the pressure holds it
/// in the gap.
fn place(s: f64) -> [f64; 2] {
    let r = 0.5 * HEIGHT - 0.97 * GAP;
    let flat = PI * (RADIUS - r);
    // The other half is the same, turned by half a turn.
    let turned = s >= PI * RADIUS;
    let s = if turned { s - PI * RADIUS } else { s };
    let [x, z] = if s < 0.5 * flat {
        [-s, r]
    } else if s < 0.5 * flat + PI * r {
        let angle = (s - 0.5 * flat) / r;
        [-0.5 * flat - r * angle.sin(), r * angle.cos()]
    } else {
        [-0.5 * flat + (s - 0.5 * flat - PI * r), -r]
    };
    if turned { [-x, -z] } else { [x, z] }
}

fn pressed() -> Run {
    let edge = TAU * RADIUS / EDGES as f64;
    let nodes: Vec<[f64; 3]> = (0..2 * EDGES)
        .map(|i| {
            let [x, z] = place(edge * (i % EDGES) as f64);
            [x, if i < EDGES { 0.0 } else { WIDTH }, z]
        })
        .collect();
    let next = |i: usize| (i + 1) % EDGES;
    let springs: Vec<[usize; 2]> =
        (0..EDGES).flat_map(|i| [[i, next(i)], [EDGES + i, EDGES + next(i)], [i, EDGES + i]]).collect();
    // Normals out of the tube.
    let triangles: Vec<[usize; 3]> =
        (0..EDGES).flat_map(|i| [[i, next(i), EDGES + i], [next(i), EDGES + next(i), EDGES + i]]).collect();
    let plate = |side: f64| json!({"plane": {"point": [0, 0, 0.5 * HEIGHT * side], "normal": [0, 0, -side]}});
    let case = json!({
        "name": "tube",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "springs": springs, "triangles": triangles}},
            "mass": {"nodal": 1e-3},
            "springs": [{"on": "all", "axial_rigidity": RIGIDITY}],
            "supports": [{"on": "all", "fix": "y"}, {"on": {"ids": [0, EDGES]}, "fix": "x"}],
            "loads": [{"on": "all", "pressure": PRESSURE}],
            "contact": [{"between": ["all", plate(1.0)], "gap": GAP}, {"between": ["all", plate(-1.0)], "gap": GAP}]
        }},
        "time": {"end": 20.0, "method": "backward-euler", "step": 0.1}
    });
    run(&case_of(&case, &[]))
}

/// [m], [N/m] Width of the upper film at half the height, and what pulls it down there.
fn cut(ran: &Run) -> (f64, f64) {
    let (mut width, mut pull) = (0.0, 0.0);
    for i in 0..2 * EDGES {
        let j = if i % EDGES == EDGES - 1 { i + 1 - EDGES } else { i + 1 };
        let length = |x: &[[f64; 3]]| (0..3).map(|c| (x[j][c] - x[i][c]).powi(2)).sum::<f64>().sqrt();
        let [a, b] = [i, j].map(|i| ran.positions[i]);
        if a[2] * b[2] <= 0.0 && a[2] != 0.0 {
            let x = a[0] + (b[0] - a[0]) * a[2] / (a[2] - b[2]);
            width += 0.5 * x.abs();
            let tension = RIGIDITY * (length(&ran.positions) / length(&ran.reference) - 1.0);
            pull += tension * (b[2] - a[2]).abs() / length(&ran.positions) / WIDTH;
        }
    }
    (width, pull)
}

pub fn claims() -> Vec<Claim> {
    let ran = pressed();
    let flat = PI * (RADIUS - 0.5 * HEIGHT);
    let (width, pull) = cut(&ran);
    let edge = TAU * RADIUS / EDGES as f64;
    let touching = ran.positions[..EDGES].iter().filter(|x| x[2] > 0.5 * HEIGHT - GAP).count() as f64;
    let fastest = ran.velocities.iter().flatten().fold(0.0_f64, |most, v| most.max(v.abs()));
    // What the gap takes, as much from stretching, and not quite as much from corners of the round parts.
    let off = 3.0 * PI * GAP;
    vec![
        Claim::below("a tube between plates is at rest [m/s]", fastest, 1e-4),
        Claim::absolute("width on which it touches, by its nodes [m]", (touching - 1.0) * edge, flat, off + edge),
        Claim::absolute("width on which it is flat, by its breadth [m]", width - HEIGHT, flat, off),
        Claim::absolute("tension at half the height [N/m]", 0.5 * pull, 0.5 * PRESSURE * HEIGHT, PRESSURE * off),
        Claim::absolute("force on a plate [N/m]", PRESSURE * width - pull, PRESSURE * flat, PRESSURE * off),
    ]
}
