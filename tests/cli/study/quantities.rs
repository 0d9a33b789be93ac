//! Quantities in studies: their errors against closed forms, what runs are ranked by, and that nothing loses them.

use canopy_fem::study::recommendations::Recommendations;
use serde_json::{Value, json};

use super::table::{counted, study};
use crate::bench::{Bench, Results};

/// [rad/s], [m] frequency and amplitude of the oscillator below, [N/m] its stiffness
const FREQUENCY: f64 = 10.0;
const AMPLITUDE: f64 = 0.1;
const STIFFNESS: f64 = 200.0;
/// [s] end of its runs, and a time between two steps
const END: f64 = 2.0;
const BETWEEN: f64 = 1.2345;

/// x = 1 m + A sin(w t)
fn oscillator(quantities: &Value) -> Bench {
    let bench = Bench::new();
    let case = json!({
        "name": "oscillator",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0]], "springs": [[0, 1]]}},
            "mass": {"nodal": STIFFNESS / FREQUENCY.powi(2)},
            "springs": [{"on": "all", "stiffness": STIFFNESS}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "initial": {"velocity": [AMPLITUDE * FREQUENCY, 0, 0]}
        }},
        "time": {"end": END, "method": "velocity-verlet", "step": 0.01},
        "output": {
            "probes": [{"name": "mass", "on": {"ids": [1]}}],
            "gauges": [{"name": "spring", "on": "all", "of": "tension"}]
        },
        "study": {"methods": ["velocity-verlet", "newmark", "rk4"], "steps": [0.02, 0.005], "repeat": 1,
            "quantities": quantities}
    });
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    bench
}

fn names(all: &[(String, f64)]) -> Value {
    all.iter().map(|(name, _)| name.clone()).collect()
}

fn exact() -> Vec<(String, f64)> {
    let at = |t: f64| 1.0 + AMPLITUDE * (FREQUENCY * t).sin();
    let from = 0.9 * END;
    let integral = ((FREQUENCY * from).cos() - (FREQUENCY * END).cos()) * AMPLITUDE / FREQUENCY;
    vec![
        ("spring.tension.peak".to_owned(), STIFFNESS * AMPLITUDE),
        (format!("mass.x@{BETWEEN}"), at(BETWEEN)),
        ("mass.x.last".to_owned(), at(END)),
        ("mass.x.steady".to_owned(), 1.0 + integral / (END - from)),
    ]
}

