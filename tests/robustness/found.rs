//! What the fuzzers found, and what they start from, goes through the functions of the fuzz targets again
//! (`tests/fuzz`).

use crate::{case_oracle, mesh_oracle};
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Duration;

/// What an input that takes the fuzzers a few milliseconds may take on a busy machine.
const HANG: Duration = Duration::from_secs(30);

fn folder(below: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz").join(below)
}

/// Judges every file of some folders on a thread of its own, and names those that do not hold; how many there were.
fn replay(folders: &[&str], judge: fn(&[u8]) -> Result<(), String>) -> usize {
    // As long as nothing was found there is no folder for it; the callers count the files.
    let listed = folders.iter().flat_map(|f| std::fs::read_dir(folder(f)).into_iter().flatten());
    let mut paths: Vec<PathBuf> = listed.map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    let judge_file = |path: &PathBuf| {
        let bytes = std::fs::read(path).expect("the file is there");
        let (send, receive) = mpsc::channel();
        // After a panic nothing is sent, and receiving fails at once.
        std::thread::spawn(move || send.send(judge(&bytes)));
        match receive.recv_timeout(HANG) {
            Ok(judged) => judged.err(),
            Err(mpsc::RecvTimeoutError::Disconnected) => Some("panicked, see above".to_owned()),
            Err(mpsc::RecvTimeoutError::Timeout) => Some(format!("still at it after {HANG:?}")),
        }
    };
    let wrong: Vec<String> =
        paths.iter().filter_map(|path| judge_file(path).map(|why| format!("{}: {why}", path.display()))).collect();
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), paths.len(), wrong.join("\n"));
    paths.len()
}

#[test]
fn found_cases_and_seeds_hold() {
    let count = replay(&["found/case", "seeds/case"], |bytes| case_oracle::judge(bytes, &folder("seeds/mesh")));
    assert!(count >= 33, "{count} files are left");
}

#[test]
fn found_meshes_and_seeds_hold() {
    let count = replay(&["found/mesh", "seeds/mesh"], mesh_oracle::judge);
    assert!(count >= 16, "{count} files are left");
}
