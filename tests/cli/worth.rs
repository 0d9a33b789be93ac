//! `solve --verify` and `--within`: the errors that are told against the true ones.

mod forms;

use crate::bench::Bench;
use serde_json::{Value, json};

/// Writes the oscillator with a method and a step.
fn oscillator(bench: &Bench, method: &str, step: f64) -> &'static str {
    written(bench, forms::oscillator().case, &json!(method), step)
}

fn written(bench: &Bench, mut case: Value, method: &Value, step: f64) -> &'static str {
    (case["time"]["method"], case["time"]["step"]) = (method.clone(), json!(step));
    std::fs::write(bench.path("case.json"), case.to_string()).expect("a case");
    "case.json"
}

/// Runs `solve` and asks for these numbers; none where the method does not run with this step.
fn asked(bench: &Bench, arguments: &[&str], exact: &[(String, f64)]) -> Option<Value> {
    let names = exact.iter().flat_map(|(name, _)| ["--quantity", name]);
    let all: Vec<&str> = ["solve"].into_iter().chain(arguments.iter().copied()).chain(names).collect();
    let ended = bench.run(&[&all[..], &["--out", "out", "--force", "--quiet"]].concat());
    assert!(matches!(ended.code, Some(0 | 3)), "{arguments:?}: {}", ended.stderr);
    (ended.code == Some(0)).then(|| bench.results().summary()["quantities"].clone())
}

