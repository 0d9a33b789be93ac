//! A program that records a run (`simulation::record`) gets the files and the warnings of the command `solve`.

use crate::bench::Bench;
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::drive::observer::{AcceptedStep, ObserveError, Observer};
use canopy_fem::simulation::{EarlierResults, RecordError, RecordSettings, RecordWatch, record, record_watched};
use serde_json::{Value, json};
use std::cell::{Cell, RefCell};
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
    let how = RecordSettings::new(&out);
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

/// A mass between two springs, pulled across by a growing force: its method becomes unstable on the way.
fn pulled() -> Value {
    json!({
        "name": "pulled",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[-1, 0, 0], [0, 0, 0], [1, 0, 0]], "springs": [[0, 1], [1, 2]]}},
            "mass": {"nodal": 0.5},
            "springs": [{"on": "all", "stiffness": 50}],
            "supports": [
                {"on": {"ids": [0, 2]}, "fix": "xyz", "until": 200}, {"on": {"ids": [1]}, "fix": "xy"}
            ],
            "loads": [{"on": {"ids": [1]}, "force": [0, 0, 1], "table": [[0, 0], [100, 400]]}]
        }},
        "time": {"end": 100, "method": "velocity-verlet", "step": 0.16},
        "output": {"frames": {"every": 10}, "gauges": [{"name": "mid", "on": {"ids": [1]}, "of": "displacement"}]}
    })
}

/// The cloth of the other tests with other values at these places.
fn cloth_with(changes: &[(&str, Value)]) -> Value {
    let mut case = case(0.1);
    for (place, value) in changes {
        *case.pointer_mut(place).expect("a place") = value.clone();
    }
    case
}

/// Warnings of the case, of its scene, of the run and of its end, as soon as they are known and in this order. What a
/// case acknowledges is told by neither.
#[test]
fn warnings_are_those_of_the_command() {
    let mut acknowledged = pulled();
    acknowledged["acknowledge"] = json!(["event-beyond-end", "energy-made"]);
    let long = json!({"end": 3, "method": "velocity-verlet", "step": 0.05});
    for (case, codes) in [
        (pulled(), &["event-beyond-end", "step-above-critical", "energy-made"][..]),
        (acknowledged, &["step-above-critical"]),
        (cloth_with(&[("/time", long)]), &["step-above-critical"]),
        (cloth_with(&[]), &[]),
    ] {
        let bench = Bench::new();
        std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
        let ended = bench.run(&["solve", "case.json", "--out", "command"]);
        let command: Vec<&str> = ended.stderr.lines().filter_map(|line| line.strip_prefix("warning: ")).collect();
        let out = bench.path("program");
        let (told, begun) = (RefCell::new(Vec::new()), Cell::new(0));
        let watch = RecordWatch {
            begins: &|| begun.set(begun.get() + 1),
            warned: &|warning| told.borrow_mut().push(warning.clone()),
        };
        let (how, go) = (RecordSettings::new(&out), AtomicBool::new(false));
        let recorded = record_watched(read(&case), how, watch, &mut [], &go).expect("it runs");
        assert_eq!((told.into_inner(), begun.get()), (recorded.warnings.clone(), 1));
        let warnings: Vec<String> = recorded.warnings.iter().map(ToString::to_string).collect();
        assert_eq!(warnings, command);
        let found: Vec<String> = recorded.warnings.iter().map(|warning| warning.code.to_string()).collect();
        assert_eq!(found, codes);
        assert!(files(&out) == files(&bench.path("command")), "{codes:?}");
        // Nothing that is told changes a file.
        bench.run(&["solve", "case.json", "--out", "quiet", "--quiet"]);
        assert!(files(&out) == files(&bench.path("quiet")), "{codes:?}");
    }
}

/// A program hears of frames beyond the free room of the disk too: 17 MB almost a million times.
#[test]
fn frames_beyond_the_disk_are_announced() {
    let mesh = json!({"rectangle": {"width": 1, "height": 1, "columns": 200, "rows": 200}});
    let case = cloth_with(&[("/system/network/mesh", mesh), ("/output/frames/every", json!(1.1e-7))]);
    let bench = Bench::new();
    let (out, stopped) = (bench.path("program"), AtomicBool::new(true));
    let recorded = record(&read(&case), RecordSettings::new(&out), &mut [], &stopped).expect("it is stopped");
    assert_eq!((recorded.outcome.status, recorded.outcome.steps), (Status::Interrupted, 0));
    let disk = recorded.warnings.iter().find(|warning| warning.code.to_string() == "disk-space");
    let disk = disk.unwrap_or_else(|| panic!("not in {:?}", recorded.warnings));
    assert!(disk.text.contains("the frames need about"), "{}", disk.text);
}
