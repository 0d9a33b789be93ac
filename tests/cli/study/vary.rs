//! `canopy-fem sweep`: a case over values of its keys.

use std::time::Duration;

use serde_json::{Value, json};

use crate::bench::{Bench, Results, Table};

/// [kg], [m/s] mass and initial velocity of an oscillator
const MASS: f64 = 2.0;
const SPEED: f64 = 1.5;
/// The key of its stiffness.
const STIFFNESS: &str = "system.network.springs.0.stiffness";

fn oscillator() -> Bench {
    let bench = Bench::new();
    let case = json!({
        "name": "oscillator",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0]], "springs": [[0, 1]]}},
            "mass": {"nodal": MASS},
            "springs": [{"on": "all", "stiffness": 200.0}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "initial": {"velocity": [SPEED, 0, 0]}
        }},
        "time": {"end": 0.5, "method": "velocity-verlet", "step": 0.002},
        "output": {"gauges": [
            {"name": "spring", "on": "all", "of": "tension"},
            {"name": "way", "on": {"ids": [1]}, "of": "displacement"}
        ]}
    });
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    bench
}

fn sweep(bench: &Bench, out: &str, flags: &[&str]) -> Table {
    let ended = bench.run(&[&["sweep", "case.json", "--out", out], flags].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    Results(bench.path(out)).table("sweep.csv")
}

/// The table without processor times.
fn counted(bench: &Bench, out: &str) -> Vec<Vec<String>> {
    let text = Results(bench.path(out)).text("sweep.csv");
    let rows: Vec<Vec<String>> = text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect();
    let clock = rows[0].iter().position(|name| name == "cpu_seconds").expect("a column");
    let without =
        |row: &Vec<String>| row.iter().enumerate().filter(|(i, _)| *i != clock).map(|(_, c)| c.clone()).collect();
    rows.iter().map(without).collect()
}

fn texts(table: &Table, column: usize) -> Vec<&str> {
    table.rows.iter().map(|row| row[column].as_str()).collect()
}

/// Amplitude v / w, its time an odd quarter of a period, tension k v / w and speed v of an undamped oscillator with
/// w^2 = k/m, over the stiffness. The peak is that of a step, which is within half a step of the quarter; the
/// frequency of the scheme is off by (w h)^2 / 24: together less than (w h)^2.
#[test]
fn an_oscillator_over_its_stiffness() {
    let bench = oscillator();
    let table = sweep(&bench, "out", &["--vary", &format!("{STIFFNESS}=log:50..800:5")]);
    let column = |name: &str| table.column(name);
    let stiffness = column(STIFFNESS);
    assert_eq!(stiffness, [50.0, 100.0, 200.0, 400.0, 800.0]);
    for (i, k) in stiffness.iter().enumerate() {
        let w = (k / MASS).sqrt();
        let close = |name: &str, expected: f64, tolerance: f64| {
            let found = column(name)[i];
            assert!((found - expected).abs() <= tolerance * expected, "{name} at k = {k}: {found}, not {expected}");
        };
        let tolerance = (w * 0.002).powi(2);
        close("way.displacement_max.peak", SPEED / w, tolerance);
        close("spring.tension_max.peak", k * SPEED / w, tolerance);
        close("max_speed", SPEED, tolerance);
        close("max_strain", SPEED / w, tolerance);
        close("way.displacement_max.last", (SPEED / w * (w * 0.5).sin()).abs(), 0.02);
        close("t_end", 0.5, 1e-12);
        // At one of the turning points, which are odd quarters of a period.
        let quarters = column("way.displacement_max.peak_time")[i] * w / std::f64::consts::FRAC_PI_2;
        let odd = 2.0 * ((quarters - 1.0) / 2.0).round() + 1.0;
        assert!((quarters - odd).abs() * std::f64::consts::FRAC_PI_2 / w <= 0.002, "{quarters} quarters at k = {k}");
    }
    // The same run as that of solve, to the bit.
    let set = format!("{STIFFNESS}=400");
    let ended = bench.run(&["solve", "case.json", "--out", "alone", "--set", &set]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let alone = Results(bench.path("alone")).summary();
    let peaks = alone["peaks"].as_array().expect("gauges");
    assert_eq!(peaks.len(), 4);
    for peak in peaks {
        let name = format!("{}.{}", peak["name"].as_str().expect("a name"), peak["quantity"].as_str().expect("one"));
        for (end, key) in [("peak", "value"), ("peak_time", "t"), ("last", "last")] {
            assert_eq!(column(&format!("{name}.{end}"))[3], peak[key].as_f64().expect("a number"), "{name}.{end}");
        }
    }
    assert_eq!(column("energy_error")[3], alone["energy_error"].as_f64().expect("a number"));
}

/// A weight on a damped spring comes to rest m g / k below: a static deflection over two keys, in the order of the
/// grid.
#[test]
fn a_grid_of_static_deflections() {
    let bench = oscillator();
    let flags = [
        "--set",
        "system.network.gravity=[10,0,0]",
        "--set",
        "system.network.initial=null",
        "--set",
        r#"system.network.springs.0.dashpot={"axial":{"coefficient":40}}"#,
        "--end",
        "8",
    ];
    let vary = ["--vary", "system.network.mass.nodal=1,2", "--vary", &format!("{STIFFNESS}=100..300:3")];
    let table = sweep(&bench, "out", &[&flags[..], &vary[..]].concat());
    let columns = ["system.network.mass.nodal", STIFFNESS, "way.displacement_max.last"].map(|name| table.column(name));
    assert_eq!(columns[0], [1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    assert_eq!(columns[1], [100.0, 200.0, 300.0, 100.0, 200.0, 300.0]);
    for ((mass, stiffness), found) in columns[0].iter().zip(&columns[1]).zip(&columns[2]) {
        let expected = 10.0 * mass / stiffness;
        assert!((found - expected).abs() < 1e-4 * expected, "{mass} kg on {stiffness} N/m: {found}, not {expected}");
    }
    let out = Results(bench.path("out"));
    let told: Value = serde_json::from_str(&out.text("sweep.json")).expect("JSON");
    assert_eq!(told["rows"].as_array().map(Vec::len), Some(6));
    assert_eq!(told["rows"][4]["values"][STIFFNESS], json!(200));
    assert_eq!(told["units"]["way.displacement_max.last"], "m");
    assert!(out.text("sweep.svg").contains("nodal = 2"), "a curve for each mass");
    let page = out.text("sweep.html");
    assert!(page.contains("prefers-color-scheme: dark") && page.contains(&format!("data-run=\"{:05}-", 4)));
}

/// A run that diverges is a row that says so, and interrupts nothing.
#[test]
fn failures_are_rows() {
    let bench = oscillator();
    let table = sweep(&bench, "out", &["--vary", "time.step=0.001,0.5,0.002", "--end", "100"]);
    let status = texts(&table, 2);
    assert_eq!(status, ["completed", "diverged", "completed"]);
    let peaks = table.column("way.displacement_max.peak");
    assert!(peaks[0].is_finite() && peaks[1].is_nan() && peaks[2].is_finite(), "{peaks:?}");
    assert!(table.rows[1].last().is_some_and(|note| note.len() > 20), "{:?}", table.rows[1]);
}

/// In one go on one and on two threads, and in shards, one of them in a copy of the folder: the same bytes.
#[test]
fn shards_and_threads_change_nothing() {
    let bench = oscillator();
    let vary = format!("{STIFFNESS}=50..400:7");
    sweep(&bench, "one", &["--vary", &vary, "--threads", "1"]);
    sweep(&bench, "two", &["--vary", &vary, "--threads", "2"]);
    let expected = counted(&bench, "one");
    assert_eq!(expected.len(), 8);
    assert_eq!(counted(&bench, "two"), expected);
    let picture = |out: &str| Results(bench.path(out)).text("sweep.svg");
    assert_eq!(picture("two"), picture("one"));
    let planned = bench.run(&["sweep", "case.json", "--vary", &vary, "--plan", "--out", "parts"]);
    assert_eq!(planned.code, Some(0), "{}", planned.stderr);
    std::fs::create_dir_all(bench.path("copy/sweep")).expect("a folder");
    std::fs::copy(bench.path("parts/sweep/plan.json"), bench.path("copy/sweep/plan.json")).expect("a copy");
    for (out, shard) in [("parts", "3/3"), ("copy", "1/3"), ("parts", "2/3")] {
        let ended = bench.run(&["sweep", "--out", out, "--shard", shard]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    }
    let merged = bench.run(&["sweep", "--out", "parts", "--merge"]);
    assert!(merged.stdout.contains("3 not-run"), "a merge shows what is missing: {}", merged.stdout);
    let merged = bench.run(&["sweep", "--out", "parts", "--merge", "copy"]);
    assert_eq!(merged.code, Some(0), "{}", merged.stderr);
    assert_eq!(counted(&bench, "parts"), expected);
    assert_eq!(picture("parts"), picture("one"));
}

/// Stopped by a spent budget and by signals, and started again: the rows of a sweep that was left alone. A file of a
/// finished run is not made again.
#[test]
#[cfg(unix)]
fn an_interrupted_sweep_goes_on() {
    let bench = oscillator();
    let flags = ["--vary", &format!("{STIFFNESS}=50,300"), "--set", "time.step=2e-6", "--threads", "1"];
    sweep(&bench, "whole", &flags);
    let begin = [&["sweep", "case.json", "--out", "pieces"][..], &flags].concat();
    let mut pieces = 0;
    loop {
        let ended = bench.run(&[&begin[..], &["--budget", "60ms"]].concat());
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        if !ended.stdout.contains("not-run") {
            break;
        }
        pieces += 1;
        assert!(pieces < 200, "it never ends");
        if pieces == 1 {
            let mut child = bench.program();
            let mut child = child.args(&begin).stderr(std::process::Stdio::null()).spawn().expect("starts");
            std::thread::sleep(Duration::from_millis(50));
            let sent = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
            assert!(sent.is_ok());
            let code = child.wait().expect("ends").code();
            assert!(matches!(code, Some(0 | 130)), "{code:?}");
        }
    }
    assert!(pieces > 0, "the budget was never spent; the test needs longer runs");
    assert_eq!(counted(&bench, "pieces"), counted(&bench, "whole"));
    let file = bench.path("pieces/sweep/runs/00001-300.json");
    let before = std::fs::metadata(&file).and_then(|m| m.modified()).expect("a time");
    assert_eq!(bench.run(&begin).code, Some(0));
    assert_eq!(std::fs::metadata(&file).and_then(|m| m.modified()).expect("a time"), before);
}

/// Status 2, with the value and its place, before anything is made.
#[test]
fn bad_input_is_refused() {
    let bench = oscillator();
    let cases: [(&[&str], &[&str]); 12] = [
        (&[], &["--vary"]),
        (&["--vary", "time.step=0.01,-1"], &["--vary time.step=-1", "time.step"]),
        (&["--vary", "system.network.springs.0.stifness=1..2:2"], &["stifness=1", "stiffness"]),
        (&["--vary", "system.network.springs.3.stiffness=1,2"], &["springs.3.stiffness=1", "has 1 entries"]),
        (&["--vary", "time.method=rk4,rk5"], &["time.method=rk5", "rk4"]),
        (&["--vary", "time.step=1..2"], &["number of values is missing"]),
        (&["--vary", "time.step=0.1,0.1"], &["there twice"]),
        (&["--vary", "time.step=0.1", "--vary", "time.step=0.2"], &["given twice"]),
        (&["--vary", "a=1..2:90000", "--vary", "b=1..2:90000"], &["a sweep has at most"]),
        (&["--vary", "time.step=0.1", "--threads", "0"], &["1..=1024"]),
        (&["--vary", "time.step=0.1", "--shard", "1/2"], &["cannot be used with"]),
        (&["--shard", "1/2"], &["leave the case out"]),
    ];
    for (flags, words) in cases {
        let ended = bench.run(&[&["sweep", "case.json", "--out", "out"], flags].concat());
        assert_eq!(ended.code, Some(2), "{flags:?}: {}", ended.stderr);
        for word in words {
            assert!(ended.stderr.contains(word), "{flags:?} without {word}: {}", ended.stderr);
        }
        assert!(!bench.path("out").exists(), "{flags:?} left something");
    }
    let ended = bench.run(&["sweep", "--out", "out", "--merge"]);
    assert!(ended.code == Some(2) && ended.stderr.contains("canopy-fem sweep CASE --plan"), "{}", ended.stderr);
}

/// Another case, other values or another mesh in the same folder are refused until --force; a column to draw that is
/// not there is told with those that are.
#[test]
fn another_sweep_is_not_mixed_in() {
    let bench = oscillator();
    let go = |flags: &[&str]| bench.run(&[&["sweep", "case.json", "--out", "out", "--quiet"], flags].concat());
    let vary = ["--vary", "time.step=0.01,0.02"];
    assert_eq!(go(&vary).code, Some(0));
    for (flags, why) in [
        (&["--vary", "time.step=0.01,0.02", "--end", "0.4"][..], "time.end was 0.5 and is 0.4 now"),
        (&["--vary", "time.step=0.01,0.05"], "other keys or values"),
    ] {
        let ended = go(flags);
        assert_eq!(ended.code, Some(2), "{}", ended.stderr);
        assert!(ended.stderr.contains(why) && ended.stderr.contains("--force"), "{}", ended.stderr);
        assert_eq!(go(&[flags, &["--force"]].concat()).code, Some(0));
        assert_eq!(go(&[&vary[..], &["--force"]].concat()).code, Some(0));
    }
    let ended = go(&[&vary[..], &["--plot", "way"]].concat());
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
    assert!(ended.stderr.contains("way.displacement_max.peak"), "{}", ended.stderr);
    let ended = go(&[&vary[..], &["--plot", "steps", "--plot", "max_speed"]].concat());
    assert_eq!((ended.code, ended.stdout.as_str()), (Some(0), ""), "{}", ended.stderr);
    assert!(Results(bench.path("out")).text("sweep.svg").contains("largest speed of a node [m/s]"));
}
