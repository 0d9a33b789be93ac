//! What the report says of the stages of a run, against the rows of its gauges.

use crate::bench::{Bench, Table};
use serde_json::{Value, json};

/// [s] when the reefing line of the shipped parachute is cut
const CUT: f64 = 4.0;

/// The shipped parachute with a reefing line as a point, with a row a step.
fn reefed() -> Value {
    let path = format!("{}/assets/cases/parachute/g12-reefed.json", env!("CARGO_MANIFEST_DIR"));
    let mut case: Value = serde_json::from_str(&std::fs::read_to_string(path).expect("a case")).expect("JSON");
    case["system"]["network"]["model"] = json!("point");
    case["output"]["history"] = json!({"every": 1});
    let gauges = case["output"]["gauges"].as_array().expect("gauges").clone();
    // A point has no reefing line.
    case["output"]["gauges"] = gauges.into_iter().filter(|gauge| gauge["name"] != "reefing").collect();
    case
}

fn written(case: &Value) -> Bench {
    let bench = Bench::new();
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    bench
}

fn solve(bench: &Bench, flags: &[&str]) -> (Value, String) {
    let ended = bench.run(&[&["solve", "case.json", "--out", "out"], flags].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    (bench.results().summary()["stages"].clone(), ended.stdout)
}

/// The rows of a channel: time and value.
fn rows(table: &Table, name: &str, quantity: &str) -> Vec<[f64; 2]> {
    let at = |column: &str| table.header.iter().position(|known| known == column).expect("a column");
    let [named, of, t, value] = ["name", "quantity", "t", "value"].map(at);
    let own = table.rows.iter().filter(|row| row[named] == name && row[of] == quantity);
    own.map(|row| [t, value].map(|column| row[column].parse().expect("a number"))).collect()
}

/// The value at a time of a row.
fn value_at(rows: &[[f64; 2]], t: f64) -> f64 {
    rows.iter().find(|row| row[0] == t).unwrap_or_else(|| panic!("no row at {t}"))[1]
}

fn peak<'a>(stage: &'a Value, name: &str) -> &'a Value {
    let all = stage["peaks"].as_array().expect("peaks");
    all.iter().find(|peak| peak["name"] == name).unwrap_or_else(|| panic!("{name} in {stage:#}"))
}

/// Names and times of the stages; the peak of each is the largest row within it, with the other rows of that time; the
/// opening-force coefficient follows from the row at the start and that at the end.
#[test]
fn peaks_of_stages_are_the_largest_rows_within() {
    let bench = written(&reefed());
    let (stages, told) = solve(&bench, &[]);
    let names: Vec<&str> = stages.as_array().expect("stages").iter().filter_map(|s| s["name"].as_str()).collect();
    assert_eq!(names, ["opening", "disreef 1", "steady"]);
    assert_eq!([&stages[0]["from"], &stages[0]["to"], &stages[1]["from"]], [&json!(0.0), &json!(CUT), &json!(CUT)]);

    let table = bench.results().table("gauges.csv");
    let of = |quantity: &str| rows(&table, "canopy", quantity);
    let (drag, speed, area, q) = (of("drag"), of("axial_speed"), of("drag_area"), of("dynamic_pressure"));
    let angle = of("angle_of_attack");
    let z = bench.results().table("gauges.csv");
    assert!(rows(&z, "payload", "position_z").is_empty(), "what finds the height is not shown");
    for (stage, [from, to]) in stages.as_array().expect("stages").iter().zip([[-1.0, CUT], [CUT, 20.0]]) {
        let within = |rows: &[[f64; 2]]| {
            let own = rows.iter().filter(|[t, _]| *t > from && *t <= to);
            own.fold([0.0, f64::MIN], |most, row| if row[1] > most[1] { *row } else { most })
        };
        let [t, most] = within(&drag);
        let told = peak(stage, "canopy");
        assert_eq!([&told["value"], &told["t"]], [&json!(most), &json!(t)]);
        assert_eq!(told["speed"], json!(value_at(&speed, t)));
        assert_eq!(told["drag_area"], json!(value_at(&area, t)));
        let [_, riser] = within(&rows(&table, "riser", "tension_max"));
        assert_eq!(peak(stage, "riser")["value"], json!(riser));
        let turned = value_at(&angle, from.max(0.0)).to_radians().cos().powi(2);
        let whole = value_at(&q, from.max(0.0)) / if turned.is_finite() { turned } else { 1.0 };
        let expected = most / (whole * value_at(&area, to));
        let coefficient = told["opening_force_coefficient"].as_f64().expect("it opens");
        assert!((coefficient / expected - 1.0).abs() < 1e-12, "{coefficient}, not {expected}");
    }
    let line = told.lines().find(|line| line.starts_with("  disreef 1")).expect("a line of the stage");
    assert!(line.contains("N (canopy, drag)") && line.contains("m^2"), "{line}");
    assert!(told.contains("opening-force   coefficient 0."), "{told}");
}

