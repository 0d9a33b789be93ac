//! Results as files: exact values, frame times, rows, and what happens when the disk does not play along.

mod triangle_pair;

use std::path::Path;
use std::sync::Barrier;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::common::read_vtu::{self, Vtu};
use canopy_fem::case::spec::CrossingSearch;
use canopy_fem::case::spec::ProbeSpec;
use canopy_fem::case::spec::RowEvery;
use canopy_fem::drive::observer::{Energies, ObserveError, Observer};
use canopy_fem::output::frame::Fields;
use canopy_fem::output::recorder::{Recorder, RecorderError, RecorderSpec};
use canopy_fem::vtk::{Compression, Encoding, VtuFormat};
use triangle_pair::{Run, TrianglePair, ledger};

const ALL: Fields = Fields {
    force: true,
    reaction: true,
    tension: true,
    strain: true,
    rest_length: false,
    pressure: false,
    membrane: false,
    crossing: false,
};

fn spec(dir: &Path) -> RecorderSpec {
    RecorderSpec {
        name: "pair".to_owned(),
        out_dir: dir.to_owned(),
        frames_every: Some(0.25),
        end: 1.0,
        fields: ALL,
        edges: false,
        crossings: CrossingSearch::None,
        probes: vec![
            ProbeSpec { name: "tip".to_owned(), nodes: vec![3] },
            ProbeSpec { name: "a, b".to_owned(), nodes: vec![1, 0] },
        ],
        gauges: Vec::new(),
        quantities: Vec::new(),
        stages: canopy_fem::case::spec::StagesSpec::default(),
        history_every: RowEvery::Steps(1),
        format: VtuFormat::default(),
    }
}

fn record(pair: &TrianglePair, spec: &RecorderSpec, run: Run) {
    let mut recorder = Recorder::new(pair, spec).expect("the request is in order");
    run.through(pair, &mut recorder).expect("the folder takes files");
}

fn read(path: impl AsRef<Path>) -> String {
    std::fs::read_to_string(path).expect("the file is there")
}

fn frame(dir: &Path, number: usize) -> Vtu {
    read_vtu::parse(&std::fs::read(dir.join(format!("frames/pair_{number:06}.vtu"))).expect("the frame is there"))
}

/// (time, file) of every frame of a collection; fails unless it is complete.
fn collection(text: &str) -> Vec<(f64, String)> {
    assert!(text.starts_with("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\""), "{text}");
    assert!(text.ends_with("</Collection>\n</VTKFile>\n"), "{text}");
    let entries = text.lines().filter(|line| line.starts_with("<DataSet"));
    entries
        .map(|line| {
            let value = |key| read_vtu::attribute(line, key).expect("a data set says when and where");
            (value("timestep").parse().expect("a time"), value("file"))
        })
        .collect()
}

