//! Contact as the program tells it: runs that are interrupted and go on, and any number of threads.

use crate::bench::{Bench, contents};
use serde_json::{Value, json};
use std::ffi::OsString;

/// A sheet that falls on a ball and folds over it, with friction; it touches the ball from 0.1 s on and itself later.
fn case(method: &str) -> Value {
    let step = if method == "velocity-verlet" { 2e-4 } else { 2e-3 };
    json!({
        "name": "on-a-ball",
        "system": {"network": {
            "mesh": {"rectangle": {"width": 0.5, "height": 0.5, "columns": 9, "rows": 9}},
            "mass": {"areal_density": 0.2},
            "springs": [{"on": "all", "stiffness": 200, "dashpot": {"relative": {"coefficient": 0.01}}}],
            "gravity": [0, 0, -9.81],
            "contact": [
                {"between": "self", "gap": 0.01, "friction": 0.3},
                {"between": ["all", {"sphere": {"center": [0.25, 0.25, -0.14], "radius": 0.1}}],
                    "gap": 0.01, "friction": 0.3}
            ]
        }},
        "time": {"end": 0.3, "method": method, "step": step},
        "output": {"history": {"every": 1}, "checkpoint": {"every": 0.05}}
    })
}

const METHODS: [&str; 5] = ["newmark", "hht", "backward-euler", "energy-momentum", "velocity-verlet"];

/// The tables of a run that is made in parts.
fn tables(case: &Value, parts: &[&[&str]]) -> Vec<(Option<OsString>, Vec<u8>)> {
    let bench = Bench::new();
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    for arguments in parts {
        let ended = bench.run(&[&["solve", "case.json", "--out", "out"], *arguments].concat());
        assert_eq!(ended.code, Some(0), "{case} {arguments:?}: {}", ended.stderr);
    }
    // In free fall it were -0.22 J.
    let gravity = bench.results().summary()["final_ledger"]["gravity"].as_f64();
    assert!(gravity.is_some_and(|energy| energy > -0.1), "the ball does not hold it: {gravity:?} J");
    let all = contents(&bench.path("out"));
    let tables = all.into_iter().filter(|(path, _)| path.extension().is_some_and(|ending| ending == "csv"));
    tables.map(|(path, bytes)| (path.file_name().map(std::ffi::OsStr::to_owned), bytes)).collect()
}

/// A run that is stopped before and amid contact goes on to the same tables, and two threads have those of one.
#[test]
fn resumed_runs_and_threads_have_the_same_bytes() {
    for method in METHODS {
        let case = case(method);
        let whole = tables(&case, &[&["--threads", "1"]]);
        let parts = tables(&case, &[&["--end", "0.05"], &["--end", "0.2", "--resume"], &["--resume"]]);
        let threads = tables(&case, &[&["--threads", "2"]]);
        assert!(!whole.is_empty() && whole == parts, "{method}: resumed");
        assert!(whole == threads, "{method}: threads");
    }
}

/// What a gauge of contact measures leaves no trace in the run, and is the same in a resumed one. At first nothing
/// touches, and the load on the ball is 0; later the ball carries a part of 0.05 kg.
#[test]
fn gauges_of_contact_leave_no_trace() {
    let named = |tables: &[(Option<OsString>, Vec<u8>)], name: &str| {
        let found = tables.iter().find(|(path, _)| path.as_ref().is_some_and(|path| path == name));
        found.map(|(_, bytes)| bytes.clone()).unwrap_or_default()
    };
    for method in ["newmark", "velocity-verlet"] {
        let without = case(method);
        let mut with = without.clone();
        with["output"]["gauges"] = json!([
            {"name": "ball", "on": {"contact": 1}, "of": "contact"},
            {"name": "folds", "on": {"contact": 0}, "of": "contact"}
        ]);
        let (without, whole) = (tables(&without, &[&[]]), tables(&with, &[&[]]));
        assert!(named(&without, "history.csv") == named(&whole, "history.csv"), "{method}: it leaves a trace");
        let parts = tables(&with, &[&["--end", "0.2"], &["--resume"]]);
        assert!(named(&whole, "gauges.csv") == named(&parts, "gauges.csv"), "{method}: resumed");
        let text = String::from_utf8(named(&whole, "gauges.csv")).expect("text");
        let column = |gauge: &str, column: &str| {
            let rows = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
            let of = rows.filter(|row| row[1..3] == [gauge, column]);
            of.map(|row| row[3].parse::<f64>().expect("a number")).collect::<Vec<f64>>()
        };
        let down = column("ball", "contact_z");
        assert_eq!(down.first(), Some(&0.0), "{method}");
        let most = down.iter().fold(0.0, |most: f64, force| most.max(-force));
        assert!(most > 0.3 && most < 20.0, "{method}: {most} N on the ball");
        assert!(down.iter().all(|force| *force < 0.05), "{method}: the ball pulls");
        assert!(column("folds", "contact_total").iter().all(|force| *force == 0.0), "{method}");
    }
}

/// A step that cannot be solved names the pair that presses most where the residual is largest.
#[test]
fn a_step_that_cannot_be_solved_names_its_pair() {
    let bench = Bench::new();
    let case = json!({"name": "pressed", "system": {"network": {
        "mesh": {"rectangle": {"width": 0.4, "height": 0.4, "columns": 4, "rows": 4}},
        "mass": {"nodal": 0.1},
        "springs": [{"on": "all", "stiffness": 100.0}],
        "contact": [
            {"between": "self", "gap": 0.01},
            {"between": ["all", {"plane": {"point": [0, 0, -0.001], "normal": [0, 0, 1]}}], "gap": 0.01}
        ]}},
        "time": {"end": 0.5, "method": "newmark", "step": 0.1},
        "solver": {"newton": {"max_iterations": 1}}});
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    let ended = bench.run(&["solve", "case.json", "--out", "out"]);
    assert_ne!(ended.code, Some(0), "{}", ended.stdout);
    let failure = bench.results().summary()["failure"].clone();
    let words = format!("node {} and obstacle 1", failure["node"]);
    assert_eq!(failure["pair"], words, "{failure}");
    assert!(ended.stderr.contains(&format!("pressed most between {words}")), "{}", ended.stderr);
}
