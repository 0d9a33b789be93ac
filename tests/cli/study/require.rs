//! `canopy-fem require`: what each part of a model does to the quantities of interest, and the leanest case.

use std::path::Path;

use canopy_fem::case::schema::ClothModel;
use canopy_fem::case::spec::SystemSpec;
use canopy_fem::case::{Case, Problem};
use canopy_fem::study::require::change::{Change, edited};
use canopy_fem::study::require::variants::Variants;
use serde_json::{Value, json};

use crate::bench::{Bench, Ended, Results, Table};

/// [kg], [m^2], [s] mass and drag area of a body that falls from rest, and how long.
const MASS: f64 = 80.0;
const AREA: f64 = 0.8;
const FALL: f64 = 6.0;
/// [m/s^2], [kg/m^3]
const GRAVITY: f64 = 9.81;
const DENSITY: f64 = 1.225;

/// [m/s] Speed of the falling body, v = w tanh(g t/w) with the terminal speed w.
fn speed(area: f64) -> f64 {
    let terminal = (2.0 * MASS * GRAVITY / (DENSITY * area)).sqrt();
    terminal * (GRAVITY * FALL / terminal).tanh()
}

/// A body whose drag area is that of two equal entries, and of one that is nothing.
fn drop() -> Value {
    let drag = |area: f64| json!({"on": "all", "drag_area": area});
    json!({
        "name": "drop",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 500]], "springs": []}},
            "mass": {"points": [{"on": "all", "mass": MASS}]},
            "gravity": [0, 0, -GRAVITY],
            "aero": {"drag": [drag(AREA / 2.0), drag(AREA / 2.0), drag(1e-9)]}
        }},
        "time": {"end": FALL, "method": "newmark", "step": 0.05},
        "output": {"gauges": [{"name": "body", "on": "all", "of": "speed"}]},
        "study": {"quantities": ["body.speed.last"]}
    })
}

/// A small canopy with its payload, cut short while it fills.
fn canopy() -> Value {
    let path = format!("{}/assets/cases/parachute/c9-drop.json", env!("CARGO_MANIFEST_DIR"));
    let mut case: Value = serde_json::from_str(&std::fs::read_to_string(path).expect("a case")).expect("JSON");
    case["name"] = json!("small");
    let mesh = &mut case["system"]["network"]["mesh"]["parachute"];
    (mesh["gores"], mesh["radial_segments"], mesh["lines"]["segments"]) = (json!(8), json!(4), json!(2));
    (case["time"]["end"], case["time"]["step"]) = (json!(0.4), json!(0.004));
    case
}

fn written(case: &Value) -> Bench {
    let bench = Bench::new();
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    bench
}

fn require(bench: &Bench, out: &str, flags: &[&str]) -> (Ended, Table, Value) {
    let ended = bench.run(&[&["require", "case.json", "--out", out], flags].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let results = Results(bench.path(out));
    let told = serde_json::from_str(&results.text("require.json")).expect("JSON");
    (ended, results.table("require.csv"), told)
}

/// What `require.json` tells of a change.
fn change<'v>(told: &'v Value, described: &str) -> &'v Value {
    let changes = told["changes"].as_array().expect("a list");
    let found = changes.iter().find(|one| one["described"] == described);
    found.unwrap_or_else(|| panic!("no {described} in {changes:#?}"))
}

/// A part that does nothing is harmless. Of two equal drag areas, one off halves the drag: its speed is that of the
/// closed form. Newmark's error at this step is below 1e-4 of the speed.
#[test]
fn the_difference_is_that_of_the_closed_form() {
    let bench = written(&drop());
    let (ended, table, told) = require(&bench, "out", &[]);
    let full = told["rows"][0]["numbers"][0]["value"].as_f64().expect("a speed");
    assert!((full / speed(AREA) - 1.0).abs() < 1e-4, "{full}, not {}", speed(AREA));
    let half = change(&told, "drag of all (entry 0): off");
    let found = half["differences"][0]["difference"].as_f64().expect("a difference");
    let expected = speed(AREA / 2.0) - speed(AREA);
    assert!((found / expected - 1.0).abs() < 1e-3, "{found}, not {expected}");
    assert_eq!(half["harmless"], json!(false));
    let nothing = change(&told, "drag of all (entry 2): off");
    let share = nothing["differences"][0]["share"].as_f64().expect("a share");
    assert!(share.abs() < 1e-8 && nothing["harmless"] == json!(true), "{nothing:#}");
    // The same in the table, whose first row is the full model.
    assert_eq!(table.column("error_body.speed.last")[0], 0.0);
    assert!(table.column("error_body.speed.last").contains(&found));
    // The error of the step, against the truth.
    let step = &told["errors"]["step"][0];
    let stated = step["share"].as_f64().expect("a share") * full;
    let true_error = (full - speed(AREA)).abs();
    assert!(true_error <= 3.0 * stated && stated <= 10.0 * true_error, "{stated}, not {true_error}");
    assert!(ended.stdout.contains("mesh: it is listed in the case"), "{}", ended.stdout);
    // Twice the step is far within 1 %, so the leanest case has at least that.
    let lean = told["lean"]["changes"].as_array().expect("changes");
    assert!(lean.contains(&json!("step: 0.05 -> 0.1 s")), "{lean:?}");
}