/// A frame at a step's end holds that state bit by bit, every array in its place.
#[test]
fn frames_hold_exact_values() {
    let dir = tempfile::tempdir().expect("a folder");
    let pair = TrianglePair::new();
    record(&pair, &spec(dir.path()), Run { step: 0.25, steps: 4 });
    for (number, t) in [0.0, 0.25, 0.5, 0.75, 1.0].into_iter().enumerate() {
        let vtu = frame(dir.path(), number);
        assert_eq!((vtu.points, vtu.cells, vtu.time), (4, 7, t));
        let moved: Vec<f64> = pair.positions(t).iter().zip(pair.positions(0.0)).map(|(x, x0)| x - x0).collect();
        assert_eq!(vtu.floats("Points"), pair.positions(t));
        assert_eq!(vtu.floats("displacement"), moved);
        assert_eq!(vtu.floats("velocity"), pair.velocities(t));
        assert_eq!(vtu.floats("force"), pair.forces(t));
        assert_eq!(vtu.floats("reaction"), [9.0, 8.0, 7.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        // Edge values 1, 2, 3, 4 times t + 1; the fifth edge, the second triangle's last side, has no spring.
        let u = t + 1.0;
        let (first, second) = ((u + 2.0 * u + 3.0 * u) / 3.0, (2.0 * u + 4.0 * u) / 2.0);
        assert_eq!(vtu.floats("tension"), [first, second, u, 2.0 * u, 3.0 * u, 4.0 * u, 0.0]);
        assert_eq!(vtu.floats("strain").len(), 7);
        assert_eq!(vtu.integers("connectivity"), [0, 1, 2, 1, 3, 2, 0, 1, 1, 2, 2, 0, 1, 3, 3, 2]);
        assert_eq!(vtu.integers("offsets"), [3, 6, 8, 10, 12, 14, 16]);
        assert_eq!(vtu.bytes("types"), [5, 5, 3, 3, 3, 3, 3]);
    }
}

/// Frames stand at k * every whatever the step is: none, one or several a step; then, as the motion is a cubic in
/// time, the interpolated positions and velocities are exact up to rounding, and forces are those of that time.
#[test]
fn frames_between_steps_are_interpolated() {
    let pair = TrianglePair::new();
    for run in [Run { step: 0.3, steps: 4 }, Run { step: 1.2, steps: 1 }, Run { step: 0.07, steps: 17 }] {
        let dir = tempfile::tempdir().expect("a folder");
        record(&pair, &RecorderSpec { end: 1.2, ..spec(dir.path()) }, run);
        let listed = collection(&read(dir.path().join("pair.pvd")));
        let times: Vec<f64> = listed.iter().map(|(t, _)| *t).collect();
        assert_eq!(times, [0.0, 0.25, 0.5, 0.75, 1.0, run.end()], "{run:?}");
        for (number, (t, file)) in listed.iter().enumerate() {
            assert_eq!(file, &format!("frames/pair_{number:06}.vtu"));
            let vtu = frame(dir.path(), number);
            assert_eq!(vtu.time, *t);
            let pairs = [("Points", pair.positions(*t)), ("velocity", pair.velocities(*t)), ("force", pair.forces(*t))];
            for (name, expected) in pairs {
                for (found, expected) in vtu.floats(name).iter().zip(expected) {
                    assert!((found - expected).abs() < 1e-12, "{name} at {t}: {found} {expected}");
                }
            }
        }
    }
}

/// Without an interval only the first and the last state are shown; fields nobody asked for are not there.
#[test]
fn first_and_last_only() {
    let dir = tempfile::tempdir().expect("a folder");
    let plain = RecorderSpec { frames_every: None, fields: Fields::default(), probes: vec![], ..spec(dir.path()) };
    record(&TrianglePair::new(), &plain, Run { step: 0.1, steps: 7 });
    let times: Vec<f64> = collection(&read(dir.path().join("pair.pvd"))).iter().map(|(t, _)| *t).collect();
    assert_eq!(times, [0.0, 7.0 * 0.1]);
    let last = frame(dir.path(), 1);
    assert_eq!(
        last.names(),
        ["TimeValue", "displacement", "velocity", "kind", "vtkGhostType", "Points", "connectivity", "offsets", "types"]
    );
    assert!(!dir.path().join("probes.csv").exists());
}

/// base64 and zlib hold the very bytes the raw form holds.
#[test]
fn all_spellings_agree() {
    let pair = TrianglePair::new();
    let read_as = |format| {
        let dir = tempfile::tempdir().expect("a folder");
        record(&pair, &RecorderSpec { format, ..spec(dir.path()) }, Run { step: 0.3, steps: 2 });
        frame(dir.path(), 2)
    };
    let raw = read_as(VtuFormat::default());
    for encoding in [Encoding::Raw, Encoding::Base64] {
        for compression in [Compression::None, Compression::Zlib] {
            let other = read_as(VtuFormat { encoding, compression, ..VtuFormat::default() });
            assert_eq!(other.names(), raw.names());
            for name in raw.names().iter().filter(|name| *name != "TimeValue") {
                assert_eq!(other.bytes(name), raw.bytes(name), "{name} as {encoding:?} {compression:?}");
            }
        }
    }
}

/// Zlib blocks of 1 MiB: more than one, the last not full, read back to the same bytes.
#[test]
fn large_arrays_take_several_blocks() {
    use canopy_fem::vtk::write::{Cells, Snapshot, VtuWriter};
    let points: Vec<[f64; 3]> = (0..100_000).map(|i| [f64::from(i), f64::from(i).sqrt(), -1.0]).collect();
    let cells = Cells { points: points.len(), triangles: &[], edges: &[] };
    let picture = Snapshot { time: None, points: &points, point_data: &[], cell_data: &[] };
    for encoding in [Encoding::Raw, Encoding::Base64] {
        let format = VtuFormat { encoding, compression: Compression::Zlib, ..VtuFormat::default() };
        let mut out = Vec::new();
        let mut writer = VtuWriter::new(&cells, format).expect("points exist");
        writer.write(&picture, &mut out).expect("memory takes everything");
        let vtu = read_vtu::parse(&out);
        assert_eq!(vtu.floats("Points"), points.as_flattened());
        assert!(vtu.bytes("types").iter().all(|&kind| kind == 1) && vtu.cells == 100_000, "one vertex a point");
    }
}

/// Points and ends of cells are written in 16 bits where they can be, else in 32, and read back to the same ones.
#[test]
fn cells_are_written_in_few_bytes() {
    use canopy_fem::vtk::write::{Cells, Snapshot, VtuWriter};
    // 3 n - 4 corners: the last that 16 bits number, and one more.
    for (count, bytes) in [(3_u32, 2), (703, 2), (21_846, 2), (21_847, 4), (100_000, 4)] {
        let points: Vec<[f64; 3]> = (0..count).map(|i| [f64::from(i), f64::from(i % 2), 0.0]).collect();
        let triangles: Vec<[u32; 3]> = (2..count).map(|i| [i - 2, i - 1, i]).collect();
        let cells = Cells { points: points.len(), triangles: &triangles, edges: &[[0, count - 1]] };
        let picture = Snapshot { time: None, points: &points, point_data: &[], cell_data: &[] };
        let mut out = Vec::new();
        let mut writer = VtuWriter::new(&cells, VtuFormat::default()).expect("points exist");
        writer.write(&picture, &mut out).expect("memory takes everything");
        let vtu = read_vtu::parse(&out);
        let corners: Vec<u32> = triangles.as_flattened().iter().copied().chain([0, count - 1]).collect();
        assert_eq!(vtu.bytes("connectivity").len(), bytes * corners.len());
        let expected: Vec<i64> = corners.into_iter().map(i64::from).collect();
        assert_eq!(vtu.integers("connectivity"), expected);
        let ends = (1..count - 1).map(|i| 3 * i64::from(i)).chain([3 * i64::from(count - 2) + 2]);
        assert_eq!(vtu.integers("offsets"), ends.collect::<Vec<_>>());
    }
}

/// Columns are the contract's; floats read back to the same bits; start and last step always have a row.
#[test]
fn rows_are_complete() {
    let dir = tempfile::tempdir().expect("a folder");
    let pair = TrianglePair::new();
    record(
        &pair,
        &RecorderSpec { history_every: RowEvery::Steps(3), ..spec(dir.path()) },
        Run { step: 0.1, steps: 10 },
    );
    let history = read(dir.path().join("history.csv"));
    let mut lines = history.lines();
    let header = "t,step,kinetic,elastic,gravity,external_work,dissipated,numerical,newton_iterations,residual,max_speed,max_strain";
    assert_eq!(lines.next(), Some(header));
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect()).collect();
    let steps: Vec<f64> = rows.iter().map(|row| row[1]).collect();
    assert_eq!(steps, [0.0, 3.0, 6.0, 9.0, 10.0]);
    for row in &rows {
        let (t, account) = (row[1] * 0.1, ledger(row[1] * 0.1));
        let newton = if row[1] == 0.0 { [0.0, 0.0] } else { [3.0, 1e-9] };
        let sums = [account.kinetic, account.elastic, account.gravity, account.external_work, account.dissipated];
        assert_eq!(row[0], t);
        assert_eq!(row[2..7], sums);
        assert_eq!(row[7..], [account.numerical, newton[0], newton[1], t + 0.5, 2.0 * t], "{row:?}");
    }

    let probes = read(dir.path().join("probes.csv"));
    let lines: Vec<&str> = probes.lines().collect();
    assert_eq!((lines[0], lines.len()), ("t,name,node,x,y,z,vx,vy,vz", 1 + 5 * 3));
    assert!(lines[1].starts_with("0.0,tip,3,"), "{}", lines[1]);
    assert!(lines[2].starts_with("0.0,\"a, b\",1,") && lines[3].starts_with("0.0,\"a, b\",0,"));
    let last: Vec<f64> = lines[13].split(',').skip(3).map(|cell| cell.parse().expect("a number")).collect();
    assert_eq!(last, [&pair.positions(1.0)[9..], &pair.velocities(1.0)[9..]].concat());
}

/// A reader that looks at any moment finds a complete collection whose frames are complete too.
#[test]
fn readable_while_it_runs() {
    let dir = tempfile::tempdir().expect("a folder");
    let (done, ready) = (AtomicBool::new(false), Barrier::new(2));
    let looks = std::thread::scope(|scope| {
        let reader = scope.spawn(|| {
            let mut looks = 0;
            ready.wait();
            while !done.load(Ordering::Relaxed) {
                let Ok(text) = std::fs::read_to_string(dir.path().join("pair.pvd")) else { continue };
                let listed = collection(&text);
                let (_, newest) = listed.last().expect("it is written with its first frame");
                let bytes = std::fs::read(dir.path().join(newest)).expect("a listed frame is there");
                assert!(bytes.ends_with(b"</VTKFile>\n"), "a listed frame is complete");
                looks += 1;
            }
            looks
        });
        let all = RecorderSpec { frames_every: Some(0.01), ..spec(dir.path()) };
        ready.wait();
        record(&TrianglePair::new(), &all, Run { step: 0.005, steps: 200 });
        done.store(true, Ordering::Relaxed);
        reader.join().expect("the reader found every file in order")
    });
    assert!(looks > 0, "the reader had a chance to look");
    assert_eq!(collection(&read(dir.path().join("pair.pvd"))).len(), 101);
}

/// Waits for a condition that the writing thread brings about.
fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < Duration::from_secs(20), "waited in vain until {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A run that is killed leaves whole rows: they reach the file within a second, although nobody asks for it.
#[test]
fn rows_do_not_wait_for_the_end() {
    let dir = tempfile::tempdir().expect("a folder");
    let pair = TrianglePair::new();
    let mut recorder = Recorder::new(&pair, &spec(dir.path())).expect("the request is in order");
    let run = Run { step: 0.25, steps: 2 };
    run.begin(&pair, &mut recorder).expect("the folder takes files");
    let path = dir.path().join("history.csv");
    until("three rows are there", || read(&path).lines().count() == 4);
    assert!(read(&path).ends_with('\n'));
    until("both frames are listed", || {
        let text = std::fs::read_to_string(dir.path().join("pair.pvd")).unwrap_or_default();
        !text.is_empty() && collection(&text).len() == 3
    });
    drop(recorder);
    assert_eq!(read(&path).lines().count(), 4);
}

/// A folder that vanishes is an error with a path at the next sends, then "stopped", never a panic or a hang.
#[test]
fn vanished_folder_is_an_error() {
    let dir = tempfile::tempdir().expect("a folder");
    let pair = TrianglePair::new();
    let mut recorder = Recorder::new(&pair, &spec(dir.path())).expect("the request is in order");
    Run { step: 0.25, steps: 2 }.begin(&pair, &mut recorder).expect("the folder takes files");
    until("the frames are there", || dir.path().join("frames/pair_000002.vtu").exists());
    std::fs::remove_dir_all(dir.path()).expect("the folder can go");
    let fault = Run { step: 0.25, steps: 10_000 }.through(&pair, &mut recorder);
    match fault {
        Err(ObserveError::Write { path, source }) => {
            assert!(path.contains("pair"), "{path}");
            assert_eq!(source.kind(), std::io::ErrorKind::NotFound);
        }
        other => panic!("{other:?}"),
    }
    let again = recorder.finished(&pair.point(1.0));
    assert!(matches!(again, Err(ObserveError::WriterGone)), "{again:?}");
}

/// A fault that only shows at the end is told at the end.
#[test]
fn fault_at_the_end_is_told() {
    let dir = tempfile::tempdir().expect("a folder");
    let pair = TrianglePair::new();
    let rare = RecorderSpec { frames_every: None, ..spec(dir.path()) };
    let mut recorder = Recorder::new(&pair, &rare).expect("the request is in order");
    Run { step: 0.25, steps: 2 }.begin(&pair, &mut recorder).expect("the folder takes files");
    until("the first frame is listed", || dir.path().join("pair.pvd").exists());
    std::fs::remove_dir_all(dir.path().join("frames")).expect("the folder can go");
    let end = recorder.finished(&pair.point(0.5));
    assert!(matches!(end, Err(ObserveError::Write { .. })), "{end:?}");
}

/// An exploded state is not drawn: the last frame is the last good one.
#[test]
fn states_that_are_not_finite_are_not_shown() {
    let dir = tempfile::tempdir().expect("a folder");
    let pair = TrianglePair::new();
    let mut recorder = Recorder::new(&pair, &spec(dir.path())).expect("the request is in order");
    Run { step: 0.25, steps: 2 }.begin(&pair, &mut recorder).expect("the folder takes files");
    let mut bad = pair.point(0.75);
    bad.state.x[4] = f64::INFINITY;
    recorder.accepted(triangle_pair::view(&pair.point(0.5), &bad, 3)).expect("nothing to write");
    recorder.finished(&bad).expect("nothing to write");
    let times: Vec<f64> = collection(&read(dir.path().join("pair.pvd"))).iter().map(|(t, _)| *t).collect();
    assert_eq!(times, [0.0, 0.25, 0.5]);
}

/// A folder with earlier results is refused; with force exactly those go, and nothing is reached through a link.
#[test]
fn earlier_results_are_guarded() {
    use canopy_fem::output::folder::{FolderError, ResultFolder};
    let dir = tempfile::tempdir().expect("a folder");
    let out = dir.path().join("a/b");
    let prepare = |force| ResultFolder::prepare(&out, "pair", force);
    assert_eq!(prepare(false).expect("a new folder").stem(), "pair");
    prepare(false).expect("an empty folder is no result");
    record(&TrianglePair::new(), &spec(&out), Run { step: 0.25, steps: 4 });
    let others =
        ["notes.txt", "other.pvd", "frames/other_000000.vtu", "frames/pair_1.vtu", "frames/pair_000001.vtu.bak"];
    for name in others {
        std::fs::write(out.join(name), "mine").expect("written");
    }
    let fault = prepare(false).expect_err("results are there");
    assert!(matches!(fault, FolderError::HoldsResults { .. }) && fault.to_string().contains("--force"), "{fault}");
    assert_eq!(collection(&read(out.join("pair.pvd"))).len(), 5, "a refusal touches nothing");

    prepare(true).expect("allowed");
    let left = ["history.csv", "probes.csv", "pair.pvd", "frames/pair_000000.vtu", "frames/pair_000004.vtu"];
    left.iter().for_each(|name| assert!(!out.join(name).exists(), "{name}"));
    others.iter().for_each(|name| assert_eq!(read(out.join(name)), "mine", "{name}"));

    std::fs::write(dir.path().join("file"), "mine").expect("written");
    let fault = ResultFolder::prepare(&dir.path().join("file"), "pair", true).expect_err("no folder");
    assert!(matches!(fault, FolderError::InTheWay { .. }), "{fault}");
    std::fs::create_dir(out.join("history.csv")).expect("made");
    let fault = prepare(true).expect_err("a folder where a file belongs");
    assert!(matches!(fault, FolderError::InTheWay { what: "a folder", .. }), "{fault}");
}

/// A linked `frames` is refused and a linked result is unlinked: what they point to stays.
#[cfg(unix)]
#[test]
fn links_are_not_followed() {
    use canopy_fem::output::folder::{FolderError, ResultFolder};
    use std::os::unix::fs::symlink;
    let dir = tempfile::tempdir().expect("a folder");
    let (out, elsewhere) = (dir.path().join("out"), dir.path().join("elsewhere"));
    std::fs::create_dir_all(&out).expect("made");
    std::fs::create_dir_all(&elsewhere).expect("made");
    let precious = elsewhere.join("pair_000000.vtu");
    std::fs::write(&precious, "mine").expect("written");
    symlink(&elsewhere, out.join("frames")).expect("linked");
    let fault = ResultFolder::prepare(&out, "pair", true).expect_err("not ours");
    assert!(matches!(fault, FolderError::InTheWay { what: "a link", .. }), "{fault}");
    std::fs::remove_file(out.join("frames")).expect("unlinked");
    symlink(&precious, out.join("history.csv")).expect("linked");
    ResultFolder::prepare(&out, "pair", true).expect("allowed");
    record(&TrianglePair::new(), &spec(&out), Run { step: 0.25, steps: 4 });
    assert_eq!(read(&precious), "mine");
}

/// A name with everything in it that file systems and XML dislike still gives a set of files that agree.
#[test]
fn any_name_works() {
    let dir = tempfile::tempdir().expect("a folder");
    let odd = RecorderSpec { name: "../a b/<c> & \"d\"".to_owned(), ..spec(dir.path()) };
    record(&TrianglePair::new(), &odd, Run { step: 0.25, steps: 4 });
    let listed = collection(&read(dir.path().join("_a_b__c_____d_.pvd")));
    assert_eq!(listed.len(), 5);
    listed.iter().for_each(|(_, file)| assert!(dir.path().join(file).exists(), "{file}"));
}

/// The summary has the contract's keys, nothing that JSON cannot hold, and reads back as it was.
#[test]
fn summary_keeps_the_contract() {
    use canopy_fem::drive::{Failure, Status};
    use canopy_fem::output::summary::Summary;
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("summary.json");
    let failure = Failure { time: 0.1, step: 7, node: Some(3), blow_up_time: None, ..Failure::default() };
    let summary = Summary {
        status: Status::NotConverged,
        method: "hht".to_owned(),
        method_parameters: [("alpha".to_owned(), -0.1)].into(),
        energy_error: f64::NAN,
        critical_step: Some(f64::INFINITY),
        final_ledger: Energies { kinetic: f64::NEG_INFINITY, elastic: 0.1, ..Energies::default() },
        failure: Some(failure),
        case: serde_json::json!({"name": "x"}),
        ..Summary::default()
    };
    std::fs::write(&path, "old").expect("written");
    summary.write(&path).expect("the folder takes files");
    assert_eq!(std::fs::read_dir(dir.path()).expect("a folder").count(), 1, "no temporary file is left");
    let json: serde_json::Value = serde_json::from_str(&read(&path)).expect("JSON");
    let keys = "status method method_parameters steps rejected_steps t_end cpu_seconds wall_seconds peak_memory_bytes startup \
                force_evaluations tangent_assemblies factorizations lu_factorizations linear_solves newton_iterations cg_iterations sweeps unknowns \
                matrix_nonzeros factor_nonzeros linear_solver linear critical_step energy_error final_ledger failure resumed_from \
                case case_digest version";
    let mut expected: Vec<&str> = keys.split_whitespace().collect();
    expected.sort_unstable();
    let mut found: Vec<&String> = json.as_object().expect("an object").keys().collect();
    found.sort_unstable();
    assert_eq!(found, expected);
    let failure_keys = [
        "advice",
        "blow_up_time",
        "cause",
        "critical_step",
        "grew",
        "growth",
        "node",
        "pair",
        "spring",
        "step",
        "term",
        "time",
        "triangle",
    ];
    let mut found: Vec<&String> = json["failure"].as_object().expect("an object").keys().collect();
    found.sort_unstable();
    assert_eq!(found, failure_keys);
    assert_eq!(json["status"], "not-converged");
    for key in ["energy_error", "critical_step", "cpu_seconds"] {
        assert!(json[key].is_null(), "{key}");
    }
    assert!(json["final_ledger"]["kinetic"].is_null());
    let names: Vec<_> = [Status::Completed, Status::Diverged, Status::Interrupted]
        .map(|status| serde_json::to_value(status).expect("a word"))
        .into();
    assert_eq!(names, ["completed", "diverged", "interrupted"]);
}

/// What cannot be recorded is refused before anything is created, with the numbers.
#[test]
fn bad_requests_are_refused() {
    let dir = tempfile::tempdir().expect("a folder");
    let pair = TrianglePair::new();
    let refuse = |spec: RecorderSpec| Recorder::new(&pair, &spec).err().expect("refused");
    for every in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let fault = refuse(RecorderSpec { frames_every: Some(every), ..spec(dir.path()) });
        assert!(matches!(fault, RecorderError::BadInterval { .. }), "{fault}");
    }
    let fault = refuse(RecorderSpec { frames_every: Some(1e-9), ..spec(dir.path()) });
    assert!(fault.to_string().contains("output.frames.every >= 1e-6 s"), "{fault}");
    let fault = refuse(RecorderSpec { frames_every: Some(1.0), end: f64::NAN, ..spec(dir.path()) });
    assert!(matches!(fault, RecorderError::TooManyFrames { .. }), "{fault}");
    assert!(matches!(
        refuse(RecorderSpec { history_every: RowEvery::Steps(0), ..spec(dir.path()) }),
        RecorderError::BadHistory
    ));
    let probes = vec![ProbeSpec { name: "far".to_owned(), nodes: vec![0, 4] }];
    let fault = refuse(RecorderSpec { probes, ..spec(dir.path()) });
    assert_eq!(fault.to_string(), "probe \"far\" follows node 4, but there are 4 nodes, counted from 0");
    assert_eq!(std::fs::read_dir(dir.path()).expect("the folder is there").count(), 0);
}

/// Cells and arrays that do not fit are refused, with the numbers.
#[test]
fn bad_pictures_are_refused() {
    use canopy_fem::vtk::write::{Array, Cells, Snapshot, Values, VtuWriter};
    let bad = Cells { points: 2, triangles: &[[0, 1, 2]], edges: &[] };
    let fault = VtuWriter::new(&bad, VtuFormat::default()).expect_err("no such point");
    assert_eq!(fault.to_string(), "cell 0 uses point 2, but there are 2 points, counted from 0");
    let mut writer = VtuWriter::new(&Cells { triangles: &[], ..bad }, VtuFormat::default()).expect("points exist");
    let short = [Array { name: "p", values: Values::Scalars(&[1.0]) }];
    let picture = Snapshot { time: None, points: &[[0.0; 3]; 2], point_data: &short, cell_data: &[] };
    let fault = writer.write(&picture, &mut Vec::new()).expect_err("too short");
    assert_eq!(fault.to_string(), "array \"p\" holds 1 values where 2 are needed");
}
