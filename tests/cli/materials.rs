//! A parachute in twenty lines: it flies like the case that says everything, and what is written out for it runs to the
//! same bytes.

use crate::bench::{Bench, Ended};
use serde_json::Value;

const TWENTY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/guide/cases/twenty-lines.json");
const FULL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cases/parachute/c9-drop.json");

fn done(bench: &Bench, arguments: &[&str]) -> Ended {
    let ended = bench.run(arguments);
    assert_eq!(ended.code, Some(0), "{arguments:?}: {}", ended.stderr);
    ended
}

/// The largest tension of the riser [N] and the last speed [m/s].
fn flown(bench: &Bench, case: &str, out: &str) -> [f64; 2] {
    done(bench, &["solve", case, "--out", out]);
    let text = std::fs::read_to_string(bench.path(out).join("summary.json")).expect("a summary");
    let summary: Value = serde_json::from_str(&text).expect("JSON");
    let peaks = summary["peaks"].as_array().expect("peaks");
    let value = |name: &str, quantity: &str, key: &str| {
        let found = peaks.iter().find(|peak| peak["name"] == name && peak["quantity"] == quantity);
        found.and_then(|peak| peak[key].as_f64()).unwrap_or_else(|| panic!("{name} {quantity}: {peaks:?}"))
    };
    [value("riser", "tension_max", "value"), value("canopy", "axial_speed", "last")]
}

/// It has cloth that is lighter by a third than the full case, 0.9 kg, lines of 4 mm, not 3, and a stiffer riser.
#[test]
fn twenty_lines_fly_like_the_full_case() {
    let text = std::fs::read_to_string(TWENTY).expect("the case");
    assert!(text.lines().count() <= 20);
    let bench = Bench::new();
    let (short, full) = (flown(&bench, TWENTY, "short"), flown(&bench, FULL, "full"));
    for (what, i, tolerance) in [("load of the riser", 0, 0.03), ("rate of fall", 1, 0.01)] {
        let ratio = short[i] / full[i];
        assert!((ratio - 1.0).abs() < tolerance, "{what}: {} of {}", short[i], full[i]);
    }
}

/// What `check --expand` prints is a case without names, and runs to the same bytes.
#[test]
fn a_case_written_out_runs_to_the_same_bytes() {
    let bench = Bench::new();
    let printed = done(&bench, &["check", TWENTY, "--expand"]).stdout;
    assert!(!printed.contains("material") && !printed.contains("mil-c"), "{printed}");
    std::fs::write(bench.path("whole.json"), &printed).expect("written");
    let again = done(&bench, &["check", "whole.json", "--expand"]).stdout;
    assert_eq!(again, printed);
    for (case, out) in [(TWENTY, "names"), ("whole.json", "numbers")] {
        done(&bench, &["solve", case, "--out", out, "--end", "0.4"]);
    }
    for file in ["history.csv", "gauges.csv"] {
        let read = |out: &str| std::fs::read(bench.path(out).join(file)).expect("results");
        assert!(read("names") == read("numbers"), "{file} differs");
    }
    // A case without names is printed as it is.
    let full = done(&bench, &["check", FULL, "--expand"]).stdout;
    let own: Value = serde_json::from_str(&std::fs::read_to_string(FULL).expect("the case")).expect("JSON");
    assert_eq!(serde_json::from_str::<Value>(&full).expect("JSON"), own);
}

/// `check` says what it takes, and `materials` prints a file that a case can name.
#[test]
fn what_is_taken_is_said() {
    let bench = Bench::new();
    let text = done(&bench, &["check", TWENTY, "--end", "0.01"]).stdout;
    for words in
        ["drag_coefficient 0.75", "filling_constant 8", "the air through mil-c-7020-type-i", "riser: mil-w-4088"]
    {
        assert!(text.contains(words), "\"{words}\" is not in {text}");
    }
    let printed = done(&bench, &["materials"]).stdout;
    std::fs::write(bench.path("mine.json"), printed.replace("mil-c-5040-type-iii", "our-cord")).expect("written");
    std::fs::copy(TWENTY, bench.path("case.json")).expect("copied");
    let set = ["--set", "materials=mine.json", "--set", "system.network.mesh.parachute.lines.material=our-cord"];
    let ours = done(&bench, &[&["check", "case.json", "--expand"][..], &set].concat()).stdout;
    let theirs = done(&bench, &["check", "case.json", "--expand"]).stdout;
    assert_eq!(ours, theirs);
    let stiffer = bench.run(&["tradeoff", TWENTY, "--stiffness-sweep", "10", "--out", "study"]);
    assert_eq!(stiffer.code, Some(2));
    assert!(stiffer.stderr.contains("check --expand"), "{}", stiffer.stderr);
    let wrong = bench.run(&["check", TWENTY, "--set", "system.network.mesh.parachute.cloth=mil-c-7020-type-1"]);
    assert_eq!(wrong.code, Some(2));
    assert!(wrong.stderr.contains("did you mean \"mil-c-7020-type-i\"?"), "{}", wrong.stderr);
}

/// One mistake is one fault: a mistyped key of a spring leaves nothing to say of the speed at the start, a cover takes
/// no material, and a size that is not there leads to one that is.
#[test]
fn a_mistake_is_told_once_and_leads_to_what_is_meant() {
    let bench = Bench::new();
    let refused = |case: &str, set: &str| {
        let ended = bench.run(&["check", case, "--set", set]);
        assert_eq!(ended.code, Some(2), "{}", ended.stdout);
        ended.stderr
    };
    let told = refused(FULL, r#"system.network.springs.0.slak="none""#);
    assert!(told.contains("did you mean \"slack\"") && !told.contains("at rest in the air"), "{told}");
    let springs = |rule: &str| format!(r#"system.network.springs=[{{"on": {{"group": "lines"}}, {rule}}}]"#);
    let told = refused(TWENTY, &springs(r#""material": "steel-cable-4mm""#));
    assert!(told.contains("did you mean \"steel-cable-7x19-4mm\"?"), "{told}");
    let told = refused(TWENTY, &springs(r#""loads_only": true, "material": "steel-cable-7x19-4mm""#));
    assert!(told.contains("springs/0/material") && told.contains("not together with loads_only"), "{told}");
    assert!(!told.contains("strength") && !told.contains("axial_rigidity"), "{told}");
}
