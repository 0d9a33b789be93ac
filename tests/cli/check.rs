//! `check`: what it predicts against what `solve` then counts, and what it refuses.

use crate::bench::{Bench, contents};
use crate::common::read_vtu::parse;
use serde_json::Value;

fn checked(bench: &Bench, arguments: &[&str]) -> Value {
    let ended = bench.run(&[&["check"], arguments, &["--json"]].concat());
    assert_eq!(ended.code, Some(0), "{arguments:?}: {}", ended.stderr);
    serde_json::from_str(&ended.stdout).unwrap_or_else(|e| panic!("{e}: {}", ended.stdout))
}

/// The same with a row of every method.
fn all(bench: &Bench, arguments: &[&str]) -> Value {
    checked(bench, &[arguments, &["--all"]].concat())
}

fn rows(report: &Value) -> &[Value] {
    report["methods"].as_array().expect("rows")
}

fn row<'a>(report: &'a Value, method: &str) -> &'a Value {
    rows(report).iter().find(|row| row["method"] == method).unwrap_or_else(|| panic!("no row for {method}"))
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} is no number: {value}"))
}

/// A square cloth of 12 x 12 nodes, held on one edge, in the wind or not.
fn cloth(bench: &Bench, wind: bool) -> &'static str {
    let mut case: Value = serde_json::json!({
        "name": "cloth",
        "system": {"network": {
            "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 11, "rows": 11}},
            "mass": {"areal_density": 0.5},
            "springs": [{"on": "all", "stiffness": 200.0, "dashpot": {"relative": {"time": 0.002}}}],
            "supports": [{"on": {"box": [[-0.01, -1, -1], [0.01, 2, 1]]}, "fix": "xyz"}],
            "gravity": [0, 0, -9.81]
        }},
        "time": {"end": 0.4, "method": "newmark", "step": 0.004},
        "output": {"frames": {"every": 0.1}}
    });
    if wind {
        case["system"]["network"]["aero"] = serde_json::json!({
            "wind": [0, 0, 5.0], "law": {"pressure_coefficient": {"cp": 1.2, "air_density": 1.225}}
        });
    }
    std::fs::write(bench.path("cloth.json"), case.to_string()).expect("a case");
    "cloth.json"
}

/// The pendulum of the assets.
fn pendulum(bench: &Bench) -> &'static str {
    let case = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cases/pendulum.json");
    std::fs::copy(case, bench.path("pendulum.json")).expect("a copy");
    "pendulum.json"
}

/// Steps are told exactly, force passes and factorisations within a factor of two, for every method, each with the step
/// it is told.
#[test]
fn the_work_that_check_predicts_is_the_work_that_solve_counts() {
    for wind in [false, true] {
        let bench = Bench::new();
        let case = cloth(&bench, wind);
        let report = all(&bench, &[case]);
        let mut compared = 0;
        for row in rows(&report) {
            let (method, run) = (row["method"].as_str().expect("a name"), &row["run"]);
            assert!(run.is_object() || row["refused"].is_string(), "{row}");
            if !run.is_object() || number(run, "steps") > 5000.0 {
                continue;
            }
            let step = number(row, "step").to_string();
            let ended =
                bench.run(&["solve", case, "--method", method, "--step", &step, "--out", "out", "--force", "--quiet"]);
            assert_eq!(ended.code, Some(0), "{method}: {}", ended.stderr);
            let summary = bench.results().summary();
            assert_eq!(number(run, "steps"), number(&summary, "steps"), "{method}");
            for key in
                ["force_evaluations", "tangent_assemblies", "factorizations", "linear_solves", "newton_iterations"]
            {
                let (told, counted) = (number(run, key), number(&summary, key));
                assert!(told <= 2.0 * counted && counted <= 2.0 * told.max(1.0), "{method} {key}: {told}, {counted}");
            }
            compared += 1;
        }
        assert!(compared >= 8, "only {compared} methods were compared");
    }
}

/// Adaptive steps too: their number and their work, from a trial of a part of the run.
#[test]
fn the_work_of_adaptive_steps_is_predicted() {
    let bench = Bench::new();
    let case = cloth(&bench, true);
    for method in ["velocity-verlet", "rk4", "newmark"] {
        let tolerance = ["--method", method, "--tolerance", "1e-3"];
        let report = all(&bench, &[&[case], &tolerance[..]].concat());
        let run = &row(&report, method)["run"];
        let ended = bench.run(&[&["solve", case, "--out", "out", "--force", "--quiet"], &tolerance[..]].concat());
        assert_eq!(ended.code, Some(0), "{method}: {}", ended.stderr);
        let summary = bench.results().summary();
        for key in ["steps", "force_evaluations"] {
            let (told, counted) = (number(run, key), number(&summary, key));
            assert!(told <= 2.0 * counted && counted <= 2.0 * told, "{method} {key}: {told}, {counted}");
        }
    }
}

