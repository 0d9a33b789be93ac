//! Gauges of membranes against closed forms, and what they cannot measure; names of groups in reports.

use crate::bench::{Bench, Ended};
use serde_json::{Value, json};

/// [Pa], [m], [-] modulus, thickness and Poisson's ratio of the sheets
const SHEET: [f64; 3] = [1e6, 1e-3, 0.3];

fn gauges(on: &Value) -> Value {
    let of = |(name, what): (&str, &str)| json!({"name": name, "on": on, "of": what});
    let all = [("s", "stress"), ("e", "strain"), ("w", "wrinkling")].map(of);
    json!({"gauges": all})
}

fn run(command: &str, case: &Value) -> (Bench, Ended) {
    let bench = Bench::new();
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    let ended = bench.run(&[command, "case.json", "--out", "out"]);
    (bench, ended)
}

/// The last value of a column.
fn last(bench: &Bench, quantity: &str) -> f64 {
    let text = bench.results().text("gauges.csv");
    let row = text.lines().rev().find(|line| line.split(',').nth(2) == Some(quantity));
    let cell = row.and_then(|row| row.split(',').nth(3)).unwrap_or_else(|| panic!("no {quantity} in {text}"));
    cell.parse().expect("a number")
}

/// A sheet pulled along x to 1.1 of its length, its sides free: E11 = (1.1^2 - 1)/2, S11 = E E11, E22 = -nu E11. A
/// force per width at rest of 1.1 S11 t does that. Per current width and thickness at rest the stress is S11 1.1/l_y.
#[test]
fn a_sheet_pulled_along_one_axis() {
    let [modulus, thickness, poisson] = SHEET;
    let stretch: f64 = 1.1;
    let green = 0.5 * (stretch * stretch - 1.0);
    let across = (1.0 - 2.0 * poisson * green).sqrt();
    let force = 0.5 * stretch * modulus * green * thickness;
    let case = json!({
        "name": "pulled",
        "system": {"network": {
            "mesh": {"explicit": {
                "nodes": [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]],
                "springs": [],
                "triangles": [[0, 1, 2], [0, 2, 3]]
            }},
            "mass": {"nodal": 0.1},
            "membranes": [{"on": "all", "thickness": thickness, "modulus": modulus, "poisson": poisson}],
            "supports": [
                {"on": "all", "fix": "z"},
                {"on": {"ids": [0, 3]}, "fix": "x"},
                {"on": {"ids": [0]}, "fix": "y"}
            ],
            "loads": [{"on": {"ids": [1, 2]}, "force": [force, 0, 0]}]
        }},
        "time": {"end": 1.0, "method": "newmark", "step": 0.01},
        "output": gauges(&json!("all"))
    });
    let (bench, ended) = run("static", &case);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let near = |quantity: &str, expected: f64| {
        let value = last(&bench, quantity);
        assert!((value - expected).abs() < 1e-9 * expected.abs().max(1e-3), "{quantity} {value}, not {expected}");
    };
    near("strain_max", stretch - 1.0);
    near("strain_mean", stretch - 1.0);
    near("stress_max", modulus * green * stretch / across);
    near("stress_mean", modulus * green * stretch / across);
    near("taut_share", 1.0);
    near("wrinkled_share", 0.0);
}

