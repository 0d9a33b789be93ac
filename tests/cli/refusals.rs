//! Bad usage and bad cases: status 2 (or 1 for the system's fault), the place and what is allowed, and nothing written.

use crate::bench::{Bench, contents};

/// A value of the case, the pointer the message must show, and words that must be in it.
type Row = (&'static str, &'static str, &'static str);

const N: &str = "/system/network";

/// Everything that the project promises to refuse.
const ROWS: [Row; 19] = [
    ("time.step=\"fast\"", "/time/step", "a number"),
    ("time.stepp=1", "/time/stepp", "did you mean \"step\""),
    ("time.step=-1", "/time/step", "above 0"),
    ("time.step=0", "/time/step", "above 0"),
    ("time.method=nwmark", "/time/method", "newmark"),
    ("time.method={\"hht\":{\"alpha\":0.5}}", "/time/method/hht/alpha", "[-0.3333333333333333, 0]"),
    ("N.mass.nodal=[1,0,1,1,1,1]", "/mass", "free nodes 1"),
    ("N.mass.nodal=-1", "/mass/nodal", "0 or more"),
    ("N.mesh.explicit.nodes.4=[1,0,0]", "/mesh/explicit", "nodes 1 and 4 coincide"),
    ("N.mesh.explicit.nodes.4=[0.5,0,0]", "/mesh/explicit", "triangle 0 is degenerate"),
    ("N.mesh.explicit.triangles.1=[0,4,4]", "/mesh/explicit/triangles/1", "different nodes"),
    ("N.mesh.explicit.springs.1=[1,6]", "/mesh/explicit/springs/1", "nodes 0 to 5"),
    ("N.supports.0.on={\"ids\":[99]}", "/supports/0/on/ids/0", "0 to 5"),
    ("N.mesh={\"file\":\"nowhere.vtu\"}", "/mesh/file", "No such file"),
    ("N.aero.wind.table=[[0,0,0,1],[0,0,0,2]]", "/aero/wind/table/1", "strictly increasing"),
    ("N.mesh.explicit.triangles.1=[0,3,4]", "/loads/0", "turn opposite ways"),
    ("N.mesh={\"explicit\":{\"nodes\":[]}}", "/mesh/explicit/nodes", "0 nodes"),
    ("N.supports=[{\"on\":\"all\",\"fix\":\"xyz\"}]", "/supports", "something that can move"),
    ("output.frames.every=0", "/output/frames/every", "above 0"),
];

/// A bad case ends with status 2 and its place in the case, and writes nothing at all.
#[test]
fn bad_cases_are_refused_and_write_nothing() {
    let bench = Bench::new();
    for (set, pointer, words) in ROWS {
        let set = set.replace("N.", "system.network.");
        let pointer = if set.starts_with("system") { format!("{N}{pointer}") } else { pointer.to_owned() };
        for command in ["solve", "check"] {
            let ended = bench.run(&[command, "sail.json", "--set", &set]);
            assert_eq!(ended.code, Some(2), "{command} {set}: {}", ended.stderr);
            let said = format!("{}\n{}", ended.stderr, ended.stdout);
            assert!(
                said.lines().any(|line| line.starts_with(&format!("{pointer}:"))),
                "{set}: no {pointer} in\n{said}"
            );
            assert!(said.contains(words), "{set}: no \"{words}\" in\n{said}");
        }
        assert_eq!(contents(&bench.path("")).len(), 1, "{set}: something was written");
    }
}

/// All faults of a case come at once.
#[test]
fn all_faults_at_once() {
    let bench = Bench::new();
    let ended =
        bench.solve(&["--step", "0", "--set", "system.network.mass.nodal=-1", "--set", "output.history.every=0"]);
    assert_eq!(ended.code, Some(2));
    for words in ["3 faults", "/time/step: 0", "/system/network/mass/nodal: -1", "/output/history/every: 0"] {
        assert!(ended.stderr.contains(words), "no \"{words}\" in\n{}", ended.stderr);
    }
}

/// A path that is spelt as elsewhere is answered with the spelling that is meant.
#[test]
fn set_names_the_dotted_path() {
    let bench = Bench::new();
    for set in ["/system/network/springs/0/stiffness=1", "system.network.springs[0].stiffness=1"] {
        let ended = bench.solve(&["--set", set]);
        assert_eq!(ended.code, Some(2));
        assert!(ended.stderr.contains("did you mean system.network.springs.0.stiffness?"), "{}", ended.stderr);
    }
}

/// A method that needs a network refuses a pendulum.
#[test]
fn kang_refuses_a_pendulum() {
    let bench = Bench::new();
    let case = r#"{"name": "p", "system": {"pendulum": {"length": 1, "mass": 1, "gravity": 9.81, "angle": 0.5}},
                   "time": {"end": 0.1, "method": "kang", "step": 0.01}}"#;
    std::fs::write(bench.path("p.json"), case).expect("a case");
    let ended = bench.run(&["solve", "p.json"]);
    assert_eq!(ended.code, Some(2));
    assert!(ended.stderr.contains("/time/method"), "{}", ended.stderr);
    assert!(!bench.path("out").exists());
    assert_eq!(bench.run(&["solve", "p.json", "--method", "newmark", "--quiet"]).code, Some(0));
}

