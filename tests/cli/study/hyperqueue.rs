//! The HyperQueue sweep of docs/sweeps.md on a local cluster.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::table::{counted, study};
use crate::bench::Bench;

/// A Python that has the package `hyperqueue`: that of `.ci/run`, or the user's.
fn python() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let named = std::env::var_os("CANOPY_FEM_PYTHON").map(PathBuf::from);
    let all = named.into_iter().chain([root.join("target/ci/venv/bin/python"), "python3".into()]);
    let has = |python: &PathBuf| {
        Command::new(python).args(["-c", "import hyperqueue"]).output().is_ok_and(|done| done.status.success())
    };
    all.into_iter().find(has)
}

/// Planned, run as tasks of a local cluster, merged: the rows of the study made in one go.
#[test]
fn hyperqueue_makes_the_same_study() {
    let Some(python) = python() else {
        println!(
            "skipped: no Python with the package hyperqueue was found (pip install hyperqueue; CANOPY_FEM_PYTHON names another)"
        );
        return;
    };
    let bench = Bench::new();
    let flags = ["--methods", "rk4,newmark,velocity-verlet", "--steps", "1e-2,5e-3", "--repeat", "1"];
    let whole = bench.run(&[&["tradeoff", "sail.json", "--out", "whole"], &flags[..]].concat());
    assert_eq!(whole.code, Some(0), "{}", whole.stderr);
    let planned = bench.run(&[&["tradeoff", "sail.json", "--plan", "--out", "queue"], &flags[..]].concat());
    assert_eq!(planned.code, Some(0), "{}", planned.stderr);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/sweeps/hyperqueue_local.py");
    let program = assert_cmd::cargo::cargo_bin!("canopy-fem");
    let done = Command::new(python)
        .arg(script)
        .arg(program)
        .args(["queue", "4"])
        .current_dir(bench.path("."))
        .output()
        .expect("Python starts");
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{said}\n{}", String::from_utf8_lossy(&done.stdout));
    let queued = study(&bench.path("queue"));
    assert_eq!(counted(&queued.rows), counted(&study(&bench.path("whole")).rows));
    assert_eq!(queued.rows.iter().filter(|row| !row.measured.repeats.is_empty()).count(), 6);
}
