//! Inflated and tensile structures as a user of the program meets them: gauges of a gas, steps of the loads, loads that
//! do not act yet, the strength of membranes.

use crate::bench::{Bench, Ended};
use crate::common::octahedron;
use serde_json::{Value, json};

/// [Pa], [-] of the gas below
const AMBIENT: f64 = 101_325.0;
const GAMMA: f64 = 1.4;
/// \[m^3\] of the octahedron
const START: f64 = 4.0 / 3.0 * 0.343;

fn run(bench: &Bench, command: &str, case: &Value, more: &[&str]) -> Ended {
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    let out: &[&str] = if command == "check" { &[] } else { &["--out", "out", "--force"] };
    bench.run(&[&[command, "case.json"], out, more].concat())
}

fn good(ended: Ended) -> String {
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    ended.stdout
}

/// A bag of springs around a gas, held so that it can only grow along the axes.
fn bag(gas: &Value) -> Value {
    let mut network = octahedron();
    network["gas"] = gas.clone();
    network["supports"] = json!([
        {"on": {"ids": [0, 1]}, "fix": "yz"}, {"on": {"ids": [2, 3]}, "fix": "xz"}, {"on": {"ids": [4, 5]}, "fix": "xy"}
    ]);
    json!({"name": "bag", "system": {"network": network},
        "time": {"end": 0.2, "method": "rk4", "step": 1e-3}})
}

/// The values of a column of gauges.csv, row by row.
fn column(bench: &Bench, name: &str, quantity: &str) -> Vec<f64> {
    let text = bench.results().text("gauges.csv");
    let cells = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let own = cells.filter(|cells| cells.get(1..3) == Some(&[name, quantity][..]));
    own.map(|cells| cells[3].parse().expect("a number")).collect()
}

/// (p + p_a) V^gamma keeps its value to 1e-10 in a bag that swings, as a gauge tells p and V at every step; without a
/// gauge at the rows of the history, under the name `gas`.
#[test]
fn a_gauge_tells_pressure_and_volume() {
    let bench = Bench::new();
    let mut case = bag(&json!({"on": "all", "pressure": 9000.0}));
    for (name, gauges) in [("air", json!([{"name": "air", "on": {"ids": [3]}, "of": "gas"}])), ("gas", json!([]))] {
        case["output"] = json!({"gauges": gauges});
        let report = good(run(&bench, "solve", &case, &[]));
        let [p, v] = ["gas_pressure", "gas_volume"].map(|quantity| column(&bench, name, quantity));
        assert_eq!([p.len(), v.len()], [201; 2], "{name}");
        let range = v.iter().fold([f64::MAX, f64::MIN], |[low, high], v| [low.min(*v), high.max(*v)]);
        assert!(range[0] == v[0] && (v[0] / START - 1.0).abs() < 1e-12 && range[1] > 1.001 * v[0], "{range:?}");
        for (p, v) in p.iter().zip(&v) {
            let ratio = (p + AMBIENT) / (9000.0 + AMBIENT) * (v / START).powf(GAMMA);
            assert!((ratio - 1.0).abs() < 1e-10, "{p} Pa in {v} m^3");
        }
        for words in ["gas pressure)", "gas volume)"] {
            assert!(report.contains(&format!("({name}, {words}")), "no \"{name}, {words}\" in\n{report}");
        }
    }
    let found = good(run(&bench, "static", &case, &[]));
    assert!(found.contains("gas             gas_pressure = "), "{found}");
    case["output"] = json!({"gauges": [{"name": "air", "on": {"ids": [3]}, "of": "gas"}]});
    case["system"]["network"].as_object_mut().expect("a network").remove("gas");
    let refused = run(&bench, "solve", &case, &[]);
    assert!(refused.stderr.contains("triangles around a gas"), "{}", refused.stderr);
}

/// A gas is filled with the steps of the loads, and all of it is in at the end.
#[test]
fn load_steps_fill_a_gas() {
    let bench = Bench::new();
    for gas in [json!({"on": "all", "pressure": 9000.0}), json!({"on": "all", "amount": 1.2 * START})] {
        let mut case = bag(&gas);
        case["output"] = json!({"probes": [{"name": "corner", "on": {"ids": [0]}}]});
        let x = |more: &[&str]| {
            good(run(&bench, "static", &case, more));
            let results = bench.results();
            let steps = results.summary()["equilibrium"]["load_steps"].as_u64();
            (results.table("probes.csv").column("x")[0], column(&bench, "gas", "gas_pressure")[0], steps)
        };
        let ((once, p1, _), (stepped, p2, steps)) = (x(&[]), x(&["--load-steps", "6"]));
        assert!(once > 0.701 && (once - stepped).abs() < 1e-7 && (p1 - p2).abs() < 1e-4 * p1, "{once} {stepped}");
        assert!(steps >= Some(3), "{steps:?}");
    }
}

