//! The built program: its exit status, its messages and its files, within a limit of time.

use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// [s] What a run of these tests may take on a busy machine; each takes well under a second on a quiet one.
const LIMIT: Duration = Duration::from_secs(120);

/// What a finished run of the program left.
pub struct Finished {
    /// [-] exit status; `None` if it was still running at the limit and was killed
    pub status: Option<i32>,
    /// what it printed for a person
    pub stdout: String,
    /// warnings, faults and failures
    pub stderr: String,
}

/// Writes a case into a folder and runs the program there on it; `args` begin with the command, and the case's path
/// follows it.
pub fn program(folder: &Path, case: &serde_json::Value, args: &[&str]) -> Finished {
    std::fs::write(folder.join("case.json"), case.to_string()).expect("written");
    let (command, rest) = args.split_first().expect("a command");
    let mut all = vec![*command, "case.json"];
    all.extend(rest);
    program_with(folder, &all)
}

/// Runs the program in a folder.
pub fn program_with(folder: &Path, args: &[&str]) -> Finished {
    // Files rather than pipes: nothing blocks on a full one.
    let (out, err) = (folder.join("stdout.txt"), folder.join("stderr.txt"));
    let mut child = Command::new(env!("CARGO_BIN_EXE_canopy-fem"))
        .args(args)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(File::create(&out).expect("created"))
        .stderr(File::create(&err).expect("created"))
        .spawn()
        .expect("it starts");
    let begun = Instant::now();
    let status = loop {
        match child.try_wait().expect("waited for") {
            Some(status) => break status.code(),
            None if begun.elapsed() > LIMIT => {
                child.kill().and_then(|()| child.wait()).expect("killed");
                break None;
            }
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    };
    let read = |path| std::fs::read_to_string(path).expect("text");
    Finished { status, stdout: read(out), stderr: read(err) }
}

/// `summary.json` of a run in `out/<name>` below a folder.
pub fn summary(folder: &Path, name: &str) -> serde_json::Value {
    let path = folder.join("out").join(name).join("summary.json");
    serde_json::from_str(&std::fs::read_to_string(path).expect("a summary")).expect("JSON")
}
