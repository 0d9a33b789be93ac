//! Newton's iteration in situations where a plausible result would be wrong: large steps past a spring's anchor, scenes
//! of very different stiffness, scenes that start without any force.

mod iteration;
mod mixed;

use crate::common::run::{case_of, run};
use canopy_fem::drive::Status;
use serde_json::{Value, json};

const IMPLICIT: [&str; 6] = ["newmark", "hht", "generalized-alpha", "backward-euler", "esdirk4", "energy-momentum"];

/// Masses on x-directed springs of 1 m from anchors of their own, displaced along x.
struct Bob {
    stiffness: f64,
    displacement: f64,
}

fn bobs(list: &[Bob], method: &str, step: f64) -> Value {
    let mut nodes = Vec::new();
    let mut springs = Vec::new();
    let mut rules = Vec::new();
    let mut displacement = Vec::new();
    for (i, bob) in list.iter().enumerate() {
        nodes.extend([json!([0.0, i as f64, 0.0]), json!([1.0, i as f64, 0.0])]);
        springs.push(json!([2 * i, 2 * i + 1]));
        rules.push(json!({"on": {"ids": [i]}, "stiffness": bob.stiffness}));
        displacement.extend([json!([0.0, 0.0, 0.0]), json!([bob.displacement, 0.0, 0.0])]);
    }
    let anchors: Vec<usize> = (0..list.len()).map(|i| 2 * i).collect();
    json!({
        "name": "bobs",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
            "mass": {"nodal": 1.0},
            "springs": rules,
            "supports": [{"on": {"ids": anchors}, "fix": "xyz"}, {"on": "all", "fix": "yz"}],
            "initial": {"displacement": displacement},
        }},
        "time": {"end": 20.0, "method": method, "step": step},
    })
}

#[test]
fn a_large_step_does_not_carry_a_spring_through_its_anchor() {
    let w = 10.0;
    let first = 0.5 * w * w * 0.1 * 0.1;
    for method in IMPLICIT {
        for wh in [1.0, 4.0, 5.0, 10.0, 30.0] {
            let bob = Bob { stiffness: w * w, displacement: 0.1 };
            let done = run(&case_of(&bobs(&[bob], method, wh / w), &[]));
            assert_eq!(done.outcome.status, Status::Completed, "{method}, w h = {wh}");
            let energy = done.outcome.ledger.kinetic + done.outcome.ledger.elastic;
            assert!(energy <= first * (1.0 + 1e-9), "{method}, w h = {wh}: {energy} J of {first} J");
            assert!(done.positions[1][0] > 0.85, "{method}, w h = {wh}: the mass is at x = {}", done.positions[1][0]);
        }
    }
}

#[test]
fn a_stiff_neighbour_does_not_spoil_a_soft_spring() {
    let amplitude = 1e-4;
    for stiff in [1e6, 1e8, 1e10, 1e12] {
        for (step, tolerance) in [(0.05, 2e-2), (0.01, 2e-3), (0.001, 2e-4)] {
            let soft = Bob { stiffness: 1.0, displacement: amplitude };
            let rigid = Bob { stiffness: stiff, displacement: 0.0 };
            let done = run(&case_of(&bobs(&[soft, rigid], "newmark", step), &[]));
            let found = (done.positions[1][0] - 1.0) / amplitude;
            let exact = 20.0f64.cos();
            assert!((found - exact).abs() < tolerance, "k {stiff:e}, step {step}: {found}, exact {exact}");
        }
    }
}

#[test]
fn a_scene_without_any_force_at_the_start_is_solved() {
    for method in IMPLICIT {
        let case = json!({
            "name": "ramp",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[0.0, 0.0, 0.0]], "springs": []}},
                "mass": {"nodal": 1.0},
                "springs": [],
                "loads": [{"on": {"ids": [0]}, "force": [1.0, 0.0, 0.0], "table": [[0.0, 0.0], [1.0, 1.0]]}],
            }},
            "time": {"end": 1.0, "method": method, "step": 0.01},
        });
        let done = run(&case_of(&case, &[]));
        assert_eq!(done.outcome.status, Status::Completed, "{method}: {:?}", done.outcome.failure);
        // x = t^3/6
        let x = done.positions[0][0];
        assert!((x - 1.0 / 6.0).abs() < 6e-3, "{method}: x = {x}");
    }
}

#[test]
fn a_stiff_spring_is_followed_through_a_turn() {
    // The benchmark of Kuhl and Crisfield (1999) at their step: while the mass moves 8 cm across the spring, the norm
    // of the residual first rises a hundredfold, as it only sees the spring.
    for method in IMPLICIT {
        let case = json!({
            "name": "turn",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[0, 0, 0], [3.0443, 0, 0]], "springs": [[0, 1]]}},
                "mass": {"nodal": [0.0, 10.0]},
                "springs": [{"on": "all", "axial_rigidity": 1e10}],
                "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
                "initial": {"velocity": [[0, 0, 0], [0, 7.72, 0]]}
            }},
            "time": {"end": 0.5, "method": method, "step": 0.01}
        });
        let done = run(&case_of(&case, &[]));
        assert_eq!(done.outcome.status, Status::Completed, "{method}");
        let stages = if method == "esdirk4" { 5 } else { 1 };
        assert!(done.most_iterations <= 14 * stages, "{method}: {} iterations", done.most_iterations);
    }
}
