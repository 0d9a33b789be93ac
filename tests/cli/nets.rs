//! Nets of cables and bars: prestress that a form hands on, edges that only carry loads, supports that settle, and what
//! `static` and `check` say of them.

use crate::bench::{Bench, Ended, Results};
use serde_json::{Value, json};

fn case(name: &str, network: Value) -> Value {
    json!({"name": "sail", "description": name, "system": {"network": network}, "output": {
        "fields": ["tension"],
        "gauges": [{"name": "net", "on": "all", "of": "tension"}],
        "probes": [{"name": "all", "on": "all"}]
    }})
}

fn rest(bench: &Bench, case: &Value, out: &str, more: &[&str]) -> Ended {
    let file = format!("{out}.json");
    std::fs::write(bench.path(&file), case.to_string()).expect("written");
    bench.run(&[&["static", &file, "--out", out, "--force"], more].concat())
}

/// Runs `static`, which finds an equilibrium without a warning.
fn settle(bench: &Bench, case: &Value, out: &str, more: &[&str]) -> Results {
    let ended = rest(bench, case, out, more);
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""), "{}", ended.stdout);
    Results(bench.path(out))
}

/// Positions of all nodes, one number after the other.
fn positions(results: &Results) -> Vec<f64> {
    let rows = results.table("probes.csv");
    let [x, y, z] = ["x", "y", "z"].map(|axis| rows.column(axis));
    x.into_iter().zip(y).zip(z).flat_map(|((x, y), z)| [x, y, z]).collect()
}

