//! What runs, but is seldom meant: `check` and `solve` say so in the same words, with numbers.

use std::path::PathBuf;

use canopy_fem::case::Case;
use canopy_fem::output::frame::Fields;
use canopy_fem::output::space::frame_bytes;
use canopy_fem::simulation::build_scene;
use canopy_fem::vtk::Precision;
use serde_json::{Value, json};

use crate::bench::{Bench, Ended, SAIL};

const N: &str = "system.network.";

/// The sail with the mass of a cloth, about which there is nothing to say.
const LIGHT: [&str; 2] = ["--set", "system.network.mass.nodal=0.1"];

fn warnings(text: &str) -> Vec<String> {
    text.lines().filter(|line| line.starts_with("warning: ")).map(str::to_owned).collect()
}

/// The warnings of `check` and of `solve` for the same arguments.
fn both(bench: &Bench, arguments: &[&str]) -> [Vec<String>; 2] {
    let checked = bench.run(&[&["check", "sail.json"], arguments].concat());
    assert_eq!(checked.code, Some(0), "{arguments:?}: {}", checked.stderr);
    let solved = bench.solve(&[&["--force"], arguments].concat());
    assert!(matches!(solved.code, Some(0 | 3)), "{arguments:?}: {}", solved.stderr);
    let mut solved = warnings(&solved.stderr);
    // Known after the run only.
    let after = ["the scheme itself has made energy", "[cloth-crossing]", "[strained-cloth]"];
    solved.retain(|w| !after.iter().any(|words| w.contains(words)));
    [warnings(&checked.stdout), solved]
}

/// Every doubt alone, with its numbers.
#[test]
#[ignore = "long"]
fn check_and_solve_warn_with_numbers() {
    let bench = Bench::new();
    assert_eq!(both(&bench, &LIGHT), [const { Vec::<String>::new() }; 2]);
    for (set, words) in [
        (
            "N.aero.wind=[0,0,1000]",
            "/system/network/aero/wind: the wind has 1000 m/s, 2.94 times the speed of sound (340 m/s)",
        ),
        ("N.aero.wind.table=[[0,0,0,8],[0.5,0,0,-341]]", "the wind has 341 m/s, 1 times"),
        ("N.initial.velocity=[0,0,-350]", "m/s, 1.03 times the speed of sound"),
        ("N.springs.0.rest_scale=0.5", "starts with a strain of 1 (length"),
        ("N.springs.0.dashpot={\"relative\":\"step\"}", "a \"step\" dashpot has c = k h"),
        ("N.mass.nodal=0.009", "0.054 kg on 2 m^2 of triangles are 0.027 kg/m^2; cloth has 0.03 to 1.8"),
    ] {
        let set = set.replace("N.", N);
        let arguments = [&LIGHT[..], &["--method", "newmark", "--set", &set]].concat();
        let [checked, solved] = both(&bench, &arguments);
        assert_eq!(checked.len(), 1, "{set}: {checked:?}");
        assert!(checked[0].contains(words), "{set}: {checked:?}");
        assert_eq!(checked, solved, "{set}");
    }
}

/// A step above the critical one is announced before the run, with both numbers; a method without limit has nothing to
/// announce.
#[test]
fn a_step_above_the_critical_one_is_announced() {
    let bench = Bench::new();
    let step = ["--step", "0.3", "--end", "3"];
    for (method, warned) in [
        ("velocity-verlet", true),
        ("rk4", true),
        ("newmark", false),
        ("{\"newmark\":{\"beta\":0.1666,\"gamma\":0.5}}", true),
        ("kang", false),
    ] {
        let arguments = [&LIGHT[..], &step, &["--method", method]].concat();
        let [checked, solved] = both(&bench, &arguments);
        assert_eq!(checked, solved, "{method}");
        assert_eq!(checked.len(), usize::from(warned), "{method}: {checked:?}");
        if let Some(warning) = checked.first() {
            let number = |after: &str| -> f64 {
                let rest = warning.split_once(after).expect("the words").1;
                rest.split_whitespace().next().expect("a number").parse().expect("a number")
            };
            let (times, critical) = (number("of 0.3 s is "), number("about "));
            assert!(times > 1.0 && (times * critical / 0.3 - 1.0).abs() < 0.02, "{warning}");
            let advised = number("take a step of ");
            let advised = advised.to_string();
            let good = [&LIGHT[..], &["--method", method, "--step", &advised]].concat();
            assert!(both(&bench, &good)[0].is_empty(), "{method} at {advised}");
        }
    }
    let undamped: Vec<&str> = ["aero=null", "loads=null", "damping=null", "springs.0.dashpot=null"].to_vec();
    let sets: Vec<String> = undamped.iter().flat_map(|s| ["--set".to_owned(), format!("{N}{s}")]).collect();
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    let [checked, solved] = both(&bench, &[&LIGHT[..], &["--method", "explicit-euler"], &sets].concat());
    assert!(checked.len() == 1 && checked[0].contains("has no stable step"), "{checked:?}");
    assert_eq!(checked, solved);
}

