//! What use of the program found: every case here went wrong once, mostly without a word. Each test keeps the right
//! value. A test of this kind belongs in the file of its topic in `tests/robustness/faults/`.

mod adaptive;
mod canopies;
mod cloth;
mod contact;
mod endless;
mod first_steps;
mod folders;
mod frames;
mod free_stream;
mod held;
mod kang;
mod loads;
mod messages;
mod program;
mod sheets;
#[cfg(unix)]
mod signals;
mod solver;
mod warnings;
mod words;

use program::program;

#[test]
fn a_program_of_these_tests_runs_and_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let case = serde_json::json!({"name": "p", "system": {"pendulum": {"length": 1.0, "mass": 1.0, "angle": 0.1, "gravity": 9.81}},
        "time": {"end": 0.1, "method": "rk4", "step": 0.01}});
    let run = program(folder.path(), &case, &["solve"]);
    assert_eq!(run.status, Some(0), "{}{}", run.stdout, run.stderr);
    assert_eq!(program::summary(folder.path(), "p")["status"], "completed");
}
