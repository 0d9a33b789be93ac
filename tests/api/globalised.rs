//! Newton far from the solution: a flat canopy loaded suddenly, stiff chains thrown into their shape, in steps up to a
//! thousand times the explicit limit. Every step must converge, and to the branch that small steps reach.

use crate::common::run::{asset, case_of, changed, run};
use crate::common::{patch, spring_group};
use canopy_fem::assembly::TangentSystem;
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::model::spec::Slack;
use canopy_fem::model::system::System;
use canopy_fem::scene::build_network;
use serde_json::json;

/// [N/m]
const STIFFNESS: [&str; 4] = ["1e3", "1e4", "1e5", "1e6"];
/// Steps [s] and ends [s].
const STEPS: [[&str; 2]; 3] = [["1e-3", "0.01"], ["1e-2", "0.2"], ["1e-1", "1"]];

/// The thesis' canopy without dashpots under a sudden load.
fn canopy(sets: &[(&str, &str)]) -> Case {
    let bare = [("system.network.springs.0.dashpot", "null"), ("time.method", "newmark"), ("output", "{}")];
    changed(&asset("cloth-k1000", &bare), sets)
}

fn every_step_converges(base: &Case) {
    for k in STIFFNESS {
        for [step, end] in STEPS {
            let sets = [("system.network.springs.0.stiffness", k), ("time.step", step), ("time.end", end)];
            let outcome = run(&changed(base, &sets)).outcome;
            assert_eq!(outcome.status, Status::Completed, "K {k}, step {step}: {:?}", outcome.failure);
        }
    }
}

#[test]
fn a_flat_canopy_under_a_sudden_dead_pressure_converges_in_every_step() {
    let load = r#"[{"on": "all", "pressure": 60.0, "kind": "dead", "direction": [0, 0, 1]}]"#;
    let base = canopy(&[("system.network.aero", "null"), ("system.network.loads", load)]);
    every_step_converges(&base);
    every_step_converges(&changed(&base, &[("system.network.springs.0.slack", "tension-only")]));
    // Forty times lighter, so that buckling meets less inertia.
    every_step_converges(&changed(&base, &[("system.network.mass.areal_density", "0.05")]));
}

#[test]
fn a_flat_canopy_under_a_pressure_that_follows_converges_in_every_step() {
    let load = r#"[{"on": "all", "pressure": 60.0, "kind": "follower"}]"#;
    every_step_converges(&canopy(&[("system.network.aero", "null"), ("system.network.loads", load)]));
}

#[test]
fn a_flat_canopy_in_a_sudden_wind_converges_in_every_step() {
    every_step_converges(&canopy(&[]));
}

/// Mass damping brings the canopy to rest; the rest does not remember the steps.
#[test]
fn large_steps_end_on_the_branch_of_small_ones() {
    let load = r#"[{"on": "all", "pressure": 60.0, "kind": "dead", "direction": [0, 0, 1]}]"#;
    let damping = r#"{"rayleigh": {"mass": 20.0}}"#;
    for k in ["1e3", "1e5"] {
        let base = canopy(&[
            ("system.network.aero", "null"),
            ("system.network.loads", load),
            ("system.network.damping", damping),
            ("system.network.springs.0.stiffness", k),
            ("time.method", "backward-euler"),
            ("time.end", "4"),
        ]);
        let ends = ["5e-3", "1e-1", "1"].map(|step| {
            let done = run(&changed(&base, &[("time.step", step)]));
            assert_eq!(done.outcome.status, Status::Completed, "K {k}, step {step}: {:?}", done.outcome.failure);
            done.positions
        });
        let highest = ends[0].iter().fold(0.0_f64, |m, p| m.max(p[2]));
        for end in &ends[1..] {
            let off = ends[0].iter().zip(end).flat_map(|(a, b)| (0..3).map(move |c| (a[c] - b[c]).abs()));
            let off = off.fold(0.0, f64::max);
            assert!(off < 2e-3 * highest, "K {k}: {off} m of {highest} m apart");
        }
    }
}

/// A chain of nearly inextensible links that starts as an arc with its links a little too short: the residual of the
/// links hides everything else from a search that looks at its norm.
#[test]
fn a_stiff_chain_finds_its_catenary() {
    let links = 40_usize;
    let nodes: Vec<[f64; 3]> = (0..=links)
        .map(|i| {
            let a = std::f64::consts::PI * (i as f64 / links as f64 - 0.5);
            [a.sin(), 0.0, -a.cos()]
        })
        .collect();
    let springs: Vec<[usize; 2]> = (0..links).map(|i| [i, i + 1]).collect();
    for step in [0.02, 0.5] {
        let case = json!({
            "name": "chain",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
                "mass": {"nodal": 1.0 / 9.81 / links as f64},
                "springs": [{"on": "all", "axial_rigidity": 1e5, "rest_scale": 1.001}],
                "supports": [{"on": {"ids": [0, links]}, "fix": "xyz"}],
                "gravity": [0, 0, -9.81],
                "damping": {"rayleigh": {"mass": 10.0}}
            }},
            "time": {"end": 10.0, "method": "backward-euler", "step": step}
        });
        let done = run(&case_of(&case, &[]));
        assert_eq!(done.outcome.status, Status::Completed, "step {step}: {:?}", done.outcome.failure);
        let lowest = done.positions.iter().fold(0.0_f64, |m, p| m.min(p[2]));
        // y = a cosh(x/a) of length pi over a span of 2: a = 0.5816, sag a (cosh(1/a) - 1) = 1.0934; links of pi/40 are
        // off by less than 1 %.
        assert!((lowest + 1.0934).abs() < 0.02, "step {step}: sag {lowest}");
    }
}

/// A first guess is looked at half way only where a spring points away from where it pointed, or has no direction:
/// nodes of the patch are 1 m apart.
#[test]
fn a_spring_that_turns_over_is_seen() {
    let mut spec = patch();
    spec.springs = vec![spring_group(&spec, Slack::None)];
    let scene = build_network(spec, Threads::one()).expect("the fixture is sound");
    let from = scene.initial_state().x;
    for node in 0..from.len() / 3 {
        for (distance, expected) in [(0.0, false), (0.4, false), (2.5, true)] {
            for direction in 0..2 {
                let mut to = from.clone();
                // Away from the middle of the patch springs only get longer.
                let outwards = if from[3 * node + direction] < 1.0 { -1.0 } else { 1.0 };
                to[3 * node + direction] -= outwards * distance;
                assert_eq!(scene.turns_over(&from, &to), expected, "node {node} moved by {distance} m");
            }
        }
    }
    let together = vec![0.5; from.len()];
    assert!(scene.turns_over(&from, &together) && scene.turns_over(&together, &from));
}