/// A sheet of which one half is sheared by g = 0.2 at constant area, which wrinkles it: its larger stretch is
/// g/2 + sqrt(1 + g^2/4), and it is in tension along that only, with the stress E (stretch^2 - 1)/2 stretch^2. The
/// other half is as it was, which counts as taut.
fn half_sheared(on: &Value) -> Value {
    let [modulus, thickness, poisson] = SHEET;
    json!({
        "name": "sheared",
        "system": {"network": {
            "mesh": {"explicit": {
                "nodes": [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0], [3, 0, 0]],
                "springs": [[2, 6]],
                "triangles": [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]],
                "groups": {"right": {"triangles": [2, 3]}, "left": {"triangles": [0, 1]}, "line": {"edges": [0]}}
            }},
            "mass": {"nodal": 0.1},
            "springs": [{"on": {"group": "line"}, "stiffness": 10.0, "strength": 5.0}],
            "membranes": [
                {"on": "all", "thickness": thickness, "modulus": modulus, "poisson": poisson, "wrinkling": true}
            ],
            "supports": [{"on": {"ids": [0, 1, 2, 3, 4, 5]}, "fix": "xyz"}],
            "initial": {
                "displacement": [[0, 0, 0], [0, 0, 0], [0, 0.2, 0], [0, 0, 0], [0, 0, 0], [0, 0.2, 0], [0.1, 0.2, 0]]
            }
        }},
        "time": {"end": 0.02, "method": "velocity-verlet", "step": 1e-3},
        "output": gauges(on)
    })
}

#[test]
fn a_sheet_of_which_one_half_is_sheared() {
    let stretch = 0.1 + 1.01_f64.sqrt();
    let stress = SHEET[0] * 0.5 * (stretch * stretch - 1.0) * stretch * stretch;
    let [whole, right] = [json!("all"), json!({"group": "right"})].map(|on| run("solve", &half_sheared(&on)));
    for ((bench, ended), share) in [(whole, 0.5), (right, 1.0)] {
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        for (quantity, expected) in [
            ("strain_max", stretch - 1.0),
            ("strain_mean", share * (stretch - 1.0)),
            ("stress_max", stress),
            ("stress_mean", share * stress),
            ("wrinkled_share", share),
            ("taut_share", 1.0 - share),
            ("slack_share", 0.0),
        ] {
            let value = last(&bench, quantity);
            assert!((value - expected).abs() < 1e-9 * expected.max(1.0), "{quantity} {value}, not {expected}");
        }
        // The report has them, with their times, and the names of groups.
        for words in ["at t = 0 s (s, stress)", "(e, strain)", "(w, wrinkled share)", "(line), strength 5 N"] {
            assert!(ended.stdout.contains(words), "no {words} in {}", ended.stdout);
        }
        assert!(ended.stdout.contains("the largest, of node 6 (line)"), "{}", ended.stdout);
        let peaks = bench.results().summary()["peaks"].clone();
        let line = peaks.as_array().expect("peaks").iter().find(|peak| peak["name"] == "springs[0] line");
        assert_eq!(line.map(|peak| &peak["label"]), Some(&json!("line")), "{peaks}");
        assert!(ended.stdout.contains("wrinkled share)") && !ended.stdout.contains(" - at t"), "{}", ended.stdout);
    }
}

#[test]
fn what_has_no_membrane_is_refused() {
    for (on, words) in [
        (json!("outer"), "it is measured on membranes"),
        (json!({"group": "line"}), "a group with triangles"),
        (json!({"ids": [9]}), "0 to 3"),
    ] {
        let (_, ended) = run("solve", &half_sheared(&on));
        assert!(ended.code == Some(2) && ended.stderr.contains(words), "{on}: {}", ended.stderr);
    }
    let mut bare = half_sheared(&json!({"group": "left"}));
    bare["system"]["network"]["membranes"][0]["on"] = json!({"group": "right"});
    let (_, ended) = run("solve", &bare);
    assert!(ended.stderr.contains("no rule of the membranes section selects them"), "{}", ended.stderr);
}

/// A failure says which groups its node belongs to, on the terminal and in the summary.
#[test]
fn failures_name_groups() {
    let mut case = half_sheared(&json!("all"));
    case["time"] = json!({"end": 20.0, "method": "velocity-verlet", "step": 1.0});
    let (bench, ended) = run("solve", &case);
    assert_eq!(ended.code, Some(3), "{}", ended.stderr);
    assert!(ended.stderr.contains("where   node 6 (line), spring 0 (line)"), "{}", ended.stderr);
    let groups = bench.results().summary()["failure_groups"].clone();
    assert_eq!(groups, json!({"node": ["line"], "spring": ["line"]}));
}
