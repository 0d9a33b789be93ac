//! What a good run leaves, and what the flags of `solve` do.

use canopy_fem::integrate::registry::methods;
use serde_json::json;

use crate::bench::{Bench, Results, contents};

/// Which linear solver worked, and why, is in the summary.
#[test]
fn the_summary_tells_the_linear_solver() {
    let bench = Bench::new();
    let solve = |more: &[&str]| {
        let ended = bench.solve(&[&["--force", "--method", "newmark"], more].concat());
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        bench.results().summary()
    };
    let asked = solve(&["--set", "solver.linear=cg"]);
    assert_eq!(
        [&asked["linear_solver"], &asked["linear"]["solver"], &asked["linear"]["reason"], &asked["factor_nonzeros"]],
        [&json!("cg"), &json!("cg"), &json!("the case asks for it"), &json!(null)]
    );
    assert!(asked["cg_iterations"].as_u64() > Some(0) && asked["factorizations"] == json!(0), "{asked}");
    let full = solve(&["--set", "solver.newton.strategy=full"]);
    assert_eq!([&full["linear"]["solver"], &full["linear"]["predicted"]], [&json!("lu"), &json!(null)]);
    let chosen = solve(&["--set", "solver.newton.strategy=quasi"]);
    let told = &chosen["linear"];
    assert!(told["reason"].as_str().is_some_and(|reason| reason.starts_with("by counted work: ")), "{told}");
    assert!(told["predicted"]["cg_iterations"].is_u64(), "{told}");
    for key in ["cholesky_work", "cg_work", "factor_nonzeros", "factor_operations"] {
        assert!(told["predicted"][key].as_f64() > Some(0.0), "{key} in {told}");
    }
    let explicit = bench.solve(&["--force"]);
    assert_eq!((explicit.code, &bench.results().summary()["linear"]), (Some(0), &json!(null)));
}

/// The files of the contract, and status 0.
#[test]
fn solve_writes_the_files_of_the_contract() {
    let bench = Bench::new();
    let ended = bench.solve(&[]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stdout.contains("completed"), "{}", ended.stdout);
    let results = bench.results();
    let summary = results.summary();
    for key in "status method steps rejected_steps t_end cpu_seconds wall_seconds peak_memory_bytes force_evaluations \
                tangent_assemblies factorizations lu_factorizations linear_solves newton_iterations cg_iterations sweeps unknowns \
                matrix_nonzeros factor_nonzeros linear_solver linear critical_step energy_error failure case version"
        .split_whitespace()
    {
        assert!(summary.get(key).is_some(), "summary.json has no {key}");
    }
    assert_eq!([&summary["status"], &summary["failure"]], [&json!("completed"), &json!(null)]);
    assert_eq!([&summary["steps"], &summary["unknowns"]], [&json!(100), &json!(12)]);
    let header = "t,step,kinetic,elastic,gravity,external_work,dissipated,numerical,newton_iterations,residual,max_speed,\
                  max_strain";
    assert_eq!(results.text("history.csv").lines().next(), Some(header));
    assert_eq!(results.table("history.csv").rows.len(), 101, "a row a step and one for the start");
    assert_eq!(results.text("probes.csv").lines().next(), Some("t,name,node,x,y,z,vx,vy,vz"));
    let frames = results.frames();
    assert_eq!(frames.len(), 11);
    for (time, frame) in frames {
        assert_eq!((frame.points, frame.cells, frame.time), (6, 13, time), "triangles and springs are cells");
        for (name, length) in [("displacement", 18), ("velocity", 18), ("force", 18), ("reaction", 18)] {
            let values = frame.floats(name);
            assert!(values.len() == length && values.iter().all(|v| v.is_finite()), "{name} at {time}");
        }
        assert_eq!([frame.floats("tension").len(), frame.floats("strain").len()], [13, 13]);
    }
}

