//! Some of the table through the program itself: the exit status tells how it ended, and standard error why.

use super::table::{Hostile, cases};
use super::verdict::{Kind, attempt, judge};
use canopy_fem::integrate::registry::methods;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A prime: every method and every section of the table has its turn.
const EVERY: usize = 5;

/// What the program may take for a case that the library ends in a second.
const HANG: Duration = Duration::from_secs(60);

/// How a command ended.
struct Ended {
    code: Option<i32>,
    stderr: String,
}

fn program(folder: &Path, arguments: &[&str]) -> Result<Ended, String> {
    let mut child = Command::new(env!("CARGO_BIN_EXE_canopy-fem"))
        .current_dir(folder)
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(std::fs::File::create(folder.join("stderr")).expect("a file"))
        .spawn()
        .expect("the program starts");
    let start = Instant::now();
    let code = loop {
        match child.try_wait().expect("it is our child") {
            Some(status) => break status.code(),
            None if start.elapsed() > HANG => {
                child.kill().expect("it is our child");
                child.wait().expect("it is our child");
                return Err(format!("{arguments:?}: still at it after {HANG:?}"));
            }
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    };
    let stderr = std::fs::read_to_string(folder.join("stderr")).map_err(|error| error.to_string())?;
    Ok(Ended { code, stderr })
}

/// The exit status that belongs to an end.
fn status_of(kind: Kind) -> i32 {
    match kind {
        Kind::Completed | Kind::Doubted => 0,
        Kind::Refused => 2,
        Kind::Diverged | Kind::NotConverged => 3,
    }
}

fn hold(case: &Hostile, method: &str, folder: &Path) -> Result<(), String> {
    let sets = case.sets_for(method);
    let kind = judge(&attempt(&case.json, &sets))?;
    std::fs::write(folder.join("hostile.json"), case.json.to_string()).expect("a file");
    let assignments: Vec<String> = sets.iter().map(|(key, value)| format!("{key}={value}")).collect();
    let with = |first: &[&'static str]| -> Vec<String> {
        let words = first.iter().map(|w| (*w).to_owned());
        words.chain(assignments.iter().flat_map(|a| ["--set".to_owned(), a.clone()])).collect()
    };
    let run = |arguments: Vec<String>| {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        program(folder, &arguments)
    };
    let solved = run(with(&["solve", "hostile.json", "--out", "out", "--force"]))?;
    let checked = run(with(&["check", "hostile.json"]))?;
    let complain = |what: &str, ended: &Ended| Err(format!("{what}: status {:?}, {}", ended.code, ended.stderr));
    if solved.code != Some(status_of(kind)) {
        return complain(&format!("solve ends otherwise than the library ({kind:?})"), &solved);
    }
    if checked.code != Some(if kind == Kind::Refused { 2 } else { 0 }) {
        return complain(&format!("check ends otherwise than solve ({kind:?})"), &checked);
    }
    for ended in [&solved, &checked] {
        if ended.stderr.contains("panicked") {
            return complain("a panic shows", ended);
        }
        if ended.code != Some(0) && !ended.stderr.lines().any(|line| line.starts_with("error: ")) {
            return complain("no error is told", ended);
        }
    }
    if kind == Kind::Doubted && !solved.stderr.contains("warning: ") {
        return complain("doubtful without a warning", &solved);
    }
    if kind != Kind::Refused { summed_up(kind, folder) } else { Ok(()) }
}

/// The summary says the same.
fn summed_up(kind: Kind, folder: &Path) -> Result<(), String> {
    let text = std::fs::read_to_string(folder.join("out/summary.json")).map_err(|error| error.to_string())?;
    let summary: serde_json::Value = serde_json::from_str(&text).map_err(|error| error.to_string())?;
    let status = match kind {
        Kind::Diverged => "diverged",
        Kind::NotConverged => "not-converged",
        _ => "completed",
    };
    let fails = summary["failure"].is_object() == (status == "completed");
    if summary["status"] != status || fails { Err(format!("{kind:?}, but the summary is {text}")) } else { Ok(()) }
}

#[test]
#[ignore = "long"]
fn the_program_ends_as_the_library_does() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut wrong = Vec::new();
    let all = cases();
    let some = all.iter().enumerate().step_by(EVERY);
    for (i, case) in some {
        let method = methods()[i % methods().len()].name;
        if let Err(why) = hold(case, method, folder.path()) {
            wrong.push(format!("{} with {method}: {why}", case.name));
        }
        let _ = std::fs::remove_dir_all(folder.path().join("out"));
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), all.len() / EVERY, wrong.join("\n"));
}

/// Damaged mesh files in a case, through the program: a sentence, and no trace of the parser that gave up.
#[test]
fn damaged_mesh_files_end_in_one_sentence() {
    let folder = tempfile::tempdir().expect("a folder");
    let square = include_bytes!("../../fuzz/seeds/mesh/square.vtu");
    let case = |name: &str| {
        format!(
            "{{\"name\": \"m\", \"system\": {{\"network\": {{\"mesh\": {{\"file\": \"{name}\"}}, \"mass\": {{\"nodal\": 1}}}}}}, \
             \"time\": {{\"end\": 1, \"step\": 1, \"method\": \"newmark\"}}}}"
        )
    };
    for cut in (0..square.len()).step_by(97) {
        std::fs::write(folder.path().join("cut.vtu"), &square[..cut]).expect("a file");
        std::fs::write(folder.path().join("case.json"), case("cut.vtu")).expect("a file");
        for arguments in [&["check", "case.json"][..], &["mesh", "inspect", "cut.vtu"]] {
            let ended = program(folder.path(), arguments).expect("an end");
            assert!(matches!(ended.code, Some(1 | 2)), "{arguments:?} at {cut}: {:?} {}", ended.code, ended.stderr);
            assert!(!ended.stderr.contains("panicked"), "{arguments:?} at {cut}: {}", ended.stderr);
            assert!(ended.stderr.contains("cut.vtu"), "{arguments:?} at {cut}: {}", ended.stderr);
        }
    }
}
