//! Scenes in which nothing is free at the start: supports let go later, or move.

use super::program::{program, summary};
use crate::common::run::{case_of, run};
use canopy_fem::drive::Status;
use canopy_fem::integrate::registry::methods;
use serde_json::{Value, json};

/// A chain of three masses on springs that is held at its top, and with all its nodes until a time.
fn chain(until: Option<f64>, method: &str, end: f64) -> Value {
    let mut supports = vec![json!({"on": {"ids": [0]}, "fix": "xyz"})];
    supports.extend(until.map(|t| json!({"on": {"ids": [1, 2, 3]}, "fix": "xyz", "until": t})));
    json!({
        "name": "held",
        "system": {"network": {
            "mesh": {"chain": {"from": [0, 0, 0], "to": [0, 0, -1.2], "segments": 3}},
            "mass": {"nodal": 0.5},
            "springs": [{"on": "all", "stiffness": 200.0}],
            "gravity": [0, 0, -9.81],
            "supports": supports
        }},
        "time": {"end": end, "method": method, "step": 0.01}
    })
}

/// From the time at which its supports let go it moves as one that was never held.
#[test]
fn what_is_held_at_first_moves_once_it_is_let_go() {
    for method in methods() {
        let held = run(&case_of(&chain(Some(0.4), method.name, 1.0), &[]));
        let free = run(&case_of(&chain(None, method.name, 0.6), &[]));
        assert_eq!(held.outcome.status, Status::Completed, "{}: {:?}", method.name, held.outcome.failure);
        let fallen = free.positions[3][2] + 1.2;
        for (held, free) in held.positions.iter().zip(&free.positions) {
            // Newton's iterations end within their tolerance.
            assert!((held[2] - free[2]).abs() < 1e-4 * fallen.abs(), "{}: {held:?} for {free:?}", method.name);
        }
    }
}

/// Adaptive steps go through it, too.
#[test]
fn adaptive_steps_let_go() {
    let free = run(&case_of(&chain(None, "dop853", 0.6), &[("time.step", "1e-4")])).positions[3][2];
    for method in ["newmark", "velocity-verlet", "dop853", "esdirk4"] {
        let tolerance = r#"{"relative": 1e-5, "absolute": 1e-8}"#;
        let case = case_of(&chain(Some(0.4), method, 1.0), &[("time.step", "null"), ("time.tolerance", tolerance)]);
        let held = run(&case);
        assert_eq!(held.outcome.status, Status::Completed, "{method}: {:?}", held.outcome.failure);
        assert!((held.positions[3][2] - free).abs() < 1e-4, "{method}: {} for {free}", held.positions[3][2]);
    }
}

/// A spring whose two ends supports move: it has the force of its length, and the run ends where they lead.
#[test]
fn a_scene_of_supports_that_move_runs() {
    for method in methods() {
        let case = json!({
            "name": "moved",
            "system": {"network": {
                "mesh": {"chain": {"from": [0, 0, 0], "to": [1, 0, 0], "segments": 1}},
                "mass": {"nodal": 0.5},
                "springs": [{"on": "all", "stiffness": 200.0}],
                "supports": [
                    {"on": {"ids": [0]}, "fix": "xyz"},
                    {"on": {"ids": [1]}, "fix": "xyz", "motion": {"table": [[0, 0, 0, 0], [0.5, 0.1, 0, 0]]}}
                ]
            }},
            "time": {"end": 1.0, "method": method.name, "step": 0.01}
        });
        let run = run(&case_of(&case, &[]));
        assert_eq!(run.outcome.status, Status::Completed, "{}: {:?}", method.name, run.outcome.failure);
        assert!((run.positions[1][0] - 1.1).abs() < 1e-12, "{}: {:?}", method.name, run.positions);
        // The spring's energy at the end, less the kinetic energy that the node has as long as it moves.
        let (work, needed) = (run.outcome.ledger.external_work, 0.5 * 200.0 * 0.01 - 0.5 * 0.5 * 0.04);
        assert!((work / needed - 1.0).abs() < 1e-9, "{}: {work} J", method.name);
    }
}

/// The program takes such a case: `check`, `solve`, and `static` at a time at which something is free. At another it
/// says so.
#[test]
fn the_program_takes_such_a_case() {
    let folder = tempfile::tempdir().expect("a folder");
    let case = chain(Some(0.4), "newmark", 1.0);
    for args in [&["check"][..], &["solve"]] {
        let run = program(folder.path(), &case, args);
        assert_eq!(run.status, Some(0), "{}{}", run.stdout, run.stderr);
    }
    assert_eq!(summary(folder.path(), "held")["status"], "completed");
    let run = program(folder.path(), &case, &["static", "--force"]);
    assert_eq!(run.status, Some(3), "{}", run.stdout);
    assert!(run.stderr.contains("at t = 0 s every node is held") && run.stderr.contains("at=0.4"), "{}", run.stderr);
    let run = program(folder.path(), &case, &["static", "--force", "--at", "0.4"]);
    assert_eq!(run.status, Some(0), "{}", run.stderr);
    // Sag of the lowest node: (3 + 2 + 1) m g/k.
    let potential = summary(folder.path(), "held")["equilibrium"]["potential_energy"].as_f64().expect("an energy");
    let drop = 0.5 * 9.81 / 200.0;
    let exact = -0.5 * 200.0 * drop * drop * (9.0 + 4.0 + 1.0);
    assert!((potential / exact - 1.0).abs() < 1e-9, "{potential} J of {exact}");
    let never = program(
        folder.path(),
        &chain(None, "newmark", 1.0),
        &["solve", "--force", "--set", "system.network.supports.0.on=all"],
    );
    assert!(never.status == Some(2) && never.stderr.contains("something that can move"), "{}", never.stderr);
}
