//! Runs that do not reach their end: status 3 with a report, or 130 when interrupted.

use serde_json::{Value, json};

use crate::bench::{Bench, Results};

/// The newest frame is finite, is of the last step or an earlier one, and everything else can be read.
fn last_good_frame(results: &Results) -> f64 {
    let frames = results.frames();
    let (time, frame) = frames.last().expect("a frame");
    for (time, frame) in &frames {
        assert!(frame.floats("displacement").iter().all(|v| v.is_finite()), "the frame at {time}");
    }
    let end = results.summary()["t_end"].as_f64().expect("a time");
    assert!(*time <= end, "a frame at {time} s, and the last step ends at {end} s");
    assert_eq!(frame.points, 6);
    *time
}

fn is_filled(failure: &Value, keys: &[&str]) {
    for key in keys {
        let value = &failure[key];
        assert!(!value.is_null() && value.as_str() != Some(""), "failure.{key} in {failure}");
    }
}

/// A step far beyond the stable one: status 3, what, where, why and what to do, and the last good frame.
#[test]
fn a_diverging_run_is_reported() {
    let bench = Bench::new();
    let ended = bench.solve(&["--method", "explicit-euler", "--step", "0.3", "--end", "100"]);
    assert_eq!(ended.code, Some(3), "{}", ended.stderr);
    let results = bench.results();
    let summary = results.summary();
    assert_eq!(summary["status"], json!("diverged"));
    let failure = &summary["failure"];
    is_filled(failure, &["time", "step", "node", "spring", "term", "grew", "critical_step", "cause", "advice"]);
    let good = last_good_frame(&results);
    let found = failure["time"].as_f64().expect("a time");
    let end = summary["t_end"].as_f64().expect("a time");
    assert!((found - end - 0.3).abs() < 1e-9 && good < found, "found in the step after the last: {found} after {end}");
    assert_eq!(failure["step"].as_u64(), summary["steps"].as_u64().map(|n| n + 1));
    assert!(failure["node"].as_u64().expect("a node") < 6 && failure["spring"].as_u64().expect("a spring") < 9);
    for words in ["diverged", "where", "cause", "advice"] {
        assert!(ended.stderr.contains(words), "no \"{words}\" in\n{}", ended.stderr);
    }
    let speeds = results.table("history.csv").column("max_speed");
    assert!(speeds.iter().all(|v| v.is_finite()), "the history holds good states only");
}

/// `--keep-going` runs on past the divergence until a value stops being finite; the report keeps the first trouble.
#[test]
fn keep_going_runs_on_to_the_blow_up() {
    let bench = Bench::new();
    let arguments = ["--quiet", "--method", "explicit-euler", "--step", "0.3", "--end", "100"];
    assert_eq!(bench.solve(&arguments).code, Some(3));
    let stopped = bench.results().summary();
    assert_eq!(bench.solve(&[&arguments[..], &["--force", "--keep-going"]].concat()).code, Some(3));
    let went_on = bench.results().summary();
    assert_eq!(went_on["status"], json!("diverged"));
    assert_eq!(stopped["failure"]["time"], went_on["failure"]["time"], "the same first trouble");
    assert!(went_on["steps"].as_u64() > stopped["steps"].as_u64(), "{} steps", went_on["steps"]);
    last_good_frame(&bench.results());
}

/// An implicit step that Newton cannot solve is refused, not accepted: status 3 and "not-converged".
#[test]
fn an_unsolvable_step_is_reported() {
    let bench = Bench::new();
    // Without a kept matrix, which would be tried first.
    let newton = "solver.newton={\"max_iterations\": 1, \"strategy\": \"full\"}";
    let ended = bench.solve(&["--method", "newmark", "--step", "5", "--end", "100", "--set", newton]);
    assert_eq!(ended.code, Some(3), "{}", ended.stderr);
    let summary = bench.results().summary();
    assert_eq!([&summary["status"], &summary["steps"]], [&json!("not-converged"), &json!(0)]);
    is_filled(&summary["failure"], &["time", "step", "node", "spring", "term", "cause", "advice"]);
    assert!(summary["failure"]["cause"].as_str().expect("words").contains("1 iterations"), "{}", summary["failure"]);
    assert_eq!(last_good_frame(&bench.results()), 0.0);
}