fn tensions(results: &Results) -> Vec<f64> {
    results.frames().last().expect("a frame").1.floats("tension")
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

/// The largest value that an equilibrium reports of a quantity.
fn largest(results: &Results, quantity: &str) -> Value {
    let summary = results.summary();
    let all = summary["equilibrium"]["largest"].as_array().expect("a list").clone();
    all.into_iter().find(|value| value["quantity"] == quantity).unwrap_or_else(|| panic!("no {quantity} in {summary}"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// A net over four corners, two of them high, with springs by some rules. Its edges are in two groups.
fn net(rules: Value) -> Value {
    json!({
        "mesh": {"explicit": {
            "nodes": [
                [0, 0, 0], [1, 0, 0.5], [2, 0, 1], [0, 1, 0.5], [1, 1, 0], [2, 1, 0.5], [0, 2, 1], [1, 2, 0.5], [2, 2, 0]
            ],
            "springs": [[1, 4], [3, 4], [4, 5], [4, 7], [0, 1], [0, 4]],
            "groups": {"up": {"edges": [0, 3]}, "across": {"edges": [1, 2]}, "rim": {"edges": [4]}, "strut": {"edges": [5]}}
        }},
        "mass": {"nodal": 0.1},
        "springs": rules,
        "supports": [{"on": {"ids": [0, 1, 2, 3, 5, 6, 7, 8]}, "fix": "xyz"}]
    })
}

/// The form of that net by force densities, one of them below 0.
fn form(bench: &Bench) -> Results {
    let rules = json!([
        {"on": {"group": "up"}, "stiffness": 70.0, "rest_length": 0.0},
        {"on": {"group": "across"}, "stiffness": 50.0, "rest_length": 0.0},
        {"on": {"group": "strut"}, "stiffness": 1000.0, "rest_length": 1.6},
        {"on": {"group": "rim"}, "stiffness": 1000.0, "slack": "tension-only", "rest_length": 1.5}
    ]);
    settle(bench, &case("form", net(rules)), "form", &[])
}

/// Real springs of every law take up the tensions of a form: what follows begins in its equilibrium, at rest and in a
/// run, and has its tensions.
#[test]
fn springs_keep_the_tensions_of_a_form() {
    let bench = Bench::new();
    let form = form(&bench);
    let (places, forces) = (positions(&form), tensions(&form));
    assert!(forces[5] < -1.0 && forces[0] > 10.0 && forces[4] == 0.0, "{forces:?}");
    let table = json!({"table": [[-0.1, -1e4], [0, 0], [1e-3, 200], [0.1, 4e4]]});
    let laws = [
        json!([{"on": "all", "axial_rigidity": 2e4}]),
        json!([{"on": "all", "stiffness": 3e4}]),
        json!([{"on": "all", "axial_rigidity": 2e3, "law": "green"}]),
        json!([{"on": "all", "stiffness": 3e3, "law": "green"}]),
        json!([{"on": "all", "law": table}]),
        json!([
            {"on": {"ids": [0, 1, 2, 3]}, "axial_rigidity": 2e4, "slack": {"dead_zone": 0.05}},
            {"on": {"ids": [4]}, "axial_rigidity": 2e4, "slack": "tension-only"},
            {"on": {"ids": [5]}, "axial_rigidity": 2e4, "slack": "compression-only"}
        ]),
        // Two springs at an edge share its tension.
        json!([{"on": {"group": "up"}, "axial_rigidity": 5e4}, {"on": "all", "stiffness": 1e4}]),
    ];
    for rules in laws {
        let mut real = case("net", net(rules.clone()));
        real["system"]["network"]["initial"] = json!({"from": "form", "keep": "tensions"});
        let found = settle(&bench, &real, "net", &[]);
        assert!(apart(&tensions(&found), &forces) < 1e-9 * 70.0, "{rules}: {:?} for {forces:?}", tensions(&found));
        assert!(apart(&positions(&found), &places) < 1e-9, "{rules}: {:?}", positions(&found));
        let summary = found.summary();
        assert!(number(&summary["equilibrium"]["residual"]) < 1e-9, "{rules}: {summary}");
        real["time"] = json!({"end": 0.2, "method": "rk4", "step": 1e-4});
        std::fs::write(bench.path("run.json"), real.to_string()).expect("written");
        let ended = bench.run(&["solve", "run.json", "--out", "run", "--force"]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        let fastest = Results(bench.path("run")).table("history.csv").column("max_speed");
        assert!(fastest.iter().all(|speed| *speed < 1e-9), "{rules}: {fastest:?}");
    }
}

/// A slack spring keeps its rest length, a load changes the net, and a third run goes on from there.
#[test]
fn a_loaded_net_is_taken_up_again() {
    let bench = Bench::new();
    form(&bench);
    let rules = json!([
        {"on": {"ids": [0, 1, 2, 3, 5]}, "axial_rigidity": 2e4},
        {"on": {"ids": [4]}, "stiffness": 1000.0, "slack": "tension-only"}
    ]);
    let mut loaded = case("loaded", net(rules));
    let network = &mut loaded["system"]["network"];
    network["loads"] = json!([{"on": {"ids": [4]}, "force": [3, 0, -40]}]);
    network["initial"] = json!({"from": "form", "keep": "tensions"});
    let first = settle(&bench, &loaded, "loaded", &[]);
    assert!(number(&largest(&first, "displacement")["value"]) > 1e-3);
    let rest_length = first.frames()[0].1.floats("rest_length");
    assert_eq!(rest_length[4], 1.5);
    for keep in ["tensions", "rest_lengths"] {
        loaded["system"]["network"]["initial"] =
            json!({"from": {"frame": "loaded/frames/sail_000000.vtu"}, "keep": keep});
        let again = settle(&bench, &loaded, "again", &[]);
        assert!(apart(&tensions(&again), &tensions(&first)) < 1e-9 * 100.0, "{keep}");
        assert!(apart(&again.frames()[0].1.floats("rest_length"), &rest_length) < 1e-12, "{keep}");
    }
    // The same lengths as a list, from the mesh as given.
    loaded["system"]["network"]["initial"] = Value::Null;
    loaded["system"]["network"]["springs"][0]["rest_length"] = json!(rest_length);
    let listed = settle(&bench, &loaded, "listed", &[]);
    assert!(apart(&positions(&listed), &positions(&first)) < 1e-9);
}

/// What cannot be kept, and keys that do not go together, are told.
#[test]
fn what_cannot_be_kept_is_refused() {
    let bench = Bench::new();
    form(&bench);
    let refused = |change: &dyn Fn(&mut Value), words: &str| {
        let mut wrong = case("net", net(json!([{"on": "all", "axial_rigidity": 2e4}])));
        change(&mut wrong["system"]["network"]);
        let ended = rest(&bench, &wrong, "wrong", &[]);
        assert_eq!(ended.code, Some(2), "{}", ended.stdout);
        assert!(ended.stderr.contains(words), "no \"{words}\" in\n{}", ended.stderr);
    };
    let keep = json!({"from": "form", "keep": "tensions"});
    refused(&|network| network["initial"] = json!({"keep": "tensions"}), "only together with from");
    refused(
        &|network| {
            network["initial"] = keep.clone();
            network["springs"][0]["slack"] = json!("tension-only");
        },
        "does not have the tensions kept on edges 5",
    );
    refused(
        &|network| {
            network["initial"] = keep.clone();
            network["mesh"]["explicit"]["springs"] = json!([[1, 4], [3, 4], [4, 5], [4, 7], [0, 4], [0, 1]]);
            network["mesh"]["explicit"]["groups"] = json!({});
        },
        "has other edges than the mesh of this case",
    );
    refused(&|network| network["springs"][0]["rest_length"] = json!([1.0, 2.0]), "a list of 6 (one per edge)");
    refused(&|network| network["springs"][0]["loads_only"] = json!(true), "not together with loads_only");
    refused(
        &|network| network["supports"] = json!([{"on": {"ids": [0]}, "fix": "xy", "settlement": [0, 0, -0.1]}]),
        "0 in z, a direction that this support does not hold",
    );
    // A frame of a run that did not write what is kept.
    let mut run = case("run", net(json!([{"on": "all", "axial_rigidity": 2e4}])));
    run["output"] = Value::Null;
    run["time"] = json!({"end": 0.01, "method": "rk4", "step": 1e-3});
    std::fs::write(bench.path("run.json"), run.to_string()).expect("written");
    assert_eq!(bench.run(&["solve", "run.json", "--out", "run"]).code, Some(0));
    refused(&|network| network["initial"] = json!({"from": "run", "keep": "tensions"}), "has no array tension");
    refused(&|network| network["initial"] = json!({"from": "run", "keep": "rest_lengths"}), "has no array rest_length");
}

/// A square net of 2 m by 2 m with a cover of triangles, whose diagonals are no cables. The file has all their sides as
/// edges.
const COVERED: &str = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 0 2 0\nv 1 2 0\nv 2 2 0\n\
    g cables\nl 4 5 6\nl 2 5 8\ng cover\nf 1 2 5\nf 1 5 4\nf 2 3 6\nf 2 6 5\n\
    f 4 5 8\nf 4 8 7\nf 5 6 9\nf 5 9 8\n";

/// A cover without springs passes its loads on: the supports carry all of it, and the net moves as under forces at its
/// nodes.
#[test]
fn a_cover_only_carries_loads() {
    let bench = Bench::new();
    std::fs::write(bench.path("covered.obj"), COVERED).expect("written");
    let cables = json!({"on": {"group": "cables"}, "axial_rigidity": 1e4, "rest_scale": 0.99});
    let mut network = json!({
        "mesh": {"file": "covered.obj"},
        "mass": {"areal_density": 0.5},
        "springs": [{"on": {"group": "cover"}, "loads_only": true}, cables],
        "supports": [{"on": {"ids": [0, 1, 2, 3, 5, 6, 7, 8]}, "fix": "xyz"}],
        "gravity": [0, 0, -10],
        "loads": [{"on": {"group": "cover"}, "pressure": 30, "kind": "dead", "direction": [0, 0, -1]}]
    });
    let covered = settle(&bench, &case("covered", network.clone()), "covered", &[]);
    let sum = covered.summary()["equilibrium"]["reaction_sum"].clone();
    // 30 Pa and 5 Pa of weight on 4 m^2; a load on a node that is held goes straight into its support.
    assert!((number(&sum[2]) - 140.0).abs() < 1e-9 && number(&sum[0]).abs() < 1e-9, "{sum}");
    let edges = covered.frames()[0].1.floats("rest_length").iter().filter(|rest| **rest >= 0.0).count();
    assert_eq!(edges, 4, "only cables have springs");
    // The middle node has a third of six triangles of half a square metre.
    let share = 30.0;
    network["loads"] = json!([{"on": {"ids": [4]}, "force": [0, 0, -share]}]);
    let forced = settle(&bench, &case("forced", network.clone()), "forced", &[]);
    assert!(apart(&positions(&forced), &positions(&covered)) < 1e-9);
    // The same after the cables, and with a rule for all other edges.
    network["springs"] = json!([cables, {"on": "all", "loads_only": true}]);
    let other = settle(&bench, &case("other", network), "other", &[]);
    assert!(apart(&positions(&other), &positions(&forced)) < 1e-12);
}

/// Two bars in line between supports, one of which settles along them: forces follow from the stiffnesses in a row.
#[test]
fn a_settlement_stretches_bars_in_line() {
    let bench = Bench::new();
    let (k1, k2, settled) = (300.0, 500.0, 0.02);
    let network = json!({
        "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "springs": [[0, 1], [1, 2]]}},
        "mass": {"nodal": 1.0},
        "springs": [{"on": {"ids": [0]}, "stiffness": k1}, {"on": {"ids": [1]}, "stiffness": k2}],
        "supports": [
            {"on": {"ids": [0]}, "fix": "xyz"},
            {"on": {"ids": [2]}, "fix": "xyz", "settlement": [settled, 0, 0]},
            {"on": {"ids": [1]}, "fix": "yz"}
        ]
    });
    let bars = case("bars", network);
    let force = settled * k1 * k2 / (k1 + k2);
    for (steps, at_least) in [("1", 1), ("5", 3)] {
        let found = settle(&bench, &bars, "bars", &["--load-steps", steps]);
        let x = positions(&found);
        assert!((x[3] - 1.0 - force / k1).abs() < 1e-12 && (x[6] - 2.0 - settled).abs() < 1e-12, "{x:?}");
        assert!(tensions(&found).iter().all(|tension| (tension - force).abs() < 1e-9), "{:?}", tensions(&found));
        let made = found.summary()["equilibrium"]["load_steps"].as_u64().expect("a count");
        assert!(made >= at_least, "{made} steps");
        let reaction = largest(&found, "reaction");
        assert!((number(&reaction["value"]) - force).abs() < 1e-9, "{reaction}");
    }
}

/// A weight on two cables: one end settles away and down, in one step or in many, alone or by the time of a motion. The
/// sums of forces at the weight vanish, with the tensions of the lengths found.
#[test]
fn a_settling_end_of_a_cable_is_followed() {
    let bench = Bench::new();
    let (weight, rigidity, rest_length) = (50.0, 2e4, 1.25);
    let network = |support: Value| {
        json!({
            "mesh": {"explicit": {"nodes": [[-1, 0, 0], [0, 0, -0.75], [1, 0, 0]], "springs": [[0, 1], [1, 2]],
                "groups": {"left": {"edges": [0]}, "right": {"edges": [1]}, "anchor": {"nodes": [2]}}}},
            "mass": {"nodal": 1.0},
            "springs": [{"on": "all", "axial_rigidity": rigidity, "slack": "tension-only", "strength": 150.0}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, support],
            "loads": [{"on": {"ids": [1]}, "force": [0, 0, -weight]}]
        })
    };
    let settled = json!({"on": {"ids": [2]}, "fix": "xyz", "settlement": [0.3, 0, -0.2]});
    let moved = json!({"on": {"ids": [2]}, "fix": "xyz", "motion": {"table": [[0, 0, 0, 0], [2, 0.6, 0, -0.4]]}});
    let both = json!({"on": {"ids": [2]}, "fix": "xyz", "settlement": [0.2, 0, 0],
        "motion": {"table": [[0, 0, 0, 0], [2, 0.2, 0, -0.4]]}});
    let ways: [(&Value, &[&str]); 4] = [
        (&settled, &[]),
        (&settled, &["--load-steps", "8"]),
        (&moved, &["--at", "1", "--load-steps", "4"]),
        (&both, &["--at", "1"]),
    ];
    for (support, how) in ways {
        let cable = case("cable", network(support.clone()));
        let ended = rest(&bench, &cable, "cable", how);
        assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""), "{}", ended.stdout);
        let found = Results(bench.path("cable"));
        let x = positions(&found);
        assert!((x[6] - 1.3).abs() < 1e-12 && (x[8] + 0.2).abs() < 1e-12, "{x:?}");
        let mut sum = [0.0, -weight];
        let mut tightest: f64 = 0.0;
        for end in [[x[0], x[2]], [x[6], x[8]]] {
            let (dx, dz) = (end[0] - x[3], end[1] - x[5]);
            let length = dx.hypot(dz);
            let tension = rigidity * (length - rest_length) / rest_length;
            tightest = tightest.max(tension);
            sum = [sum[0] + tension * dx / length, sum[1] + tension * dz / length];
        }
        assert!(sum.iter().all(|force| force.abs() < 1e-6), "{sum:?} at {x:?}");
        let tension = largest(&found, "tension");
        assert!((number(&tension["value"]) - tightest).abs() < 1e-6, "{tension} for {tightest}");
        let factor = largest(&found, "safety_factor");
        assert!((number(&factor["value"]) - 150.0 / tightest).abs() < 1e-6, "{factor}");
        assert_eq!(factor["groups"], tension["groups"]);
        assert_eq!(largest(&found, "reaction")["part"], json!("node"));
        let side = tension["groups"][0].as_str().expect("a group").to_owned();
        assert!(["left", "right"].contains(&side.as_str()), "{tension}");
        for words in
            ["  displacement    ", "  tension         ", &format!("({side}) at ("), "  safety factor   ", "N in all"]
        {
            assert!(ended.stdout.contains(words), "no \"{words}\" in\n{}", ended.stdout);
        }
    }
    // A run in time begins with it, at rest.
    let mut run = case("run", network(settled));
    run["time"] = json!({"end": 1e-3, "method": "rk4", "step": 1e-4});
    std::fs::write(bench.path("run.json"), run.to_string()).expect("written");
    let ended = bench.run(&["solve", "run.json", "--out", "run"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let rows = Results(bench.path("run")).table("probes.csv");
    let (x, v) = (rows.column("x"), rows.column("vx"));
    assert!((x[2] - 1.3).abs() < 1e-15 && (x[5] - 1.3).abs() < 1e-15 && v[5] == 0.0, "{x:?} {v:?}");
}

/// `check` of a case without `time` says whether there is an equilibrium, what it takes, and what is determined.
#[test]
fn check_knows_equilibria() {
    let bench = Bench::new();
    let check = |case: &Value, more: &[&str]| {
        std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
        let ended = bench.run(&[&["check", "case.json"], more].concat());
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        ended.stdout
    };
    let rules = json!([{"on": "all", "stiffness": 50.0, "rest_length": 0.0}]);
    let mut found = case("net", net(rules));
    let text = check(&found, &[]);
    for words in
        ["sail: no faults", "equilibrium     found, after", "determined      all free nodes; stable", "3 unknowns"]
    {
        assert!(text.contains(words), "no \"{words}\" in\n{text}");
    }
    assert!(!bench.path("out").exists(), "no files");
    let json: Value = serde_json::from_str(&check(&found, &["--json"])).expect("JSON");
    assert_eq!([&json["equilibrium"], &json["stability"]], [&json!("found"), &json!("stable")]);
    assert!(json["factor_nonzeros"].as_u64().expect("a count") > 0 && json["newton_iterations"].as_u64() > Some(0));
    // With a time section the same, if asked for.
    found["time"] = json!({"end": 0.1, "method": "rk4", "step": 1e-3});
    assert!(check(&found, &["--static"]).contains("equilibrium     found"));
    assert!(!check(&found, &[]).contains("equilibrium"));
    // A straight line moves freely across.
    let mut line = case(
        "line",
        json!({
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "springs": [[0, 1], [1, 2]]}},
            "mass": {"nodal": 1.0}, "springs": [{"on": "all", "stiffness": 100.0}],
            "supports": [{"on": {"ids": [0, 2]}, "fix": "xyz"}]
        }),
    );
    assert!(check(&line, &[]).contains("2 motions, mostly of node 1"), "{}", check(&line, &[]));
    line["system"]["network"]["supports"] = json!([{"on": {"ids": [0]}, "fix": "xy"}]);
    line["system"]["network"]["gravity"] = json!([0, 0, -9.81]);
    assert!(check(&line, &[]).contains("no support holds the scene in z"), "{}", check(&line, &[]));
}