/// Springs that are all slack at the start say nothing of the step that they will need: the limit with all of them taut
/// is told too.
#[test]
fn springs_that_are_slack_at_the_start_are_told() {
    let bench = Bench::new();
    let told = |rest_scale: &str, more: &[&str]| {
        let rest = format!("{N}springs.0.rest_scale={rest_scale}");
        let slack = format!("{N}springs.0.slack=\"tension-only\"");
        both(&bench, &[&LIGHT[..], &["--set", &rest, "--set", &slack, "--step", "1"], more].concat())
    };
    let number = |warnings: &[String], after: &str| -> f64 {
        let rest = warnings.iter().find_map(|w| w.split_once(after)).expect("the words").1;
        rest.split_whitespace().next().expect("a number").parse().expect("a number")
    };
    let [checked, solved] = told("1.2", &[]);
    assert_eq!(checked, solved);
    assert!(checked.iter().any(|w| w.contains("while all 9 springs are slack")), "{checked:?}");
    let about = "on this scene, about ";
    let (taut, known) = (number(&checked, about), number(&told("0.9999", &[])[0], about));
    assert!((taut / known - 1.0).abs() < 0.1, "{taut} s, and {known} s where they start taut");
    assert!(!told("1.2", &["--method", "newmark"])[0].iter().any(|w| w.contains("slack")));
}

/// A mass between a taut spring of 1000 N/m and a slack one of 1e5 N/m: the critical step is that with both taut, in
/// `check`, `solve` and `stability`; the present one is told beside it.
#[test]
fn the_critical_step_is_that_with_all_springs_taut() {
    let (k, slack, mass) = (1e3_f64, 1e5_f64, 0.1_f64);
    let [taut, now] = [k + slack, k].map(|k| 2.0 / (k / mass).sqrt());
    let case = json!({
        "name": "taut",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "springs": [[0, 1], [1, 2]]}},
            "mass": {"nodal": mass},
            "springs": [
                {"on": {"ids": [0]}, "stiffness": k, "slack": "tension-only"},
                {"on": {"ids": [1]}, "stiffness": slack, "slack": "tension-only", "rest_scale": 1.5}
            ],
            "supports": [{"on": {"ids": [0, 2]}, "fix": "xyz"}, {"on": {"ids": [1]}, "fix": "yz"}],
            "initial": {"velocity": [[0, 0, 0], [0.01, 0, 0], [0, 0, 0]]}
        }},
        "time": {"end": 0.5, "method": "velocity-verlet", "step": 0.005}
    });
    let bench = Bench::new();
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    let run = |arguments: &[&str]| {
        let ended = bench.run(&[&arguments[..1], &["case.json"], &arguments[1..]].concat());
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        ended
    };
    let json_of = |more: &[&str]| -> Value {
        serde_json::from_str(&run(&[&["check", "--json"], more].concat()).stdout).expect("JSON")
    };
    let near = |found: &Value, expected: f64| found.as_f64().is_some_and(|h| (h / expected - 1.0).abs() < 0.01);
    let told = json_of(&[]);
    let all = told["critical_steps"].as_array().expect("a list");
    let verlet = all.iter().find(|row| row["method"] == "velocity-verlet").expect("a row");
    assert!(near(&verlet["critical_step"], taut), "{verlet}");
    let while_slack = &told["while_slack"];
    assert!(while_slack["slack"] == 1 && while_slack["springs"] == 2, "{while_slack}");
    assert!(near(&while_slack["critical_step"], now) && told["stable"] == "no", "{told}");
    let [checked, solved] = [run(&["check"]), run(&["solve", "--out", "out"])];
    assert!(
        checked.stdout.contains("  stable          no: the step is 2.51 times the critical step, 0.00199 s with all")
    );
    let words = "1 of 2 springs are slack at the start; with all of them taut the critical step of velocity-verlet is about \
                 0.00199 s";
    assert_eq!([&checked.stdout, &solved.stderr].map(|text| text.matches(words).count()), [1, 1], "{}", solved.stderr);
    assert!(
        solved.stdout.contains("with all springs taut, 0.02 s while 1 of 2 springs are slack"),
        "{}",
        solved.stdout
    );
    assert!(near(&bench.results().summary()["critical_step"], taut));
    run(&["stability", "--methods", "velocity-verlet", "--out", "limits"]);
    let limits = std::fs::read_to_string(bench.path("limits/stability.csv")).expect("a table");
    let predicted: f64 =
        limits.lines().nth(1).and_then(|row| row.split(',').nth(1)).expect("a row").parse().expect("[s]");
    assert!((predicted / taut - 1.0).abs() < 0.01, "{limits}");
    for (method, stable) in
        [("newmark", "on linear scenes"), ("esdirk4", "on linear scenes"), ("energy-momentum", "yes")]
    {
        let told = json_of(&["--method", method]);
        assert_eq!((&told["stable"], &told["while_slack"]), (&json!(stable), &Value::Null), "{method}");
    }
    let within = json_of(&["--step", "0.001"]);
    assert!(within["stable"] == "yes" && within["warnings"] == json!([]), "{within}");
}