/// Backward Euler takes energy, but not where an axial dashpot turns far within a step: said with the way out.
#[test]
fn a_dashpot_that_turns_is_named() {
    let bench = Bench::new();
    let case = json!({
        "name": "bar",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0]], "springs": [[0, 1]]}},
            "mass": {"nodal": 1.0},
            "springs": [{"on": "all", "stiffness": 1e6, "dashpot": {"axial": {"time": 1.0}}}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "gravity": [0, 0, -9.81]
        }},
        "time": {"end": 2, "method": "backward-euler", "step": 0.1}
    });
    std::fs::write(bench.path("bar.json"), case.to_string()).expect("written");
    let ended = bench.run(&["solve", "bar.json", "--out", "bar"]);
    assert_eq!(ended.code, Some(3), "{}", ended.stderr);
    for words in ["an axial dashpot takes a spring that turns within a step", "or dashpots of a shorter time"] {
        assert!(ended.stderr.contains(words), "no \"{words}\" in\n{}", ended.stderr);
    }
    let softer = "system.network.springs.0.dashpot={\"axial\": {\"time\": 1e-3}}";
    let ended = bench.run(&["solve", "bar.json", "--out", "softer", "--step", "0.01", "--set", softer]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
}

/// A file that reaches the size a shell allows is a file that cannot be written: status 1 and its name, where a signal
/// would end the program without a word.
#[cfg(unix)]
#[test]
fn a_file_that_may_not_grow_is_told() {
    let bench = Bench::new();
    let mut shell = std::process::Command::new("sh");
    let program = bench.program();
    shell
        .current_dir(program.get_current_dir().expect("a folder"))
        .args(["-c", "ulimit -f 8; exec \"$@\"", "sh"])
        .arg(program.get_program());
    let ended = shell
        .args(["solve", "sail.json", "--out", "out", "--step", "1e-4", "--set", "output.history.every=1", "--quiet"])
        .output()
        .expect("a shell");
    let words = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(1), "{words}");
    assert!(words.contains("history.csv") && words.contains("too large"), "{words}");
}

/// Ctrl-C ends the run after the step it is in: status 130, "interrupted", and results that can be read.
#[cfg(unix)]
#[test]
fn an_interrupted_run_keeps_its_results() {
    use std::process::{Child, Command, Stdio};
    use std::time::{Duration, Instant};

    /// Ends the program if the test fails before it has ended by itself.
    struct Running(Child);
    impl Drop for Running {
        fn drop(&mut self) {
            let _ = self.0.kill();
            let _ = self.0.wait();
        }
    }

    let limit = Duration::from_secs(60);
    let until = |what: &str, done: &mut dyn FnMut() -> bool| {
        let start = Instant::now();
        while !done() {
            assert!(start.elapsed() < limit, "{what}: not within {limit:?}");
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    let bench = Bench::new();
    // 1e9 steps and 1e5 frames: hours of work.
    let arguments =
        ["solve", "sail.json", "--out", "out", "--step", "1e-6", "--end", "1000", "--set", "output.frames.every=0.01"];
    let mut command = bench.program();
    command.args(arguments).args(["--set", "output.history.every=10000"]).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut running = Running(command.spawn().expect("the program starts"));
    // The collection is written once the run is under way, and so once an interrupt is caught.
    until("the first frame", &mut || bench.path("out/sail.pvd").exists());
    let sent = Command::new("kill").args(["-INT", &running.0.id().to_string()]).status().expect("kill(1)");
    assert!(sent.success());
    let mut status = None;
    until("the end", &mut || {
        status = running.0.try_wait().expect("a child");
        status.is_some()
    });
    assert_eq!(status.and_then(|s| s.code()), Some(130));
    let summary = bench.results().summary();
    assert_eq!([&summary["status"], &summary["failure"]], [&json!("interrupted"), &json!(null)]);
    assert!(summary["steps"].as_u64().expect("a count") > 0);
    last_good_frame(&bench.results());
    let table = bench.results().table("history.csv");
    assert_eq!(table.column("t").last().copied(), summary["t_end"].as_f64());
}
