//! Stopped from outside: `kill -9` at any moment, Ctrl-C, and the SIGTERM of a batch system.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::json;

use super::folders::{assert_readable, assert_same, checkpoint};
use crate::bench::Bench;
use crate::common::Random;

/// Ends the program if the test fails before it has ended by itself.
pub struct Running(pub Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Running {
    pub fn start(bench: &Bench, arguments: &[&str]) -> Self {
        let mut command = bench.program();
        command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped());
        Running(command.spawn().expect("the program starts"))
    }

    /// Waits until `done`; fails after a minute.
    pub fn until(&mut self, what: &str, mut done: impl FnMut(&mut Child) -> bool) {
        let start = Instant::now();
        while !done(&mut self.0) {
            assert!(start.elapsed() < Duration::from_secs(60), "{what}: not within a minute");
            // Once more after its end, because what is waited for may have come just before.
            if self.0.try_wait().expect("a child").is_some() {
                assert!(done(&mut self.0), "{what}: the program has ended without it");
                return;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// The exit status and what was said on standard error.
    pub fn end(mut self) -> (Option<i32>, String) {
        self.until("the end", |child| child.try_wait().expect("a child").is_some());
        let mut said = String::new();
        let mut errors = self.0.stderr.take().expect("piped");
        std::io::Read::read_to_string(&mut errors, &mut said).expect("UTF-8");
        (self.0.wait().expect("a child").code(), said)
    }
}

/// 10,000 steps with a frame each 50th and a checkpoint each 200th.
const LONG: [&str; 8] = [
    "sail.json",
    "--quiet",
    "--step",
    "1e-4",
    "--set",
    "output.frames.every=0.005",
    "--set",
    "output.checkpoint.every=0.02",
];

fn solve(bench: &Bench, out: &str, more: &[&str]) -> Running {
    Running::start(bench, &[&["solve"], &LONG[..], &["--out", out], more].concat())
}

/// Kills the run eight times at random moments and resumes it each time; returns the steps of the checkpoints it left.
/// Two kills fall into the start of the program, the others after a new checkpoint, so that the run comes on.
fn killed_and_resumed(bench: &Bench, out: &str, random: &mut Random) -> BTreeSet<u64> {
    let folder = bench.path(out);
    let step = || checkpoint(&folder).map(|found| found.snapshot.step);
    let mut seen = BTreeSet::new();
    for kill in 0..8 {
        let before = step();
        let mut running = solve(bench, out, &[if before.is_some() { "--resume" } else { "--force" }]);
        if kill % 4 > 0 {
            running.until("a new checkpoint", |_| step() > before);
        }
        std::thread::sleep(Duration::from_micros((10_000.0 * (1.0 + random.next())) as u64));
        assert!(running.0.try_wait().expect("a child").is_none(), "the run is too short for its kills");
        running.0.kill().expect("SIGKILL");
        running.0.wait().expect("a child");
        assert_readable(&folder, "sail");
        seen.extend(step());
    }
    let (code, said) = solve(bench, out, &["--resume"]).end();
    assert_eq!(code, Some(0), "{said}");
    seen
}

/// The results of a run that was killed again and again are those of one that was not.
#[test]
fn killed_at_any_moment_a_run_resumes_with_the_same_bytes() {
    let bench = Bench::new();
    assert_eq!(solve(&bench, "whole", &[]).end().0, Some(0));
    let mut random = Random(11);
    for out in ["a", "b", "c", "d"] {
        let steps = killed_and_resumed(&bench, out, &mut random);
        assert!(steps.len() >= 6, "killed with checkpoints at steps {steps:?} only");
        assert_same(&bench.path(out), &bench.path("whole"), out);
    }
}

/// Ctrl-C finishes the step, keeps a checkpoint though the case asks for none, and exits 130, and so does SIGTERM;
/// resumed with two threads the run ends with the bytes of one in one piece, and leaves no checkpoint.
#[test]
fn an_interrupted_run_resumes() {
    let bench = Bench::new();
    let long = ["sail.json", "--step", "2e-6", "--set", "output.history.every=100"];
    let start =
        |out: &str, more: &[&str]| Running::start(&bench, &[&["solve"], &long[..], &["--out", out], more].concat());
    let (whole, out) = (start("whole", &[]).end(), bench.path("out"));
    assert_quiet(&whole);
    let mut before = None;
    for (signal, frame, more) in [("-INT", 3, &[][..]), ("-TERM", 6, &["--resume"])] {
        let mut running = start("out", more);
        running.until("some frames", |_| out.join(format!("frames/sail_{frame:06}.vtu")).exists());
        send(signal, &running.0);
        assert_eq!(running.end().0, Some(130), "{signal}");
        let summary = bench.results().summary();
        assert_eq!([&summary["status"], &summary["resumed_from"]], [&json!("interrupted"), &json!(before)], "{signal}");
        let kept = checkpoint(&out).expect("a checkpoint");
        assert_eq!([summary["steps"].as_u64(), Some(kept.snapshot.step)], [Some(kept.snapshot.step); 2], "{signal}");
        assert!(before < Some(kept.snapshot.t), "{signal}");
        assert_readable(&out, "sail");
        before = Some(kept.snapshot.t);
    }
    let spent = checkpoint(&out).expect("a checkpoint").spent.wall.as_secs_f64();
    assert_quiet(&start("out", &["--resume", "--threads", "2"]).end());
    assert_same(&out, &bench.path("whole"), "resumed");
    let summary = bench.results().summary();
    assert_eq!(summary["resumed_from"].as_f64(), before);
    assert!(summary["wall_seconds"].as_f64() > Some(spent), "the parts are added up");
}

/// Done, and no word but that the sail is heavy.
fn assert_quiet((code, said): &(Option<i32>, String)) {
    let heavy = said.lines().all(|line| line.starts_with("warning: /system/network/mass:"));
    assert!(*code == Some(0) && heavy, "{code:?}: {said}");
}

fn send(signal: &str, child: &Child) {
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().expect("kill(1)");
    assert!(sent.success());
}

/// A second run does not write where one is writing: neither by `--resume` nor by `--force`.
#[test]
fn two_runs_do_not_write_into_one_folder() {
    let bench = Bench::new();
    let long = ["solve", "sail.json", "--out", "out", "--step", "1e-6", "--end", "1000"];
    let sets =
        ["--set", "output.checkpoint.every=0.001", "--set", "output.frames=null", "--set", "output.history.every=1000"];
    let arguments = [&long[..], &sets[..]].concat();
    let mut running = Running::start(&bench, &arguments);
    running.until("a checkpoint", |_| Path::new(&bench.path("out/checkpoint.bin")).exists());
    for flag in ["--resume", "--force"] {
        let ended = bench.run(&[&arguments[..], &[flag]].concat());
        assert_eq!(ended.code, Some(2), "{}", ended.stderr);
        assert!(ended.stderr.contains("history.csv is being written by another run"), "{}", ended.stderr);
    }
    send("-INT", &running.0);
    assert_eq!(running.end().0, Some(130));
    assert_readable(&bench.path("out"), "sail");
}
