//! Reports and messages that a person reads once: the answer first, one and many, what is wrong as well as what is
//! allowed, and names that people type.

use crate::bench::{Bench, SAIL};
use serde_json::{Value, json};

/// The first lines of `check` are the answer, in this order; the tables come with `--all`, below it.
#[test]
fn check_answers_first() {
    let bench = Bench::new();
    let short = bench.run(&["check", "sail.json"]).stdout;
    let label = |line: &str| line.get(2..18).unwrap_or(line).trim().to_owned();
    let answer = short.lines().skip(1).filter(|line| !line.starts_with("warning: "));
    let labels: Vec<String> = answer.map(label).filter(|label| label != "or").collect();
    assert_eq!(short.lines().next(), Some("sail: no faults"));
    let expected = ["your run", "its numbers", "within 1 %", "known", "stable", "size", "more"];
    assert_eq!(labels, expected, "{short}");
    assert!(short.contains("  your run        velocity-verlet, step 0.01 s: 100 steps, about "), "{short}");
    assert!(short.contains("  its numbers     ") && short.contains(" ± "), "{short}");
    assert!(short.contains("  stable          yes: the step is "), "{short}");
    assert!(short.contains("  size            6 nodes, 9 springs, 4 triangles, 12 unknowns, 3.15 kg"), "{short}");
    let all = bench.run(&["check", "sail.json", "--all"]).stdout;
    let (answer, tables) = all.split_once("\n\n").expect("an answer and tables");
    assert!(answer.lines().count() < 11 && answer.contains("  stable ") && !answer.contains("  more "), "{answer}");
    for words in ["  network         6 nodes", "  forces          springs", "critical steps [s]", "* velocity-verlet"] {
        assert!(tables.contains(words), "no {words} in {tables}");
    }
}

/// The answer says whether the step is stable: below, above and after an event, for adaptive steps and without limit.
#[test]
fn check_says_whether_the_step_is_stable() {
    let bench = Bench::new();
    let answer = |more: &[&str]| {
        let ended = bench.run(&[&["check", "sail.json"], more].concat());
        let line = ended.stdout.lines().find(|line| line.starts_with("  stable ")).map(str::to_owned);
        line.unwrap_or_else(|| panic!("{more:?}: {}{}", ended.stdout, ended.stderr))
    };
    for (more, words) in [
        (&["--step", "0.001"][..], "yes: the step is "),
        (&["--step", "0.5"], "no: the step is "),
        (&["--tolerance", "1e-3"], "yes: adaptive steps stay below the critical step, "),
        (&["--method", "newmark"], "on linear scenes: the method has no largest stable step there"),
        (&["--method", "backward-euler"], "yes: no largest stable step was found for this method"),
    ] {
        let line = answer(more);
        assert!(line.contains(words), "{more:?}: {line}");
    }
    // Springs that go slack, undamped, in steps above their motion: the method makes energy, and `solve` says so too.
    let key = |key: &str| format!("system.network.{key}");
    let slack = [key("damping=null"), key("springs.0.dashpot=null"), key("springs.0.slack=\"tension-only\"")];
    let sets: Vec<&str> = slack.iter().flat_map(|set| ["--set", set]).collect();
    let line = answer(&[&["--method", "newmark", "--step", "0.5"], &sets[..]].concat());
    assert!(line.contains("w h = ") && line.contains("expect it to make energy"), "{line}");
    for more in [&["--method", "newmark", "--step", "1e-4"], &["--method", "backward-euler", "--step", "0.5"]] {
        let line = answer(&[&more[..], &sets[..]].concat());
        assert!(!line.contains("to make energy"), "{more:?}: {line}");
    }
    let above = bench.run(&["check", "sail.json", "--step", "0.5"]).stdout;
    assert!(above.starts_with("sail: no faults, 1 warning below\n"), "{above}");
    assert!(above.contains("  your run        fails at t = "), "{above}");
}

/// One step is not "1 steps", and the displacement and the energy error are whole sentences.
#[test]
fn one_and_many_are_told_apart() {
    let bench = Bench::new();
    let one = bench.solve(&["--end", "0.01"]).stdout;
    assert!(one.starts_with("sail: completed at t = 0.01 s after 1 step of velocity-verlet\n"), "{one}");
    assert!(one.contains(" m at the end, the largest, of node "), "{one}");
    let many = bench.solve(&["--force", "--tolerance", "1e-4"]).stdout;
    assert!(many.contains(" steps of velocity-verlet\n") && many.contains(" on average, "), "{many}");
    assert!(!many.contains(" 1 attempts"), "{many}");
}

