//! Runs that end once their scene is at rest.

use crate::bench::{Bench, Ended, Results};
use serde_json::{Value, json};

/// A weight of 2 kg that falls onto a damped spring, and would move for 100 s.
fn case(method: &str, damping: f64, until_rest: Value) -> Value {
    json!({
        "name": "drop",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [0, 0, -1]], "springs": [[0, 1]]}},
            "mass": {"nodal": 2.0},
            "springs": [{"on": "all", "stiffness": 100.0, "dashpot": {"axial": {"coefficient": damping}}}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "gravity": [0, 0, -9.81]
        }},
        "time": {"end": 100.0, "method": method, "step": 0.01, "until_rest": until_rest},
        "output": {"probes": [{"name": "weight", "on": {"ids": [1]}}], "checkpoint": {"every": 1.0}}
    })
}

fn solve(bench: &Bench, case: &Value, arguments: &[&str]) -> Ended {
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    bench.run(&[&["solve", "case.json", "--out", "out"], arguments].concat())
}

/// The end is at rest, at a multiple of `every`, with a last frame and row there, for methods with and without blocks.
#[test]
fn a_run_ends_at_rest() {
    for method in ["velocity-verlet", "newmark", "rk4"] {
        let bench = Bench::new();
        let ended = solve(&bench, &case(method, 10.0, json!({"speed": 1e-6, "every": 0.5})), &[]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        assert!(ended.stdout.contains("at rest         yes"), "{}", ended.stdout);
        let results = bench.results();
        let summary = results.summary();
        assert_eq!([&summary["status"], &summary["at_rest"]], [&json!("completed"), &json!(true)]);
        let end = summary["t_end"].as_f64().expect("a time");
        // exp(-2.5 t) of 1.4 m/s is 1e-6 at 5.7 s.
        assert!((4.0..8.0).contains(&end) && (2.0 * end - (2.0 * end).round()).abs() < 1e-9, "{method}: {end}");
        let history = results.table("history.csv");
        assert_eq!(history.column("t").last(), Some(&end));
        assert!(history.column("max_speed").last().expect("a row") <= &1e-6);
        let probes = results.table("probes.csv");
        assert_eq!(probes.column("t").last(), Some(&end));
        let z = *probes.column("z").last().expect("a row");
        assert!((z + 1.0 + 2.0 * 9.81 / 100.0).abs() < 1e-6, "{z}");
        let again = solve(&bench, &case(method, 10.0, json!({"speed": 1e-6, "every": 0.5})), &["--resume"]);
        assert!(again.code == Some(0) && again.stdout.contains("nothing is left"), "{}{}", again.stdout, again.stderr);
    }
}

/// A weight that turns round is not at rest, however slow it is there; nor is one that swings on.
#[test]
fn a_turning_point_is_no_rest() {
    let bench = Bench::new();
    let ended = solve(&bench, &case("rk4", 0.0, json!({"speed": 0.05, "every": 0.01})), &["--end", "20"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let summary = bench.results().summary();
    assert_eq!([&summary["at_rest"], &summary["t_end"]], [&json!(false), &json!(20.0)]);
    let slowest = bench.results().table("history.csv").column("max_speed").into_iter().skip(1).fold(1.0, f64::min);
    assert!(slowest < 0.05, "some row is slow: {slowest}");
}

/// A run that was stopped by its end and goes on ends at rest where an uninterrupted one does, with its bytes.
#[test]
fn a_resumed_run_ends_at_the_same_step() {
    let rest = || json!({"speed": 1e-6, "every": 0.5});
    let whole = Bench::new();
    assert_eq!(solve(&whole, &case("velocity-verlet", 10.0, rest()), &["--quiet"]).code, Some(0));
    let parts = Bench::new();
    assert_eq!(solve(&parts, &case("velocity-verlet", 10.0, rest()), &["--quiet", "--end", "2"]).code, Some(0));
    assert_eq!(parts.results().summary()["at_rest"], json!(false));
    let ended = solve(&parts, &case("velocity-verlet", 10.0, rest()), &["--quiet", "--resume"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let history = |bench: &Bench| Results(bench.path("out")).table("history.csv").rows.last().cloned();
    assert_eq!(history(&parts), history(&whole));
}

/// Numbers out of range are faults with their place.
#[test]
fn a_speed_of_zero_is_refused() {
    let bench = Bench::new();
    let ended = solve(&bench, &case("rk4", 1.0, json!({"speed": 0.0})), &[]);
    assert!(ended.code == Some(2) && ended.stderr.contains("/time/until_rest/speed"), "{}", ended.stderr);
}
