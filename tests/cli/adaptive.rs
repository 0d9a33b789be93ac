//! Adaptive steps as a user meets them: flags, frames, counts, words.

use crate::bench::Bench;
use serde_json::json;

/// A tolerance in place of the step: frames stay on their times and change nothing, dropped attempts are counted, and
/// what is shown is within the tolerance of a run in small fixed steps.
#[test]
fn a_tolerance_replaces_the_step() {
    let bench = Bench::new();
    let ended = bench.solve(&["--tolerance", "1e-4", "--set", "output.frames.every=0.07"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stdout.contains("adaptive        tolerance 1e-4 of the motion and 1e-6;"), "{}", ended.stdout);
    let (results, summary) = (bench.results(), bench.results().summary());
    assert_eq!(summary["case"]["time"]["tolerance"], json!({"relative": 1e-4, "absolute": 1e-6}));
    assert!(summary["case"]["time"].get("step").is_none(), "{}", summary["case"]["time"]);
    assert!(summary["rejected_steps"].is_u64() && summary["steps"].as_u64() > Some(20), "{summary}");
    let times: Vec<f64> = results.frames().iter().map(|(time, _)| *time).collect();
    let expected: Vec<f64> = (0..15).map(|k| f64::from(k) * 0.07).chain([1.0]).collect();
    assert_eq!(times.len(), expected.len(), "{times:?}");
    assert!(times.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-12), "{times:?}");
    let tips = || results.table("probes.csv").rows;
    let adaptive = tips();
    let plain = bench.solve(&["--force", "--tolerance", "1e-4", "--set", "output.frames=null"]);
    assert_eq!(plain.code, Some(0), "{}", plain.stderr);
    for key in ["steps", "rejected_steps", "force_evaluations"] {
        assert_eq!(bench.results().summary()[key], summary[key], "frames change {key}");
    }
    let ended = bench.solve(&["--force", "--step", "1e-4", "--method", "rk4", "--set", "output.frames.every=0.07"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let fixed = tips();
    assert_eq!(adaptive.len(), fixed.len());
    for (a, b) in adaptive.iter().zip(&fixed) {
        for column in 3..6 {
            let off = (a[column].parse::<f64>().expect("a number") - b[column].parse::<f64>().expect("a number")).abs();
            assert!(off < 1e-3, "{a:?} and {b:?}");
        }
    }
}

/// `check` tells the tolerance, a step given beside it replaces it, and what is no tolerance is refused with its place.
#[test]
fn flags_of_adaptive_steps() {
    let bench = Bench::new();
    let ended = bench.run(&["check", "sail.json", "--all", "--tolerance", "1e-3"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stdout.contains("adaptive steps, tolerance 1e-3 of the motion and 1e-5"), "{}", ended.stdout);
    for (value, words) in [("2", "below 1"), ("0", "1e-13"), ("fine", "number")] {
        let ended = bench.solve(&["--tolerance", value]);
        assert_eq!(ended.code, Some(2), "{value}: {}", ended.stderr);
        assert!(ended.stderr.contains("time.tolerance") && ended.stderr.contains(words), "{value}: {}", ended.stderr);
    }
    let both = bench.solve(&["--tolerance", "1e-3", "--step", "0.01"]);
    assert_eq!(both.code, Some(2), "{}", both.stderr);
}
