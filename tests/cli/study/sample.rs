//! `canopy-fem sweep` with distributions: samples of a linear spring and of a falling mass against closed forms, the
//! same rows however they are made, rules, failures and errors.

use serde_json::{Value, json};

use crate::bench::{Bench, Results, Table};

/// Gauge of a point on a spring: a static deflection m g / k, with steps that damp.
const DEFLECTION: &str = "way.displacement_max.last";
const FORCE: &str = "system.network.gravity.0";
/// [kg], [N/m]
const MASS: f64 = 2.0;
const STIFFNESS: f64 = 200.0;

/// A mass on a damped spring, which comes to rest at m a / k.
fn spring() -> Bench {
    written(json!({
        "name": "spring",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0]], "springs": [[0, 1]]}},
            "mass": {"nodal": MASS},
            "springs": [{"on": "all", "stiffness": STIFFNESS, "dashpot": {"axial": {"coefficient": 40}}}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "gravity": [10, 0, 0]
        }},
        "time": {"end": 3, "method": "newmark", "step": 0.02},
        "output": {"gauges": [{"name": "way", "on": {"ids": [1]}, "of": "displacement"}]}
    }))
}

/// Two masses on a line, side by side in their fall through air, which brakes both alike.
fn falling() -> Bench {
    written(json!({
        "name": "fall",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [0, 0, 1]], "springs": [[0, 1]]}},
            "mass": {"nodal": 10},
            "springs": [{"on": "all", "stiffness": 1000}],
            "gravity": [0, 0, -9.81],
            "aero": {"drag": [{"on": {"ids": [0, 1]}, "drag_area": 2.0}]},
            "initial": {"velocity": [0, 0, -10]}
        }},
        "time": {"end": 12, "method": "newmark", "step": 0.02},
        "output": {"gauges": [{"name": "mass", "on": {"ids": [0]}, "of": "speed"}]}
    }))
}

fn written(case: Value) -> Bench {
    let bench = Bench::new();
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    bench
}

fn sample(bench: &Bench, out: &str, flags: &[&str]) -> (Table, Value) {
    let ended = bench.run(&[&["sweep", "case.json", "--out", out], flags].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let results = Results(bench.path(out));
    (results.table("sweep.csv"), serde_json::from_str(&results.text("sweep.json")).expect("JSON"))
}

/// The table without processor times.
fn counted(bench: &Bench, out: &str) -> Vec<Vec<String>> {
    let text = Results(bench.path(out)).text("sweep.csv");
    let rows: Vec<Vec<String>> = text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect();
    let clock = rows[0].iter().position(|name| name == "cpu_seconds").expect("a column");
    rows.into_iter()
        .map(|mut row| {
            row.remove(clock);
            row
        })
        .collect()
}

fn of<'v>(scatter: &'v Value, name: &str) -> &'v Value {
    let all = scatter["scatter"]["quantities"].as_array().expect("quantities");
    all.iter().find(|quantity| quantity["name"] == name).expect("the quantity")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// The deflection of a spring is linear in the load: of a normal load it is normal, with mean m a/k and deviation m