/// The memory of a run in a process of its own, within a factor of two.
#[test]
fn memory_is_predicted_within_a_factor_of_two() {
    let bench = Bench::new();
    let mesh = r#"system.network.mesh={"rectangle": {"width": 1.0, "height": 1.0, "columns": 70, "rows": 70}}"#;
    let (cloth, pendulum) = (cloth(&bench, false), pendulum(&bench));
    for case in [&[cloth][..], &[pendulum], &[cloth, "--set", mesh]] {
        let case = [case, &["--end", "3e-4", "--step", "1e-5"]].concat();
        let report = all(&bench, &case);
        for method in ["velocity-verlet", "newmark"] {
            let more = ["--method", method, "--out", "out", "--force", "--quiet"];
            let ended = bench.run(&[&["solve"], &case[..], &more].concat());
            assert_eq!(ended.code, Some(0), "{case:?} {method}: {}", ended.stderr);
            let used = number(&bench.results().summary(), "peak_memory_bytes");
            let told = number(row(&report, method), "memory_bytes");
            assert!(told <= 2.0 * used && used <= 2.0 * told, "{case:?} {method}: {told:e} told, {used:e} used");
        }
    }
}

/// A net whose factorisation would take seconds is told with the solver that serves it, here conjugate gradients, and
/// what that takes.
#[test]
#[ignore = "long"]
fn a_large_net_is_predicted_with_what_solves_it() {
    let bench = Bench::new();
    let mesh = r#"system.network.mesh={"rectangle": {"width": 1.0, "height": 1.0, "columns": 250, "rows": 250}}"#;
    let case = [cloth(&bench, false), "--set", mesh, "--step", "1e-4", "--end", "3e-4"];
    let report = all(&bench, &case);
    let ended = bench.run(&[&["solve"], &case[..], &["--out", "out", "--quiet"]].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let summary = bench.results().summary();
    assert_eq!(report["tangent"]["linear_solver"], summary["linear_solver"]);
    assert_eq!(summary["linear_solver"], "cg", "the net is too small, or the step too long, to show it");
    let run = &row(&report, "newmark")["run"];
    assert_eq!([run, &summary].map(|work| number(work, "factorizations")), [0.0; 2]);
    for method in ["newmark", "velocity-verlet"] {
        let step = number(row(&report, method), "step").to_string();
        let more = ["--method", method, "--step", &step, "--out", "out", "--force", "--quiet"];
        let ended = bench.run(&[&["solve"], &case[..3], &["--end", "3e-4"], &more].concat());
        assert_eq!(ended.code, Some(0), "{method}: {}", ended.stderr);
        let (told, used) =
            (number(row(&report, method), "memory_bytes"), number(&bench.results().summary(), "peak_memory_bytes"));
        assert!(told <= 2.0 * used && used <= 2.0 * told, "{method}: {told:e} told, {used:e} used");
    }
}

/// What a scene of membranes is made of, and no word of springs that it does not have.
#[test]
fn membranes_are_told() {
    let bench = Bench::new();
    cloth(&bench, false);
    let mut case: Value =
        serde_json::from_slice(&std::fs::read(bench.path("cloth.json")).expect("a case")).expect("JSON");
    let network = &mut case["system"]["network"];
    network["springs"] = serde_json::json!([]);
    network["membranes"] = serde_json::json!([
        {"on": {"ids": [0, 1]}, "thickness": 1e-3, "modulus": 4e5, "poisson": 0.3},
        {"on": "all", "thickness": 1e-3, "modulus": [4e5, 2e5], "poisson": 0.3, "shear": 1e5, "warp": [1, 0, 0],
         "wrinkling": true, "damping_time": 0.001}
    ]);
    network["bending"] = serde_json::json!([{"on": "all", "stiffness": 1e-4}]);
    std::fs::write(bench.path("sheet.json"), case.to_string()).expect("a case");
    let ended = bench.run(&["check", "sheet.json", "--all"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    for words in [
        "144 nodes, 242 triangles of membrane, ",
        "membrane        2 triangles of 0.001 m: E 400000 Pa, nu 0.3\n",
        "membrane        240 triangles of 0.001 m: E 400000 Pa along the warp and 200000 Pa across, nu 0.3, G 100000 Pa, wrinkles, damped by 0.001 s\n",
        "bending         341 edges of cloth of 1e-4 N m\n",
        "the method is made for linear springs",
    ] {
        assert!(ended.stdout.contains(words), "no \"{words}\" in {}", ended.stdout);
    }
    assert!(!ended.stdout.contains("the springs"), "{}", ended.stdout);
}

/// There is a row for every method, a refused one with its reason.
#[test]
fn every_method_has_a_row() {
    let bench = Bench::new();
    let case = pendulum(&bench);
    let report = all(&bench, &[case]);
    let names: Vec<&str> = rows(&report).iter().filter_map(|row| row["method"].as_str()).collect();
    let known: Vec<&str> = canopy_fem::integrate::registry::methods().iter().map(|m| m.name).collect();
    assert_eq!(names, known);
    let kang = row(&report, "kang");
    assert!(kang["run"].is_null() && kang["refused"].as_str().is_some_and(|why| why.contains("network")), "{kang}");
    let text = bench.run(&["check", case, "--all"]).stdout;
    for name in known {
        assert!(
            text.lines().filter(|line| line.trim_start_matches(['*', ' ']).starts_with(name)).count() >= 2,
            "{name}: {text}"
        );
    }
}

/// What is not modelled costs nothing and is not told.
#[test]
fn a_scene_without_air_shows_no_air() {
    let bench = Bench::new();
    for wind in [false, true] {
        let case = cloth(&bench, wind);
        let report = checked(&bench, &[case]);
        let terms = report["force"]["terms"].as_array().expect("terms");
        let air = terms.iter().find(|term| term["name"] == "air");
        assert_eq!(air.is_some(), wind, "{terms:?}");
        if let Some(air) = air {
            assert!(number(air, "elements") == 242.0 && number(air, "seconds") > 0.0, "{air}");
        }
        let text = bench.run(&["check", case, "--all"]).stdout;
        assert!(text.contains("    springs") && text.contains("    air") == wind, "{text}");
    }
}

/// An accuracy is a share of the numbers or a number with its unit; the default is the case's tolerance, else 1 %.
#[test]
fn an_accuracy_out_of_range_is_refused() {
    let bench = Bench::new();
    let case = pendulum(&bench);
    for (wrong, words) in
        [("0", "not above 0"), ("1", "below the whole value"), ("-1e-3", "not above 0"), ("fine", "such as 1%")]
    {
        let ended = bench.run(&["check", case, "--within", wrong]);
        assert_eq!(ended.code, Some(2), "{wrong}: {}", ended.stderr);
        assert!(ended.stderr.contains(words), "{wrong}: {}", ended.stderr);
    }
    for (arguments, accuracy) in [
        (&[][..], "1 %"),
        (&["--tolerance", "1e-5"], "0.001 %"),
        (&["--tolerance", "1e-5", "--accuracy", "0.02"], "2 %"),
    ] {
        let report = checked(&bench, &[&[case], arguments].concat());
        assert_eq!(report["within"], accuracy, "{arguments:?}");
    }
}

/// Trials leave nothing.
#[test]
fn nothing_is_written() {
    let bench = Bench::new();
    let case = cloth(&bench, true);
    let before = contents(&bench.path(""));
    for more in [&[][..], &["--json"], &["--accuracy", "1e-2"]] {
        assert_eq!(bench.run(&[&["check", case], more].concat()).code, Some(0));
    }
    assert_eq!(contents(&bench.path("")), before);
}

/// All positions at the frames of a run.
fn frames(bench: &Bench, arguments: &[&str]) -> Vec<Vec<f64>> {
    let ended = bench.run(&[&["solve"], arguments, &["--out", "out", "--force", "--quiet"]].concat());
    assert_eq!(ended.code, Some(0), "{arguments:?}: {}", ended.stderr);
    let mut files: Vec<_> =
        std::fs::read_dir(bench.path("out/frames")).expect("frames").flatten().map(|e| e.path()).collect();
    files.sort();
    let positions = |path: &std::path::PathBuf| parse(&std::fs::read(path).expect("a frame")).floats("Points");
    files.iter().map(positions).collect()
}

/// Root mean square distance of two runs over the root mean square motion of the first.
fn error(reference: &[Vec<f64>], other: &[Vec<f64>]) -> f64 {
    assert_eq!(reference.len(), other.len());
    let square = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum() };
    let off: f64 = reference.iter().zip(other).map(|(a, b)| square(a, b)).sum();
    let moved: f64 = reference.iter().map(|a| square(&reference[0], a)).sum();
    (off / moved).sqrt()
}

/// A file of the assets.
fn asset(bench: &Bench, name: &'static str) -> &'static str {
    let case = format!("{}/assets/cases/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::copy(case, bench.path(name)).expect("a copy");
    name
}

/// What is recommended for an accuracy delivers it, and what is said of the case's own run is true: measured against
/// dop853 with a far smaller tolerance.
#[test]
fn what_is_recommended_delivers_the_wanted_accuracy() {
    for (name, end, accuracies) in [
        ("cloth", "0.4", &["1%"][..]),
        ("pendulum.json", "20", &["1%", "1e-4"]),
        ("spring-pendulum.json", "10", &["1e-2"]),
        ("oscillator-damped.json", "30", &["1e-2", "1e-3"]),
    ] {
        let bench = Bench::new();
        let case = if name == "cloth" { cloth(&bench, true) } else { asset(&bench, name) };
        let case = [case, "--end", end];
        let reference = frames(&bench, &[&case[..], &["--method", "dop853", "--tolerance", "1e-9"]].concat());
        let own = error(&reference, &frames(&bench, &case));
        for accuracy in accuracies {
            let wanted = accuracy.strip_suffix('%').map_or_else(
                || accuracy.parse::<f64>().expect("a number"),
                |percent| percent.parse::<f64>().expect("a number") / 100.0,
            );
            let quantity = ["--within", accuracy, "--quantity", "motion"];
            let report = checked(&bench, &[&case[..], &quantity].concat());
            let told = number(&report["this_case"]["errors"]["motion"], "error");
            assert!(own < 3.0 * told && told < 10.0 * own, "{name}: {own:e} made, {told:e} told");
            let recommended = report["recommended"].as_array().expect("a list");
            assert!(!recommended.is_empty(), "{name} {accuracy}: {report}");
            for choice in recommended {
                let method = choice["method"].as_str().expect("a method");
                let step = number(choice, "step").to_string();
                let run = frames(&bench, &[&case[..], &["--method", method, "--step", &step]].concat());
                let made = error(&reference, &run);
                assert!(made <= 1.05 * wanted, "{name} {method} --step {step}: {made:e} for {wanted:e}");
                let told = number(&choice["errors"]["motion"], "error");
                assert!(made < 3.0 * told, "{name} {method} --step {step}: {made:e}, {told:e} told");
            }
        }
    }
}

/// The clock has no part in what is recommended where costs are clearly apart or equal.
#[test]
#[ignore = "long"]
fn the_same_question_has_the_same_answer() {
    let bench = Bench::new();
    for case in [cloth(&bench, true), asset(&bench, "pendulum.json"), asset(&bench, "spring-pendulum.json")] {
        let answers: Vec<Value> = (0..4)
            .map(|_| {
                let best = &checked(&bench, &[case, "--accuracy", "1e-3"])["recommended"][0];
                serde_json::json!([best["method"], best["step"], best["errors"]])
            })
            .collect();
        assert!(answers.iter().all(|answer| *answer == answers[0]), "{answers:?}");
    }
}

/// The processor time of adaptive runs is told when the case has a tolerance: for every method that of its own steps.
#[test]
fn a_tolerance_of_the_case_is_predicted_with() {
    let bench = Bench::new();
    let case = cloth(&bench, false);
    let report = all(&bench, &[case, "--tolerance", "1e-3"]);
    let steps = |method: &str| number(&row(&report, method)["run"], "steps");
    assert!(row(&report, "newmark")["step"].is_null() && number(row(&report, "newmark"), "tolerance") == 1e-3);
    assert!(steps("explicit-euler") > 3.0 * steps("velocity-verlet"), "{report}");
    for method in ["velocity-verlet", "newmark"] {
        let run = &row(&report, method)["run"];
        assert!(number(run, "cpu_seconds") >= number(run, "steps") * number(run, "step_seconds"), "{run}");
    }
}

/// A run whose adaptive steps change along it is no multiple of its beginning, and where it is far too long to be made
/// its figure is marked.
#[test]
#[ignore = "long"]
fn adaptive_steps_that_change_along_the_run_are_told_as_doubtful() {
    let bench = Bench::new();
    let case = [asset(&bench, "cloth-k1000.json"), "--method", "euler-cromer", "--tolerance", "1e-3"];
    let report = all(&bench, &case);
    assert_eq!(row(&report, "kang")["run"]["doubtful"], true);
    let ended = bench.run(&[&["solve"], &case[..], &["--out", "out", "--quiet"]].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let (told, counted) =
        (number(&row(&report, "euler-cromer")["run"], "steps"), number(&bench.results().summary(), "steps"));
    assert!(told <= 3.0 * counted && counted <= 3.0 * told, "{told} told, {counted} counted");
}

/// A line of light nodes that is short of tension until it is reeled in, and a support that lets go of a light node:
/// the critical step afterwards is told, and a warning where the step is above it.
#[test]
fn the_critical_step_after_an_event_is_told() {
    let case = serde_json::json!({
        "name": "later",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "springs": [[0, 1], [1, 2]]}},
            "mass": {"nodal": [1.0, 1.0, 0.01]},
            "springs": [{"on": "all", "stiffness": 100.0}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [2]}, "fix": "xyz", "until": 0.5}]
        }},
        "time": {"end": 1.0, "method": "velocity-verlet", "step": 0.05},
        "output": {"frames": {"every": 0.5}}
    });
    let bench = Bench::new();
    std::fs::write(bench.path("later.json"), case.to_string()).expect("a case");
    let report = checked(&bench, &["later.json"]);
    let later = &report["later_critical_step"];
    assert_eq!(number(later, "from"), 0.5);
    // Two springs on 1 kg and a free 0.01 kg: w^2 is the larger root of w^4 - (200 + 1e4) w^2 + 1e6 = 0.
    let square = 5100.0 + (5100.0_f64 * 5100.0 - 1e6).sqrt();
    let limit = number(later, "critical_step");
    assert!((limit / (2.0 / square.sqrt()) - 1.0).abs() < 0.02, "{limit}");
    let warned = report["warnings"].as_array().expect("warnings").iter().filter_map(Value::as_str);
    assert!(warned.clone().any(|text| text.contains("from t = 0.5 s on")), "{:?}", report["warnings"]);
    let ended = bench.run(&["check", "later.json"]);
    assert!(ended.stdout.contains("from t = 0.5 s on"), "{}", ended.stdout);
    let text = case.to_string().replace(",\"until\":0.5", "");
    assert_ne!(text, case.to_string());
    std::fs::write(bench.path("never.json"), text).expect("a case");
    assert!(checked(&bench, &["never.json"])["later_critical_step"].is_null());
    // Reeled in to a fifth, a line resists motion across it, which it did not at rest: w^2 = 2 T/(l m).
    let mut reeled = case;
    reeled["system"]["network"]["springs"][0]["rest_scale"] = serde_json::json!({"table": [[0, 1.0], [0.4, 0.2]]});
    reeled["system"]["network"]["supports"] =
        serde_json::json!([{"on": {"ids": [0, 2]}, "fix": "xyz"}, {"on": {"ids": [1]}, "fix": "x"}]);
    std::fs::write(bench.path("reeled.json"), reeled.to_string()).expect("a case");
    let later = checked(&bench, &["reeled.json"])["later_critical_step"].clone();
    let expected = 2.0 / (2.0 * 100.0 * 0.8_f64).sqrt();
    assert_eq!(number(&later, "from"), 0.4);
    assert!((number(&later, "critical_step") / expected - 1.0).abs() < 0.02, "{later}");
}

/// The gauge of a rule of springs is named by its group alone, and with another number of the rule.
#[test]
fn a_quantity_of_lines_needs_no_number_of_its_rule() {
    let bench = Bench::new();
    let case = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cases/parachute/c9-drop.json");
    let value = |name: &str| {
        let quantity = format!("{name}.tension.peak");
        let more = ["--end", "0.01", "--quantity", &quantity, "--out", "out", "--force", "--quiet"];
        let ended = bench.run(&[&["solve", case], &more[..]].concat());
        assert_eq!(ended.code, Some(0), "{name}: {}", ended.stderr);
        number(&bench.results().summary()["quantities"][&quantity], "value")
    };
    let exact = value("springs[5] lines");
    assert!(exact > 0.0 && value("lines") == exact && value("springs[2] lines") == exact);
    let ended = bench.run(&["check", case, "--quantity", "rope.tension.peak"]);
    assert!(ended.code == Some(2) && ended.stderr.contains("gauge \"rope\""), "{}", ended.stderr);
}
