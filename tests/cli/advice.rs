//! What `check` says to take on the scenes of the assets: steps, costs and ratios that belong together.

use crate::bench::Bench;
use serde_json::Value;

fn recommended(case: &str, accuracy: &str) -> Vec<Value> {
    let case = format!("{}/assets/cases/{case}", env!("CARGO_MANIFEST_DIR"));
    let ended = Bench::new().run(&["check", &case, "--within", accuracy, "--json"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let report: Value = serde_json::from_str(&ended.stdout).expect("a report");
    report["recommended"].as_array().cloned().unwrap_or_default()
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} is no number: {value}"))
}

/// Nothing is recommended that costs clearly more than what stands beside it: implicit steps of a net of 10,000 nodes
/// are tried, and the cheapest come first.
#[test]
fn a_net_of_ten_thousand_nodes_is_integrated_with_what_is_cheap_on_it() {
    let told = recommended("big/annulus-10k.json", "1%");
    let seconds: Vec<f64> = told.iter().map(|choice| number(choice, "cpu_seconds")).collect();
    let newmark = told.iter().find(|choice| choice["method"] == "newmark").unwrap_or_else(|| panic!("{told:?}"));
    assert!(number(newmark, "step") > 5e-4, "{newmark}");
    assert!(seconds.windows(2).all(|pair| pair[0] < 2.0 * pair[1]), "{told:?}");
}

/// A method whose own run fails is told so, and another run is recommended if one is found.
#[test]
fn what_fails_is_told_beside_what_runs() {
    let bench = Bench::new();
    let case = format!("{}/assets/cases/oscillator.json", env!("CARGO_MANIFEST_DIR"));
    let ended = bench.run(&["check", &case, "--method", "explicit-euler", "--step", "1.5", "--end", "200", "--json"]);
    let report: Value = serde_json::from_str(&ended.stdout).unwrap_or_else(|e| panic!("{e}: {}", ended.stderr));
    assert!(report["refused"].as_str().is_some_and(|why| why.starts_with("fails at t = ")), "{report}");
    assert_eq!(report["stable"], "no");
}

/// Where a method fails is told as its own run tells it.
#[test]
#[ignore = "long"]
fn a_failure_is_that_of_the_run() {
    let bench = Bench::new();
    let case = format!("{}/assets/cases/parachute-50ms.json", env!("CARGO_MANIFEST_DIR"));
    let ended = bench.run(&["check", &case, "--all", "--json"]);
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