/// `static` and `check --static` tell which loads are 0 at their time, and when they act; `check` takes the time too.
#[test]
fn loads_that_do_not_act_are_told() {
    let bench = Bench::new();
    let mut case = bag(&json!({"on": "all", "pressure": {"table": [[0, 0], [3, 500], [4, 400]]}}));
    let network = &mut case["system"]["network"];
    network["loads"] = json!([
        {"on": {"ids": [0]}, "force": [1, 0, 0]},
        {"on": {"ids": [0]}, "force": [5, 0, 0], "table": [[1, 0], [2, -1]]}
    ]);
    network["aero"] =
        json!({"wind": {"table": [[0, 0, 0, 0], [1, 9, 0, 0]]}, "law": {"surface_pressure": {"all": 0.1}}});
    let lines = |text: &str| {
        let told = text.lines().filter(|line| line.starts_with("  not acting"));
        told.map(|line| line[18..].to_owned()).collect::<Vec<_>>()
    };
    let at_start = [
        "loads[1] is 0 at t = 0 s, and largest at t = 2 s: take at=2",
        "gas is 0 at t = 0 s, and largest at t = 3 s: take at=3",
        "aero.wind is 0 at t = 0 s, and largest at t = 1 s: take at=1",
    ];
    assert_eq!(lines(&good(run(&bench, "static", &case, &[]))), at_start);
    let idle = bench.results().summary()["equilibrium"]["idle_loads"].clone();
    assert_eq!(idle[0], json!({"load": "loads[1]", "at": 0.0, "largest_at": 2.0}));
    assert_eq!(lines(&good(run(&bench, "check", &case, &["--static"]))), at_start);
    for (command, more) in [("static", &["--at", "0.5"][..]), ("check", &["--static", "--at", "0.5"])] {
        assert_eq!(
            lines(&good(run(&bench, command, &case, more))),
            ["loads[1] is 0 at t = 0.5 s, and largest at t = 2 s: take at=2"]
        );
    }
    let json: Value =
        serde_json::from_str(&good(run(&bench, "check", &case, &["--static", "--at", "2", "--json"]))).expect("JSON");
    assert_eq!([&json["at"], &json["idle_loads"]], [&json!(2.0), &json!([])]);
    assert!(run(&bench, "check", &case, &["--at", "2"]).stderr.contains("--at is for --static"));
}

/// A strip of 2 m by 1 m that a force stretches: its stress times its thickness over its strength, in `static`, and by
/// a gauge of stress, which knows no strength where two differ.
#[test]
fn membranes_have_a_safety_factor() {
    let bench = Bench::new();
    let case = |left: f64, right: Value| {
        let sheet = json!({"thickness": 1e-3, "modulus": 1e6, "poisson": 0.0});
        let rule = |group: &str, strength: Value| {
            let mut rule = sheet.clone();
            rule["on"] = json!({"group": group});
            rule["strength"] = strength;
            rule
        };
        json!({"name": "strip", "system": {"network": {
            "mesh": {"explicit": {
                "nodes": [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]],
                "triangles": [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]],
                "groups": {"left": {"triangles": [0, 1]}, "right": {"triangles": [2, 3]}}
            }},
            "mass": {"nodal": 1.0},
            "membranes": [rule("left", json!(left)), rule("right", right)],
            "supports": [{"on": "all", "fix": "yz"}, {"on": {"ids": [0, 3]}, "fix": "x"}],
            "loads": [{"on": {"ids": [2, 5]}, "force": [50, 0, 0]}]
        }},
        "time": {"end": 1e-2, "method": "newmark", "step": 1e-3},
        "output": {"gauges": [{"name": "all", "on": "all", "of": "stress"}, {"name": "left", "on": {"group": "left"}, "of": "stress"}]}})
    };
    // 100 N on a width of 1 m, which poisson = 0 and the supports keep.
    let report = good(run(&bench, "static", &case(400.0, json!(250.0)), &[]));
    let summary = bench.results().summary();
    let largest = summary["equilibrium"]["largest"].as_array().expect("a list").clone();
    let factor = largest.iter().find(|one| one["quantity"] == "safety_factor").expect("a safety factor");
    assert!((factor["value"].as_f64().expect("a number") - 2.5).abs() < 1e-7, "{factor}");
    assert_eq!([&factor["part"], &factor["groups"]], [&json!("triangle"), &json!(["right"])]);
    assert!(report.contains("safety factor   2.5, the smallest, of triangle"), "{report}");
    let of_gauge = |name: &str| {
        let peaks = summary["peaks"].as_array().expect("a list");
        let own = peaks.iter().find(|one| one["name"] == name && one["quantity"] == "stress_max");
        own.expect("a peak")["safety_factor"].clone()
    };
    assert!((of_gauge("left").as_f64().expect("a number") - 4.0).abs() < 1e-7 && of_gauge("all").is_null());
    assert!(good(run(&bench, "static", &case(99.0, Value::Null), &[])).contains("0.99, it would break"));
    let solved = good(run(&bench, "solve", &case(400.0, json!(400.0)), &[]));
    assert!(
        solved.contains("  cloth stress    ") && solved.contains("(all), strength 400000 Pa: safety factor"),
        "{solved}"
    );
}
