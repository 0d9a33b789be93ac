//! Sweeps over the stiffness.

use super::table::study;
use crate::bench::Bench;

/// A factor on the stiffness is a variant with its own reference, and its runs are those of the case with that
/// stiffness.
#[test]
fn a_factor_is_another_case() {
    let bench = Bench::new();
    let flags = ["--methods", "newmark,velocity-verlet", "--steps", "1e-3", "--repeat", "1"];
    let ended =
        bench.run(&[&["tradeoff", "sail.json", "--out", "sweep", "--stiffness-sweep", "1..100"], &flags[..]].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let swept = study(&bench.path("sweep"));
    let factors: Vec<f64> = swept.plan.variants.iter().map(|v| v.stiffness_factor).collect();
    assert_eq!((factors, swept.rows.len()), (vec![1.0, 10.0, 100.0], 6));
    let set = "system.network.springs.0.stiffness=5000";
    let ended = bench.run(&[&["tradeoff", "sail.json", "--out", "alone", "--set", set], &flags[..]].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let alone = study(&bench.path("alone"));
    assert_eq!(swept.plan.variants[2].fingerprint.differences(&alone.plan.variants[0].fingerprint), None);
    for (a, b) in swept.rows[4..].iter().zip(&alone.rows) {
        assert_eq!((a.measured.error, a.measured.counters), (b.measured.error, b.measured.counters), "{}", a.job.id);
    }
}

#[test]
fn a_pendulum_has_no_springs() {
    let bench = Bench::new();
    let path = format!("{}/assets/cases/pendulum.json", env!("CARGO_MANIFEST_DIR"));
    let ended = bench.run(&["tradeoff", &path, "--out", "out", "--stiffness-sweep", "1,10"]);
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
    assert!(ended.stderr.contains("no springs"), "{}", ended.stderr);
}
