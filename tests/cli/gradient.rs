//! `canopy-fem gradient`: what it prints, and its exit statuses.

use crate::bench::{Bench, contents};
use serde_json::{Value, json};

fn written(bench: &Bench) -> &'static str {
    let case = json!({
        "name": "weight",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [0, 0, -1.15]], "springs": [[0, 1]], "triangles": []}},
            "mass": {"nodal": 0.7},
            "springs": [{"on": "all", "stiffness": 50.0, "rest_length": 1.1}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "gravity": [0, 0, -9.81]
        }},
        "time": {"end": 1.0, "method": "newmark", "step": 0.01},
        "output": {"gauges": [{"name": "line", "on": "all", "of": "tension"}]}
    });
    std::fs::write(bench.path("case.json"), case.to_string()).expect("a case");
    "case.json"
}

/// The report ranks the keys, tells units and the time of the peak, and `--verify` agrees with whole runs.
#[test]
fn derivatives_are_ranked_with_their_units() {
    let bench = Bench::new();
    let keys = ["--of", "line.tension.peak", "--by", "mass.nodal", "--by", "springs.0.stiffness", "--by", "gravity"];
    let ended = bench.run(&[&["gradient", written(&bench), "--verify"][..], &keys].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let text = ended.stdout;
    for words in
        ["weight: derivatives of a run of 100 steps by newmark", "line.tension.peak = ", "at t = ", " N/kg", " N/(N/m)"]
    {
        assert!(text.contains(words), "{words}: {text}");
    }
    let rank = |key: &str| text.find(key).unwrap_or_else(|| panic!("{key}: {text}"));
    assert!(
        rank("gravity.2") < rank("springs.0.stiffness") && rank("springs.0.stiffness") < rank("gravity.0"),
        "{text}"
    );
    assert!(text.contains("by whole runs") && !text.contains("note:"), "{text}");
}

/// `--json` holds the same numbers, and nothing is written.
#[test]
fn json_holds_the_derivatives() {
    let bench = Bench::new();
    let case = written(&bench);
    let before = contents(&bench.path(""));
    let ended = bench.run(&["gradient", case, "--of", "line.tension.peak", "--by", "mass", "--json"]);
    let report: Value = serde_json::from_str(&ended.stdout).expect("json");
    let one = &report["quantities"][0]["derivatives"][0];
    assert_eq!((one["by"].as_str(), one["by_unit"].as_str()), (Some("system.network.mass.nodal"), Some("kg")));
    assert!(one["value"].as_f64().expect("a number") > 0.0 && report["factorizations"] == 100, "{report}");
    assert_eq!(contents(&bench.path("")), before, "nothing is written");
}

/// Bad usage and what has no derivative end with status 2 and say what to do; a run that fails with 3.
#[test]
fn what_cannot_be_done_says_so() {
    let bench = Bench::new();
    let case = written(&bench);
    for (arguments, code, words) in [
        (&["--by", "stiffnes"][..], 2, "--by stiffnes: the case has no number there"),
        (&["--by", "time.end"], 2, "time.end is no part of the scene"),
        (&["--by", "mass", "--of", "no.such.peak"], 2, "there is no gauge"),
        (&["--by", "mass", "--tolerance", "1e-3"], 2, "give time.step, or --step"),
        (&["--by", "mass", "--method", "multirate"], 2, "the derivative of a step by multirate is not known"),
        (&["--by", "mass", "--method", "rk4", "--step", "0.5", "--end", "50"], 3, "the run fails after t = "),
        (&[], 2, "--by <KEY>"),
    ] {
        let ended = bench.run(&[&["gradient", case, "--quiet"][..], arguments].concat());
        assert_eq!(ended.code, Some(code), "{arguments:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(words) && ended.stdout.is_empty(), "{words}: {}", ended.stderr);
    }
}
