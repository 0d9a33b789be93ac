//! A program that records a run (`simulation::record`) gets the files that the command `solve` writes.

use crate::bench::Bench;
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::drive::observer::{AcceptedStep, ObserveError, Observer};
use canopy_fem::simulation::{EarlierResults, RecordError, RecordSettings, record};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// Keys of the summary that differ from run to run.
const COSTS: [&str; 4] = ["cpu_seconds", "wall_seconds", "peak_memory_bytes", "startup"];

fn case(end: f64) -> Value {
    json!({
        "name": "recorded",
        "system": {"network": {
            "mesh": {"rectangle": {"width": 1, "height": 1, "columns": 4, "rows": 4}},
            "mass": {"nodal": 0.01},
            "springs": [{"on": "all", "stiffness": 50, "dashpot": {"axial": {"time": 0.001}}}],
            "supports": [{"on": {"ids": [0, 4]}, "fix": "xyz"}],
            "gravity": [0, 0, -9.81]
        }},
        "time": {"end": end, "method": "newmark", "step": 0.001},
        "output": {
            "frames": {"every": 0.02}, "fields": ["tension"], "probes": [{"name": "p", "on": {"ids": [12]}}],
            "gauges": [{"name": "held", "on": {"ids": [0]}, "of": "reaction"}]
        }
    })
}

fn files(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for folder in [dir.to_owned(), dir.join("frames")] {
        for entry in std::fs::read_dir(folder).expect("results") {
            let path = entry.expect("a file").path();
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            let is_file = path.is_file() && name != "checkpoint.bin";
            if let Some(bytes) = is_file.then(|| std::fs::read(&path).expect("read")) {
                found.insert(name.clone(), if name == "summary.json" { without_costs(&bytes) } else { bytes });
            }
        }
    }
    found
}

fn without_costs(summary: &[u8]) -> Vec<u8> {
    let mut summary: Value = serde_json::from_slice(summary).expect("JSON");
    COSTS.iter().for_each(|key| drop(summary.as_object_mut().expect("an object").remove(*key)));
    summary.to_string().into_bytes()
}

fn read(case: &Value) -> Case {
    Case::from_text(case.to_string(), "case.json", "".into(), &[]).expect("a case")
}

/// Sets a flag at a step.
struct StopAfter<'a>(u64, &'a AtomicBool);

impl Observer for StopAfter<'_> {
    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.1.store(step.step >= self.0, Ordering::Relaxed);
        Ok(())
    }
}

/// The files are those of the command; earlier ones are kept; a run that was stopped goes on to the same files.
#[test]
fn files_are_those_of_the_command() {
    let (bench, case) = (Bench::new(), case(0.1));
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    let ended = bench.run(&["solve", "case.json", "--out", "command"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let expected = files(&bench.path("command"));
    assert!(expected.len() > 9, "{:?}", expected.keys());
    let out = bench.path("program");
    let how = RecordSettings { out: &out, earlier: EarlierResults::Keep, threads: 1, keep_going: false };
    let go = AtomicBool::new(false);
    let recorded = record(&read(&case), how, &mut [], &go).expect("it runs");
    assert_eq!((recorded.outcome.status, recorded.outcome.steps), (Status::Completed, 100));
    assert!(files(&out) == expected);
    let kept = record(&read(&case), how, &mut [], &go);
    assert!(matches!(kept, Err(RecordError::Folder(_))), "{kept:?}");

    let replace = RecordSettings { earlier: EarlierResults::Replace, ..how };
    let stop = AtomicBool::new(false);
    let stopped = record(&read(&case), replace, &mut [&mut StopAfter(37, &stop)], &stop).expect("it runs");
    assert_eq!(stopped.outcome.status, Status::Interrupted);
    let resume = RecordSettings { earlier: EarlierResults::Resume, ..how };
    let resumed = record(&read(&case), resume, &mut [], &go).expect("it goes on");
    assert!(resumed.summary.resumed_from.is_some_and(|t| t > 0.0 && t < 0.1));
    for (name, bytes) in files(&out).iter().filter(|(name, _)| *name != "summary.json") {
        assert!(expected[name] == *bytes, "{name}");
    }
}
