//! Folders of results compared, and looked at after a kill.

use std::path::Path;

use canopy_fem::output::checkpoint::Checkpoint;
use canopy_fem::process::Cost;
use serde_json::Value;

use crate::bench::contents;
use crate::common::read_vtu;

/// What a run may cost, and where it was resumed: nothing else in a summary depends on interruptions.
const MAY_DIFFER: [&str; 5] = ["cpu_seconds", "wall_seconds", "peak_memory_bytes", "startup", "resumed_from"];

pub fn checkpoint(folder: &Path) -> Option<Checkpoint> {
    let bytes = std::fs::read(folder.join("checkpoint.bin")).ok()?;
    Some(Checkpoint::decode(&bytes).unwrap_or_else(|fault| panic!("{}: {fault}", folder.display())))
}

/// Every file of `found` has the bytes it has in `expected`, and none is missing or left over. Of the checkpoint and
/// the summary only the cost may differ.
pub fn assert_same(found: &Path, expected: &Path, what: &str) {
    let (a, b) = (contents(found), contents(expected));
    let names = |files: &[(std::path::PathBuf, Vec<u8>)], folder: &Path| -> Vec<String> {
        files.iter().map(|(path, _)| path.strip_prefix(folder).expect("below").display().to_string()).collect()
    };
    assert_eq!(names(&a, found), names(&b, expected), "{what}: the files");
    for ((path, a), (_, b)) in a.iter().zip(&b) {
        match path.file_name().and_then(|name| name.to_str()) {
            Some("summary.json") => assert_eq!(summary(a), summary(b), "{what}"),
            Some("checkpoint.bin") => {
                let of = |folder| Checkpoint { spent: Cost::default(), ..checkpoint(folder).expect("is there") };
                assert!(of(found) == of(expected), "{what}: the checkpoints differ");
            }
            _ => assert!(a == b, "{what}: {} differs", path.display()),
        }
    }
}

fn summary(bytes: &[u8]) -> Value {
    let mut summary: Value = serde_json::from_slice(bytes).expect("JSON");
    for key in MAY_DIFFER {
        assert!(summary.as_object_mut().expect("an object").remove(key).is_some(), "no {key}");
    }
    summary
}

/// What a reader finds in a folder whose run was killed: a collection of whole frames, csv files of whole lines but for
/// the last one, and a sound checkpoint if there is one.
pub fn assert_readable(folder: &Path, stem: &str) {
    if let Ok(collection) = std::fs::read_to_string(folder.join(format!("{stem}.pvd"))) {
        assert!(collection.ends_with("</VTKFile>\n"), "{collection}");
        for line in collection.lines().filter(|line| line.starts_with("<DataSet")) {
            let time: f64 = read_vtu::attribute(line, "timestep").expect("a time").parse().expect("a number");
            let file = read_vtu::attribute(line, "file").expect("a file");
            let frame = read_vtu::parse(&std::fs::read(folder.join(file)).expect("a listed frame is there"));
            assert_eq!(frame.time, time);
        }
    }
    for name in ["history.csv", "probes.csv"] {
        let text = std::fs::read_to_string(folder.join(name)).unwrap_or_default();
        let columns = text.lines().next().map_or(0, |header| header.split(',').count());
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        assert!(whole.lines().all(|line| line.split(',').count() == columns), "{name}: {text}");
    }
    checkpoint(folder);
}