/// A name that no mesh can be written to is bad usage: status 2, and nothing is made or changed.
#[test]
fn names_no_mesh_is_written_to_are_status_2() {
    let bench = Bench::new();
    std::fs::write(bench.path("there.obj"), "mine").expect("a file");
    let annulus = ["mesh", "annulus", "--inner", "0.1", "--outer", "1", "--nodes", "60", "--output"];
    for (output, words) in [
        ("net.zip", "ends in .vtu, .vtp, .msh, .obj, .ply, .stl, .inp, .bdf, .mdpa or .glb"),
        ("there.obj", "exists already"),
    ] {
        let ended = bench.run(&[&annulus[..], &[output]].concat());
        assert_eq!(ended.code, Some(2), "{output}: {}", ended.stderr);
        assert!(ended.stderr.contains(output) && ended.stderr.contains(words), "{}", ended.stderr);
    }
    assert!(!bench.path("net.zip").exists());
    assert_eq!(std::fs::read_to_string(bench.path("there.obj")).expect("still there"), "mine");
}

/// What cannot be read or written is the system's fault: status 1, with the path.
#[test]
fn unreadable_and_unwritable_files_are_status_1() {
    let bench = Bench::new();
    std::fs::write(bench.path("file"), "").expect("a file");
    // Memory of a process is there, but its first page is not mapped.
    #[cfg(target_os = "linux")]
    assert_eq!(bench.run(&["solve", "/proc/self/mem"]).code, Some(1));
    for (arguments, name) in [
        (["solve", "sail.json", "--out", "file/out"].as_slice(), "file/out"),
        (&["solve", "sail.json", "--out", "good", "--dump-matrices", "file/m"], "file/m"),
    ] {
        let ended = bench.run(arguments);
        assert_eq!(ended.code, Some(1), "{arguments:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(name), "{arguments:?}: {}", ended.stderr);
    }
}

/// Wrong usage is status 2, whether the command line's reader finds it or the case's.
#[test]
fn wrong_usage_is_status_2() {
    let bench = Bench::new();
    for arguments in [
        [].as_slice(),
        &["solve"],
        &["solve", "nowhere.json"],
        &["check", "nowhere.json"],
        &["solve", "."],
        &["solve", "sail.json/case.json"],
        &["sovle", "sail.json"],
        &["solve", "sail.json", "--threads", "0"],
        &["solve", "sail.json", "--set", "time.step"],
        &["solve", "sail.json", "--set", "time.step.x=1"],
        &["solve", "sail.json", "--set", "system.network.springs.7.stiffness=1"],
        &["solve", "sail.json", "--frobnicate"],
    ] {
        let ended = bench.run(arguments);
        assert_eq!(ended.code, Some(2), "{arguments:?}: {}", ended.stderr);
        assert!(!ended.stderr.is_empty() && ended.stdout.is_empty(), "{arguments:?}");
    }
    assert!(!bench.path("out").exists());
}

/// Text that is no JSON is a bad case with line and column.
#[test]
fn text_that_is_no_json_is_status_2() {
    let bench = Bench::new();
    std::fs::write(bench.path("sail.json"), "{\n  \"name\": \"sail\",\n  \"system\" 5\n}").expect("a case");
    let ended = bench.solve(&[]);
    assert_eq!(ended.code, Some(2));
    assert!(ended.stderr.contains("sail.json:3"), "{}", ended.stderr);
}

/// A folder with results is refused before the scene is built: a solver that does not suit it is not looked at.
#[test]
fn a_folder_with_results_is_refused_first() {
    let bench = Bench::new();
    for command in ["solve", "static"] {
        let case = "sail.json";
        assert_eq!(bench.run(&[command, case, "--quiet", "--out", command]).code, Some(0));
        let unsuitable =
            ["--set", "solver.linear=lu", "--set", "solver.newton.strategy=quasi", "--set", "time.method=newmark"];
        for (folder, why) in [(command, "already holds results"), ("other", "keep a symmetric one")] {
            let ended = bench.run(&[&[command, case, "--out", folder], &unsuitable[..]].concat());
            assert!(ended.code == Some(2) && ended.stderr.contains(why), "{command}: {}", ended.stderr);
        }
    }
}

/// A strategy that keeps a factor is not run as another one because the solver that was asked for keeps none.
#[test]
fn a_solver_that_keeps_nothing_is_refused_where_something_is_to_be_kept() {
    let bench = Bench::new();
    for strategy in ["quasi", "modified"] {
        let strategy = format!("solver.newton.strategy={strategy}");
        let ended = bench.solve(&["--method", "newmark", "--set", "solver.linear=lu", "--set", &strategy]);
        assert_eq!(ended.code, Some(2), "{}", ended.stderr);
        assert!(ended.stderr.contains("keep a symmetric one"), "{}", ended.stderr);
    }
    for strategy in ["full", "auto"] {
        let strategy = format!("solver.newton.strategy={strategy}");
        let ended = bench.solve(&["--method", "newmark", "--set", "solver.linear=lu", "--set", &strategy, "--force"]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    }
}