/// The true error is below three times the one that is told, for every method and four steps each, but for a few rows
/// (one in twenty), and below ten times in all; and it is not told far too large.
#[test]
fn errors_that_are_told_are_those_that_are_made() {
    let (mut beyond, mut far, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    let methods = ["velocity-verlet", "euler-cromer", "rk4", "newmark", "backward-euler", "energy-momentum", "dop853"];
    let methods = methods.into_iter().map(|name| json!(name)).chain([json!({"hht": {"alpha": -0.1}})]);
    let methods: Vec<Value> = methods.collect();
    for form in forms::all() {
        let mut told_of = 0;
        for (method, step) in methods.iter().flat_map(|method| form.steps.map(|step| (method, step))) {
            let bench = Bench::new();
            let case = written(&bench, form.case.clone(), method, step);
            let Some(told) = asked(&bench, &[case, "--verify"], &form.exact) else { continue };
            for (name, exact) in &form.exact {
                let quantity = &told[name];
                let value = quantity["value"].as_f64().unwrap_or_else(|| panic!("{name}: {told}"));
                let Some(error) = quantity["error"].as_f64() else { continue };
                let made = (value - exact).abs();
                let what = format!("{} {method} {step} {name}: {made:e} made, {error:e} told", form.name);
                told_of += 1;
                ratios.push(made / error);
                if made > 10.0 * error {
                    far.push(what);
                } else if made > 3.0 * error {
                    beyond.push(what);
                }
            }
        }
        assert!(told_of > 8 * form.exact.len(), "{}: {told_of}", form.name);
    }
    let rows = ratios.len();
    assert!(rows > 400, "{rows}");
    assert!(far.is_empty(), "{far:#?}");
    assert!(20 * beyond.len() <= rows, "{} of {rows}: {beyond:#?}", beyond.len());
    ratios.sort_by(f64::total_cmp);
    println!("{rows} rows, {} beyond 3 times, median {:.3}: {beyond:#?}", beyond.len(), ratios[rows / 2]);
    assert!(ratios[rows / 2] > 0.05, "told errors are far too large: {ratios:?}");
}

/// The run that is kept is within the accuracy, and no more expensive one is.
#[test]
fn the_step_for_an_accuracy_is_found() {
    let exact = forms::oscillator().exact;
    for (method, accuracy) in [("newmark", "10%"), ("newmark", "1e-4"), ("rk4", "1%"), ("velocity-verlet", "3%")] {
        let bench = Bench::new();
        let arguments = [oscillator(&bench, method, 0.005), "--within", accuracy];
        let quantities = asked(&bench, &arguments, &exact).expect("a run");
        let wanted = match accuracy.strip_suffix('%') {
            Some(percent) => percent.parse::<f64>().expect("a number") / 100.0,
            None => accuracy.parse().expect("a number"),
        };
        for (name, exact) in &exact {
            let value = quantities[name]["value"].as_f64().expect("a value");
            assert!((value - exact).abs() <= wanted * exact.abs(), "{method} {accuracy} {name}: {value}, {exact}");
        }
        let step = bench.results().summary()["case"]["time"]["step"].as_f64().expect("a step");
        assert!((step > 0.005) == (accuracy != "1e-4"), "{method} {accuracy}: {step}");
    }
}

/// Numbers are printed with their errors, and asked for by name; what is not there is refused with what is.
#[test]
fn numbers_are_printed_with_their_errors() {
    let bench = Bench::new();
    let case = oscillator(&bench, "newmark", 0.02);
    let ended = bench.run(&["solve", case, "--verify", "--quantity", "bob.z.last", "--quantity", "wall.reaction.peak"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let peak = ended.stdout.lines().find(|line| line.contains("(wall, reaction)")).expect("a line");
    assert!(peak.contains(" ± "), "{peak}");
    for words in ["quantity        wall.reaction.peak = ", "± by the step   beside step 0.04 s, step 0.08 s"] {
        assert!(ended.stdout.contains(words), "no \"{words}\" in {}", ended.stdout);
    }
    let refused = bench.run(&["solve", case, "--verify", "--quantity", "wall.tension.peak", "--out", "other"]);
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    assert!(refused.stderr.contains("no column \"tension\" of wall") && refused.stderr.contains("reaction_total"));
    assert!(!bench.path("other").exists(), "nothing is written");
    let unit = bench.run(&["solve", case, "--within", "20N", "--quantity", "bob.speed.peak", "--out", "other"]);
    assert!(unit.code == Some(2) && unit.stderr.contains("is in m/s, not in N"), "{}", unit.stderr);
    let form = bench.run(&["solve", case, "--quantity", "wall"]);
    assert!(form.code == Some(2) && form.stderr.contains("/study/quantities/0"), "{}", form.stderr);
}

/// Where the motion of the runs differs by much of itself, as in a net that swings as fast as the steps follow, a value
/// at the end has no error, even if the runs agree there.
#[test]
fn values_at_the_end_of_other_motions_are_not_settled() {
    let bench = Bench::new();
    let case = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/guide/cases/hypar.json");
    let ended = bench.run(&["solve", case, "--verify", "--quantity", "motion", "--quantity", "displacement_end"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let line = ended.stdout.lines().find(|line| line.trim_start().starts_with("not settled"));
    assert!(line.is_some_and(|line| line.contains("displacement_end: the runs contradict")), "{}", ended.stdout);
    assert!(
        !ended.stdout.lines().any(|line| line.contains("displacement") && line.contains(" ± ")),
        "{}",
        ended.stdout
    );
}

/// Steps of explicit methods near their limit are compared with shorter ones.
#[test]
fn beside_a_step_near_the_limit_goes_one_of_half_of_it() {
    let bench = Bench::new();
    let case = oscillator(&bench, "velocity-verlet", 0.2);
    let ended = bench.run(&["solve", case, "--verify", "--quantity", "wall.reaction.peak"]);
    assert!(ended.stdout.contains("± by the step   beside step 0.1 s\n"), "{}", ended.stdout);
    let within =
        bench.run(&["solve", case, "--within", "1e-9", "--quantity", "bob.x.last", "--out", "fine", "--quiet"]);
    assert!(within.code == Some(3) && within.stderr.contains("no run was within"), "{}", within.stderr);
}

/// A folder with results is refused before runs are made to find a step: here none would be within the accuracy.
#[test]
fn results_are_refused_before_a_step_is_looked_for() {
    let bench = Bench::new();
    let case = oscillator(&bench, "velocity-verlet", 0.2);
    assert_eq!(bench.run(&["solve", case, "--quiet", "--out", "out"]).code, Some(0));
    let within = ["--within", "1e-9", "--quantity", "bob.x.last"];
    let ended = bench.run(&[&["solve", case, "--quiet", "--out", "out"], &within[..]].concat());
    assert!(ended.code == Some(2) && ended.stderr.contains("already holds results"), "{}", ended.stderr);
}

/// The errors of a run do not change it: frames and history are byte-equal.
#[test]
fn a_run_is_the_same_with_its_errors() {
    let bench = Bench::new();
    let case = oscillator(&bench, "newmark", 0.02);
    for (more, out) in [(&["--verify"][..], "with"), (&[], "without")] {
        let ended = bench.run(&[&["solve", case, "--quiet", "--out", out], more].concat());
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    }
    for file in ["history.csv", "gauges.csv", "probes.csv"] {
        let [a, b] = ["with", "without"].map(|out| std::fs::read(bench.path(out).join(file)).expect("a file"));
        assert!(a == b, "{file}");
    }
}

/// What a tolerance gives stands in the column of all other lines of the report.
#[test]
fn errors_by_a_tolerance_have_a_line() {
    let bench = Bench::new();
    let case = oscillator(&bench, "dop853", 0.01);
    let ended = bench.run(&["solve", case, "--out", "out", "--verify", "--tolerance", "1e-5"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let line = "  ± by tolerance  beside tolerance 1e-4, tolerance 1e-3\n";
    assert!(ended.stdout.contains(line), "{}", ended.stdout);
}
