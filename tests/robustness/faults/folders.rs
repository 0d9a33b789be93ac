//! Two runs in one folder, and inputs that are no files.

use super::program::{program, program_with, summary};
use serde_json::{Value, json};
use std::path::Path;
use std::process::{Child, Command, Stdio};

fn case(gravity: f64, end: f64) -> Value {
    json!({"name": "p", "system": {"pendulum": {"length": 1.0, "mass": 1.0, "angle": 0.1, "gravity": gravity}},
        "time": {"end": end, "method": "rk4", "step": 0.01}, "output": {"frames": {"every": 1.0}}})
}

fn start(folder: &Path, args: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_canopy-fem"))
        .args(args)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts")
}

/// Two cases started at the same moment into one folder: whoever runs has its results whole; whoever is refused says
/// why.
fn race(force: bool, rounds: usize) {
    let dir = tempfile::tempdir().expect("a folder");
    let folder = dir.path();
    for (name, gravity) in [("a.json", 9.81), ("b.json", 5.0)] {
        std::fs::write(folder.join(name), case(gravity, 300.0).to_string()).expect("written");
    }
    assert_eq!(program_with(folder, &["solve", "a.json", "--out", "o", "-q"]).status, Some(0));
    let times = || -> Vec<f64> {
        let history = std::fs::read_to_string(folder.join("o/history.csv")).expect("a history");
        history.lines().skip(1).map(|row| row.split(',').next().and_then(|t| t.parse().ok()).expect("a time")).collect()
    };
    let alone = times();
    for round in 0..rounds {
        if !force {
            let _ = std::fs::remove_dir_all(folder.join("o"));
        }
        let args = |case: &'static str| {
            [["solve", case, "--out", "o", "-q"].as_slice(), &["--force"][..usize::from(force)]].concat()
        };
        let both = [("a.json", 9.81), ("b.json", 5.0)].map(|(case, g)| (start(folder, &args(case)), g));
        let ended = both.map(|(child, g)| (child.wait_with_output().expect("it ends"), g));
        let (ran, refused): (Vec<_>, Vec<_>) = ended.iter().partition(|(out, _)| out.status.code() == Some(0));
        for (out, _) in &refused {
            let said = String::from_utf8_lossy(&out.stderr);
            assert_eq!(out.status.code(), Some(2), "round {round}: {said}");
            assert!(
                said.contains("is being written by another run") || said.contains("already holds results"),
                "{said}"
            );
        }
        // Where one begins when the other has ended, --force replaces its results; without, it is refused.
        assert!(ran.len() == 1 || force && ran.len() == 2, "round {round}: {} ran", ran.len());
        assert_eq!(times(), alone, "round {round}: rows of two runs");
        let text = std::fs::read_to_string(folder.join("o/summary.json")).expect("a summary");
        let kept: Value = serde_json::from_str(&text).expect("JSON");
        let gravity = kept["case"]["system"]["pendulum"]["gravity"].as_f64().expect("a number");
        assert!(ran.iter().any(|(_, g)| *g == gravity), "round {round}");
        let frames = std::fs::read_dir(folder.join("o/frames")).expect("frames").count();
        assert_eq!(frames, 301, "round {round}");
    }
}

#[test]
fn of_two_runs_that_start_in_one_folder_one_is_refused() {
    race(false, 10);
}

#[test]
fn force_does_not_take_files_from_a_run_that_has_just_started() {
    race(true, 10);
}

#[cfg(unix)]
fn pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().expect("mkfifo(1)").success());
}

#[cfg(unix)]
#[test]
fn a_named_pipe_as_case_is_refused_at_once() {
    let dir = tempfile::tempdir().expect("a folder");
    pipe(&dir.path().join("p.json"));
    for command in ["solve", "check", "tradeoff", "stability"] {
        let run = program_with(dir.path(), &[command, "p.json"]);
        assert_eq!(run.status, Some(2), "{command}: {}", run.stderr);
        assert!(run.stderr.contains("p.json: this is a named pipe"), "{command}: {}", run.stderr);
    }
}

/// What a shell makes of `<(command)` and of `command |`: a pipe that is open already and has a writer.
#[cfg(unix)]
#[test]
fn a_case_may_come_through_a_pipe_of_the_shell() {
    let dir = tempfile::tempdir().expect("a folder");
    std::fs::write(dir.path().join("case.json"), case(9.81, 0.1).to_string()).expect("written");
    for line in ["cat case.json | \"$B\" solve /dev/stdin --out o", "\"$B\" solve <(cat case.json) --out o2"] {
        let run = Command::new("bash")
            .args(["-c", line])
            .env("B", env!("CARGO_BIN_EXE_canopy-fem"))
            .current_dir(dir.path())
            .output()
            .expect("bash");
        assert_eq!(run.status.code(), Some(0), "{line}: {}", String::from_utf8_lossy(&run.stderr));
    }
}

#[cfg(unix)]
#[test]
fn a_named_pipe_as_mesh_is_refused_at_once() {
    let dir = tempfile::tempdir().expect("a folder");
    pipe(&dir.path().join("m.obj"));
    let case = json!({"name": "p", "system": {"network": {"mesh": {"file": "m.obj"}, "mass": {"nodal": 1.0},
        "springs": [{"on": "all", "stiffness": 1.0}]}}, "time": {"end": 1.0, "method": "rk4", "step": 0.01}});
    for run in [program(dir.path(), &case, &["check"]), program_with(dir.path(), &["mesh", "inspect", "m.obj"])] {
        assert_eq!(run.status, Some(2), "{}", run.stderr);
        assert!(run.stderr.contains("this is a named pipe"), "{}", run.stderr);
    }
}

/// Named pipes where results of an earlier run belong.
#[cfg(unix)]
#[test]
fn a_named_pipe_among_results_blocks_no_command() {
    let dir = tempfile::tempdir().expect("a folder");
    let case = case(9.81, 1.0);
    for name in ["history.csv", "summary.json", "checkpoint.bin"] {
        assert_eq!(program(dir.path(), &case, &["solve", "--force"]).status, Some(0), "{name}");
        let path = dir.path().join("out/p").join(name);
        let _ = std::fs::remove_file(&path);
        pipe(&path);
        let run = program(dir.path(), &case, &["solve"]);
        assert_eq!(run.status, Some(2), "{name}: {}", run.stderr);
        let run = program(dir.path(), &case, &["solve", "--resume"]);
        assert!(run.status.is_some(), "{name} and --resume");
        let run = program_with(dir.path(), &["plot", "out/p"]);
        assert!(matches!(run.status, Some(0 | 2)), "{name} and plot: {:?} {}", run.status, run.stderr);
        let run = program(dir.path(), &case, &["solve", "--force"]);
        assert_eq!(run.status, Some(0), "{name} and --force: {}", run.stderr);
        assert_eq!(summary(dir.path(), "p")["status"], "completed", "{name}");
    }
}
