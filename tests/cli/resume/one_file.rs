//! A run whose frames are in one file, killed at any moment: the file can be read, and the run goes on to the same
//! bytes.

use std::fs::File;
use std::time::Duration;

use canopy_fem::vtk::hdf::HdfFrames;

use super::folders::{assert_same, checkpoint};
use super::kills::Running;
use crate::bench::Bench;
use crate::common::Random;

/// 10,000 steps with a frame each 20th and a checkpoint each 200th.
const LONG: [&str; 10] = [
    "sail.json",
    "--quiet",
    "--step",
    "1e-4",
    "--set",
    "output.format=vtkhdf",
    "--set",
    "output.frames.every=0.002",
    "--set",
    "output.checkpoint.every=0.02",
];

fn solve(bench: &Bench, out: &str, more: &[&str]) -> Running {
    Running::start(bench, &[&["solve"], &LONG[..], &["--out", out], more].concat())
}

/// The number of frames in the file, all of which are read.
fn readable(bench: &Bench, out: &str) -> usize {
    let Ok(file) = File::open(bench.path(out).join("sail.vtkhdf")) else { return 0 };
    let mut frames = HdfFrames::of(file).expect("a file that can be read");
    let times = frames.times().to_vec();
    for (number, t) in times.iter().enumerate() {
        assert!((t - 0.002 * number as f64).abs() < 1e-9, "{number}: {t}");
        let frame = frames.frame(number, &["displacement", "velocity"]).expect("a frame");
        assert!(frame.pieces[0].points.iter().flatten().all(|x| x.is_finite()));
    }
    times.len()
}

#[test]
fn killed_at_any_moment_one_file_is_readable_and_resumes_with_the_same_bytes() {
    let bench = Bench::new();
    assert_eq!(solve(&bench, "whole", &[]).end().0, Some(0));
    assert_eq!(readable(&bench, "whole"), 501);
    let mut random = Random(17);
    let step = || checkpoint(&bench.path("out")).map(|found| found.snapshot.step);
    let mut most = 0;
    for kill in 0..8 {
        let before = step();
        let mut running = solve(&bench, "out", &[if before.is_some() { "--resume" } else { "--force" }]);
        if kill % 4 > 0 {
            running.until("a new checkpoint", |_| step() > before);
        }
        std::thread::sleep(Duration::from_micros((10_000.0 * (1.0 + random.next())) as u64));
        running.0.kill().expect("SIGKILL");
        running.0.wait().expect("a child");
        most = most.max(readable(&bench, "out"));
    }
    assert!(most > 20, "killed after {most} frames");
    let (code, said) = solve(&bench, "out", &["--resume", "--threads", "2"]).end();
    assert_eq!(code, Some(0), "{said}");
    assert_same(&bench.path("out"), &bench.path("whole"), "out");
}
