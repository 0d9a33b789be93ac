//! `canopy-fem static` as a user meets it: exit statuses, messages, files, and runs that begin where it ended.

use crate::bench::{Bench, Ended, Results};
use crate::common::octahedron;
use serde_json::{Value, json};

/// [m/s^2]
const G: f64 = 9.81;

/// A case without a `time` section.
fn case(network: Value) -> Value {
    json!({"name": "sail", "system": {"network": network}})
}

fn rest(bench: &Bench, case: &Value, arguments: &[&str]) -> Ended {
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    bench.run(&[&["static", "case.json", "--out", "out"], arguments].concat())
}

/// A weight that hangs below a bar, from a start beside it.
fn weight() -> Value {
    json!({
        "mesh": {"explicit": {"nodes": [[0, 0, 0], [0.5, 0, 0]], "springs": [[0, 1]]}},
        "mass": {"nodal": 2.0},
        "springs": [{"on": "all", "stiffness": 100.0, "rest_length": 1.0}],
        "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
        "gravity": [0, 0, -G]
    })
}

/// Closed forms of position, tension and frequencies in the files, without a `time` section in the case.
#[test]
fn an_equilibrium_is_written() {
    let bench = Bench::new();
    let mut case = case(weight());
    case["output"] = json!({
        "fields": ["tension"],
        "gauges": [{"name": "bar", "on": "all", "of": "tension"}],
        "probes": [{"name": "weight", "on": {"ids": [1]}}]
    });
    let ended = rest(&bench, &case, &["--modes", "3"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert_eq!(ended.stderr, "", "no warning of steps that are not made");
    let results = bench.results();
    let length = 1.0 + 2.0 * G / 100.0;
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
    near(results.table("probes.csv").column("z")[0], -length);
    near(results.table("gauges.csv").column("value")[0], 2.0 * G);
    let frames = results.frames();
    assert_eq!(frames.len(), 1);
    near(frames[0].1.floats("displacement")[5], -length);
    let summary = results.summary();
    assert_eq!([&summary["status"], &summary["method"]], [&json!("completed"), &json!("static")]);
    let found = &summary["equilibrium"];
    assert_eq!([&found["stability"], &found["findings"]], [&json!("stable"), &json!([])]);
    let potential = 0.5 * 100.0 * (length - 1.0).powi(2) - 2.0 * G * length;
    near(found["potential_energy"].as_f64().expect("a number"), potential);
    assert!(found["residual"].as_f64().expect("a number") < 1e-9);
    let modes = results.table("modes.csv");
    let swing = (G / length).sqrt() / std::f64::consts::TAU;
    let bounce = 50.0_f64.sqrt() / std::f64::consts::TAU;
    for (found, expected) in modes.column("frequency").into_iter().zip([swing, swing, bounce]) {
        near(found, expected);
    }
    // All of the weight moves in the third mode, along z.
    near(modes.column("mass_z")[2], 2.0);
    let shapes = Results(bench.path("out/modes")).frames();
    assert_eq!(shapes.len(), 3);
    let bouncing = shapes[2].1.floats("displacement");
    assert!(bouncing[5] > 0.0 && bouncing[..5].iter().all(|x| x.abs() < 1e-9), "{bouncing:?}");
}

/// A run from the folder of an equilibrium stays there.
#[test]
fn a_run_begins_at_the_equilibrium() {
    let bench = Bench::new();
    assert_eq!(rest(&bench, &case(weight()), &["--quiet"]).code, Some(0));
    let mut run = case(weight());
    run["system"]["network"]["initial"] = json!({"from": "out"});
    run["time"] = json!({"end": 3.0, "method": "rk4", "step": 0.01});
    std::fs::write(bench.path("run.json"), run.to_string()).expect("written");
    let ended = bench.run(&["solve", "run.json", "--out", "run"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let fastest = Results(bench.path("run")).table("history.csv").column("max_speed");
    assert!(fastest.iter().all(|v| *v < 1e-6), "{fastest:?}");
}

/// What nothing holds is named, with the sum of its loads, before anything is computed.
#[test]
fn a_part_that_falls_is_named() {
    let bench = Bench::new();
    let mut network = weight();
    network["mesh"] = json!({"explicit": {
        "nodes": [[0, 0, 0], [0.5, 0, 0], [0, 3, 0], [1, 3, 0]], "springs": [[0, 1], [2, 3]],
        "groups": {"payload": {"nodes": [2, 3]}}
    }});
    let ended = rest(&bench, &case(network), &[]);
    assert_eq!(ended.code, Some(3), "{}", ended.stderr);
    for words in ["no support holds nodes 2, 3 (group payload) in z", "-39.24 N", "hold a node of this part in z"] {
        assert!(ended.stderr.contains(words), "no \"{words}\" in\n{}", ended.stderr);
    }
    let summary = bench.results().summary();
    assert_eq!([&summary["status"], &summary["failure"]["node"]], [&json!("not-converged"), &json!(2)]);
    assert!(summary["counters"].is_null() && summary["newton_iterations"] == json!(0));
}

/// A body that the wind blows away ends, too.
#[test]
fn a_body_that_is_blown_away_is_no_equilibrium() {
    let bench = Bench::new();
    let network = json!({
        "mesh": {"rectangle": {"width": 1, "height": 1, "columns": 4, "rows": 4}},
        "mass": {"areal_density": 0.2},
        "springs": [{"on": "all", "stiffness": 1000.0, "slack": "tension-only"}],
        "aero": {"wind": [0, 0, 10], "law": {"pressure_coefficient": {"cp": 1.2, "air_density": 1.225}}}
    });
    let ended = rest(&bench, &case(network), &[]);
    assert_eq!(ended.code, Some(3), "{}", ended.stderr);
    assert!(ended.stderr.contains("no support holds the scene in z"), "{}", ended.stderr);
}

/// The iterations of a case are a bound: what is left, where, and advice, never a success.
#[test]
fn too_few_iterations_are_a_failure() {
    let bench = Bench::new();
    let mut network = weight();
    // A soft flat net that is held along one side: it hangs down and grows to twice its length.
    network["mesh"] = json!({"rectangle": {"width": 1.0, "height": 1.0, "columns": 40, "rows": 40}});
    network["mass"] = json!({"areal_density": 0.2});
    network["springs"] = json!([{"on": "all", "stiffness": 10.0}]);
    network["supports"] = json!([{"on": {"box": [[-1e-9, -1e-9, -1], [1e-9, 1.1, 1]]}, "fix": "xyz"}]);
    let few = ["--set", "solver.newton={\"max_iterations\": 1, \"relative\": 1e-14}"];
    let ended = rest(&bench, &case(network), &few);
    assert_eq!(ended.code, Some(3), "{}\n{}", ended.stdout, ended.stderr);
    for words in ["iterations", "N are left, most of it at node", "apply the loads in 20 steps"] {
        assert!(ended.stderr.contains(words), "no \"{words}\" in\n{}", ended.stderr);
    }
    let summary = bench.results().summary();
    assert_eq!(summary["status"], json!("not-converged"));
    assert!(summary["newton_iterations"].as_u64().expect("a count") < 400);
}

/// Slack lines, free joints and a pole on its tip: found, named, and no failure.
#[test]
fn what_is_not_determined_is_named() {
    let bench = Bench::new();
    let finding = |network: Value, arguments: &[&str]| {
        let ended = rest(&bench, &case(network), &[&["--force"], arguments].concat());
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        let summary = bench.results().summary();
        let found = summary["equilibrium"].clone();
        let text = found["findings"][0]["text"].as_str().expect("a finding").to_owned();
        assert!(ended.stderr.contains(&text), "{text}\n{}", ended.stderr);
        (found, text)
    };
    // A line of two links without weight or pull.
    let mut slack = weight();
    slack["mesh"] = json!({"explicit": {
        "nodes": [[0, 0, 0], [0.5, 0, 0], [1, 0, 0]], "springs": [[0, 1], [1, 2]], "groups": {"line": {"edges": [0, 1]}}
    }});
    slack["supports"] = json!([{"on": {"ids": [0, 2]}, "fix": "xyz"}]);
    slack["springs"] = json!([{"on": "all", "stiffness": 100.0, "rest_length": 1.0, "slack": "tension-only"}]);
    slack["gravity"] = Value::Null;
    let (found, text) = finding(slack.clone(), &[]);
    assert_eq!([&found["findings"][0]["kind"], &found["findings"][0]["nodes"]], [&json!("slack"), &json!([1])]);
    assert!(text.contains("no spring in tension holds node 1 (group line)"), "{text}");
    // The same line straight, and as long as it is: its middle moves freely across it.
    slack["springs"] = json!([{"on": "all", "stiffness": 100.0}]);
    let (found, text) = finding(slack, &[]);
    assert_eq!(found["stability"], json!("neutral"));
    assert!(text.contains("2 motions, mostly of node 1") && text.contains("mechanism"), "{text}");
    let mut pole = weight();
    pole["mesh"] = json!({"explicit": {"nodes": [[0, 0, 0], [0, 0, 1]], "springs": [[0, 1]]}});
    let (found, text) = finding(pole, &["--modes", "3"]);
    assert_eq!(found["stability"], json!("unstable"));
    assert!(text.contains("unstable: 2 motions, mostly of node 1"), "{text}");
    let squares = bench.results().table("modes.csv").column("omega_squared");
    let expected = -G / (1.0 - 2.0 * G / 100.0);
    assert!(squares[..2].iter().all(|w| (w / expected - 1.0).abs() < 1e-9), "{squares:?} for {expected}");
}

/// Loads and supports as they are at a time.
#[test]
fn loads_are_those_of_the_time() {
    let bench = Bench::new();
    let mut network = weight();
    network["loads"] = json!([{"on": {"ids": [1]}, "force": [0, 0, -10], "table": [[0, 0], [2, 1]]}]);
    let mut case = case(network);
    case["output"] = json!({"gauges": [{"name": "bar", "on": "all", "of": "tension"}]});
    for (at, load) in [("0", 0.0), ("1", 5.0), ("7.5", 10.0)] {
        let ended = rest(&bench, &case, &["--at", at, "--force", "--quiet"]);
        assert_eq!((ended.code, ended.stdout.as_str()), (Some(0), ""), "{}", ended.stderr);
        let row = bench.results().table("gauges.csv");
        let (t, tension) = (row.column("t")[0], row.column("value")[0]);
        assert!((tension - 2.0 * G - load).abs() < 1e-8 && t == at.parse::<f64>().expect("a number"), "{t}: {tension}");
    }
    assert_eq!(rest(&bench, &case, &["--at", "-1", "--force"]).code, Some(2));
}

/// Steps of the load lead to the same place.
#[test]
fn load_steps_change_the_way_only() {
    let bench = Bench::new();
    let mut case = case(weight());
    case["output"] = json!({"probes": [{"name": "weight", "on": {"ids": [1]}}]});
    let ended = rest(&bench, &case, &["--load-steps", "7"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let z = bench.results().table("probes.csv").column("z")[0];
    assert!((z + 1.0 + 2.0 * G / 100.0).abs() < 1e-9, "{z}");
    let steps = bench.results().summary()["equilibrium"]["load_steps"].as_u64().expect("a count");
    // Equal ones at first, longer ones where they are easy.
    assert!((3..=7).contains(&steps), "{steps} load steps");
}

/// Earlier results are kept without --force, and removed with it, modes among them.
#[test]
fn earlier_results_are_kept_without_force() {
    let bench = Bench::new();
    assert_eq!(rest(&bench, &case(weight()), &["--quiet", "--modes", "1"]).code, Some(0));
    let refused = rest(&bench, &case(weight()), &["--quiet"]);
    assert!(refused.code == Some(2) && refused.stderr.contains("--force"), "{}", refused.stderr);
    assert_eq!(rest(&bench, &case(weight()), &["--quiet", "--force"]).code, Some(0));
    assert!(!bench.path("out/modes.csv").exists() && !bench.path("out/modes").exists());
    let too_many = rest(&bench, &case(weight()), &["--quiet", "--force", "--modes", "4"]);
    assert_eq!(too_many.code, Some(3));
    assert!(too_many.stderr.contains("4 modes were asked for, but the scene has 3"), "{}", too_many.stderr);
}

/// The bits are the same for one thread and for two; a scene above 2,000 nodes uses both.
#[test]
fn threads_change_no_bit() {
    let bench = Bench::new();
    let disc = case(json!({
        "mesh": {"annulus": {"inner_radius": 0.1, "outer_radius": 1.0, "nodes": 2600, "boundary_nodes": 240}},
        "mass": {"areal_density": 0.3},
        "springs": [{"on": "all", "stiffness": 1000.0, "slack": "tension-only"}],
        "supports": [{"on": "outer", "fix": "xyz"}],
        "loads": [{"on": "all", "pressure": 50.0}]
    }));
    let bytes = |threads: &str| {
        let ended = rest(&bench, &disc, &["--quiet", "--force", "--modes", "4", "--threads", threads]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        ["frames/sail_000000.vtu", "modes.csv", "modes/frames/sail_000003.vtu", "history.csv"]
            .map(|file| std::fs::read(bench.path("out").join(file)).expect("a file"))
    };
    assert!(bytes("1") == bytes("2"));
}

/// A prism of struts and strings that stress each other, held by nothing: its start is its equilibrium, and from a
/// start beside it the search comes back to its shape.
#[test]
fn a_free_body_under_its_own_stress_rests() {
    let bench = Bench::new();
    let turn = |radius: f64, degrees: f64, z: f64| {
        let angle = degrees.to_radians();
        [radius * angle.cos(), radius * angle.sin(), z]
    };
    let nodes: Vec<[f64; 3]> = (0..6)
        .map(
            |i| if i < 3 { turn(0.8, 120.0 * f64::from(i), 0.0) } else { turn(0.8, 120.0 * f64::from(i) - 210.0, 1.3) },
        )
        .collect();
    let (ring, struts, strings) =
        ([[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3]], [[0, 3], [1, 4], [2, 5]], [[0, 5], [1, 3], [2, 4]]);
    // The stress of a twist of 150 degrees: force densities 1 in the rings, sqrt(3) in the strings, -sqrt(3) in struts.
    let distance = |[a, b]: [usize; 2]| (0..3).map(|c| (nodes[a][c] - nodes[b][c]).powi(2)).sum::<f64>().sqrt();
    let density = 30.0;
    let springs: Vec<[usize; 2]> = [&ring[..], &struts, &strings].concat();
    let rules = springs.iter().enumerate().map(|(edge, &pair)| {
        let share = if edge < 6 {
            1.0
        } else if edge < 9 {
            -3.0_f64.sqrt()
        } else {
            3.0_f64.sqrt()
        };
        // k (l - l0) = q l
        let rest = distance(pair) * (1.0 - share * density / 4000.0);
        json!({"on": {"ids": [edge]}, "stiffness": 4000.0, "rest_length": rest})
    });
    let mut network = json!({
        "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
        "mass": {"nodal": 0.7},
        "springs": rules.collect::<Vec<Value>>()
    });
    let ended = rest(&bench, &case(network.clone()), &["--modes", "18"]);
    assert_eq!(ended.code, Some(0), "{}{}", ended.stdout, ended.stderr);
    let summary = bench.results().summary();
    let found = &summary["equilibrium"];
    assert!(summary["newton_iterations"].as_u64().expect("a count") <= 1, "{summary}");
    assert!(found["residual"].as_f64().expect("a number") < 1e-11, "{found}");
    assert!(found["residual_scale"].as_f64().expect("a number") > 100.0, "{found}");
    let frequencies = bench.results().table("modes.csv").column("frequency");
    assert!(frequencies.len() == 18 && frequencies[..6].iter().all(|f| *f == 0.0), "{frequencies:?}");
    assert!(frequencies[6] > 0.1, "{frequencies:?}");
    network["initial"] =
        json!({"displacement": [[0.02, 0, 0], [0, 0.01, 0], [0, 0, 0.01], [0, 0, 0], [0, 0, 0], [0, 0, 0]]});
    let ended = rest(&bench, &case(network), &["--force"]);
    assert_eq!(ended.code, Some(0), "{}{}", ended.stdout, ended.stderr);
    let lengths = bench.results().frames();
    let moved = lengths[0].1.floats("displacement");
    let at = |node: usize, c: usize| nodes[node][c] + moved[3 * node + c];
    for &[a, b] in &springs {
        let length = (0..3).map(|c| (at(a, c) - at(b, c)).powi(2)).sum::<f64>().sqrt();
        assert!((length / distance([a, b]) - 1.0).abs() < 1e-6, "{a}-{b}: {length}");
    }
}

/// A line that is much longer than the place it is packed in hangs where its rest lengths let it: nothing diverges.
#[test]
fn a_packed_line_hangs_at_its_length() {
    let bench = Bench::new();
    let mut network = json!({
        "mesh": {"chain": {"from": [0, 0, 0], "to": [0, 0, -0.02], "segments": 10}},
        "mass": {"nodal": 0.1, "points": [{"on": {"ids": [10]}, "mass": 5.0}]},
        "springs": [{"on": "all", "stiffness": 20000.0, "slack": "tension-only", "rest_length": 6.0}],
        "gravity": [0, 0, -G],
        "supports": [{"on": {"ids": [0]}, "fix": "xyz"}]
    });
    let depth = |network: &Value, arguments: &[&str]| {
        let mut case = case(network.clone());
        case["output"] = json!({"probes": [{"name": "end", "on": {"ids": [10]}}]});
        let ended = rest(&bench, &case, &[&["--force"], arguments].concat());
        assert_eq!(ended.code, Some(0), "{}{}", ended.stdout, ended.stderr);
        -bench.results().table("probes.csv").column("z")[0]
    };
    // Every segment carries 5 kg and the nodes below it.
    let stretched = (1..=10).map(|segment| G * (5.0 + 0.1 * f64::from(11 - segment)) / 20000.0).sum::<f64>();
    let found = depth(&network, &[]);
    assert!((found - 60.0 - stretched).abs() < 1e-6, "{found} for {}", 60.0 + stretched);
    // The same by a reel that lets the line out.
    network["springs"][0]["rest_length"] = json!(0.002);
    network["springs"][0]["rest_scale"] = json!({"table": [[0, 1], [1, 3000]]});
    let found = depth(&network, &["--at", "1"]);
    assert!((found - 60.0 - stretched).abs() < 1e-6, "{found} for {}", 60.0 + stretched);
}

/// Air at rest carries nothing: that a free parachute has no equilibrium is said before anything is computed. In a wind
/// that may carry it the search is made.
#[test]
fn a_free_body_in_still_air_is_told_at_once() {
    let bench = Bench::new();
    let mut network = json!({
        "mesh": {"rectangle": {"width": 1, "height": 1, "columns": 4, "rows": 4}},
        "mass": {"areal_density": 0.2},
        "springs": [{"on": "all", "stiffness": 1000.0, "slack": "tension-only"}],
        "gravity": [0, 0, -G],
        "initial": {"velocity": [0, 0, -5]},
        "aero": {"wind": [0, 0, 0], "law": {"pressure_coefficient": {"cp": 1.2, "air_density": 1.225}}}
    });
    let ended = rest(&bench, &case(network.clone()), &[]);
    assert_eq!(ended.code, Some(3), "{}", ended.stderr);
    for words in ["no support holds the scene in z", "-1.962 N"] {
        assert!(ended.stderr.contains(words), "no \"{words}\" in\n{}", ended.stderr);
    }
    assert_eq!(bench.results().summary()["newton_iterations"], json!(0));
    // A wind across the weight cannot carry it either; one from below may.
    let mut across = network.clone();
    across["aero"]["wind"] = json!([6, 2, 0]);
    let ended = rest(&bench, &case(across), &["--force"]);
    assert!(ended.code == Some(3) && ended.stderr.contains("add up to -1.962 N"), "{}", ended.stderr);
    assert_eq!(bench.results().summary()["newton_iterations"], json!(0));
    network["aero"]["wind"] = json!([0, 0, 1.6336]);
    rest(&bench, &case(network), &["--force"]);
    assert!(bench.results().summary()["newton_iterations"].as_u64().expect("a count") > 0);
}

/// A cloth that hangs on one corner swings about it and is slack in part; it has all the modes that are asked for.
#[test]
fn a_cloth_on_one_corner_has_modes() {
    let bench = Bench::new();
    let cloth = case(json!({
        "mesh": {"rectangle": {"width": 1, "height": 1, "columns": 6, "rows": 6}},
        "mass": {"areal_density": 0.2},
        "springs": [{"on": "all", "stiffness": 1000.0}],
        "gravity": [0, 0, -G],
        "supports": [{"on": {"ids": [0]}, "fix": "xyz"}]
    }));
    for count in ["5", "40"] {
        let ended = rest(&bench, &cloth, &["--modes", count, "--force"]);
        assert_eq!(ended.code, Some(0), "{}{}", ended.stdout, ended.stderr);
        let modes = bench.results().table("modes.csv");
        let (squares, errors) = (modes.column("omega_squared"), modes.column("error"));
        assert_eq!(squares.len().to_string(), count);
        assert!(squares.windows(2).all(|pair| pair[0] <= pair[1]), "{squares:?}");
        let last = squares.last().expect("a mode");
        assert!(errors.iter().all(|error| *error < 1e-6 * last), "{errors:?} of {last}");
    }
}

/// The modes of a closed surface under pressure have its pressure in them; that the stiffness of an open one is not
/// symmetric is said.
#[test]
fn pressure_is_part_of_the_modes() {
    let bench = Bench::new();
    let mut network = octahedron();
    network["loads"] = json!([{"on": "all", "pressure": 300.0}]);
    let ended = rest(&bench, &case(network.clone()), &["--modes", "18"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(!ended.stdout.contains("not symmetric"), "{}", ended.stdout);
    // By an eigenvalue solver for dense matrices.
    let expected = [(0.0, 6), (7.89146, 3), (8.18052, 2), (10.73586, 3), (12.60756, 3), (13.56684, 1)];
    let expected = expected.iter().flat_map(|&(frequency, times)| std::iter::repeat_n(frequency, times));
    let found = bench.results().table("modes.csv").column("frequency");
    assert_eq!(found.len(), 18);
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 5e-6, "{found} for {expected}");
    }
    let summary = bench.results().summary();
    assert_eq!(summary["equilibrium"]["modes_symmetric"], json!(true));
    assert_eq!(summary["equilibrium"]["growing"], json!([]));
    network["loads"] = json!([{"on": {"ids": [0]}, "pressure": 30.0}]);
    network["supports"] = json!([{"on": {"ids": [1, 3, 5]}, "fix": "xyz"}]);
    let ended = rest(&bench, &case(network), &["--modes", "4", "--force"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stdout.contains("of the symmetric part of the tangent"), "{}", ended.stdout);
    assert_eq!(bench.results().summary()["equilibrium"]["modes_symmetric"], json!(false));
}
