//! A critical step that falls while a run goes on is told once, with its numbers, and changes nothing else.

use crate::bench::Bench;

/// A mass between two springs, pulled across by a growing force: at first nothing holds it, at last both springs do.
const STRING: &str = r#"{
  "name": "sail",
  "system": {"network": {
    "mesh": {"explicit": {"nodes": [[-1,0,0],[0,0,0],[1,0,0]], "springs": [[0,1],[1,2]]}},
    "mass": {"nodal": 0.5},
    "springs": [{"on": "all", "stiffness": 50.0}],
    "supports": [{"on": {"ids": [0, 2]}, "fix": "xyz"}, {"on": {"ids": [1]}, "fix": "xy"}],
    "loads": [{"on": {"ids": [1]}, "force": [0, 0, 1], "table": [[0, 0], [100, 400]]}]
  }},
  "time": {"end": 100, "method": "velocity-verlet", "step": 0.16},
  "output": {"frames": {"every": 10}, "probes": [{"name": "mid", "on": {"ids": [1]}}]}
}"#;

fn string() -> Bench {
    let bench = Bench::new();
    std::fs::write(bench.path("sail.json"), STRING).expect("a case");
    bench
}

fn told(stderr: &str) -> Vec<&str> {
    stderr.lines().filter(|line| line.contains("has fallen")).collect()
}

/// The number after some words.
fn number(text: &str, words: &str) -> f64 {
    let rest = text.split_once(words).unwrap_or_else(|| panic!("no \"{words}\" in {text}")).1;
    let end = rest.find([' ', ',']).unwrap_or(rest.len());
    rest[..end].parse().unwrap_or_else(|_| panic!("no number after \"{words}\" in {text}"))
}

/// Across the springs, at height z, K = 2 (T/l (1 - n^2) + k n^2) with n = z/l, so w^2 goes from 0 to 2 k/m = 200 and
/// the limit to 2/sqrt(200) = 0.1414 s: 0.16 s is too much from some time on, 0.139 s never is.
#[test]
fn a_string_that_is_pulled_taut_warns_once() {
    let bench = string();
    let started = bench.run(&["check", "sail.json"]);
    assert!(!started.stdout.contains("warning"), "nothing is to be said of the start: {}", started.stdout);
    let ended = bench.solve(&[]);
    let warnings = told(&ended.stderr);
    assert_eq!(warnings.len(), 1, "{}", ended.stderr);
    let (t, step) = (number(warnings[0], "at t = "), number(warnings[0], "fallen to about "));
    assert!((0.1414..0.16).contains(&step) && t > 1.0 && t < 100.0, "{}", warnings[0]);
    for words in
        ["velocity-verlet", "(certified; set around node 1, spring ", "below the step of 0.16 s", "time.method=newmark"]
    {
        assert!(warnings[0].contains(words), "no \"{words}\" in {}", warnings[0]);
    }
    assert!(number(warnings[0], "take a step of ") < step, "{}", warnings[0]);
    for arguments in [&["--step", "0.139"][..], &["--method", "newmark"], &["--method", "kang"]] {
        let ended = bench.solve(&[&["--force"], arguments].concat());
        assert!(told(&ended.stderr).is_empty(), "{arguments:?}: {}", ended.stderr);
    }
    assert!(bench.solve(&["--force", "--quiet"]).stderr.lines().all(|line| !line.contains("warning")));
}

/// Wind that grows fastens the air's damping, m/(dF/dv), until the step is too long for it.
#[test]
fn wind_that_grows_warns_with_an_estimate() {
    let bench = Bench::new();
    let wind = "system.network.aero.wind={\"table\":[[0,0,0,1],[10,0,0,300]]}";
    let law = "system.network.aero.law={\"pressure_coefficient\":{\"cp\":1.2,\"air_density\":1.225}}";
    let ended = bench.solve(&["--set", wind, "--set", law, "--step", "0.01", "--end", "10"]);
    let warnings = told(&ended.stderr);
    assert_eq!(warnings.len(), 1, "{}", ended.stderr);
    assert!(
        number(warnings[0], "fallen to about ") < 0.01 && warnings[0].contains("(an estimate; "),
        "{}",
        warnings[0]
    );
}
