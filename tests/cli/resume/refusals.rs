//! What cannot be resumed is refused with the reason, status 2, and without a change in the folder.

use canopy_fem::drive::event::Fired;
use canopy_fem::drive::{Failure, Snapshot};
use canopy_fem::output::checkpoint::{Checkpoint, CheckpointFault, FORMAT};

use super::folders::assert_same;
use crate::bench::{Bench, contents};
use crate::common::{Random, write_net};

const KEEP: [&str; 2] = ["--set", "output.checkpoint.every=0.3"];

/// A finished run with a checkpoint; without its summary, so that there is something left to resume.
fn stopped() -> Bench {
    let bench = Bench::new();
    let ended = bench.solve(&KEEP);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    std::fs::remove_file(bench.path("out/summary.json")).expect("was there");
    bench
}

/// Fails unless resuming ends with status 2 and these words, and changes nothing.
fn assert_refused(bench: &Bench, arguments: &[&str], words: &[&str]) {
    let before = contents(&bench.path("out"));
    let ended = bench.solve(&[arguments, &["--resume"]].concat());
    assert_eq!(ended.code, Some(2), "{arguments:?}: {}{}", ended.stdout, ended.stderr);
    for word in words {
        assert!(ended.stderr.contains(word), "{arguments:?}: no \"{word}\" in {}", ended.stderr);
    }
    assert!(contents(&bench.path("out")) == before, "{arguments:?}: a refused run changed something");
}

fn checkpoint_of(bench: &Bench) -> Vec<u8> {
    std::fs::read(bench.path("out/checkpoint.bin")).expect("a checkpoint")
}

/// Bytes changed as a program that knows the format would, with a checksum that is right.
fn sealed(mut bytes: Vec<u8>, change: impl FnOnce(&mut [u8])) -> Vec<u8> {
    let end = bytes.len() - 4;
    change(&mut bytes[..end]);
    let sum = crc32fast::hash(&bytes[..end]);
    bytes[end..].copy_from_slice(&sum.to_le_bytes());
    bytes
}

#[test]
fn a_folder_without_checkpoint() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("out")).expect("a folder");
    assert_refused(&bench, &[], &["out holds no checkpoint.bin", "nothing to resume", "output.checkpoint"]);
    let ended = bench.run(&["solve", "sail.json", "--out", "elsewhere", "--resume"]);
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
    assert!(!bench.path("elsewhere").exists());
    assert_refused(&bench, &["--force"], &["--force", "cannot be used with"]);
}