/// The leanest case of a canopy runs from its file, and its numbers are within the accuracy.
#[test]
fn the_lean_case_is_within_the_accuracy() {
    let bench = written(&canopy());
    let (ended, _, told) = require(&bench, "out", &["--within", "15%", "--budget", "none"]);
    let lean = &told["lean"];
    assert!(lean["changes"].as_array().is_some_and(|changes| !changes.is_empty()), "{lean:#}");
    assert_eq!(lean["distance"]["harmless"], json!(true));
    assert_eq!(lean["file_differs"], Value::Null);
    let there = lean["elsewhere"]["described"].as_str().expect("another state");
    assert_eq!(there, "initial velocity: 1.2 times; mass of payload: 1.2 times");
    let text = Results(bench.path("out")).text("small-lean.json");
    let case: Value = serde_json::from_str(&text).expect("JSON");
    let description = case["description"].as_str().expect("a description");
    assert!(description.starts_with("case.json with "), "{description}");
    for file in ["case.json", "out/small-lean.json"] {
        let ended = bench.run(&["solve", file, "--out", &format!("{file}-solved")]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    }
    let quantities = |file: &str| Results(bench.path(&format!("{file}-solved"))).summary()["quantities"].clone();
    let (full, own) = (quantities("case.json"), quantities("out/small-lean.json"));
    for number in told["rows"][0]["numbers"].as_array().expect("numbers") {
        let name = number["name"].as_str().expect("a name");
        let [full, own] = [&full, &own].map(|of| of[name]["value"].as_f64().expect("a value"));
        let scale = full.abs().max(0.01 * number["largest"].as_f64().expect("a number"));
        assert!((own - full).abs() <= 0.15 * scale, "{name}: {own}, not {full}");
        let wanted = number["value"].as_f64();
        assert_eq!(Some(full), wanted, "{name}: the full model is the run of solve");
    }
    // Finer meshes show the error of the mesh, and what cannot be run says why.
    let finer = change(&told, "mesh: 4 -> 8 radial_segments");
    assert_eq!((&finer["finer"], &finer["status"]), (&json!(true), &json!("completed")));
    assert!(ended.stdout.contains("the full model itself is not within 15 % by its mesh, "), "{}", ended.stdout);
    assert!(told["errors"]["mesh"].as_array().is_some_and(|errors| !errors.is_empty()));
    let weightless = change(&told, "weight of lines: off");
    assert_eq!(weightless["status"], "refused");
    assert!(ended.stdout.contains("weight of lines: off: refused: "), "{}", ended.stdout);
    for described in ["lines: 2 -> 1 segments", "drag of lines: off", "stiffness of riser: 10 times"] {
        assert_eq!(change(&told, described)["status"], "completed", "{described}");
    }
    let page = Results(bench.path("out")).text("require.html");
    assert!(page.contains("Errors side by side") && page.contains("<svg") && page.contains("lines: 2 -&gt; 1"), "page");
}

/// The whole parachute as one mass: what it is enough for, and what it has not. Where only that is asked for, it is the
/// leanest case.
#[test]
fn a_given_opening_load_needs_one_mass_only() {
    let mut case = canopy();
    let gauges = case["output"]["gauges"].as_array_mut().expect("gauges");
    gauges.push(json!({"name": "rim", "on": {"group": "skirt"}, "of": "tension"}));
    let bench = written(&case);
    let point = "parachute: network -> point";
    let (ended, _, told) = require(&bench, "out", &["--within", "10%", "--budget", "none"]);
    let found = change(&told, point);
    assert_eq!(found["status"], "completed", "{found:#}");
    let share = |name: &str| {
        let all = found["differences"].as_array().expect("a list").iter();
        all.clone().find(|one| one["name"] == name).unwrap_or_else(|| panic!("no {name} in {found:#}"))["share"]
            .as_f64()
    };
    assert!(share("opening_load").is_some_and(|share| share.abs() < 0.1), "{found:#}");
    assert_eq!(share("rim.tension.peak"), None);
    assert!(found["saved"].as_f64().is_some_and(|saved| saved > 0.9), "{found:#}");
    let told_of =
        ["one mass:   ", "opening_load +", "a point has no rim.tension.peak, springs[5] lines.tension.peak, "];
    assert!(told_of.iter().all(|words| ended.stdout.contains(words)), "{}", ended.stdout);
    // The tape of a skirt without nodes between the lines has no tension, and so no shares of it.
    assert!(!ended.stdout.contains("inf"), "{}", ended.stdout);
    assert!(
        ended.stdout.contains("numbers the scene needs no more than --set system.network.model=point"),
        "{}",
        ended.stdout
    );
    let page = Results(bench.path("out")).text("require.html");
    assert!(page.contains("The whole parachute as one mass"), "page");
    let flags = ["--within", "10%", "--quantity", "opening_load", "--quantity", "rim.tension.peak"];
    let (_, _, told) = require(&bench, "both", &flags);
    assert_eq!(change(&told, point)["status"], "completed");
    let (_, _, told) = require(&bench, "load", &flags[..4]);
    let lean = told["lean"]["changes"].as_array().expect("changes");
    assert!(lean.contains(&json!(point)), "{lean:?}");
    assert_eq!(told["lean"]["file_differs"], Value::Null, "{:#}", told["lean"]);
    // Without a schedule there is no such model, which is said.
    let set = r#"system.network.aero.canopy={"on":{"group":"canopy"},"table":{"pressure_coefficient":1.7}}"#;
    let (ended, _, _) = require(&bench, "table", &["--set", set, "--budget", "1ms"]);
    assert!(ended.stdout.contains("parachute as one mass: /system/network/aero/canopy: "), "{}", ended.stdout);
}

/// In one go and in shards the runs are the same; a second merge makes none anew.
#[test]
fn shards_change_nothing() {
    let mut case = drop();
    case["time"]["end"] = json!(1.0);
    let bench = written(&case);
    let (_, _, whole) = require(&bench, "one", &["--threads", "2"]);
    let planned = bench.run(&["require", "case.json", "--plan", "--out", "parts"]);
    assert_eq!(planned.code, Some(0), "{}", planned.stderr);
    for shard in ["2/2", "1/2"] {
        let ended = bench.run(&["require", "--out", "parts", "--shard", shard]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    }
    let merge = || {
        let ended = bench.run(&["require", "--out", "parts", "--merge"]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        let text = Results(bench.path("parts")).text("require.json");
        serde_json::from_str::<Value>(&text).expect("JSON")
    };
    let merged = merge();
    let counted = |told: &Value| -> Vec<Value> {
        let mut rows = told["rows"].as_array().expect("rows").clone();
        rows.iter_mut().for_each(|row| row["cpu_seconds"] = Value::Null);
        rows
    };
    assert_eq!(counted(&merged), counted(&whole));
    // Counted work decides, so that the leanest case is the same too.
    assert_eq!(merged["lean"]["changes"], whole["lean"]["changes"]);
    assert!(merged["rows"][0]["work"].as_f64().is_some_and(|work| work > 0.0), "{:#}", merged["rows"][0]);
    assert_eq!(merged["lean"]["distance"]["harmless"], json!(true));
    let again = merge();
    assert_eq!((&again["rows"], &again["lean"]), (&merged["rows"], &merged["lean"]));
    let other = bench.run(&["require", "case.json", "--out", "parts", "--end", "0.5"]);
    assert_eq!(other.code, Some(2), "{}", other.stdout);
    assert!(other.stderr.contains("time.end was 1"), "{}", other.stderr);
}

/// What a budget leaves out is listed, and made by the same command.
#[test]
fn a_spent_budget_lists_what_is_left() {
    let bench = written(&drop());
    let (ended, _, told) = require(&bench, "out", &["--budget", "1ms"]);
    let rows = told["rows"].as_array().expect("rows").len();
    let left = told["rows"].as_array().expect("rows").iter().filter(|row| row["status"] == "not-run").count();
    assert!(left > 0 && ended.stdout.contains("the budget was spent before it"), "{left}: {}", ended.stdout);
    let (_, _, told) = require(&bench, "out", &[]);
    let all = told["rows"].as_array().expect("rows");
    assert!(all.len() == rows && all.iter().all(|row| row["status"] == "completed"), "{all:#?}");
}

/// Nodes that are selected by their numbers are the same places on other meshes, or these are not tried.
#[test]
fn numbers_of_nodes_follow_the_mesh() {
    let chain = json!({
        "name": "chain",
        "system": {"network": {
            "mesh": {"chain": {"from": [0, 0, 0], "to": [3, 0, 0], "segments": 6}},
            "springs": [{"on": "all", "axial_rigidity": 1e4, "linear_density": 0.5}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "gravity": [0, 0, -9.81]
        }},
        "time": {"end": 0.3, "method": "newmark", "step": 0.005},
        "output": {"probes": [{"name": "tip", "on": {"ids": [6]}}]},
        "study": {"quantities": ["tip.z@0.2"]}
    });
    let bench = written(&chain);
    let (_, _, told) = require(&bench, "out", &[]);
    // The end of a chain that falls from the horizontal is in free fall at first, on all meshes.
    let fallen = -0.5 * GRAVITY * 0.2 * 0.2;
    for described in ["chain: 6 -> 3 segments", "chain: 6 -> 12 segments"] {
        let z = change(&told, described)["differences"][0]["value"].as_f64().expect("a height");
        assert!((z / fallen - 1.0).abs() < 0.05, "{described}: {z}, not {fallen}");
    }
    let set = r#"output.probes.0.on={"ids":[5]}"#;
    let (ended, _, told) = require(&bench, "odd", &["--set", set]);
    assert!(ended.stdout.contains("/output/probes/0/on/ids selects by numbers of this mesh"), "{}", ended.stdout);
    assert_eq!(change(&told, "chain: 6 -> 12 segments")["status"], "completed");
    // A stiffness of each edge is that of this mesh only.
    let set = r#"system.network.springs.0={"on":"all","stiffness":1e4,"linear_density":0.5}"#;
    let (ended, _, _) = require(&bench, "stiff", &["--set", set]);
    assert!(ended.stdout.contains("/stiffness is that of an edge of this mesh"), "{}", ended.stdout);
}

/// The cloth of the other model is what `tradeoff` compares with: the same springs on the same edges, the same
/// membranes.
#[test]
fn the_other_model_of_the_cloth_is_that_of_a_tradeoff() {
    let network = |problem: &Problem| match &problem.system {
        SystemSpec::Network(spec) => (spec.springs.clone(), spec.membranes.clone()),
        SystemSpec::Pendulum(_) => unreachable!("a network"),
    };
    let cases = [
        ("docs/guide/cases/drum.json", ClothModel::Net),
        ("assets/cases/parachute/c9-drop.json", ClothModel::Membrane),
    ];
    for (file, model) in cases {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
        let case = Case::from_file(&path, &[]).expect("a case");
        let found = Variants::of(&case).all.into_iter().find(|variant| variant.change == Change::Cloth(model));
        let changed = edited(&case.problem().case_json, &[found.expect("another model")]);
        let changed = Case::from_text(changed.to_string(), file, path.parent().expect("a folder").to_owned(), &[]);
        let changed = network(changed.expect("a case").problem());
        let expected = network(&case.as_model(model).expect("another model"));
        assert_eq!(changed.1, expected.1, "{file}");
        assert_eq!(changed.0.len(), expected.0.len(), "{file}");
        for (own, expected) in changed.0.iter().zip(&expected.0) {
            assert_eq!((&own.edges, &own.stiffness), (&expected.edges, &expected.stiffness), "{file}");
            assert_eq!((&own.slack, &own.dashpot), (&expected.slack, &expected.dashpot), "{file}");
        }
    }
}

/// The leanest case finds the files of the full one from its own folder.
#[test]
fn the_lean_case_finds_its_files() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("sub")).expect("a folder");
    for file in ["square-from-file.json", "square.obj"] {
        let path = format!("{}/docs/guide/cases/{file}", env!("CARGO_MANIFEST_DIR"));
        std::fs::copy(path, bench.path("sub").join(file)).expect("a copy");
    }
    let flags = ["--quantity", "max_displacement", "--within", "10%", "--out", "out"];
    let ended = bench.run(&[&["require", "sub/square-from-file.json"], &flags[..]].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stdout.contains("mesh: it is a file"), "{}", ended.stdout);
    let results = Results(bench.path("out"));
    let told: Value = serde_json::from_str(&results.text("require.json")).expect("JSON");
    assert_eq!(told["lean"]["file_differs"], Value::Null, "{:#}", told["lean"]);
    let file = told["lean"]["file"].as_str().expect("a file");
    assert_eq!(bench.run(&["check", file, "--quiet"]).code, Some(0), "{file}");
}

/// The motion of all nodes has no number, and an accuracy in newtons is not one of speeds.
#[test]
fn what_cannot_be_compared_is_refused() {
    let bench = written(&drop());
    for (flags, words) in [
        (["--quantity", "motion"], "other meshes have other nodes"),
        (["--within", "20N"], "body.speed.last is in m/s, not in N"),
        (["--within", "soon"], "--within soon: expected a share"),
        (["--quantity", "body.tension.peak"], "there is no"),
    ] {
        let ended = bench.run(&[&["require", "case.json", "--out", "out"], &flags[..]].concat());
        assert_eq!(ended.code, Some(2), "{flags:?}: {}", ended.stdout);
        assert!(ended.stderr.contains(words), "{flags:?}: {}", ended.stderr);
        let _ = std::fs::remove_dir_all(bench.path("out"));
    }
}
