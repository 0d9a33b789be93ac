//! Runs that end on the ground, in single runs and in studies: what is steady there, and the numbers of the landing.

use crate::bench::{Bench, Results};
use serde_json::{Value, json};

/// [m/s^2]
const G: f64 = 9.81;
/// [m]
const HEIGHT: f64 = 75.0;

/// A body that is thrown along with 3 and 4 m/s from 80 m, over ground at z = 5 m.
fn thrown() -> Value {
    json!({
        "name": "thrown",
        "system": {"network": {
            "mesh": {"explicit": {
                "nodes": [[1, 2, 5.0 + HEIGHT]], "springs": [], "groups": {"payload": {"nodes": [0]}}
            }},
            "mass": {"nodal": 1.0},
            "gravity": [0, 0, -G],
            "initial": {"velocity": [[3, 4, 0]]}
        }},
        "time": {"end": 20.0, "method": "velocity-verlet", "step": 0.01, "until": {"ground": 5.0}},
        "acknowledge": ["loose-nodes"]
    })
}

fn with(case: &Value) -> Bench {
    let bench = Bench::new();
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    bench
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// The columns of the landing are those of the closed forms of free fall, and the runs end there.
#[test]
fn a_sweep_ends_on_the_ground() {
    let bench = with(&thrown());
    let gravity = "system.network.gravity.2=-9.81,-2.5";
    let ended = bench.run(&["sweep", "case.json", "--out", "s", "--vary", gravity]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(!ended.stderr.contains("time.end"), "{}", ended.stderr);
    let table = Results(bench.path("s")).table("sweep.csv");
    for (row, g) in [G, 2.5].into_iter().enumerate() {
        let landed = (2.0 * HEIGHT / g).sqrt();
        for (name, expected) in [
            ("t_end", landed),
            ("landing.time", landed),
            ("landing.speed", (g * landed).hypot(5.0)),
            ("landing.drift", 5.0 * landed),
            ("landing.heading", 3.0_f64.atan2(4.0).to_degrees()),
            ("landing.x", 1.0 + 3.0 * landed),
            ("landing.y", 2.0 + 4.0 * landed),
        ] {
            let found = table.column(name)[row];
            assert!((found - expected).abs() < 1e-7, "{name} with {g}: {found}, not {expected}");
        }
    }
    assert!(Results(bench.path("s")).text("sweep.json").contains("\"landing.speed\""));
}

/// Straight down there is no heading, and where the ground is not reached there is no landing; the rest stays.
#[test]
fn what_a_landing_has_not_is_empty() {
    let mut case = thrown();
    case["system"]["network"]["initial"]["velocity"] = json!([[0, 0, 0]]);
    let bench = with(&case);
    let ended = bench.run(&["sweep", "case.json", "--out", "s", "--vary", "time.end=1,20"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let table = Results(bench.path("s")).table("sweep.csv");
    assert!(table.column("landing.time")[0].is_nan());
    assert_eq!(table.column("t_end")[0], 1.0);
    assert!((table.column("landing.speed")[1] - (2.0 * G * HEIGHT).sqrt()).abs() < 1e-7);
    assert_eq!(table.column("landing.drift")[1], 0.0);
    assert!(table.header.iter().all(|name| name != "landing.heading"), "{:?}", table.header);
}

/// A number of the landing is a quantity with an error; without `time.until` there is none.
#[test]
fn the_landing_is_asked_for_by_name() {
    let bench = with(&thrown());
    let asked = ["--quantity", "landing.speed", "--quantity", "landing.x"];
    let ended = bench.run(&[&["solve", "case.json", "--out", "out", "--verify"][..], &asked].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let landed = (2.0 * HEIGHT / G).sqrt();
    let quantities = &bench.results().summary()["quantities"];
    for (name, expected) in [("landing.speed", (G * landed).hypot(5.0)), ("landing.x", 1.0 + 3.0 * landed)] {
        let of = &quantities[name];
        let (value, error) = (number(&of["value"]), number(&of["error"]));
        assert!((value - expected).abs() <= error.max(1e-9) && error < 1e-6, "{name}: {of}");
    }
    assert!(ended.stdout.contains("quantity        landing.x = "), "{}", ended.stdout);
    let mut free = thrown();
    free["time"].as_object_mut().expect("an object").remove("until");
    std::fs::write(bench.path("case.json"), free.to_string()).expect("written");
    let ended = bench.run(&["solve", "case.json", "--out", "free", "--quantity", "landing.speed"]);
    assert!(ended.code == Some(1) && ended.stderr.contains("no landing without time.until"), "{}", ended.stderr);
}

/// The runs of `require` end on the ground too; those of `tradeoff` do not, and it says so.
#[test]
fn other_studies_of_a_landing() {
    let bench = with(&thrown());
    let ended = bench.run(&["require", "case.json", "--within", "1%", "--out", "r"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(!ended.stderr.contains("time.end"), "{}", ended.stderr);
    assert!(Results(bench.path("r")).text("require.json").contains("landing.speed"));
    let quick = ["--steps", "0.1,0.05", "--methods", "velocity-verlet,rk4", "--repeat", "1"];
    let ended =
        bench.run(&[&["tradeoff", "case.json", "--out", "t", "--quantity", "landing.speed"][..], &quick].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stderr.contains("go on to time.end"), "{}", ended.stderr);
    let table = Results(bench.path("t")).table("tradeoff.csv");
    assert!(table.column("error_landing.speed").iter().all(|error| *error < 1e-6));
}

/// A fall with quadratic drag that lands before `time.end`: v = V tanh(g t/V), which is steady at V. The steady value
/// is the mean over the last tenth of the time of the run, wherever that ends; so for a fall too short to be steady.
#[test]
fn what_is_steady_is_judged_at_the_landing() {
    let (area, density, mass) = (0.5, 1.2, 2.0);
    let terminal = (2.0 * mass * G / (density * area)).sqrt();
    for (height, steady) in [(200.0, true), (4.0, false)] {
        let case = json!({
            "name": "fall",
            "system": {"network": {
                "mesh": {"explicit": {
                    "nodes": [[0, 0, height]], "springs": [], "groups": {"payload": {"nodes": [0]}}
                }},
                "mass": {"nodal": mass},
                "gravity": [0, 0, -G],
                "aero": {"drag": [{"on": {"ids": [0]}, "drag_area": area}], "atmosphere": {"density": density}}
            }},
            "time": {"end": 200.0, "method": "rk4", "step": 0.005, "until": {"ground": 0.0}},
            "output": {"gauges": [{"name": "body", "on": {"ids": [0]}, "of": "speed"}]},
            "acknowledge": ["loose-nodes"]
        });
        let bench = with(&case);
        let ended = bench.run(&["solve", "case.json", "--out", "out", "--quantity", "body.speed.steady"]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        let summary = bench.results().summary();
        let landed = number(&summary["t_end"]);
        let at = |t: f64| (G * t / terminal).cosh().ln() * terminal * terminal / G;
        assert!((at(landed) - height).abs() < 1e-6, "{landed}");
        let mean = (height - at(0.9 * landed)) / (0.1 * landed);
        let found = number(&summary["quantities"]["body.speed.steady"]["value"]);
        // The trapezoidal rule in steps of 5 ms.
        assert!((found / mean - 1.0).abs() < 1e-5, "{found}, not {mean}");
        assert_eq!((found / terminal - 1.0).abs() < 1e-3, steady, "{found} {terminal}");
        assert_eq!(summary["peaks"][0]["steady"], json!(steady), "{}", summary["peaks"]);
    }
}