/// Another case is named by the keys in which it differs; what leaves the results alone may differ.
#[test]
fn another_case() {
    let bench = stopped();
    for (key, value, words) in [
        ("time.step", "0.02", "time.step was 0.01 and is 0.02 now"),
        ("time.method", "rk4", "time.method was [\"velocity-verlet\",{}] and is [\"rk4\",{}] now"),
        ("solver.newton.relative", "1e-9", "solver was"),
        ("system.network.springs.0.stiffness", "50.000000000000007", "system.network.springs is not what it was"),
        ("system.network.mass.nodal.0", "0.51", "system.network.mass is not what it was"),
        ("system.network.supports.0.fix", "xy", "system.network.supports is"),
        ("system.network.gravity", "null", "system.network.gravity was [0.0,0.0,-9.81] and is null now"),
        ("system.network.aero.wind", "[0, 0, 8]", "system.network.aero is"),
        ("system.network.loads.0.pressure", "0.6", "system.network.loads is"),
        ("system.network.damping.rayleigh.mass", "0.2", "system.network.damping.rayleigh was"),
        ("system.network.initial.velocity", "[0, 0, 1]", "system.network.initial is"),
        ("system.network.mesh.explicit.nodes.5.2", "0.001", "system.network.mesh is"),
        ("output.frames.every", "0.2", "output.frames.every was 0.1 and is 0.2 now"),
        ("output.fields", "[\"force\"]", "output.fields was"),
        ("output.crossings", "none", "output.crossings was \"frames\" and is \"none\" now"),
        ("output.probes.0.on", "all", "output.probes is"),
        ("output.history.every", "2", "output.history.every was 1 and is 2 now"),
    ] {
        let change = format!("{key}={value}");
        assert_refused(&bench, &["--set", &change], &["checkpoint.bin belongs to another case", words]);
    }
    let two = ["--step", "0.005", "--set", "output.history.every=5"];
    assert_refused(&bench, &two, &["time.step was", "; output.history.every was"]);
    assert_refused(&bench, &["--tolerance", "1e-3"], &["time.step is not what it was", "time.tolerance is not"]);
    let ended = bench.solve(&["--resume", "--threads", "2", "--set", "output.checkpoint.every=0.7"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
}

/// Another format, another program, damage, and files of another kind, each with its own sentence.
#[test]
fn another_format_or_a_damaged_file() {
    let bench = stopped();
    let good = checkpoint_of(&bench);
    let version = env!("CARGO_PKG_VERSION").as_bytes();
    let at = good.windows(version.len()).position(|w| w == version).expect("the program's version");
    let mut flipped = good.clone();
    flipped[good.len() / 2] ^= 4;
    for (bytes, words) in [
        (
            sealed(good.clone(), |b| b[8] += 1),
            format!("has format {}, and this program reads format {FORMAT}", FORMAT + 1),
        ),
        (sealed(good.clone(), |b| b[at] += 1), "was written by version 1.1.0, and this is version 0.1.0".to_owned()),
        (flipped, "is damaged: its checksum is".to_owned()),
        (good[..good.len() - 1].to_vec(), format!("is cut short: {} bytes of {}", good.len() - 1, good.len())),
        (good[..5].to_vec(), "is cut short: 5 bytes of 24".to_owned()),
        ([&good[..], b"x"].concat(), "is damaged".to_owned()),
        (b"t,step,kinetic\n".to_vec(), "is not a checkpoint of canopy-fem".to_owned()),
        (Vec::new(), "is not a checkpoint of canopy-fem".to_owned()),
    ] {
        std::fs::write(bench.path("out/checkpoint.bin"), bytes).expect("a file");
        assert_refused(&bench, &KEEP, &["checkpoint.bin: th", &words]);
    }
}

/// No cut, no flipped bit, and no sealed rubbish is taken for a checkpoint, and none makes the program panic.
#[test]
fn no_damage_goes_unseen() {
    let good = checkpoint_of(&stopped());
    assert!(Checkpoint::decode(&good).is_ok());
    for length in 0..good.len() {
        assert!(Checkpoint::decode(&good[..length]).is_err(), "cut to {length}");
    }
    for place in 0..8 * good.len() {
        let mut bytes = good.clone();
        bytes[place / 8] ^= 1 << (place % 8);
        assert!(Checkpoint::decode(&bytes).is_err(), "bit {place}");
    }
    let mut random = Random(5);
    let mut refused = 0;
    for _ in 0..20_000 {
        let bytes = sealed(good.clone(), |b| {
            let place = 20 + ((random.next() + 1.0) / 2.0 * (b.len() - 20) as f64) as usize;
            b[place] = ((random.next() + 1.0) * 128.0) as u8;
        });
        match Checkpoint::decode(&bytes) {
            Ok(found) => assert!(found.snapshot.x.len() <= bytes.len(), "more numbers than the file holds"),
            Err(CheckpointFault::Content(_) | CheckpointFault::Program { .. }) => refused += 1,
            Err(other) => panic!("{other}"),
        }
    }
    assert!(refused > 100, "{refused}");
}

/// The layout of a format never changes: whoever stores something else makes another format, and with it another sum
/// here.
#[test]
fn a_format_has_one_layout() {
    let failure = Failure { time: 1.0, node: Some(3), term: Some("air".to_owned()), ..Failure::default() };
    let fired = vec![Fired { event: 2, t: 0.25, name: "main".to_owned(), ..Fired::default() }];
    let (x, v, failure) = (vec![1.0, 2.0], vec![3.0], Some(failure));
    let snapshot = Snapshot { step: 7, t: 0.5, x, v, failure, fired, ..Snapshot::default() };
    let mut bytes = Vec::new();
    Checkpoint { snapshot, ..Checkpoint::default() }.encode(&mut bytes).expect("it fits");
    let content = &bytes[20 + 1 + env!("CARGO_PKG_VERSION").len()..bytes.len() - 4];
    assert_eq!((FORMAT, content.len(), crc32fast::hash(content)), (24, 443, 2_728_573_548));
}

/// Results that are not what they were when they were counted.
#[test]
fn changed_results() {
    let spoil = |name: &str, change: &dyn Fn(&std::path::Path), words: &[&str]| {
        let bench = stopped();
        change(&bench.path("out").join(name));
        assert_refused(&bench, &KEEP, &[&[name], words].concat());
    };
    let edit = |change: fn(&mut Vec<u8>)| {
        move |path: &std::path::Path| {
            let mut bytes = std::fs::read(path).expect("a file");
            change(&mut bytes);
            std::fs::write(path, bytes).expect("a file");
        }
    };
    let gone = |path: &std::path::Path| std::fs::remove_file(path).expect("was there");
    for name in ["history.csv", "probes.csv", "sail.pvd"] {
        spoil(name, &edit(|bytes| bytes[100] ^= 1), &["are not those it held"]);
        spoil(name, &edit(|bytes| bytes.truncate(101)), &["holds 101 bytes, but held"]);
        spoil(name, &gone, &["is missing"]);
    }
    spoil("frames/sail_000004.vtu", &gone, &["is missing"]);
    let folder = |path: &std::path::Path| {
        std::fs::remove_file(path).expect("was there");
        std::fs::create_dir(path).expect("a folder");
    };
    spoil("frames/sail_000004.vtu", &folder, &["is not a plain file"]);
}

/// A run that has reached its end says so; with a later end it goes on as if it had never stopped, if the steps are the
/// same.
#[test]
fn a_finished_run_goes_on_only_beyond_its_end() {
    let bench = Bench::new();
    assert_eq!(bench.solve(&KEEP).code, Some(0));
    let before = contents(&bench.path("out"));
    let again = bench.solve(&[&KEEP[..], &["--resume"]].concat());
    assert_eq!(again.code, Some(0), "{}", again.stderr);
    assert!(again.stdout.contains("already completed at t = 1 s"), "{}", again.stdout);
    assert!(contents(&bench.path("out")) == before);
    assert_refused(
        &bench,
        &["--end", "0.5"],
        &["the saved state is at t = 0.99 s after 99 steps", "50 steps", "0.5 s"],
    );
    let longer = bench.solve(&[&KEEP[..], &["--resume", "--end", "1.255"]].concat());
    assert_eq!(longer.code, Some(0), "{}", longer.stderr);
    let arguments = [&["solve", "sail.json", "--out", "whole", "--end", "1.255"], &KEEP[..]].concat();
    assert_eq!(bench.run(&arguments).code, Some(0));
    assert_same(&bench.path("out"), &bench.path("whole"), "longer");
    // The last step was shortened to meet 1.255 s; the checkpoint is from before it.
    assert_eq!(bench.solve(&[&KEEP[..], &["--resume", "--end", "2"]].concat()).code, Some(0));
    let arguments = [&["solve", "sail.json", "--out", "whole", "--force", "--end", "2"], &KEEP[..]].concat();
    assert_eq!(bench.run(&arguments).code, Some(0));
    assert_same(&bench.path("out"), &bench.path("whole"), "longer still");
}

/// A finished run on a mesh from a file is not that of the case any more once the file holds another mesh, though the
/// case is the same to the letter.
#[test]
fn another_mesh_in_the_same_file() {
    let bench = Bench::new();
    let arguments =
        ["--set", r#"system.network.mesh={"file":"net.obj"}"#, "--set", "system.network.supports.0.on={\"ids\":[0]}"];
    write_net(&bench.path("net.obj"), 0.0);
    let ended = bench.solve(&arguments);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert_eq!(bench.solve(&[&arguments[..], &["--resume"]].concat()).code, Some(0));
    write_net(&bench.path("net.obj"), 0.25);
    assert_refused(&bench, &arguments, &["out holds no checkpoint.bin"]);
}