/// A bob that swings with ever longer steps of a method that damps: good, doubtful, wrong, as the thresholds say.
#[test]
fn the_energy_error_has_a_verdict() {
    let bench = Bench::new();
    let case = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cases/pendulum.json");
    let mut seen = Vec::new();
    for step in ["0.0001", "0.0005", "0.005"] {
        let ended =
            bench.run(&["solve", case, "--method", "backward-euler", "--step", step, "--force", "--out", "out"]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        let error = bench.results().summary()["energy_error"].as_f64().expect("a number");
        let expected = if error < 0.01 {
            "good"
        } else if error < 0.1 {
            "doubtful"
        } else {
            "wrong"
        };
        let line = ended.stdout.lines().find(|line| line.contains("energy error")).expect("a line");
        assert!(line.contains(&format!(" of the energy that was exchanged: {expected} (")), "{error}: {line}");
        // The implicit Euler method takes energy.
        assert_eq!(line.contains("took energy from the motion"), expected != "good", "{line}");
        seen.push(expected);
    }
    let kept = bench.run(&["solve", case, "--step", "0.01", "--force", "--out", "out"]);
    assert!(kept.stdout.contains(": good (below 1 %)"), "{}", kept.stdout);
    assert_eq!(seen, ["good", "doubtful", "wrong"]);
}

fn refused(bench: &Bench, change: (&str, Value)) -> String {
    let mut case: Value = serde_json::from_str(SAIL).expect("JSON");
    *case.pointer_mut(change.0).unwrap_or_else(|| panic!("nothing at {}", change.0)) = change.1;
    std::fs::write(bench.path("bad.json"), case.to_string()).expect("a case");
    let ended = bench.run(&["check", "bad.json"]);
    assert_eq!(ended.code, Some(2), "{}", ended.stdout);
    ended.stderr
}

/// A message says what was found as well as what is expected.
#[test]
fn messages_say_what_is_wrong() {
    let bench = Bench::new();
    for (place, value, words) in [
        ("/time/step", json!("fast"), "  wrong: expected a number, found a text\n  allowed: a number"),
        ("/time/step", json!("0.01"), "expected a number, found a text in double quotes"),
        ("/time/end", json!([1]), "expected a number, found a list"),
        ("/system/network/gravity", json!([0, -9.81]), "the list has 2 entries"),
        ("/system/network/springs", json!({"on": "all"}), "expected a list, found an object"),
        ("/system/network/mesh/explicit/springs/0/0", json!(0.5), "expected a whole number, found one with a fraction"),
        ("/system/network/mesh/explicit/springs/0/0", json!(-1), "expected a whole number, found a negative one"),
        ("/name", json!(3), "expected a text, found a number"),
        ("/time", json!({"end": 1.0, "method": "rk4", "steps": 0.1}), "  wrong: there is no key \"steps\" here\n"),
    ] {
        let text = refused(&bench, (place, value.clone()));
        assert!(text.contains(words), "{place} = {value}: no \"{words}\" in\n{text}");
    }
}

/// Names that people type lead to the method that is meant, in a case, on the command line and in a study.
#[test]
fn other_names_of_methods_are_known() {
    let bench = Bench::new();
    for (name, method) in [
        ("runge-kutta", "rk4"),
        ("RK4", "rk4"),
        ("rk45", "dormand-prince"),
        ("ode45", "dormand-prince"),
        ("leapfrog", "velocity-verlet"),
        ("verlet", "velocity-verlet"),
        ("central_difference", "central-difference"),
        ("CDM", "central-difference"),
        ("implicit-euler", "backward-euler"),
        ("forward-euler", "explicit-euler"),
        ("symplectic-euler", "euler-cromer"),
        ("trapezoidal", "newmark"),
        ("Newmark-beta", "newmark"),
        ("hht-alpha", "hht"),
        ("generalised-alpha", "generalized-alpha"),
        ("SDIRK4", "esdirk4"),
        ("Simo-Tarnow", "energy-momentum"),
    ] {
        let ended = bench.run(&["check", "sail.json", "--method", name]);
        assert_eq!(ended.code, Some(2), "{name}");
        let hint = ended.stderr.lines().find(|line| line.starts_with("  hint: ")).unwrap_or_default();
        assert!(hint.contains(&format!("\"{method}\"")), "{name}: {hint} in {}", ended.stderr);
    }
    let study = bench.run(&["tradeoff", "sail.json", "--methods", "leapfrog"]);
    assert_eq!(study.code, Some(2));
    assert!(study.stderr.contains("\"velocity-verlet\""), "{}", study.stderr);
}

/// A mesh of another format is refused with the converter that works for it, by name and command.
#[test]
fn other_mesh_formats_name_their_converter() {
    let bench = Bench::new();
    for (file, words) in [
        ("canopy.xdmf", "files \".xdmf\" are not read"),
        ("canopy.xdmf", "`meshio convert canopy.xdmf canopy.vtu`"),
        ("canopy.step", "`gmsh -2 canopy.step -o canopy.msh`"),
        ("canopy.unv", "`gmsh -save canopy.unv -o canopy.msh`"),
        ("canopy.fbx", "`assimp export canopy.fbx canopy.glb`"),
        ("canopy.dwg", "export it as .dxf, .obj or .stl"),
        ("canopy.blend", "Blender"),
        ("canopy.zzz", "files \".zzz\" are not read; read are .vtu, .vtp, .vtk, .msh"),
        ("canopy", "no extension"),
    ] {
        std::fs::write(bench.path(file), "x").expect("a file");
        let ended = bench.run(&["mesh", "inspect", file]);
        assert_eq!(ended.code, Some(2), "{file}");
        assert!(ended.stderr.contains(words), "{file}: no \"{words}\" in {}", ended.stderr);
    }
}
