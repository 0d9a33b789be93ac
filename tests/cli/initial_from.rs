//! A run that begins where another ended.

use crate::bench::{Bench, Ended};
use serde_json::{Value, json};

/// Two masses on springs that swing for `end` [s]; nothing depends on the time.
fn case(end: f64) -> Value {
    json!({
        "name": "chain",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "springs": [[0, 1], [1, 2]]}},
            "mass": {"nodal": 0.5},
            "springs": [{"on": "all", "stiffness": 80.0, "rest_scale": 0.9, "dashpot": {"axial": {"coefficient": 0.3}}}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "gravity": [0, 0, -9.81],
            "initial": {"velocity": [0, 1, 0]}
        }},
        "time": {"end": end, "method": "rk4", "step": 0.001}
    })
}

fn solve(bench: &Bench, case: &Value, out: &str, more: &[&str]) -> Ended {
    let file = format!("{out}.json");
    std::fs::write(bench.path(&file), case.to_string()).expect("written");
    bench.run(&[&["solve", &file, "--out", out], more].concat())
}

/// Probes at the end: positions and velocities of all nodes.
fn last(bench: &Bench, out: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(bench.path(out).join("probes.csv")).expect("probes");
    let rows: Vec<&str> = text.lines().skip(1).collect();
    let cells = rows[rows.len() - 3..].iter().flat_map(|row| row.split(',').skip(3));
    cells.map(|cell| cell.parse().expect("a number")).collect()
}

fn probed(mut case: Value) -> Value {
    case["output"] = json!({"probes": [{"name": "all", "on": "all"}]});
    case
}

/// Two halves, the second from the folder of the first or from its last frame, end as one whole run.
#[test]
fn a_run_goes_on_from_the_end_of_another() {
    let bench = Bench::new();
    assert_eq!(solve(&bench, &probed(case(1.0)), "whole", &[]).code, Some(0));
    assert_eq!(solve(&bench, &probed(case(0.4)), "first", &[]).code, Some(0));
    for (out, from) in [("folder", json!("first")), ("frame", json!({"frame": "first/frames/chain_000001.vtu"}))] {
        let mut second = probed(case(0.6));
        second["system"]["network"]["initial"] = json!({"from": from});
        let ended = solve(&bench, &second, out, &[]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        for (found, expected) in last(&bench, out).iter().zip(last(&bench, "whole")) {
            assert!((found - expected).abs() < 1e-11, "{out}: {found} for {expected}");
        }
    }
}

/// Displacement and velocity of the case are added; what is held now stands still; stiffness and method may differ.
#[test]
fn the_case_adds_to_it() {
    let bench = Bench::new();
    assert_eq!(solve(&bench, &probed(case(0.4)), "first", &[]).code, Some(0));
    let mut second = probed(case(0.001));
    let network = &mut second["system"]["network"];
    network["initial"] = json!({"from": "first", "displacement": [0.25, 0, 0], "velocity": [0, 0, 0.5]});
    network["supports"] = json!([{"on": {"ids": [1]}, "fix": "xyz"}]);
    network["springs"][0]["stiffness"] = json!(20.0);
    second["time"]["method"] = json!("newmark");
    let ended = solve(&bench, &second, "second", &[]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let text = std::fs::read_to_string(bench.path("second").join("probes.csv")).expect("probes");
    let first: Vec<f64> = text
        .lines()
        .skip(1)
        .take(3)
        .flat_map(|row| row.split(',').skip(3))
        .map(|cell| cell.parse().expect("a number"))
        .collect();
    let before = last(&bench, "first");
    for node in 0..3 {
        let shift = |i: usize| if node != 1 { [0.25, 0.0, 0.0, 0.0, 0.0, 0.5][i] } else { 0.0 };
        for i in 0..6 {
            let kept = if node == 1 && i > 2 { 0.0 } else { before[6 * node + i] };
            let (found, expected) = (first[6 * node + i], kept + shift(i));
            assert!((found - expected).abs() < 1e-14, "node {node}, {i}: {found} for {expected}");
        }
    }
}

#[test]
fn another_mesh_and_missing_results_are_refused() {
    let bench = Bench::new();
    assert_eq!(solve(&bench, &case(0.01), "first", &[]).code, Some(0));
    let from = |change: &dyn Fn(&mut Value), from: Value| {
        let mut second = case(0.01);
        second["system"]["network"]["initial"] = json!({"from": from});
        change(&mut second["system"]["network"]);
        solve(&bench, &second, "second", &["--force"])
    };
    let nodes = "/mesh/explicit/nodes";
    let moved = from(
        &|network| *network.pointer_mut(nodes).expect("nodes") = json!([[0, 0, 0], [1, 0, 0], [3, 0, 0]]),
        json!("first"),
    );
    let fewer = from(
        &|network| network["mesh"]["explicit"] = json!({"nodes": [[0, 0, 0], [1, 0, 0]], "springs": [[0, 1]]}),
        json!("first"),
    );
    let missing = from(&|_| {}, json!("nowhere"));
    let no_frame = from(&|_| {}, json!({"frame": "first.json"}));
    for (ended, words) in [
        (moved, "node 2 is elsewhere on the mesh"),
        (fewer, "has 3 nodes, the mesh of this case 2"),
        (missing, "a folder with the results of a run"),
        (no_frame, "a frame (.vtu) of a run"),
    ] {
        assert_eq!(ended.code, Some(2), "{}", ended.stderr);
        assert!(
            ended.stderr.contains("/system/network/initial/from") && ended.stderr.contains(words),
            "{}",
            ended.stderr
        );
    }
}

/// Who tries to resume with another case is told how to go on.
#[test]
fn resume_names_it() {
    let bench = Bench::new();
    let mut kept = case(0.01);
    kept["output"] = json!({"checkpoint": {"every": 0.005}});
    assert_eq!(solve(&bench, &kept, "first", &[]).code, Some(0));
    kept["system"]["network"]["springs"][0]["stiffness"] = json!(81.0);
    let ended = solve(&bench, &kept, "first", &["--resume"]);
    assert!(ended.stderr.contains("system.network.initial.from"), "{}", ended.stderr);
}