fn tradeoff(bench: &Bench, out: &str, flags: &[&str]) -> String {
    let ended = bench.run(&[&["tradeoff", "case.json", "--out", out], flags].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    ended.stdout
}

/// The reference is as close to the closed form as it says, and the errors of runs are their distances from it.
#[test]
fn errors_of_quantities_are_those_against_closed_forms() {
    let all = exact();
    let bench = oscillator(&names(&all));
    let text = tradeoff(&bench, "o", &[]);
    let found = study(&bench.path("o"));
    let known = found.plan.quantities();
    let table = Results(bench.path("o")).table("tradeoff.csv");
    let columns: Vec<String> = all.iter().map(|(name, _)| format!("error_{name}")).collect();
    assert_eq!(table.header[12..], [&["pareto".to_owned()][..], &columns].concat());
    for (known, (name, exact)) in known.iter().zip(&all) {
        assert_eq!(known.name, *name);
        let off = (known.value.expect("a value") / exact - 1.0).abs();
        let stated = known.error.expect("known");
        assert!(stated < 1e-6 && off <= 3.0 * stated, "{name}: off by {off:e}, stated {stated:e}");
        let told = table.column(&format!("error_{name}"));
        for (row, told) in found.rows.iter().zip(told) {
            let run = row.measured.quantities[name];
            assert_eq!(run.error, Some(told));
            let off = (run.value.expect("a value") / exact - 1.0).abs();
            assert!((told - off).abs() <= 3.0 * stated, "{name}, {}: {told:e}, off by {off:e}", row.job.id);
            assert!(off > 10.0 * stated || row.job.method.name == "rk4", "{name}, {}: {off:e}", row.job.id);
        }
    }
    // The numbers are those of solve with the same step.
    let ended = bench.run(&["solve", "case.json", "--method", "newmark", "--step", "0.02", "--out", "alone"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let alone = Results(bench.path("alone")).summary();
    let row = found.rows.iter().find(|row| row.job.id.contains("newmark-h2")).expect("a run");
    for (name, _) in &all {
        let value = row.measured.quantities[name].value;
        assert_eq!(value, alone["quantities"][name]["value"].as_f64(), "{name}");
    }
    // Runs are ranked by the worst.
    let answers = Recommendations::of(&found.plan, &found.rows).expect("answers");
    assert!(!answers.targets.is_empty());
    for target in &answers.targets {
        assert_eq!(target.quantities.len(), all.len());
        let row = found.rows.iter().find(|row| row.job.id == target.best.id).expect("its run");
        let worst = row.measured.quantities.values().filter_map(|of| of.error).fold(0.0, f64::max);
        assert_eq!(target.best.error, worst);
        assert!(worst.max(target.reference_error) <= target.wanted);
    }
    assert!(text.contains("within 10 % ") && text.contains(" of all 4 quantities use "), "{text}");
    assert!(text.contains("spring.tension.peak = 20 N, known to "), "{text}");
}

/// What is not asked for is measured beside the motion, by which runs are ranked; with a name they are ranked by that.
#[test]
fn runs_are_ranked_by_what_is_asked_for() {
    let bench = oscillator(&Value::Null);
    let flags = ["--methods", "newmark", "--steps", "0.05,0.02"];
    let text = tradeoff(&bench, "report", &flags);
    assert!(text.contains("for 1e-1 use newmark") && text.contains("of spring.tension.peak use newmark"), "{text}");
    let text = tradeoff(&bench, "asked", &[&flags[..], &["--quantity", "spring.tension.peak"]].concat());
    assert!(!text.contains("for 1e-1 use") && text.contains("of spring.tension.peak use newmark"), "{text}");
    let [report, asked] = ["report", "asked"].map(|out| study(&bench.path(out)));
    for (a, b) in report.rows.iter().zip(&asked.rows) {
        assert_eq!((a.measured.error, &a.measured.quantities), (b.measured.error, &b.measured.quantities));
    }
    assert_eq!(report.plan.quantities().len(), 1);
    // One picture of each on the page, with a menu; the first is what runs are ranked by.
    for (out, first) in [("report", "motion"), ("asked", "spring.tension.peak")] {
        let page = Results(bench.path(out)).text("tradeoff.html");
        assert!(page.contains(&format!("<select><option>{first}</option><option>")), "{out}");
        assert!(page.contains("error of spring.tension.peak, relative [-]") && page.contains("relative to the motion"));
    }
    // Motion alone: the study of a case without gauges.
    tradeoff(&bench, "alone", &[&flags[..], &["--set", "output.gauges=[]"]].concat());
    let alone = Results(bench.path("alone"));
    assert_eq!(alone.table("tradeoff.csv").header.last().map(String::as_str), Some("pareto"));
    assert!(!alone.text("tradeoff.html").contains("<select>"));
}

/// A name that is not there is refused before anything is made.
#[test]
fn a_quantity_must_be_there() {
    let bench = oscillator(&Value::Null);
    for name in ["riser.tension.peak", "spring.tension.top"] {
        let ended = bench.run(&["tradeoff", "case.json", "--quantity", name, "--out", "o"]);
        assert_eq!(ended.code, Some(2), "{}", ended.stderr);
        assert!(ended.stderr.contains("GAUGE.COLUMN.STATISTIC") || ended.stderr.contains("no gauge \"riser\""));
    }
}

/// Shards and a budget that is spent within runs: the rows of the whole study, with the bits of their quantities.
#[test]
fn parts_of_a_study_keep_quantities() {
    let bench = oscillator(&names(&exact()));
    let flags = ["--methods", "newmark,rk4", "--steps", "1e-4", "--tolerances", "1e-3", "--end", "20"];
    tradeoff(&bench, "whole", &[&flags[..], &["--budget", "none"]].concat());
    let expected = counted(&study(&bench.path("whole")).rows);
    assert!(expected.iter().all(|row| row.contains("mass.x.steady")), "{expected:?}");
    for out in ["shards", "pieces"] {
        tradeoff(&bench, out, &[&flags[..], &["--plan"]].concat());
    }
    for shard in ["2/2", "1/2"] {
        let ended = bench.run(&["tradeoff", "--out", "shards", "--shard", shard]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    }
    let merged = bench.run(&["tradeoff", "--out", "shards", "--merge"]);
    assert!(merged.stdout.contains("all 4 quantities use"), "{}{}", merged.stdout, merged.stderr);
    let mut pieces = 0;
    while tradeoff(&bench, "pieces", &[&flags[..], &["--budget", "100ms"]].concat()).contains("not-run") {
        pieces += 1;
        assert!(pieces < 1000, "it never ends");
    }
    assert!(pieces > 0, "the budget was never spent; the test needs longer runs");
    for out in ["shards", "pieces"] {
        assert_eq!(counted(&study(&bench.path(out)).rows), expected, "{out}");
    }
}

/// A sweep has a column for each quantity, with the numbers of solve, and draws them.
#[test]
fn a_sweep_has_columns_of_quantities() {
    // Flags win over the case.
    let bench = oscillator(&json!(["spring.tension.steady", "energy.kinetic.mean", "max_speed"]));
    let vary = ["--vary", "time.step=0.01,0.005", "--quantity", "spring.tension.steady", "--quantity", "max_speed"];
    let more = ["--quantity", "energy.kinetic.mean", "--plot", "energy.kinetic.mean", "--out", "s"];
    let ended = bench.run(&[&["sweep", "case.json"], &vary[..], &more[..]].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let out = Results(bench.path("s"));
    let table = out.table("sweep.csv");
    assert_eq!(table.header.iter().filter(|name| *name == "max_speed").count(), 1);
    let ended = bench.run(&["solve", "case.json", "--step", "0.005", "--out", "alone"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let alone = Results(bench.path("alone")).summary();
    for name in ["spring.tension.steady", "energy.kinetic.mean", "max_speed"] {
        assert_eq!(Some(table.column(name)[1]), alone["quantities"][name]["value"].as_f64(), "{name}");
    }
    let steady = table.header.iter().position(|name| name == "spring.tension_max.is_steady").expect("a column");
    assert!(table.rows.iter().all(|row| row[steady] == "false"));
    assert!(out.text("sweep.svg").contains("kinetic energy, mean over the run [J]"));
    let told: Value = serde_json::from_str(&out.text("sweep.json")).expect("JSON");
    assert_eq!(told["units"]["energy.kinetic.mean"], "J");
}
