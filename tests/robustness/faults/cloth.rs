//! Cloth too soft for its loads, and starts from runs that failed: what a run says of them.

use super::program::{program, summary};
use serde_json::{Value, json};

/// A sheet of 1 m, held all round, under a pressure [Pa].
fn sheet(stiffness: f64, pressure: f64) -> Value {
    json!({
        "name": "sheet",
        "system": {"network": {
            "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 4, "rows": 4}},
            "mass": {"areal_density": 0.1},
            "springs": [{"on": "all", "stiffness": stiffness, "dashpot": {"axial": {"coefficient": 0.2}}}],
            "supports": [{"on": "outer", "fix": "xyz"}],
            "loads": [{"on": "all", "pressure": pressure}]
        }},
        "time": {"end": 0.4, "method": "newmark", "step": 2e-3}
    })
}

/// Membranes of a modulus [Pa] in place of its springs.
fn of_membranes(mut case: Value, modulus: f64) -> Value {
    let network = case["system"]["network"].as_object_mut().expect("an object");
    network.remove("springs");
    let law = json!({"on": "all", "thickness": 1e-4, "modulus": modulus, "poisson": 0.3, "wrinkling": true});
    network.insert("membranes".to_owned(), json!([law]));
    case["system"]["network"]["damping"] = json!({"rayleigh": {"mass": 10.0}});
    case
}

#[test]
fn cloth_strained_beyond_what_it_bears_is_warned_of() {
    let folder = tempfile::tempdir().expect("a folder");
    for (case, soft) in [
        (sheet(5.0, 20.0), true),
        (sheet(5000.0, 20.0), false),
        (of_membranes(sheet(1.0, 20.0), 5e4), true),
        (of_membranes(sheet(1.0, 20.0), 5e7), false),
    ] {
        let run = program(folder.path(), &case, &["solve", "--force"]);
        assert_eq!(run.status, Some(0), "{}{}", run.stdout, run.stderr);
        assert_eq!(run.stderr.contains("[strained-cloth]"), soft, "{}", run.stderr);
        if soft {
            assert!(run.stderr.contains("the cloth is too soft for its loads"), "{}", run.stderr);
        }
        let mut known = case.clone();
        known["acknowledge"] = json!(["strained-cloth"]);
        let run = program(folder.path(), &known, &["solve", "--force"]);
        assert!(!run.stderr.contains("[strained-cloth]"), "{}", run.stderr);
    }
    // A line of rubber is no cloth.
    let rubber = json!({
        "name": "rubber",
        "system": {"network": {
            "mesh": {"chain": {"from": [0, 0, 0], "to": [0, 0, -1], "segments": 1}},
            "mass": {"nodal": 1.0},
            "springs": [{"on": "all", "stiffness": 10.0}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "gravity": [0, 0, -9.81]
        }},
        "time": {"end": 2.0, "method": "newmark", "step": 0.01}
    });
    let run = program(folder.path(), &rubber, &["solve"]);
    assert!(run.status == Some(0) && run.stderr.is_empty(), "{}", run.stderr);
}

/// A balloon whose cloth is softer than pressure times radius has no equilibrium: a step that cannot be solved, or a
/// search that finds none, names the cause.
#[test]
fn a_balloon_too_soft_for_its_pressure_is_told_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let nodes = [
        [-1.0, g, 0.0],
        [1.0, g, 0.0],
        [-1.0, -g, 0.0],
        [1.0, -g, 0.0],
        [0.0, -1.0, g],
        [0.0, 1.0, g],
        [0.0, -1.0, -g],
        [0.0, 1.0, -g],
        [g, 0.0, -1.0],
        [g, 0.0, 1.0],
        [-g, 0.0, -1.0],
        [-g, 0.0, 1.0],
    ];
    let triangles = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    let balloon = |pressure: f64| {
        json!({
            "name": "balloon",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": nodes, "triangles": triangles}},
                "mass": {"areal_density": 0.1},
                "springs": [{"on": "all", "stiffness": 100.0, "dashpot": {"axial": {"coefficient": 1.0}}}],
                "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
                "loads": [{"on": "all", "pressure": pressure}]
            }},
            "time": {"end": 2.0, "method": "newmark", "step": 0.05}
        })
    };
    let good = program(folder.path(), &balloon(5.0), &["static"]);
    assert_eq!(good.status, Some(0), "{}", good.stderr);
    for args in [&["static", "--force"][..], &["solve", "--force"]] {
        let run = program(folder.path(), &balloon(500.0), args);
        assert_eq!(run.status, Some(3), "{args:?}: {}{}", run.stdout, run.stderr);
        assert!(run.stderr.contains("the cloth is too soft for its loads"), "{args:?}: {}", run.stderr);
        let cause = summary(folder.path(), "balloon")["failure"]["cause"].to_string();
        assert!(cause.contains("too soft"), "{args:?}: {cause}");
    }
}

/// A start from what a failed run left is warned of; from one that completed, and from a lone frame, nothing is said.
#[test]
fn a_start_from_a_run_that_failed_is_warned_of() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut bad = sheet(500.0, 20.0);
    bad["time"] = json!({"end": 1.0, "method": "velocity-verlet", "step": 0.05});
    let run = program(folder.path(), &bad, &["solve", "--out", "bad"]);
    assert_eq!(run.status, Some(3), "{}", run.stderr);
    let run = program(folder.path(), &sheet(500.0, 20.0), &["solve", "--out", "good"]);
    assert_eq!(run.status, Some(0), "{}", run.stderr);
    std::fs::copy(folder.path().join("bad/frames/sheet_000000.vtu"), folder.path().join("alone.vtu")).expect("copied");
    for (from, warned) in [
        (json!("bad"), true),
        (json!({"frame": "bad/frames/sheet_000000.vtu"}), true),
        (json!("good"), false),
        (json!({"frame": "alone.vtu"}), false),
    ] {
        let mut next = sheet(500.0, 20.0);
        next["system"]["network"]["initial"] = json!({"from": from});
        let run = program(folder.path(), &next, &["solve", "--force"]);
        assert_eq!(run.stderr.contains("[failed-start]"), warned, "{from}: {}", run.stderr);
        assert_eq!(run.stderr.contains("the run in bad diverged"), warned, "{from}: {}", run.stderr);
    }
}
