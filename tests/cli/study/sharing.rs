//! One study made in one go, in shards, in pieces, and under kills: the same rows.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use super::table::{counted, study};
use crate::bench::Bench;

/// Methods that carry something from step to step, that take their steps from a tolerance, and that solve.
const FLAGS: [&str; 8] = [
    "--methods",
    "improved-euler-pec,newmark,rk4,kang",
    "--steps",
    "5e-3,1e-3",
    "--tolerances",
    "1e-3",
    "--repeat",
    "1",
];

fn whole(bench: &Bench, out: &str) -> Vec<String> {
    let ended = bench.run(&[&["tradeoff", "sail.json", "--out", out][..], &FLAGS].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    counted(&study(&bench.path(out)).rows)
}

fn run_files(out: &Path) -> BTreeMap<PathBuf, SystemTime> {
    let folder = out.join("tradeoff/runs");
    let Ok(entries) = std::fs::read_dir(folder) else { return BTreeMap::new() };
    let file = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry.expect("an entry");
        (entry.path(), entry.metadata().and_then(|m| m.modified()).expect("a time"))
    };
    entries.map(file).filter(|(path, _)| path.extension().is_some_and(|e| e == "json")).collect()
}

/// Again in another folder: the same counters and errors to the bit. Again in the same folder: nothing is made.
#[test]
fn a_study_repeats_and_finished_runs_are_not_made_again() {
    let bench = Bench::new();
    let first = whole(&bench, "a");
    assert_eq!(first.len(), 12);
    assert!(first.iter().all(|row| row.contains("Completed")), "{first:#?}");
    assert_eq!(first, whole(&bench, "b"));
    let before = run_files(&bench.path("a"));
    assert_eq!(whole(&bench, "a"), first);
    assert_eq!(run_files(&bench.path("a")), before, "finished runs were made again");
}

/// Shards in any order, one of them in a copy of the folder, and a merge: the rows of the whole study.
#[test]
fn shards_join_to_the_whole() {
    let bench = Bench::new();
    let expected = whole(&bench, "whole");
    let planned = bench.run(&[&["tradeoff", "sail.json", "--plan", "--out", "parts"][..], &FLAGS].concat());
    assert_eq!(planned.code, Some(0), "{}", planned.stderr);
    let copy = bench.path("copy/tradeoff");
    std::fs::create_dir_all(&copy).expect("a folder");
    for file in ["plan.json", "reference-0.bin"] {
        std::fs::copy(bench.path("parts/tradeoff").join(file), copy.join(file)).expect("a copy");
    }
    for (out, shard) in [("parts", "3/3"), ("copy", "1/3"), ("parts", "2/3")] {
        let ended = bench.run(&["tradeoff", "--out", out, "--shard", shard]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    }
    let merged = bench.run(&["tradeoff", "--out", "parts", "--merge"]);
    assert!(merged.stdout.contains("4 not-run"), "a merge shows what is missing: {}", merged.stdout);
    let merged = bench.run(&["tradeoff", "--out", "parts", "--merge", "copy"]);
    assert_eq!(merged.code, Some(0), "{}", merged.stderr);
    assert!(!merged.stdout.contains("not-run"), "{}", merged.stdout);
    assert_eq!(counted(&study(&bench.path("parts")).rows), expected);
}

/// A budget that ends within a run keeps it; the same command goes on and ends with the rows of a study that was never
/// stopped.
#[test]
fn a_spent_budget_is_taken_up() {
    let bench = Bench::new();
    let flags = ["--methods", "newmark,rk4", "--steps", "1e-4", "--repeat", "1", "--set", "time.end=4"];
    let go = |out: &str, budget: &str| {
        let ended = bench.run(&[&["tradeoff", "sail.json", "--out", out, "--budget", budget][..], &flags].concat());
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        ended.stdout
    };
    go("whole", "none");
    // The first makes the reference, which has its own share.
    let planned = bench.run(&[&["tradeoff", "sail.json", "--plan", "--out", "pieces"][..], &flags].concat());
    assert_eq!(planned.code, Some(0), "{}", planned.stderr);
    let mut pieces = 0;
    while go("pieces", "100ms").contains("not-run") {
        pieces += 1;
        assert!(pieces < 1000, "it never ends");
    }
    assert!(pieces > 0, "the budget was never spent; the test needs longer runs");
    assert_eq!(counted(&study(&bench.path("pieces")).rows), counted(&study(&bench.path("whole")).rows));
}

/// Killed at any moment and started again, a shard ends with the rows of one that was left alone.
#[test]
#[cfg(unix)]
fn kills_cost_nothing_but_time() {
    let bench = Bench::new();
    let expected = whole(&bench, "whole");
    let planned = bench.run(&[&["tradeoff", "sail.json", "--plan", "--out", "killed"][..], &FLAGS].concat());
    assert_eq!(planned.code, Some(0), "{}", planned.stderr);
    for (wait, signal) in [(5, "KILL"), (30, "INT"), (60, "KILL"), (120, "INT")] {
        let mut child = bench.program();
        child.args(["tradeoff", "--out", "killed", "--shard", "1/1", "--quiet"]);
        let mut child = child.stderr(std::process::Stdio::null()).spawn().expect("starts");
        std::thread::sleep(Duration::from_millis(wait));
        let killed = std::process::Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
        assert!(killed.is_ok());
        let status = child.wait().expect("ends");
        assert!(matches!(status.code(), Some(0 | 130) | None), "{status:?}");
    }
    let ended = bench.run(&["tradeoff", "--out", "killed", "--shard", "1/1"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert_eq!(counted(&study(&bench.path("killed")).rows), expected);
    let parts = std::fs::read_dir(bench.path("killed/tradeoff/runs")).expect("a folder");
    // A kill within a write may leave its hidden half-written file, which nobody reads.
    let unfinished = |name: &str| name.ends_with(".part") && !name.starts_with('.');
    let left = parts.filter(|e| e.as_ref().is_ok_and(|e| unfinished(&e.file_name().to_string_lossy()))).count();
    assert_eq!(left, 0, "nothing unfinished is left");
}

/// Four processes that all make the whole study in one folder at the same time end well, with the rows of one that was
/// alone.
#[test]
#[ignore = "long"]
fn processes_may_make_the_same_runs() {
    let bench = Bench::new();
    let expected = whole(&bench, "whole");
    let planned = bench.run(&[&["tradeoff", "sail.json", "--plan", "--out", "crowd"][..], &FLAGS].concat());
    assert_eq!(planned.code, Some(0), "{}", planned.stderr);
    for _ in 0..5 {
        let start = |_| {
            let mut child = bench.program();
            child.args(["tradeoff", "--out", "crowd", "--shard", "1/1", "--quiet"]);
            child.stderr(std::process::Stdio::piped()).spawn().expect("starts")
        };
        let crowd: Vec<_> = (0..4).map(start).collect();
        for child in crowd {
            let ended = child.wait_with_output().expect("ends");
            assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
        }
        assert_eq!(counted(&study(&bench.path("crowd")).rows), expected);
        std::fs::remove_dir_all(bench.path("crowd/tradeoff/runs")).expect("there");
    }
}

/// One thread and two give the same rows.
#[test]
fn threads_change_nothing() {
    let bench = Bench::new();
    let expected = whole(&bench, "one");
    let ended = bench.run(&[&["tradeoff", "sail.json", "--out", "two", "--threads", "2"][..], &FLAGS].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert_eq!(counted(&study(&bench.path("two")).rows), expected);
}