/// The height at a peak is that of the payload: a point's z, from the probe's rows at frame times.
#[test]
fn the_height_is_that_of_the_payload() {
    let mut case = reefed();
    case["time"]["end"] = json!(1.0);
    case["output"]["gauges"].as_array_mut().expect("gauges").push(json!({
        "name": "place", "on": {"group": "payload"}, "of": "position"
    }));
    let bench = written(&case);
    let (stages, _) = solve(&bench, &[]);
    let told = peak(&stages[0], "riser");
    let z = rows(&bench.results().table("gauges.csv"), "place", "position_z");
    let t = told["t"].as_f64().expect("a time");
    assert_eq!(told["height"], json!(value_at(&z, t)));
}

/// Springs that are cut divide a run without canopies too; without events and canopies there are no stages.
#[test]
fn a_cut_begins_a_stage() {
    let oscillator = |springs: Value| {
        json!({
            "name": "cut",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0]], "springs": [[0, 1]]}},
                "mass": {"nodal": 2.0},
                "springs": springs,
                "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
                "initial": {"velocity": [1.5, 0, 0]}
            }},
            "time": {"end": 0.4, "method": "velocity-verlet", "step": 0.002},
            "output": {"gauges": [{"name": "wall", "on": {"ids": [0]}, "of": "reaction"}]}
        })
    };
    let bench = written(&oscillator(json!([{"on": "all", "stiffness": 200.0, "cut": 0.1}])));
    let (stages, told) = solve(&bench, &[]);
    let names: Vec<&str> = stages.as_array().expect("stages").iter().filter_map(|s| s["name"].as_str()).collect();
    assert_eq!(names, ["start", "cut"]);
    // k v/w sin(w t) at the cut, w = 10/s; nothing after it.
    let value = peak(&stages[0], "wall")["value"].as_f64().expect("a number");
    assert!((value / (200.0 * 0.15 * 1.0_f64.sin()) - 1.0).abs() < 1e-4, "{value}");
    assert_eq!(peak(&stages[1], "wall")["value"], json!(0.0));
    assert!(!told.contains("speed"), "there is no canopy: {told}");

    let bench = written(&oscillator(json!([{"on": "all", "stiffness": 200.0}])));
    assert_eq!(solve(&bench, &[]).0, Value::Null);
}

/// A run that was stopped within a stage and resumed has the stages of one in one piece.
#[test]
fn stages_survive_a_checkpoint() {
    let bench = written(&reefed());
    let (whole, _) = solve(&bench, &[]);
    let keep = ["--set", "output.checkpoint={\"every\": 1.5}"];
    let ended = bench.run(&[&["solve", "case.json", "--out", "parts", "--end", "5"][..], &keep].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let ended = bench.run(&[&["solve", "case.json", "--out", "parts", "--resume"][..], &keep].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let text = std::fs::read_to_string(bench.path("parts/summary.json")).expect("a summary");
    let summary: Value = serde_json::from_str(&text).expect("JSON");
    assert!(summary["resumed_from"].as_f64().is_some_and(|t| t > CUT), "{}", summary["resumed_from"]);
    assert_eq!([&summary["stages"][0], &summary["stages"][1]], [&whole[0], &whole[1]]);
}

/// A stage begins at an event that waits for a state, under its name or in words; the event's own state ends the stage
/// before.
#[test]
fn an_event_by_state_begins_a_stage() {
    let fall = |when: Value| {
        let mut case = reefed();
        let stages = case["system"]["network"]["aero"]["canopy"]["schedule"].as_array_mut().expect("stages");
        stages[1].as_object_mut().expect("a stage").remove("start");
        stages[1]["when"] = when;
        let springs = case["system"]["network"]["springs"].as_array_mut().expect("rules");
        springs.iter_mut().for_each(|rule| drop(rule.as_object_mut().expect("a rule").remove("cut")));
        case
    };
    for (when, name) in [
        (json!({"name": "second opening", "speed_below": 30.0}), "second opening"),
        (json!({"speed_below": 30.0}), "disreef 1"),
    ] {
        let bench = written(&fall(when));
        let (stages, _) = solve(&bench, &[]);
        let events = bench.results().summary()["events"].clone();
        let fired = events.as_array().expect("events").iter().find(|event| event["what"] == "stage 2").expect("fired");
        assert_eq!([&stages[1]["name"], &stages[1]["from"]], [&json!(name), &fired["time"]]);
        assert_eq!(stages[0]["to"], fired["time"]);
        let t = peak(&stages[1], "canopy")["t"].as_f64().expect("a time");
        assert!(t > fired["time"].as_f64().expect("a time"), "{t}");
    }
}
