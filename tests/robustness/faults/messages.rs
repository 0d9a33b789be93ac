//! What a run that fails says and shows: one fault has one advice, and nothing is shown of a state that is wrong.

use super::program::{Finished, program_with, summary};
use std::path::Path;

/// Runs a shipped case in a folder.
fn shipped(folder: &Path, command: &str, case: &str, rest: &[&str]) -> Finished {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/cases").join(format!("{case}.json"));
    program_with(folder, &[&[command, path.to_str().expect("UTF-8")], rest].concat())
}

/// All that is advised: the words after "take" up to the end of the line or the code of a warning.
fn advices(text: &str) -> Vec<&str> {
    text.split("take ").skip(1).map(|rest| rest.split(['\n', '[']).next().unwrap_or_default().trim()).collect()
}

/// The columns of a row of `history.csv` at a time [s].
fn history_at(folder: &Path, t: f64) -> Vec<f64> {
    let text = std::fs::read_to_string(folder.join("history.csv")).expect("a history");
    let rows = text.lines().skip(1).map(|row| row.split(',').flat_map(str::parse).collect::<Vec<f64>>());
    rows.min_by(|a, b| (a[0] - t).abs().total_cmp(&(b[0] - t).abs())).expect("a row")
}

/// [s] the times in a `.pvd`, and whether each of its frames is there and no other.
fn frame_times(folder: &Path, name: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(folder.join(format!("{name}.pvd"))).expect("a collection");
    let value = |line: &str, key: &str| {
        line.split(&format!("{key}=\"")).nth(1).and_then(|r| r.split('"').next()).map(str::to_owned)
    };
    let sets: Vec<&str> = text.lines().filter(|line| line.starts_with("<DataSet")).collect();
    for line in &sets {
        let file = value(line, "file").expect("a file");
        assert!(folder.join(&file).exists(), "{file}");
    }
    let files = std::fs::read_dir(folder.join("frames")).expect("frames").count();
    assert_eq!(files, sets.len(), "frames that are not listed");
    sets.iter().filter_map(|line| value(line, "timestep")?.parse().ok()).collect()
}

/// `check`, the warning before the run, that in it and the report after it: the same step and the same method.
#[test]
fn a_step_above_its_limit_has_one_advice() {
    let folder = tempfile::tempdir().expect("a folder");
    let wrong = ["--method", "explicit-euler", "--step", "1e-2"];
    let run = shipped(folder.path(), "solve", "cloth-k1000", &wrong);
    assert_eq!(run.status, Some(3), "{}", run.stderr);
    let given = advices(&run.stderr);
    assert!(given.len() >= 2, "{}", run.stderr);
    assert!(run.stderr.contains("advice  take "), "{}", run.stderr);
    let sets = ["--set", "time.method=explicit-euler", "--set", "time.step=1e-2", "--set", "time.end=0.1"];
    let check = shipped(folder.path(), "check", "cloth-k1000", &sets);
    let checked: Vec<&str> = check.stdout.lines().filter(|line| line.contains("expect it to diverge")).collect();
    for advice in given.iter().copied().chain(checked.iter().flat_map(|line| advices(line))) {
        assert_eq!(advice, given[0]);
    }
    assert_eq!(checked.len(), 1, "{}", check.stdout);
    // The advice holds.
    let step = given[0].strip_prefix("a step of ").and_then(|rest| rest.split(' ').next()).expect("a step");
    let method = given[0].split("time.method=").nth(1).expect("a method");
    for changed in [["--method", "explicit-euler", "--step", step], ["--method", method, "--step", "1e-2"]] {
        let run =
            shipped(folder.path(), "solve", "cloth-k1000", &[&changed[..], &["--end", "0.5", "--force"]].concat());
        assert_eq!(run.status, Some(0), "{changed:?}: {}", run.stderr);
    }
}

/// The block after a failure has no counts of work that was not done, and no figures of the state that is wrong.
#[test]
fn a_failed_run_says_only_what_holds() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = shipped(folder.path(), "solve", "cloth-k1000", &["--method", "explicit-euler", "--step", "1e-2"]);
    assert!(run.stdout.contains("last frame") && run.stdout.contains("force passes"), "{}", run.stdout);
    for word in [" 0 ", "displacement", "energy error", "of it used"] {
        assert!(!run.stdout.contains(word), "{word:?} in\n{}", run.stdout);
    }
}

/// The last frame is the last state in which the scheme had made no more energy than there was.
#[test]
fn the_last_frame_keeps_the_first_law() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = shipped(folder.path(), "solve", "cloth-k1000", &["--method", "explicit-euler", "--step", "1e-2"]);
    assert_eq!(run.status, Some(3), "{}", run.stderr);
    let out = folder.path().join("out/cloth-k1000");
    let last = *frame_times(&out, "cloth-k1000").last().expect("a frame");
    let end = summary(folder.path(), "cloth-k1000")["t_end"].as_f64().expect("a time");
    assert!(last < end, "the state at {end} s has more energy than came in");
    // t, step, kinetic, elastic, gravity, external work, dissipated, numerical
    let (good, bad) = (history_at(&out, last), history_at(&out, end));
    let made = |row: &[f64]| -row[7] - row[6].min(0.0);
    let came_in = |row: &[f64]| (row[5] - row[4]).max(0.5);
    assert!(made(&good) <= came_in(&good), "{good:?}");
    assert!(made(&bad) > came_in(&bad), "{bad:?}");
    // With all frames asked for, and to the end of what can be run, they all stay.
    let all = ["--method", "explicit-euler", "--step", "1e-2", "--keep-going", "--end", "0.06", "--force"];
    assert_eq!(shipped(folder.path(), "solve", "cloth-k1000", &all).status, Some(3));
    assert_eq!(frame_times(&out, "cloth-k1000").last(), Some(&0.06));
}

/// In the last frame of the thesis' run no node has moved farther than the canopy's size in a step, nor has it in any
/// before.
#[test]
fn the_last_frame_shows_nodes_that_stay_within_the_scene_in_a_step() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = shipped(folder.path(), "solve", "parachute-original", &[]);
    assert_eq!(run.status, Some(3), "{}", run.stderr);
    let out = folder.path().join("out/parachute-original");
    let times = frame_times(&out, "parachute-original");
    let last = *times.last().expect("a frame");
    // A frame a step of 1e-12 s, from 0 on; the run goes on for some steps.
    assert_eq!(times.len() as f64, (last / 1e-12).round() + 1.0);
    assert!(history_at(&out, 1.0)[0] > last, "no step after {last} s");
    let speed = |t: f64| history_at(&out, t)[10];
    assert!(speed(last) * 1e-12 <= 1.05, "{} m in a step", speed(last) * 1e-12);
    assert!(speed(last + 2e-12) * 1e-12 > 1.0, "{} m in a step", speed(last + 2e-12) * 1e-12);
}

/// Where the air damps nothing that the springs do, explicit Euler has no stable step, however small; nor have other
/// methods whose growth in so small a step is lost in rounding.
#[test]
fn no_limit_is_made_of_rounding() {
    let folder = tempfile::tempdir().expect("a folder");
    for method in ["explicit-euler", "improved-euler", "improved-euler-pec"] {
        let run = shipped(
            folder.path(),
            "solve",
            "parachute-50ms",
            &["--method", method, "--step", "1e-10", "--end", "1e-9", "--force"],
        );
        assert_eq!(run.status, Some(0), "{}", run.stderr);
        assert!(run.stderr.contains(&format!("{method} has no stable step on this scene")), "{}", run.stderr);
    }
}