/// Events after the end of a run are told and do not happen: the run is that of a case without them.
#[test]
fn events_after_the_end_are_told() {
    let bench = Bench::new();
    let probes = |arguments: &[&str]| {
        let [checked, solved] = both(&bench, arguments);
        assert_eq!(checked, solved, "{arguments:?}");
        (checked, bench.results().text("probes.csv"))
    };
    let (none, plain) = probes(&LIGHT);
    let cut = format!("{N}springs.0.cut=2");
    let until = format!("{N}supports.0.until=1");
    for (event, at) in [(&cut, "springs/0/cut"), (&until, "supports/0/until")] {
        let (told, same) = probes(&[&LIGHT[..], &["--set", event]].concat());
        assert_eq!(told.len(), none.len() + 1, "{told:?}");
        assert!(told.iter().any(|w| w.contains(at) && w.contains("the run ends at 1 s")), "{told:?}");
        assert!(same == plain, "{event}");
        let (reached, other) = probes(&[&LIGHT[..], &["--set", event, "--end", "2.5"]].concat());
        assert!(reached.len() == none.len() && other != plain, "{event}: {reached:?}");
    }
}

/// The size of a frame is known before it is written.
#[test]
fn frames_have_the_size_that_was_foretold() {
    let large = MESH.replace("20", "150");
    let all = "[\"force\",\"reaction\",\"tension\",\"strain\"]";
    for (fields, mesh) in [("[]", MESH), ("[\"force\",\"strain\"]", MESH), (all, MESH), ("[]", large.as_str())] {
        let bench = Bench::new();
        let sets =
            [("output.fields".to_owned(), fields.to_owned()), ("system.network.mesh".to_owned(), mesh.to_owned())];
        let sets = [&sets[..], &REST.map(|(k, v)| (k.to_owned(), v.to_owned()))].concat();
        let arguments: Vec<String> = sets.iter().flat_map(|(k, v)| ["--set".to_owned(), format!("{k}={v}")]).collect();
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let ended = bench.solve(&[&["--end", "1e-4"], arguments.as_slice()].concat());
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        let case = Case::from_text(SAIL.to_owned(), "sail.json", PathBuf::new(), &sets).expect("good");
        let scene = build_scene(case.into_problem().take_system(), 1).expect("good");
        let has = |field| fields.contains(field);
        let fields = Fields {
            force: has("force"),
            reaction: has("reaction"),
            tension: has("tension"),
            strain: has("strain"),
            rest_length: has("rest-length"),
            pressure: has("pressure"),
            membrane: false,
            crossing: true,
        };
        let foretold = frame_bytes(&*scene, fields, Precision::F64) as f64;
        let size = std::fs::metadata(bench.path("out/frames/sail_000000.vtu")).expect("a frame").len() as f64;
        assert!((foretold / size - 1.0).abs() < 0.02, "{foretold} bytes foretold, {size} written");
    }
}

