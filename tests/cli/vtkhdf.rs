//! All frames of a run in one file: its numbers are those of the .vtu frames, it is smaller, and what reads frames
//! reads it.

use std::fs::File;
use std::path::Path;

use canopy_fem::vtk::hdf::HdfFrames;
use canopy_fem::vtk::read::{Column, DataSet, read};
use serde_json::{Value, json};

use crate::bench::{Bench, contents};

/// All arrays of frames.
const ARRAYS: [&str; 15] = [
    "displacement",
    "velocity",
    "force",
    "reaction",
    "tension",
    "strain",
    "pressure",
    "stress_1",
    "stress_2",
    "strain_1",
    "strain_2",
    "wrinkling",
    "warp",
    "crossing",
    "reference_position",
];

/// A small parachute with lines and groups, and every field that it can have.
fn parachute() -> Value {
    let mut case = crate::group_frames::parachute();
    case["time"]["end"] = json!(0.04);
    case["output"] = json!({
        "frames": {"every": 0.002},
        "fields": ["force", "reaction", "tension", "strain", "pressure"],
        "probes": [{"name": "payload", "on": {"group": "payload"}}]
    });
    case
}

fn solve(bench: &Bench, out: &str, sets: &[&str]) {
    let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", *set]).collect();
    let ended = bench.run(&[&["solve", "case.json", "--out", out], sets.as_slice()].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
}

/// The same run twice: `vtu` with a file for each frame, `hdf` with one for all.
fn both(sets: &[&str]) -> Bench {
    let bench = Bench::new();
    std::fs::write(bench.path("case.json"), parachute().to_string()).expect("written");
    solve(&bench, "vtu", sets);
    solve(&bench, "hdf", &[&["output.format=vtkhdf"], sets].concat());
    bench
}

fn frames(path: &Path) -> HdfFrames {
    HdfFrames::of(File::open(path).expect("the file of the run")).expect("a VTKHDF file")
}

/// Whether two frames hold the same, down to the last bit; the number of their arrays.
fn compare(found: &DataSet, expected: &DataSet) -> usize {
    let (a, b) = (&found.pieces[0], &expected.pieces[0]);
    assert_eq!(a.points, b.points);
    assert!(a.cells.iter().eq(b.cells.iter()));
    let mut fields = [found.fields.clone(), expected.fields.clone()];
    fields.iter_mut().for_each(|list| list.sort());
    assert_eq!(fields[0], fields[1]);
    for (a, b) in [(&a.point_data, &b.point_data), (&a.cell_data, &b.cell_data)] {
        assert_eq!(a.len(), b.len());
        for column in b {
            let same = |other: &&Column| other.name == column.name;
            let found = a.iter().find(same).unwrap_or_else(|| panic!("no array {}", column.name));
            assert_eq!((found.components, &found.numbers), (column.components, &column.numbers), "{}", column.name);
        }
    }
    a.point_data.len() + a.cell_data.len()
}

/// Every array of every frame has the same numbers in both formats, whatever their digits and compression; other files
/// are the same, and two threads change nothing. With defaults the one file has at most 0.6 of the bytes.
#[test]
fn one_file_holds_what_the_frames_hold() {
    for sets in [&[][..], &["output.compression=none"], &["output.precision=f32"]] {
        let bench = both(sets);
        let mut one = frames(&bench.path("hdf/small.vtkhdf"));
        assert_eq!(one.times().len(), 21);
        let mut bytes = 0;
        for number in 0..21 {
            let frame = std::fs::read(bench.path(&format!("vtu/frames/small_{number:06}.vtu"))).expect("a frame");
            bytes += frame.len();
            let expected = read(&frame, &ARRAYS).expect("a frame");
            assert_eq!(compare(&one.frame(number, &ARRAYS).expect("a frame"), &expected), 13);
            assert!((one.times()[number] - 0.002 * number as f64).abs() < 1e-12);
        }
        let hdf = std::fs::metadata(bench.path("hdf/small.vtkhdf")).expect("the file").len() as f64;
        let share = hdf / bytes as f64;
        assert!(share < if sets.is_empty() { 0.6 } else { 0.75 }, "{sets:?}: {share}");
        assert!(!bench.path("hdf/frames").exists() && !bench.path("hdf/small.pvd").exists());
        for name in ["history.csv", "probes.csv"] {
            let [a, b] = ["hdf", "vtu"].map(|out| std::fs::read(bench.path(out).join(name)).expect(name));
            assert!(a == b, "{name}");
        }
    }
    let bench = both(&[]);
    let ended = bench.run(&["solve", "case.json", "--out", "two", "--threads", "2", "--set", "output.format=vtkhdf"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stdout.contains("two/small.vtkhdf"), "{}", ended.stdout);
    let [one, two] = ["hdf", "two"].map(|out| std::fs::read(bench.path(out).join("small.vtkhdf")).expect("the file"));
    assert!(one == two);
}

/// `view`, `plot`, `export` and `initial.from` give of both formats the same.
#[test]
fn what_reads_frames_reads_one_file() {
    let bench = both(&[]);
    let mut made = Vec::new();
    for out in ["vtu", "hdf"] {
        let folder = format!("{out}-made");
        let run = |arguments: &[&str]| {
            let ended = bench.run(arguments);
            assert_eq!(ended.code, Some(0), "{arguments:?}: {}", ended.stderr);
        };
        run(&["view", out, "--out", &folder]);
        run(&["plot", out, "--out", &folder]);
        for to in ["glb", "usda"] {
            run(&["export", out, "--to", to, "--output", &format!("{folder}/small.{to}")]);
        }
        made.push(
            contents(&bench.path(&folder))
                .into_iter()
                .map(|(path, bytes)| (path.file_name().map(std::ffi::OsStr::to_owned), bytes))
                .collect::<Vec<_>>(),
        );
    }
    assert!(made[0].len() >= 4, "{:?}", made[0].iter().map(|(name, _)| name).collect::<Vec<_>>());
    assert_eq!(made[0].len(), made[1].len());
    for ((name, a), (_, b)) in made[0].iter().zip(&made[1]) {
        assert!(a == b, "{name:?}");
    }
    let begin = |out: &str, from: &str| {
        solve(&bench, out, &[&format!("system.network.initial.from={from}"), "time.end=0.01"]);
        std::fs::read(bench.path(out).join("history.csv")).expect("a history")
    };
    let expected = begin("from-vtu", "\"vtu\"");
    assert!(begin("from-hdf", "\"hdf\"") == expected);
    assert!(begin("from-file", "{\"frame\": \"hdf/small.vtkhdf\"}") == expected);
    let ended = bench.run(&[
        "solve",
        "case.json",
        "--out",
        "no",
        "--set",
        "system.network.initial.from={\"frame\": \"case.json\"}",
    ]);
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
}

/// A folder of the other format is replaced whole on request, and a checkpoint is not taken for one of the other.
#[test]
fn formats_do_not_mix() {
    let bench = both(&["output.checkpoint.every=0.01"]);
    let one = std::fs::read(bench.path("hdf/small.vtkhdf")).expect("the file");
    let resumed =
        bench.run(&["solve", "case.json", "--out", "hdf", "--resume", "--set", "output.checkpoint.every=0.01"]);
    assert_eq!(resumed.code, Some(2), "{}", resumed.stderr);
    assert!(resumed.stderr.contains("output.format"), "{}", resumed.stderr);
    assert!(std::fs::read(bench.path("hdf/small.vtkhdf")).expect("the file") == one);
    assert_eq!(bench.run(&["solve", "case.json", "--out", "hdf", "--force", "--quiet"]).code, Some(0));
    assert!(!bench.path("hdf/small.vtkhdf").exists() && bench.path("hdf/small.pvd").exists());
    let set = ["--set", "output.format=vtkhdf"];
    assert_eq!(
        bench.run(&[&["solve", "case.json", "--out", "hdf", "--force", "--quiet"], &set[..]].concat()).code,
        Some(0)
    );
    assert!(bench.path("hdf/small.vtkhdf").exists() && !bench.path("hdf/small.pvd").exists());
    assert!(!bench.path("hdf/frames").exists());
}

/// A file that is damaged or cut short is named, and nothing else is changed.
#[test]
fn a_damaged_file_is_refused() {
    let bench = both(&["output.checkpoint.every=0.01"]);
    let path = bench.path("hdf/small.vtkhdf");
    let bytes = std::fs::read(&path).expect("the file");
    let resume = ["solve", "case.json", "--out", "hdf", "--resume", "--end", "0.05"];
    let resume = [&resume[..], &["--set", "output.format=vtkhdf", "--set", "output.checkpoint.every=0.01"]].concat();
    let mut other = bytes.clone();
    other[300] ^= 1;
    for wrong in [&bytes[..1000], &other, b"no such file"] {
        std::fs::write(&path, wrong).expect("written");
        let ended = bench.run(&resume);
        assert_eq!(ended.code, Some(2), "{}", ended.stderr);
        assert!(ended.stderr.contains("small.vtkhdf"), "{}", ended.stderr);
        assert!(std::fs::read(&path).expect("the file") == wrong);
    }
    std::fs::remove_file(&path).expect("removed");
    assert_eq!(bench.run(&resume).code, Some(2));
    std::fs::write(&path, &bytes).expect("written");
    let ended = bench.run(&resume);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert_eq!(frames(&path).times().len(), 26);
}
