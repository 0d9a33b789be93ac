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

/// A mass of 1.5 kg on a spring, at rest until something changes at 1.5 s; braked, so that it comes to rest again. What
/// changes stands at a JSON pointer of the network.
fn event(pointer: &str, value: Value) -> Value {
    let mut case = json!({
        "name": "event",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [0.8, 0, 0], [1.6, 0, 0]], "springs": [[0, 1], [1, 2]]}},
            "mass": {"nodal": 1.5},
            "springs": [{"on": {"ids": [0]}, "stiffness": 60.0}, {"on": {"ids": [1]}, "stiffness": 60.0}],
            "supports": [
                {"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [1]}, "fix": "yz"}, {"on": {"ids": [2]}, "fix": "xyz"}
            ],
            "damping": {"rayleigh": {"mass": 4.0}}
        }},
        "time": {"end": 20.0, "method": "newmark", "step": 0.01, "until_rest": {"speed": 1e-4, "every": 0.1}}
    });
    let (above, key) = pointer.rsplit_once('/').expect("a pointer");
    match case.pointer_mut(&format!("/system/network{above}")).expect("it is there") {
        Value::Array(list) => list.push(value),
        other => other[key] = value,
    }
    case
}

/// A run is not at rest while something is still to come: every kind of change. It ends at rest later, but for one
/// whose change goes on; a change after the end of the run does not count.
#[test]
fn a_run_waits_for_what_is_to_come() {
    let vector = |x: f64| json!({"table": [[1.5, 0, 0, 0], [1.6, x, 0, 0]]});
    let drag = json!([{"on": {"ids": [1]}, "drag_area": 0.01}]);
    let load = |rows: Value| json!([{"on": {"ids": [1]}, "force": [3, 0, 0], "table": rows}]);
    let held = json!({"on": {"ids": [1]}, "fix": "x", "until": 1.5});
    let moved = json!([
        {"on": {"ids": [0]}, "fix": "xyz", "motion": vector(0.1)}, {"on": {"ids": [1]}, "fix": "yz"},
        {"on": {"ids": [2]}, "fix": "xyz"}
    ]);
    let mut stretched = event("/supports/-", held);
    stretched["system"]["network"]["springs"][0]["rest_length"] = json!(0.7);
    let mut cut = event("/loads", load(json!([[0, 1]])));
    cut["system"]["network"]["springs"][1]["cut"] = json!(1.5);
    cut["system"]["network"]["initial"] = json!({"displacement": [[0, 0, 0], [0.025, 0, 0], [0, 0, 0]]});
    let mut reeled = event("/damping/rayleigh/mass", json!(4.0));
    reeled["system"]["network"]["springs"][0]["rest_scale"] = json!({"table": [[1.5, 1.0], [1.6, 0.9]]});
    let gust = json!({"gust": {"velocity": [20, 0, 0], "start": 1.5, "duration": 0.4}});
    let cases = [
        ("load", event("/loads", load(json!([[1.5, 0], [1.6, 1]])))),
        ("wind", event("/aero", json!({"drag": drag, "wind": {"table": [[1.5, 0, 0, 0], [1.6, 20, 0, 0]]}}))),
        ("gust", event("/aero", json!({"drag": drag, "wind": gust}))),
        ("base", event("/base_acceleration", vector(1.0))),
        ("release", stretched),
        ("motion", event("/supports", moved)),
        ("cut", cut),
        ("rest length", reeled),
    ];
    for (what, case) in cases {
        let bench = Bench::new();
        let ended = solve(&bench, &case, &[]);
        assert_eq!(ended.code, Some(0), "{what}: {}", ended.stderr);
        let summary = bench.results().summary();
        let end = summary["t_end"].as_f64().expect("a time");
        assert_eq!(summary["at_rest"], json!(true), "{what}");
        assert!((2.5..15.0).contains(&end), "{what}: at rest at {end} s");
        let fastest = bench.results().table("history.csv").column("max_speed").into_iter().fold(0.0, f64::max);
        assert!(fastest > 1e-3, "{what}: {fastest} m/s");
    }
    for (rows, end, at_rest) in [
        (json!([[1.5, 0], [1.6, 1]]), 1.2, true),
        (json!([[0, 0], [1e3, 1e-3]]), 5.0, false),
        (json!([[0, 0], [4.0, 0], [9.0, 0]]), 20.0, true),
    ] {
        let bench = Bench::new();
        let ended = solve(&bench, &event("/loads", load(rows.clone())), &["--end", &end.to_string()]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        let summary = bench.results().summary();
        assert_eq!(summary["at_rest"], json!(at_rest), "{rows}");
        assert_eq!(summary["t_end"].as_f64().expect("a time") < 0.5, at_rest, "{rows}");
    }
    let bench = Bench::new();
    assert_eq!(solve(&bench, &event("/loads", load(json!([[1.5, 0], [1.6, 1]]))), &[]).code, Some(0));
    let probe = bench.results().summary()["final_ledger"]["elastic"].as_f64().expect("an energy");
    // Two springs of 60 N/m share 3 N: 25 mm.
    assert!((probe / (0.5 * 120.0 * 0.025 * 0.025) - 1.0).abs() < 1e-3, "{probe} J");
}

/// Numbers out of range are faults with their place.
#[test]
fn a_speed_of_zero_is_refused() {
    let bench = Bench::new();
    let ended = solve(&bench, &case("rk4", 1.0, json!({"speed": 0.0})), &[]);
    assert!(ended.code == Some(2) && ended.stderr.contains("/time/until_rest/speed"), "{}", ended.stderr);
}