const MESH: &str = r#"{"rectangle":{"width":1,"height":1,"columns":20,"rows":20}}"#;
const REST: [(&str, &str); 4] = [
    ("system.network.mass", r#"{"areal_density":0.1}"#),
    ("system.network.supports", r#"[{"on":"outer","fix":"xyz"}]"#),
    ("output.probes", "null"),
    ("time.step", "1e-4"),
];

/// Frames beyond the free room of the disk are announced: 17 MB a million times. The run itself ends at once, as it
/// must.
#[test]
#[ignore = "long"]
fn frames_beyond_the_disk_are_announced() {
    let bench = Bench::new();
    let mesh = MESH.replace("20", "200");
    let sets = [("system.network.mesh", mesh.as_str()), ("output.frames.every", "1.1e-6"), ("time.step", "0.9")];
    let sets: Vec<String> =
        sets.iter().chain(&REST[..3]).flat_map(|(k, v)| ["--set".to_owned(), format!("{k}={v}")]).collect();
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    let said = |ended: &Ended| format!("{}{}", ended.stdout, ended.stderr);
    let checked = bench.run(&[&["check", "sail.json"], sets.as_slice()].concat());
    let solved = bench.solve(&[&["--set", "system.network.aero.wind=[0,0,1e200]"], sets.as_slice()].concat());
    assert_eq!((checked.code, solved.code), (Some(0), Some(3)), "{}", solved.stderr);
    for ended in [checked, solved] {
        let warning = warnings(&said(&ended)).into_iter().find(|w| w.contains("output.frames.every"));
        let warning = warning.unwrap_or_else(|| panic!("no warning in\n{}", said(&ended)));
        assert!(warning.contains("the frames need about") && warning.contains("TB (909092 of"), "{warning}");
    }
}

/// What a mesh file's reader left out is a warning of both commands.
#[test]
fn notes_of_a_mesh_file_are_told() {
    let bench = Bench::new();
    std::fs::write(bench.path("square.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 9 9 9\nf 1 2 3\n").expect("written");
    let case = r#"{"name": "sail", "system": {"network": {"mesh": {"file": "square.obj"}, "mass": {"areal_density": 0.1}}},
                   "time": {"end": 1, "step": 0.1, "method": "rk4"}}"#;
    std::fs::write(bench.path("sail.json"), case).expect("written");
    for told in both(&bench, &[]) {
        assert!(told.iter().any(|w| w.contains("/mesh/file: 1 ")), "{told:?}");
    }
}

/// Cholesky solves with the symmetric part of a tangent that is not symmetric. With the strategy that does not use this
/// part it is refused by both commands, with its place, and nothing is written.
#[test]
fn cholesky_of_a_tangent_that_is_not_symmetric_needs_its_symmetric_part() {
    let bench = Bench::new();
    let with = |solver: &str| {
        let text = SAIL.replace("\"output\"", &format!("\"solver\": {{{solver}}},\n  \"output\""));
        std::fs::write(bench.path("sail.json"), text).expect("a case");
    };
    with("\"linear\": \"cholesky\"");
    let ended = bench.run(&["solve", "sail.json", "--method", "newmark", "--out", "kept", "--json"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stdout.contains("\"cholesky\""), "{}", ended.stdout);
    with("\"linear\": \"cholesky\", \"newton\": {\"strategy\": \"full\"}");
    for command in ["check", "solve"] {
        let ended = bench.run(&[command, "sail.json", "--method", "newmark"]);
        assert_eq!((ended.code, ended.stdout.as_str()), (Some(2), ""), "{command}");
        for words in ["/solver/linear: \"cholesky\"\n  --> sail.json:19:24", "^^^^^^^^^^", "not symmetric (air,"] {
            assert!(ended.stderr.contains(words), "{command}: no \"{words}\" in\n{}", ended.stderr);
        }
        assert_eq!(
            bench.run(&[command, "sail.json", "--method", "rk4"]).code,
            Some(0),
            "an explicit method has no tangent"
        );
        assert!(!bench.path("out").exists() || std::fs::remove_dir_all(bench.path("out")).is_ok());
    }
}

/// Conjugate gradients need a symmetric tangent, or a strategy that makes one, and nodes.
#[test]
fn conjugate_gradients_are_refused_where_they_cannot_work() {
    let bench = Bench::new();
    let solver = "\"solver\": {\"linear\": \"cg\", \"newton\": {\"strategy\": \"full\"}},\n  \"output\"";
    std::fs::write(bench.path("sail.json"), SAIL.replace("\"output\"", solver)).expect("a case");
    let pendulum = r#"{"name": "pendulum", "system": {"pendulum": {"length": 1, "mass": 2, "damping": 0, "gravity": 9.81, "angle": 0.5}},
                       "time": {"end": 1, "step": 0.1, "method": "newmark"}, "solver": {"linear": "cg"}}"#;
    std::fs::write(bench.path("pendulum.json"), pendulum).expect("a case");
    for (case, words) in
        [("sail.json", "use \"strategy\": \"auto\""), ("pendulum.json", "the symmetric blocks of a network's nodes")]
    {
        for command in ["check", "solve"] {
            let ended = bench.run(&[command, case, "--method", "newmark"]);
            assert_eq!((ended.code, ended.stdout.as_str()), (Some(2), ""), "{command} {case}");
            assert!(
                ended.stderr.contains("/solver/linear: \"cg\"") && ended.stderr.contains(words),
                "{}",
                ended.stderr
            );
        }
    }
}

/// What is said to be allowed in its place is: no hint leads to the next refusal. Nothing is written, and results that
/// stand are left.
#[test]
fn refused_solvers_lead_to_ones_that_solve() {
    let bench = Bench::new();
    let pendulum = r#"{"name": "pendulum", "system": {"pendulum": {"length": 1, "mass": 2, "damping": 0, "gravity": 9.81, "angle": 0.5}},
                       "time": {"end": 1, "step": 0.1, "method": "newmark"}}"#;
    std::fs::write(bench.path("pendulum.json"), pendulum).expect("a case");
    let mut refused = 0;
    for case in ["sail.json", "pendulum.json"] {
        for (strategy, linear) in
            ["full", "modified", "quasi", "auto"].into_iter().flat_map(|s| ["cholesky", "lu", "cg"].map(|l| (s, l)))
        {
            let of = |linear: &str| {
                let set = [format!("solver.newton.strategy={strategy}"), format!("solver.linear={linear}")];
                let sets =
                    ["--set", &set[0], "--set", &set[1], "--method", "newmark", "--force", "--out", "out", "--quiet"];
                bench.run(&[&["solve", case], &sets[..]].concat())
            };
            assert_eq!(of("auto").code, Some(0));
            let ended = of(linear);
            if ended.code == Some(0) {
                continue;
            }
            refused += 1;
            assert!(
                ended.code == Some(2) && ended.stderr.contains("/solver/linear"),
                "{case} {strategy} {linear}: {}",
                ended.stderr
            );
            assert_eq!(bench.results().summary()["status"], "completed", "results that stood are gone");
            let (_, allowed) = ended.stderr.split_once("allowed: ").expect("what is allowed");
            let (allowed, _) = allowed.split_once(" for this scene and strategy").expect("for what");
            for other in allowed.split(", ") {
                let ended = of(other.trim_matches('"'));
                assert_eq!(ended.code, Some(0), "{case} {strategy} {linear} {other}: {}", ended.stderr);
            }
        }
    }
    assert!(refused >= 8, "{refused}");
}

/// Small steps and masses are told in powers of ten.
#[test]
fn check_shows_small_numbers() {
    let bench = Bench::new();
    let ended =
        bench.run(&["check", "sail.json", "--all", "--step", "1e-12", "--set", "system.network.mass.nodal=1e-9"]);
    assert!(ended.stdout.contains("step 1e-12 s") && ended.stdout.contains("  6e-9 kg"), "{}", ended.stdout);
    let ended = bench.run(&["check", "sail.json", "--step", "1e-17"]);
    assert!(ended.stderr.contains("at least 1e-15, which makes 1e15 steps until the end"), "{}", ended.stderr);
}