/// s/k. A Latin hypercube of 200 has the mean to a thousandth of the deviation, and percentiles to a fifth of it at
/// the ends.
#[test]
fn the_linear_response_of_a_normal_is_normal() {
    let bench = spring();
    let flags = ["--vary", &format!("{FORCE}=normal:10±1"), "--samples", "200", "--plot", DEFLECTION];
    let (table, told) = sample(&bench, "out", &flags);
    let (loads, found) = (table.column(FORCE), table.column(DEFLECTION));
    assert_eq!(loads.len(), 200);
    for (load, x) in loads.iter().zip(&found) {
        assert!((x - MASS * load / STIFFNESS).abs() < 1e-5, "{load} m/s^2: {x} m");
    }
    let deflection = of(&told, DEFLECTION);
    let (mean, sd) = (0.1, 0.01);
    assert!((number(&deflection["mean"]["value"]) - mean).abs() < 0.002 * sd + 1e-5, "{deflection}");
    assert!((number(&deflection["sd"]["value"]) - sd).abs() < 0.02 * sd, "{deflection}");
    let normal = [-2.326_347_874, -1.644_853_627, 0.0, 1.644_853_627, 2.326_347_874];
    for (quantile, z) in deflection["quantiles"].as_array().expect("five").iter().zip(normal) {
        assert!((number(&quantile["value"]) - mean - sd * z).abs() < 0.2 * sd, "{quantile}, z = {z}");
    }
    // All of the scatter comes from the one key.
    assert!(number(&deflection["indices"][0]["first"]["value"]) > 0.99, "{deflection}");
    // The worst run is in the table, and is that of solve.
    let worst = deflection["largest"]["run"].as_u64().expect("a run") as usize;
    assert_eq!(found[worst], number(&deflection["largest"]["value"]));
    let ended = bench.run(&["solve", "case.json", "--out", "one", "--set", &format!("{FORCE}={:?}", loads[worst])]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert_eq!(Results(bench.path("one")).summary()["peaks"][0]["last"].as_f64(), Some(found[worst]));
}

/// A mass falls at sqrt(2 m g / (rho CdA)) at last. Of an area uniform from 1 to 3 m^2, here as a table of its
/// distribution function, all percentiles of the speed are known.
#[test]
fn a_falling_mass_has_the_distribution_of_its_terminal_speed() {
    let bench = falling();
    std::fs::write(bench.path("area.csv"), "value,cumulative\n1,0\n3,1\n").expect("written");
    let key = "system.network.aero.drag.0.drag_area";
    let vary = format!("{key}=table:area.csv");
    let flags = ["--vary", &vary, "--samples", "64", "--sampling", "sobol", "--plot", "mass.speed_max.last"];
    let (table, told) = sample(&bench, "out", &flags);
    let areas = table.column(key);
    let speed = |area: f64| (2.0 * 20.0 * 9.81 / (1.225 * area)).sqrt();
    for (area, found) in areas.iter().zip(table.column("mass.speed_max.last")) {
        assert!((found - speed(*area)).abs() < 1e-3 * speed(*area), "{area} m^2: {found} m/s, not {}", speed(*area));
    }
    // The speed falls with the area: its share p is that of the area at 1 - p. 64 even points are within 1/64.
    let speeds = of(&told, "mass.speed_max.last");
    for quantile in speeds["quantiles"].as_array().expect("five") {
        let p = number(&quantile["p"]);
        let at = |p: f64| speed(1.0 + 2.0 * (1.0 - p.clamp(0.0, 1.0)));
        let found = number(&quantile["value"]);
        let (low, high) = (at(p - 1.5 / 64.0) - 1e-3, at(p + 1.5 / 64.0) + 1e-3);
        assert!((low..=high).contains(&found), "{p}: {found} m/s, not within {low} and {high}");
    }
}

/// In one go, on two threads, in shards in any order, and after a stop: the same rows.
#[test]
fn rows_do_not_depend_on_how_they_are_made() {
    let bench = spring();
    let rows = "time.end,system.network.mass.nodal,weight\n0.5,1,1\n0.6,2,3\n";
    std::fs::write(bench.path("sets.csv"), rows).expect("written");
    let vary =
        ["--vary", &format!("{FORCE}=uniform:5..15"), "--vary", "rows:sets.csv", "--samples", "20", "--seed", "9"];
    sample(&bench, "one", &[&vary[..], &["--threads", "1"]].concat());
    let expected = counted(&bench, "one");
    assert_eq!(expected.len(), 21);
    sample(&bench, "two", &[&vary[..], &["--threads", "2"]].concat());
    assert_eq!(counted(&bench, "two"), expected);
    let planned = bench.run(&[&["sweep", "case.json", "--plan", "--out", "parts"], &vary[..]].concat());
    assert_eq!(planned.code, Some(0), "{}", planned.stderr);
    for shard in ["3/3", "1/3", "2/3"] {
        let ended = bench.run(&["sweep", "--out", "parts", "--shard", shard]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    }
    let merged = bench.run(&["sweep", "--out", "parts", "--merge"]);
    assert_eq!(merged.code, Some(0), "{}", merged.stderr);
    assert_eq!(counted(&bench, "parts"), expected);
    let scatter = |out: &str| {
        let told: Value = serde_json::from_str(&Results(bench.path(out)).text("sweep.json")).expect("JSON");
        told["scatter"].clone()
    };
    assert_eq!(scatter("parts"), scatter("one"));
    // Taken away, the last runs are made again as they were.
    for run in ["00007-sample.json", "00019-sample.json", "00020-beside.json"] {
        std::fs::remove_file(bench.path("one/sweep/runs").join(run)).expect("a run");
    }
    sample(&bench, "one", &vary);
    assert_eq!(counted(&bench, "one"), expected);
    // Both keys of a row come together, three times as often from the second.
    let table = Results(bench.path("one")).table("sweep.csv");
    let pairs: Vec<(f64, f64)> =
        table.column("time.end").into_iter().zip(table.column("system.network.mass.nodal")).collect();
    assert!(pairs.iter().all(|pair| [(0.5, 1.0), (0.6, 2.0)].contains(pair)), "{pairs:?}");
    assert_eq!(pairs.iter().filter(|pair| pair.0 == 0.6).count(), 15, "of a hypercube of 20");
    // Another seed has other rows.
    sample(&bench, "other", &[&vary[..7], &["10", "--no-errors"]].concat());
    assert_ne!(counted(&bench, "other"), expected);
}

/// The rule ends the sweep after the first batch that is enough, and a merge of shards, which make all rows, counts the
/// same ones.
#[test]
fn a_rule_ends_the_sweep() {
    let bench = spring();
    let rule = format!("1% of mean {DEFLECTION}");
    let flags = ["--vary", &format!("{FORCE}=normal:10±1"), "--samples", "1000", "--until", &rule, "--no-errors"];
    let flags = [&flags[..], &["--end", "0.4"]].concat();
    let (table, told) = sample(&bench, "out", &flags);
    let until = &told["scatter"]["until"];
    // Half of the interval is 1.96 s/sqrt(n): with s a tenth of the mean some 400 rows are enough.
    assert!(until["met"] == true && number(&until["reached"]) <= 0.01, "{until}");
    let n = table.rows.len();
    assert!(n.is_multiple_of(64) && (256..=640).contains(&n), "{n} rows");
    assert!(!bench.path("out/sweep/runs").join(format!("{n:05}-sample.json")).exists(), "no later row was made");
    let planned = bench.run(&[&["sweep", "case.json", "--plan", "--out", "parts"], &flags[..]].concat());
    assert_eq!(planned.code, Some(0), "{}", planned.stderr);
    for shard in ["2/2", "1/2"] {
        assert_eq!(bench.run(&["sweep", "--out", "parts", "--shard", shard]).code, Some(0));
    }
    assert_eq!(bench.run(&["sweep", "--out", "parts", "--merge"]).code, Some(0));
    assert_eq!(counted(&bench, "parts"), counted(&bench, "out"));
}

/// Runs that fail are counted, with their cause and numbers, and are no part of the distribution.
#[test]
fn failed_runs_are_counted_and_shown() {
    let bench = spring();
    let flags = ["--vary", "time.step=0.01,0.5", "--samples", "20", "--set", "time.method=velocity-verlet"];
    let flags = [&flags[..], &["--end", "60", "--plot", DEFLECTION]].concat();
    let ended = bench.run(&[&["sweep", "case.json", "--out", "out"], &flags[..]].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stdout.contains("10 with a result") && ended.stdout.contains("10 diverged (run"), "{}", ended.stdout);
    let results = Results(bench.path("out"));
    let told: Value = serde_json::from_str(&results.text("sweep.json")).expect("JSON");
    let failed = &told["scatter"]["failed"][0];
    assert_eq!(failed["runs"].as_array().map(Vec::len), Some(10), "{failed}");
    assert_eq!(of(&told, DEFLECTION)["runs"], 10);
    assert!(results.text("sweep.html").contains("Runs without a result"));
}

/// Beside the scatter: the error by the step of a coarse integration is the largest where nothing varies much, and the
/// scatter is where it does. A line of several segments has a finer mesh.
#[test]
fn scatter_step_and_mesh_are_compared() {
    let bench = written(json!({
        "name": "chain",
        "system": {"network": {
            "mesh": {"chain": {"from": [0, 0, 0], "to": [1, 0, 0], "segments": 4}},
            "springs": [{"on": "all", "axial_rigidity": 100.0, "linear_density": 0.1}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "gravity": [0, 0, -9.81]
        }},
        "time": {"end": 0.4, "method": "newmark", "step": 0.01},
        "output": {"gauges": [{"name": "chain", "on": "all", "of": "tension"}]}
    }));
    let compare = |out: &str, sd: &str| {
        let vary = format!("system.network.gravity.2=normal:-9.81±{sd}");
        let flags = ["--vary", &vary, "--samples", "16", "--plot", "chain.tension_max.peak"];
        let (table, told) = sample(&bench, out, &flags);
        assert_eq!(table.rows.len(), 16, "runs beside the sample are no rows");
        of(&told, "chain.tension_max.peak")["errors"].clone()
    };
    let (narrow, wide) = (compare("narrow", "1e-9"), compare("wide", "3"));
    assert!(number(&narrow["step"]) > 0.0 && number(&narrow["mesh"]) > 0.0, "{narrow}");
    assert_eq!(narrow["largest"], "mesh");
    assert_eq!(wide["largest"], "scatter", "{wide}");
    assert!((number(&narrow["step"]) - number(&wide["step"])).abs() < 1e-12, "both are at the medians");
}

/// Saltelli's design: of a deflection m a/k both are told, and a key without effect has none.
#[test]
fn indices_by_saltellis_design() {
    let bench = spring();
    let flags =
        ["--vary", &format!("{FORCE}=uniform:9..11"), "--vary", "system.network.gravity.1=uniform:-0.001..0.001"];
    let more = ["--samples", "32", "--indices", "--sampling", "sobol", "--no-errors", "--plot", DEFLECTION];
    let (table, told) = sample(&bench, "out", &[&flags[..], &more[..]].concat());
    assert_eq!(table.rows.len(), 32 * 4);
    let deflection = of(&told, DEFLECTION);
    assert_eq!(deflection["runs"], 64, "A and B are the sample");
    for kind in ["first", "total"] {
        let index = |i: usize| number(&deflection["indices"][i][kind]["value"]);
        assert!((index(0) - 1.0).abs() < 0.05 && index(1).abs() < 0.05, "{kind}: {deflection}");
    }
}

/// The ellipse of two columns that are asked for: independent displacements to two sides.
#[test]
fn two_columns_have_an_ellipse() {
    let bench = falling();
    let gauges = r#"output.gauges=[{"name":"mass","on":{"ids":[0]},"of":"position"}]"#;
    let flags = ["--set", gauges, "--vary", "system.network.initial.velocity.0=normal:0±2"];
    let more = ["--vary", "system.network.initial.velocity.1=normal:0±1", "--samples", "100", "--end", "1"];
    let last = ["--set", "system.network.aero=null", "--ellipse", "mass.position_x.last,mass.position_y.last"];
    let (_, told) = sample(&bench, "out", &[&flags[..], &more[..], &last[..]].concat());
    let landing = &told["scatter"]["landing"];
    let deviations = [0, 1].map(|i| number(&landing["deviations"][i]));
    // Free flight of one second: as many metres as m/s.
    assert!((deviations[0] - 2.0).abs() < 0.25 && (deviations[1] - 1.0).abs() < 0.15, "{landing}");
    assert!(number(&landing["within"]) > 0.88, "{landing}");
    assert!(Results(bench.path("out")).text("sweep.svg").contains("95 % ellipse"));
}

#[test]
fn bad_input_is_refused() {
    let bench = spring();
    let normal = format!("{FORCE}=normal:10±1");
    let cases: [(&[&str], &[&str]); 8] = [
        (&["--vary", &normal], &["--samples N"]),
        (&["--vary", &format!("{FORCE}=normal:10"), "--samples", "9"], &["standard deviation is missing"]),
        (&["--vary", "system.network.mass.nodal=normal:1±1", "--samples", "99"], &["system.network.mass.nodal=-"]),
        (&["--vary", &normal, "--samples", "9", "--until", "2% x"], &["p99 COLUMN"]),
        (&["--vary", &normal, "--samples", "9", "--indices", "--until", "2% of p99 x"], &["cannot be used with"]),
        (&["--vary", &normal, "--samples", "9", "--ellipse", "a"], &["two columns"]),
        (&["--vary", "rows:none.csv", "--samples", "9"], &["none.csv"]),
        (&["--vary", &normal, "--seed", "3"], &["--samples"]),
    ];
    for (flags, words) in cases {
        let ended = bench.run(&[&["sweep", "case.json", "--out", "out"], flags].concat());
        assert_eq!(ended.code, Some(2), "{flags:?}: {}", ended.stderr);
        for word in words {
            assert!(ended.stderr.contains(word), "{flags:?} without {word}: {}", ended.stderr);
        }
        assert!(!bench.path("out").exists(), "{flags:?} left something");
    }
    // A rule for a column that is not there is told with those that are.
    let flags = ["--vary", &normal, "--samples", "9", "--until", "2% of p99 way"];
    let ended = bench.run(&[&["sweep", "case.json", "--out", "out"], &flags[..]].concat());
    assert!(ended.code == Some(2) && ended.stderr.contains(DEFLECTION), "{}", ended.stderr);
}
