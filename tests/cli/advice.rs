//! What `check` says to take on the scenes of the assets: steps, costs and ratios that belong together.

use crate::bench::Bench;
use serde_json::Value;

fn advice(case: &str, accuracy: &str) -> Value {
    let case = format!("{}/assets/cases/{case}", env!("CARGO_MANIFEST_DIR"));
    let ended = Bench::new().run(&["check", &case, "--accuracy", accuracy, "--json"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let report: Value = serde_json::from_str(&ended.stdout).expect("a report");
    report["advice"].clone()
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} is no number: {value}"))
}

/// The step of an implicit runner-up was run, makes about the error that is wanted, and goes with the root of the
/// accuracy; its ratio to the best is that of the work of the two runs that are told.
#[test]
fn a_runner_up_is_measured_as_the_best_is() {
    let steps = ["1e-3", "1e-2"].map(|accuracy| {
        let told = advice("cloth-k100.json", accuracy);
        let (best, other) = (&told["best"], &told["runner_up"]);
        assert_eq!([&best["method"], &other["method"]], ["velocity-verlet", "newmark"], "{told}");
        assert_eq!(other["known_by"], "run", "{other}");
        let (error, wanted): (f64, f64) = (number(other, "step_error"), accuracy.parse().expect("a number"));
        assert!(error <= wanted && error > wanted / 5.0, "{other}");
        let factor = number(other, "integration_seconds") / number(best, "integration_seconds");
        assert!((number(&told, "factor") / factor - 1.0).abs() < 1e-9, "{told}");
        // A step of Newmark's with a kept matrix costs two to twelve force passes or so, one of Verlet's nearly two.
        let steps = |choice: &Value| number(&choice["fixed"], "steps");
        let dearer = factor * steps(best) / steps(other);
        assert!(dearer > 1.0 && dearer < 8.0, "{dearer} times dearer a step: {told}");
        number(other, "step")
    });
    assert!(steps[1] / steps[0] < 5.0, "{steps:?}");
}

/// Nothing is recommended that costs clearly more than what stands in the same table: implicit steps of a net of 10,000
/// nodes are tried, a second pass at the same positions is no full one, and one that only the account needs is one.
#[test]
fn a_net_of_ten_thousand_nodes_is_integrated_with_what_is_cheap_on_it() {
    let told = advice("big/annulus-10k.json", "1e-3");
    let [best, other] = ["best", "runner_up"].map(|which| &told[which]);
    assert_eq!([&best["method"], &other["method"]], ["newmark", "velocity-verlet"], "{told}");
    assert_eq!([&best["known_by"], &other["known_by"]], ["run", "run"], "{told}");
    assert!(number(best, "step") > 5e-4, "{best}");
}

/// Where a method fails is told as its own run tells it.
#[test]
#[ignore = "long"]
fn a_failure_is_that_of_the_run() {
    let bench = Bench::new();
    let case = format!("{}/assets/cases/parachute-50ms.json", env!("CARGO_MANIFEST_DIR"));
    let ended = bench.run(&["check", &case, "--json"]);
    let report: Value = serde_json::from_str(&ended.stdout).expect("a report");
    let rows = report["methods"].as_array().expect("rows");
    let row = rows.iter().find(|row| row["method"] == "euler-richardson").expect("a row");
    let refused = row["refused"].as_str().unwrap_or_else(|| panic!("{row}"));
    let step = number(row, "step").to_string();
    let ended =
        bench.run(&["solve", &case, "--method", "euler-richardson", "--step", &step, "--out", "out", "--quiet"]);
    assert_eq!(ended.code, Some(3), "{}", ended.stderr);
    let time = number(&bench.results().summary()["failure"], "time");
    assert!(refused.starts_with(&format!("fails at t = {time:.3e} s: ")), "{refused}; {time:e}");
}