/// The last frame of a run is the mesh of the next one, whose nodes begin where they ended.
#[test]
fn a_frame_is_the_mesh_of_the_next_case() {
    for compression in ["none", "zlib"] {
        let bench = Bench::new();
        let compressed = format!("output.compression={compression}");
        assert_eq!(bench.solve(&["--set", &compressed]).code, Some(0));
        let (_, last) = bench.results().frames().pop().expect("frames");
        std::fs::rename(bench.path("out/frames/sail_000010.vtu"), bench.path("last.vtu")).expect("the last frame");
        let mesh = "system.network.mesh={\"file\": \"last.vtu\"}";
        let ended = bench.solve(&["--force", "--set", mesh, "--set", &compressed]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        let (_, first) = bench.results().frames().swap_remove(0);
        for name in ["Points", "connectivity", "types"] {
            assert_eq!(first.bytes(name), last.bytes(name), "{name}, {compression}");
        }
    }
}

/// The summary tells where the time before the first step went; what does not take place takes no time.
#[test]
fn the_start_is_told_phase_by_phase() {
    for (method, matrix) in [("velocity-verlet", false), ("newmark", true)] {
        let bench = Bench::new();
        assert_eq!(bench.solve(&["--method", method]).code, Some(0));
        let summary = bench.results().summary();
        let seconds = |key: &str| summary["startup"][key].as_f64().unwrap_or_else(|| panic!("no {key} in {summary}"));
        let before = ["parse", "mesh", "topology", "numbering", "scene", "critical_step", "files", "forces"];
        let analysis = ["pattern", "ordering", "symbolic"];
        let phases: f64 = before.iter().chain(&analysis).map(|key| seconds(key)).sum();
        assert!(before.iter().chain(&analysis).all(|key| seconds(key) >= 0.0));
        assert!(seconds("cpu_seconds") >= 0.999 * phases && seconds("wall_seconds") > 0.0, "{summary}");
        let all = |key: &str| summary[key].as_f64().unwrap_or_else(|| panic!("no {key} in {summary}"));
        assert!(all("cpu_seconds") >= seconds("cpu_seconds"), "the start is a part: {summary}");
        assert!(all("wall_seconds") >= seconds("wall_seconds"), "{summary}");
        for key in analysis.iter().chain(&["factorization"]) {
            assert_eq!(seconds(key) > 0.0, matrix, "{key} with {method}");
        }
    }
}

/// Without `--out` the results go to `out/<case name>`.
#[test]
fn the_default_folder_bears_the_name_of_the_case() {
    let bench = Bench::new();
    assert_eq!(bench.run(&["solve", "sail.json", "--quiet"]).code, Some(0));
    assert!(bench.path("out/sail/summary.json").is_file() && bench.path("out/sail/sail.pvd").is_file());
}

/// Frames and probes lie at t = 0, at every multiple of `every` and at the end, though no step ends there.
#[test]
fn frames_are_at_multiples_of_the_interval() {
    let bench = Bench::new();
    let ended = bench.solve(&["--step", "0.03", "--end", "0.75", "--set", "output.frames.every=0.2"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let times: Vec<f64> = bench.results().frames().iter().map(|(time, _)| *time).collect();
    let expected = [0.0, 0.2, 0.4, 0.6, 0.75];
    // A frame that falls onto the end of a step bears that step's time, equal up to rounding.
    let agree = |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(agree(&times, &expected), "{times:?}");
    let probes = bench.results().table("probes.csv");
    let twice: Vec<f64> = times.iter().flat_map(|t| [*t, *t]).collect();
    assert_eq!(probes.column("t"), twice);
    assert_eq!(probes.column("node"), [2.0, 5.0].repeat(5));
}

/// Compressed frames of seven digits hold the same picture in less room; what must be exact is not touched, and `plot`
/// reads them.
#[test]
fn frames_may_be_small() {
    let bench = Bench::new();
    let solve = |out: &str, more: &[&str]| {
        let flags = ["solve", "sail.json", "--end", "0.3", "--out", out, "--quiet", "--set", "output.frames.every=0.1"];
        let ended = bench.run(&[&flags[..], more].concat());
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        let folder = bench.path(out);
        let size = |entry: std::io::Result<std::fs::DirEntry>| entry.and_then(|e| e.metadata()).expect("there").len();
        let room: u64 = std::fs::read_dir(folder.join("frames")).expect("frames").map(size).sum();
        (Results(folder), room)
    };
    let (whole, room) = solve("whole", &[]);
    let packed = ["--set", "output.compression=zlib", "--set", "output.precision=f32"];
    let (small, less) = solve("small", &packed);
    assert!(less < room, "{less} of {room} bytes");
    for ((t, a), (s, b)) in whole.frames().iter().zip(&small.frames()) {
        assert_eq!((t, a.names()), (s, b.names()));
        for name in ["Points", "displacement", "velocity"] {
            let close = |(a, b): (&f64, &f64)| (a - b).abs() <= 6e-8 * a.abs();
            assert!(a.floats(name).iter().zip(&b.floats(name)).all(close), "{name} at {t}");
        }
        assert_eq!(a.bytes("connectivity"), b.bytes("connectivity"));
    }
    assert_eq!(whole.text("history.csv"), small.text("history.csv"));
    let plotted = bench.run(&["plot", "small", "--out", "plots"]);
    assert_eq!(plotted.code, Some(0), "{}", plotted.stderr);
    let refused = bench.solve(&["--set", "output.precision=f16"]);
    assert!(refused.code == Some(2) && refused.stderr.contains("f32"), "{}", refused.stderr);
}

/// The account closes in every row for every method: its sum keeps its value at t = 0 to the rounding of its parts. And
/// what it calls numerical is small for methods of order 2 and above, so that work and loss are told right.
#[test]
fn the_ledger_closes_row_by_row() {
    let bench = Bench::new();
    for info in methods() {
        let method = info.name;
        let share = match info.order {
            _ if method == "energy-momentum" => 1e-7,
            1 => 1.0,
            // The account's work of a step is of second order where the method does not integrate it.
            2 | 3 => 2e-3,
            _ => 2e-6,
        };
        let ended = bench.solve(&["--force", "--quiet", "--method", method]);
        assert_eq!(ended.code, Some(0), "{method}: {}", ended.stderr);
        let table = bench.results().table("history.csv");
        let signs = [
            ("kinetic", 1.0),
            ("elastic", 1.0),
            ("gravity", 1.0),
            ("external_work", -1.0),
            ("dissipated", 1.0),
            ("numerical", 1.0),
        ];
        let columns = signs.map(|(name, sign)| (table.column(name), sign));
        let sum = |row: usize| columns.iter().map(|(c, sign)| sign * c[row]).sum::<f64>();
        for row in 0..table.rows.len() {
            let size = columns.iter().fold(0.0, |m: f64, (c, _)| m.max(c[row].abs()));
            assert!((sum(row) - sum(0)).abs() <= 1e-14 * size, "{method}, row {row}: {} for {}", sum(row), sum(0));
        }
        let error = bench.results().summary()["energy_error"].as_f64().expect("a number");
        assert!(error < share, "{method}: {error:e}");
        // Largest |numerical| over the largest change of the others, from the rows as a person reads them.
        let change = |(c, _): &(Vec<f64>, f64)| c.iter().fold(0.0, |m: f64, e| m.max((e - c[0]).abs()));
        let expected = change(&columns[5]) / columns[..5].iter().map(change).fold(0.0, f64::max);
        assert!((error - expected).abs() <= 1e-12 * error, "{method}: {error:e} for {expected:e}");
    }
}

/// The flags replace values of the case, and the summary shows the case as it was run.
#[test]
fn flags_replace_values_of_the_case() {
    let bench = Bench::new();
    let ended = bench.solve(&[
        "--method",
        r#"{"hht": {"alpha": -0.2}}"#,
        "--step",
        "0.02",
        "--end",
        "0.5",
        "--set",
        "system.network.springs.0.stiffness=60",
        "--set",
        "system.network.aero=null",
    ]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let summary = bench.results().summary();
    assert_eq!(summary["case"]["time"], json!({"end": 0.5, "step": 0.02, "method": {"hht": {"alpha": -0.2}}}));
    assert_eq!(summary["case"]["system"]["network"]["springs"][0]["stiffness"], json!(60));
    assert_eq!(summary["case"]["system"]["network"].get("aero"), None);
    assert_eq!([&summary["method"], &summary["method_parameters"]["alpha"]], [&json!("hht"), &json!(-0.2)]);
    assert_eq!([&summary["steps"], &summary["t_end"]], [&json!(25), &json!(0.5)]);
}

/// Threads change nothing in what is written.
#[test]
fn two_threads_write_the_same_results() {
    let (one, two) = (Bench::new(), Bench::new());
    for (bench, threads) in [(&one, "1"), (&two, "2")] {
        assert_eq!(bench.solve(&["--method", "newmark", "--threads", threads]).code, Some(0));
    }
    for name in ["history.csv", "probes.csv", "frames/sail_000010.vtu"] {
        let bytes = |bench: &Bench| std::fs::read(bench.path("out").join(name)).expect("written");
        assert!(bytes(&one) == bytes(&two), "{name} differs");
    }
}

/// Earlier results stay as they are, bit by bit, until `--force` replaces them; foreign files stay even then.
#[test]
fn earlier_results_are_not_overwritten_unasked() {
    let bench = Bench::new();
    assert_eq!(bench.solve(&[]).code, Some(0));
    std::fs::write(bench.path("out/notes.txt"), "mine").expect("a file");
    let before = contents(&bench.path("out"));
    let refused = bench.solve(&["--end", "0.3"]);
    assert_eq!(refused.code, Some(2));
    assert!(refused.stderr.contains("--force"), "{}", refused.stderr);
    assert!(contents(&bench.path("out")) == before, "a refused run changed something");
    assert_eq!(bench.solve(&["--end", "0.3", "--force"]).code, Some(0));
    assert_eq!(bench.results().frames().len(), 4);
    assert!(!bench.path("out/frames/sail_000010.vtu").exists(), "an old frame is left over");
    assert_eq!(bench.results().text("notes.txt"), "mine");
}

/// `--quiet` says nothing on either channel; without it the report is on standard output, and no progress bar is drawn
/// where standard error is no terminal.
#[test]
fn quiet_prints_nothing() {
    let bench = Bench::new();
    let quiet = bench.solve(&["--quiet", "--set", "output.checkpoint.every=0.5"]);
    assert_eq!((quiet.code, quiet.stdout.as_str(), quiet.stderr.as_str()), (Some(0), "", ""));
    // A sail heavier than cloth, and that is all there is to say of it.
    let loud = bench.solve(&["--force", "--set", "system.network.mass.areal_density=0.3"]);
    let said: Vec<&str> = loud.stderr.lines().collect();
    assert!(said.len() == 1 && said[0].starts_with("warning: /system/network/mass: "), "{}", loud.stderr);
    assert_eq!(loud.code, Some(0));
    assert!(loud.stdout.contains("energy error"), "{}", loud.stdout);
}

/// The commands that only tell something end with 0 and tell it on standard output.
#[test]
fn commands_that_only_tell() {
    let bench = Bench::new();
    for (command, words) in
        [("methods", "generalized-alpha"), ("schema", "\"areal_density\""), ("--version", "canopy-fem")]
    {
        let ended = bench.run(&[command]);
        assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""), "{command}");
        assert!(ended.stdout.contains(words), "{command}: {}", ended.stdout);
    }
    let checked = bench.run(&["check", "sail.json"]);
    assert_eq!(checked.code, Some(0), "{}", checked.stderr);
    assert!(checked.stdout.contains("12") && !bench.path("out").exists(), "{}", checked.stdout);
    let made = bench.run(&["init", "first"]);
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    let file = made.stdout.split_whitespace().next().expect("the file's name").to_owned();
    assert_eq!(bench.run(&["solve", &file, "--end", "0.01", "--quiet"]).code, Some(0), "the example case runs");
}

/// `--force` takes away what an earlier case left, under its own name too, and nothing else.
#[test]
fn the_results_of_another_case_are_replaced_whole() {
    let bench = Bench::new();
    assert_eq!(bench.solve(&["--end", "0.2"]).code, Some(0));
    assert!(bench.path("out/sail.pvd").exists());
    std::fs::write(bench.path("out/frames/sail_notes.txt"), "mine").expect("written");
    let other = ["--end", "0.1", "--set", "name=other"];
    assert_eq!(bench.solve(&other).code, Some(2), "there are results");
    assert_eq!(bench.solve(&[&other[..], &["--force"]].concat()).code, Some(0));
    let left: Vec<_> = std::fs::read_dir(bench.path("out/frames")).expect("frames").filter_map(Result::ok).collect();
    let names: Vec<String> = left.iter().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    assert!(names.iter().all(|name| name.starts_with("other_") || name == "sail_notes.txt"), "{names:?}");
    assert!(names.len() > 2 && bench.path("out/other.pvd").exists() && !bench.path("out/sail.pvd").exists());
}

/// What was made of an earlier run in the same folder is told, until it is made anew.
#[test]
fn pages_of_an_earlier_run_are_told() {
    let bench = Bench::new();
    let solve = |flags: &[&str]| {
        let ended = bench.solve(flags);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        ended.stderr
    };
    let shows = |text: &str, file: &str| text.contains(&format!("{file} shows an earlier run"));
    assert!(!shows(&solve(&["--view"]), "view.html"));
    assert_eq!(bench.run(&["export", "out", "--to", "glb"]).code, Some(0));
    let again = solve(&["--force"]);
    assert!(shows(&again, "view.html") && shows(&again, ".glb") && !shows(&again, ".usda"), "{again}");
    assert!(!shows(&solve(&["--force", "--view"]), "view.html"));
    assert_eq!(solve(&["--force", "--quiet"]), "");
}
