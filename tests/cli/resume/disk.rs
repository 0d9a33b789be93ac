//! A full disk and a vanished folder: status 1 with the file's name, nothing lost that was written, and a run to
//! resume.

use std::path::Path;
use std::process::Command;

use super::folders::{assert_readable, assert_same, checkpoint};
use super::kills::Running;
use crate::bench::{Bench, Ended};

/// 5000 steps with a frame each 50th and a checkpoint each 250th.
const LONG: &str =
    "solve sail.json --quiet --step 2e-4 --set output.frames.every=0.01 --set output.checkpoint.every=0.05";

/// Runs a script in the bench's folder with the program as `$0`.
fn shell(bench: &Bench, script: &str) -> Ended {
    let program = bench.program();
    let mut command = Command::new("sh");
    command.current_dir(program.get_current_dir().expect("set")).arg("-c").arg(script).arg(program.get_program());
    let output = command.output().expect("sh(1)");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    Ended { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

/// Status 1, the file and the reason; what is there can be read, ends with whole lines, and can be resumed to the same
/// bytes.
fn assert_survived(bench: &Bench, ended: &Ended, reason: &str) {
    assert_eq!(ended.code, Some(1), "{}", ended.stderr);
    assert!(ended.stderr.starts_with("error: ") && ended.stderr.contains(reason), "{}", ended.stderr);
    let out = bench.path("out");
    assert_readable(&out, "sail");
    for name in ["history.csv", "probes.csv"] {
        assert!(bench.results().text(name).ends_with('\n'), "{name} ends within a line");
    }
    let steps = checkpoint(&out).expect("an earlier one").snapshot.step;
    assert!(steps < 4999, "the disk was large enough");
    assert!(bench.results().table("history.csv").rows.len() as u64 > steps, "rows before the checkpoint are there");
    let resumed = shell(bench, &format!("exec $0 {LONG} --out out --resume"));
    assert_eq!((resumed.code, resumed.stderr.as_str()), (Some(0), ""));
    assert_eq!(shell(bench, &format!("exec $0 {LONG} --out whole")).code, Some(0));
    assert_same(&out, &bench.path("whole"), reason);
}

/// The largest size a file may have, reached by the history.
#[test]
fn a_file_that_may_not_grow() {
    let bench = Bench::new();
    // The signal that comes with the refused write ends a program that does not ignore it. 400 blocks of 512 bytes.
    let ended = shell(&bench, &format!("trap '' XFSZ; ulimit -f 400; exec $0 {LONG} --out out"));
    assert!(ended.stderr.contains("history.csv: "), "{}", ended.stderr);
    assert_survived(&bench, &ended, "File too large");
}

/// A disk of 400 KiB, where the system lets an ordinary user make one.
#[test]
fn a_full_disk() {
    let bench = Bench::new();
    let script = format!(
        "exec unshare -rm sh -c 'mkdir disk && mount -t tmpfs -o size=400k tmpfs disk || exit 77; \"$0\" {LONG} --out disk/out; \
         code=$?; cp -r disk/out out; exit $code' \"$0\""
    );
    let ended = shell(&bench, &script);
    if matches!(ended.code, Some(77 | 127)) || ended.stderr.contains("unshare") {
        println!("not tried, because no disk can be mounted here: {}", ended.stderr.trim());
        return;
    }
    assert_survived(&bench, &ended, "No space left on device");
}

/// A finished run is carried further, past the length from which rows would be told less often: they come as often as
/// they did.
#[test]
fn a_later_end() {
    let bench = Bench::new();
    let keep = ["--set", "output.frames=null", "--step", "1e-4"];
    let first = bench.solve(&[&keep[..], &["--set", "output.checkpoint.every=0.5", "--end", "0.9"]].concat());
    assert_eq!(first.code, Some(0), "{}", first.stderr);
    let on = bench.solve(&[&keep[..], &["--end", "1.1", "--resume", "--set", "output.checkpoint.every=0.5"]].concat());
    assert_eq!(on.code, Some(0), "{}", on.stderr);
    // What is in force may be said, and nothing else asked for.
    for (rows, code) in [("1", 0), ("2", 2)] {
        std::fs::remove_file(bench.path("out/summary.json")).expect("was there");
        let every = format!("output.history.every={rows}");
        let said = bench.solve(
            &[&keep[..], &["--end", "1.1", "--resume", "--set", &every, "--set", "output.checkpoint.every=0.5"]]
                .concat(),
        );
        assert_eq!(said.code, Some(code), "{rows}: {}", said.stderr);
    }
    let whole = Bench::new();
    let once = whole.solve(&[&keep[..], &["--end", "1.1", "--set", "output.history.every=1"]].concat());
    assert_eq!(once.code, Some(0), "{}", once.stderr);
    let rows = |bench: &Bench| std::fs::read_to_string(bench.path("out/history.csv")).expect("rows");
    assert_eq!(rows(&whole).lines().count(), 11_002);
    assert!(rows(&bench) == rows(&whole), "rows differ");
}

/// The folder is taken away while the run is writing into it.
#[test]
fn a_vanished_folder() {
    let bench = Bench::new();
    let long = ["solve", "sail.json", "--out", "out", "--quiet", "--step", "1e-6", "--end", "100"];
    let sets = ["--set", "output.frames.every=0.001", "--set", "output.history.every=1000"];
    let mut running = Running::start(&bench, &[&long[..], &sets[..]].concat());
    running.until("a frame", |_| bench.path("out/frames/sail_000001.vtu").exists());
    std::fs::rename(bench.path("out"), bench.path("gone")).expect("was there");
    let (code, said) = running.end();
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("out") && said.contains("No such file or directory"), "{said}");
    assert!(!bench.path("out").exists(), "it came back");
    assert_whole_lines(&bench.path("gone/history.csv"));
    assert_readable(&bench.path("gone"), "sail");
}

fn assert_whole_lines(path: &Path) {
    let text = std::fs::read_to_string(path).expect("a file");
    assert!(text.lines().count() > 1 && text.ends_with('\n'));
}
