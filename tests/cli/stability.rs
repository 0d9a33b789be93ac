//! `canopy-fem stability`: its files, its table, its refusals.

use crate::bench::{Bench, Results, contents};
use serde_json::Value;

/// A damped mass on a spring: every method answers within a second.
const MASS: &str = r#"{
  "name": "mass",
  "system": {"network": {
    "mesh": {"explicit": {"nodes": [[0,0,0],[10,0,0]], "springs": [[0,1]]}},
    "mass": {"nodal": 2.0},
    "springs": [{"on": "all", "stiffness": 50.0, "dashpot": {"axial": {"coefficient": 4.0}}}],
    "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [1]}, "fix": "yz"}],
    "initial": {"displacement": [[0,0,0],[0.01,0,0]]}
  }},
  "time": {"end": 2.0, "method": "rk4", "step": 0.01}
}"#;

fn bench() -> Bench {
    let bench = Bench::new();
    std::fs::write(bench.path("mass.json"), MASS).expect("a case");
    bench
}

/// Whoever names a method, by name or with parameters, gets that one.
#[test]
fn a_named_method_is_studied_alone() {
    let bench = bench();
    for (method, row) in [("rk4", "rk4,"), (r#"{"hht": {"alpha": -0.2}}"#, "hht(alpha=-0.2),")] {
        let ended = bench.run(&["stability", "mass.json", "--method", method, "--force"]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        let csv = Results(bench.path("out/mass")).text("stability.csv");
        assert!(csv.lines().count() == 2 && csv.lines().nth(1).is_some_and(|line| line.starts_with(row)), "{csv}");
    }
}

/// A membrane's limit, undamped and with stiffness damping, is the one that runs find.
#[test]
fn limits_of_membranes_are_found() {
    let bench = Bench::new();
    for damping in [0.0, 2e-3, 2e-2] {
        let case = serde_json::json!({
            "name": "sheet",
            "system": {"network": {
                "mesh": {"annulus": {"inner_radius": 0.3, "outer_radius": 1.0, "nodes": 60, "boundary_nodes": 32}},
                "mass": {"areal_density": 2.0},
                "membranes": [{
                    "on": "all", "thickness": 1e-3, "modulus": 1e6, "poisson": 0.3, "damping_time": damping
                }],
                "supports": [{"on": "outer", "fix": "xyz"}],
                "initial": {"velocity": [0, 0, 0.01]}
            }},
            "time": {"end": 2.0, "method": "velocity-verlet", "step": 1e-4}
        });
        std::fs::write(bench.path("sheet.json"), case.to_string()).expect("a case");
        let ended = bench.run(&["stability", "sheet.json", "--methods", "velocity-verlet,euler-cromer,rk4", "--force"]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        let csv = Results(bench.path("out/sheet")).text("stability.csv");
        assert_eq!(csv.lines().count(), 4, "{csv}");
        for line in csv.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let [predicted, measured] = [1, 2].map(|i| cells[i].parse::<f64>().expect("seconds"));
            assert!((measured / predicted - 1.0).abs() < 0.02, "damping time {damping} s: {line}");
        }
    }
}

/// Three files of one study that agree with each other: a row a method, seconds, empty for a method without limit.
#[test]
fn the_three_files() {
    let bench = bench();
    let ended =
        bench.run(&["stability", "mass.json", "--methods", "velocity-verlet,newmark,{\"hht\": {\"alpha\": -0.2}}"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let results = Results(bench.path("out/mass"));
    let csv = results.text("stability.csv");
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 4, "{csv}");
    assert_eq!(lines[0], "method,predicted,measured,prediction,measurement");
    let unlimited = ["newmark", "hht(alpha=-0.2)"].map(|name| format!("{name},,,unlimited,no-limit-found"));
    assert_eq!(&lines[2..], unlimited);
    assert!(lines[1].ends_with(",estimate,limit"), "{csv}");
    let cells: Vec<&str> = lines[1].split(',').collect();
    let (predicted, measured): (f64, f64) = (cells[1].parse().expect("seconds"), cells[2].parse().expect("seconds"));
    // w = 5 rad/s and zeta = 0.2, where Verlet's limit lies between 1.84/w (zeta = 0.1) and 1/w (zeta = 1).
    assert!(predicted > 0.2 && predicted < 0.368 && (measured / predicted - 1.0).abs() < 0.02, "{csv}");
    let json: Value = serde_json::from_str(&results.text("stability.json")).expect("JSON");
    let row = &json["methods"][0];
    assert_eq!((json["name"].as_str(), json["unknowns"].as_u64()), (Some("mass"), Some(1)));
    assert!((row["measured"].as_f64().expect("seconds") / measured - 1.0).abs() < 1e-5, "the same in both files");
    assert_eq!(row["runs"].as_array().map(Vec::len), Some(6));
    assert_eq!(json["case"]["study"]["methods"][2]["hht"]["alpha"].as_f64(), Some(-0.2), "flags are part of the case");
    let svg = results.text("stability.svg");
    let page = results.text("stability.html");
    let panels = page.matches("data-run=\"velocity-verlet\"").count();
    assert!(
        panels > 0 && page.contains("<polygon") && page.contains("href=\"stability.csv\""),
        "the page has the region"
    );
    for words in ["<polygon", "velocity-verlet", "no limit: newmark", "no limit: hht(alpha=-0.2)"] {
        assert!(svg.contains(words), "no {words} in the picture");
    }
    assert!(
        ended.stdout.contains("velocity-verlet") && ended.stdout.contains("no limit up to 0.5"),
        "{}",
        ended.stdout
    );
}

/// The same study writes the same bytes, over an earlier one only with --force; other files in the folder stay.
#[test]
fn studies_repeat_and_replace() {
    let bench = bench();
    let study = ["stability", "mass.json", "--methods", "rk4,kang", "--out", "out"];
    assert_eq!(bench.run(&study).code, Some(0));
    std::fs::write(bench.path("out/notes.txt"), "mine").expect("a file");
    let first = contents(&bench.path("out"));
    let again = bench.run(&study);
    assert_eq!(again.code, Some(2));
    assert!(again.stderr.contains("stability.csv") && again.stderr.contains("--force"), "{}", again.stderr);
    let forced = bench.run(&[&study[..], &["--force", "--quiet"]].concat());
    assert_eq!((forced.code, &*forced.stdout, &*forced.stderr), (Some(0), "", ""));
    assert!(contents(&bench.path("out")) == first, "the bytes differ");
}

/// The picture says of a method without a region what was measured of it: on a pendulum Newton fails at long steps.
#[test]
fn the_legend_is_true() {
    let bench = bench();
    let pendulum = r#"{"name": "bob", "system": {"pendulum": {"length": 1.0, "mass": 1.0, "gravity": 9.81, "angle": 0.5}},
        "time": {"end": 20.0, "method": "rk4", "step": 0.01}, "study": {"methods": ["rk4", "hht", "backward-euler"]}}"#;
    std::fs::write(bench.path("bob.json"), pendulum).expect("a case");
    let ended = bench.run(&["stability", "bob.json", "--out", "bob"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let results = Results(bench.path("bob"));
    let (svg, csv) = (results.text("stability.svg"), results.text("stability.csv"));
    assert!(csv.contains("\nbackward-euler,,,unlimited,no-limit-found\n"), "{csv}");
    let hht: Vec<&str> = csv.lines().find(|line| line.starts_with("hht,")).expect("a row").split(',').collect();
    assert!(hht[1].is_empty() && hht[2].parse::<f64>().is_ok() && hht[3..] == ["unlimited", "limit"], "{csv}");
    assert!(svg.contains("no limit: backward-euler") && svg.contains("hht: measured "), "a legend that is not true");
    assert!(!svg.contains("no limit: hht"));
}

/// A method that does not go with the scene is a row; a case or a flag that is wrong is refused with status 2 before
/// any file is made.
#[test]
fn refusals() {
    let bench = bench();
    for (flags, words) in [
        (&["--methods", "rk5"][..], "rk4"),
        (&["--methods", "rk4,"], "is no method"),
        (&["--methods", "{\"hht\": {\"alpha\": 3}}"], "alpha"),
        (&["--budget", "soon"], "60s"),
        (&["--budget", "0s"], "above 0"),
        (&["--end", "0"], "above 0"),
    ] {
        let ended = bench.run(&[&["stability", "mass.json", "--out", "none"], flags].concat());
        assert!(ended.code == Some(2) && ended.stderr.contains(words), "{flags:?}: {:?} {}", ended.code, ended.stderr);
        assert!(!bench.path("none").exists());
    }
    let pendulum = r#"{"name": "bob", "system": {"pendulum": {"length": 1.0, "mass": 1.0, "gravity": 9.81, "angle": 0.5}},
        "time": {"end": 5.0, "method": "rk4", "step": 0.01}, "study": {"methods": ["kang"], "budget_seconds": 100}}"#;
    std::fs::write(bench.path("bob.json"), pendulum).expect("a case");
    let ended = bench.run(&["stability", "bob.json", "--out", "bob"]);
    assert!(ended.code == Some(0) && ended.stdout.contains("refused"), "{}{}", ended.stdout, ended.stderr);
    assert_eq!(
        Results(bench.path("bob")).text("stability.csv"),
        "method,predicted,measured,prediction,measurement\nkang,nan,nan,refused,refused\n"
    );
    assert!(!bench.path("bob/stability.svg").exists(), "no method has a region");
}

/// A budget leaves rows out and says so; the others are what they are without one.
#[test]
fn a_budget_leaves_rows_out() {
    let bench = bench();
    let ended = bench.run(&["stability", "mass.json", "--budget", "0.000001s", "--methods", "rk4", "--out", "out"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stdout.contains("left out: budget"), "{}", ended.stdout);
    let csv = Results(bench.path("out")).text("stability.csv");
    assert!(csv.contains("rk4,0.") && csv.ends_with(",nan,estimate,out-of-budget\n"), "{csv}");
}
