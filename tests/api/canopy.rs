//! Canopies in the case file: what is found by topology, what is refused, and how runs of them behave.

use crate::common::parachute::Parachute;
use crate::common::run::{apart, case_of, changed, run, run_with};
use canopy_fem::case::Case;
use canopy_fem::case::spec::SystemSpec;
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::model::gauge::{CANOPY_QUANTITIES, DRAG_AREA};
use canopy_fem::model::observables::Observables;
use canopy_fem::model::spec::{CanopyAir, CanopySpec, NetworkSpec};
use canopy_fem::model::state::StateRef;
use canopy_fem::model::system::System;
use canopy_fem::scene::{BuildError, build_network};
use serde_json::{Value, json};

const SMALL: Parachute = Parachute { gores: 8, rings: 4, line_segments: 2, nominal_diameter: 2.0, line_length: 2.0 };

fn network(case: &Case) -> &NetworkSpec {
    match &case.problem().system {
        SystemSpec::Network(spec) => spec,
        SystemSpec::Pendulum(_) => panic!("a network"),
    }
}

fn canopy(sets: &[(&str, &str)]) -> CanopySpec {
    network(&case_of(&SMALL.case(1.7, 4.0, 6.0), sets)).canopies[0].clone()
}

const CANOPY: &str = "system.network.aero.canopy";

#[test]
fn skirt_and_apex_are_found_by_topology() {
    let found = canopy(&[]);
    let mut skirt: Vec<usize> = found.skirt.iter().map(|&node| node as usize).collect();
    skirt.sort_unstable();
    assert_eq!((skirt, found.apex), (SMALL.skirt(), vec![0]));
    assert_eq!(found.confluence, [SMALL.payload() as u32]);
}

/// Rings of triangles lie between rings of nodes at equal distances.
#[test]
fn the_coefficient_follows_the_arc_length() {
    let table = "[[0, 1], [1, 5]]";
    let found = canopy(&[(&format!("{CANOPY}.table.pressure_coefficient"), table)]);
    for (t, dcp) in found.triangles.iter().zip(&found.pressure_coefficient) {
        let spec = SMALL.mesh(0.0).2[*t as usize];
        let ring = |node: usize| if node == 0 { 0.0 } else { ((node - 1) / 8 + 1) as f64 };
        let place = spec.iter().map(|&node| ring(node)).sum::<f64>() / 12.0;
        assert!((dcp - 1.0 - 4.0 * place).abs() < 1e-12, "triangle {t}: {dcp} at {place}");
    }
}

/// Turned the other way round, the triangles are pushed to the same side.
#[test]
fn the_air_pushes_outwards_whichever_way_triangles_turn() {
    let case = SMALL.case(1.7, 4.0, 6.0);
    let mut turned = case.clone();
    for triangle in
        turned.pointer_mut("/system/network/mesh/explicit/triangles").and_then(Value::as_array_mut).expect("a list")
    {
        triangle.as_array_mut().expect("three").swap(1, 2);
    }
    let [one, other] = [case, turned].map(|case| run(&case_of(&case, &[("time.end", "0.05")])));
    assert!(apart(&one, &other) < 1e-12);
    assert!(one.positions[0][2] > one.positions[SMALL.skirt()[0]][2], "the apex is pushed away from the payload");
}

/// Settings of a canopy that fills.
fn filling(schedule: &'static str) -> Vec<(String, &'static str)> {
    vec![(format!("{CANOPY}.table"), "null"), (format!("{CANOPY}.schedule"), schedule)]
}

/// Stages of the drag area follow each other, each from what the one before has reached.
#[test]
fn a_reefed_canopy_fills_in_stages() {
    let stages = r#"[{"drag_area": 1, "filling_time": 0.1, "exponent": 1},
                     {"drag_area": 3, "filling_time": 0.2, "start": 0.05}, {"drag_area": 2, "filling_time": 0.1, "start": 0.4}]"#;
    let settings = filling(stages);
    let sets: Vec<(&str, &str)> = settings.iter().map(|(key, value)| (key.as_str(), *value)).collect();
    let canopy = canopy(&sets);
    let stages = canopy.air.stages();
    let area = |t: f64| {
        let mut area = 0.0;
        for stage in stages {
            let share: f64 = ((t - stage.start) / stage.duration).clamp(0.0, 1.0);
            area += share.powf(stage.exponent) * (stage.drag_area - area);
        }
        area
    };
    assert_eq!([area(0.05), area(0.1), area(0.3), area(0.6)], [0.5, 1.0 + 2.0 / 16.0, 3.0, 2.0]);
    let scene =
        build_network(network(&case_of(&SMALL.case(1.7, 4.0, 6.0), &sets)).clone(), Threads::one()).expect("it builds");
    let start = scene.initial_state();
    for t in [0.0, 0.05, 0.07, 0.3, 0.45, 9.0] {
        let values = scene.air().expect("air").canopy_values(0, StateRef { t, ..start.as_ref() });
        let found = CANOPY_QUANTITIES.iter().position(|quantity| *quantity == DRAG_AREA).map(|i| values[i]);
        assert_eq!(found, Some(area(t)), "at {t} s");
    }
}

#[test]
fn a_specification_that_fills_in_no_stage_is_refused() {
    let mut spec = network(&case_of(&SMALL.case(1.7, 4.0, 6.0), &[])).clone();
    spec.canopies[0].air = CanopyAir::Filling(Vec::new());
    assert_eq!(build_network(spec, Threads::one()).err(), Some(BuildError::NoStage));
}

#[test]
fn a_canopy_without_what_it_needs_is_refused() {
    let rows = [
        (vec![(format!("{CANOPY}.confluence"), "null")], "confluence", "where the lines meet"),
        (vec![(format!("{CANOPY}.confluence"), "{\"ids\": [1]}")], "confluence", "one of the canopy"),
        (vec![(format!("{CANOPY}.skirt"), "{\"ids\": [40]}")], "skirt", "no triangle of the canopy"),
        (vec![(format!("{CANOPY}.on"), "{\"ids\": [0, 13]}")], "on", "one outer boundary"),
        (vec![(format!("{CANOPY}.table"), "null")], "canopy", "exactly one of table, schedule, cavity and filling"),
        (filling(r#"{"drag_area": 1}"#), "schedule", "exactly one of filling_constant and filling_time"),
        (filling(r#"{"drag_area": 1, "filling_time": 1, "filling_constant": 8}"#), "schedule", "exactly one of"),
        (filling(r#"{"drag_area": 1, "filling_time": 0}"#), "schedule/filling_time", "above 0"),
        (filling("[]"), "schedule", "at least one stage"),
        (
            filling(r#"[{"drag_area": 1, "filling_time": 1}, {"drag_area": 3, "filling_time": 1}]"#),
            "schedule/1/start",
            "after the one before",
        ),
        (
            filling(r#"[{"drag_area": 1, "filling_time": 1}, {"drag_area": 3, "filling_constant": 8, "start": 2}]"#),
            "schedule/1/speed",
            "the speed at the start of the stage",
        ),
        (
            vec![(format!("{CANOPY}.table.pressure_coefficient"), "[[0, 1], [0, 2]]")],
            "table/pressure_coefficient/1",
            "arc lengths strictly",
        ),
        (
            vec![(format!("{CANOPY}.table.pressure_coefficient"), "[[0, 1], [2, 2]]")],
            "table/pressure_coefficient/1",
            "from 0 at the apex",
        ),
        (vec![(format!("{CANOPY}.tabel"), "1")], "canopy/tabel", "did you mean \"table\""),
        (
            vec![("system.network.aero.law".to_owned(), "{\"pressure_coefficient\": {\"cp\": 1.2}}")],
            "aero/law",
            "not together with canopy",
        ),
        (
            vec![(
                "system.network.aero.drag".to_owned(),
                "[{\"on\": \"outer\", \"diameter\": 0.1, \"coefficient\": 1}]",
            )],
            "drag/0/on",
            "a selection of edges",
        ),
        (
            vec![("system.network.aero.drag".to_owned(), "[{\"on\": \"lines\", \"drag_area\": 1}]")],
            "drag/0/on",
            "a selection of nodes",
        ),
        (
            vec![("system.network.aero.drag".to_owned(), "[{\"on\": \"all\", \"drag_area\": 1, \"diameter\": 2}]")],
            "drag/0",
            "either diameter and coefficient",
        ),
        (
            vec![("system.network.aero.drag".to_owned(), "[{\"on\": \"all\", \"drag_area\": 0}]")],
            "drag/0/drag_area",
            "above 0",
        ),
        (vec![("system.network.aero.atmosphere".to_owned(), "{\"density\": -1}")], "atmosphere/density", "above 0"),
        (
            vec![
                ("system.network.aero.atmosphere".to_owned(), "\"isa\""),
                ("system.network.aero.altitude".to_owned(), "90000"),
            ],
            "atmosphere",
            "86000",
        ),
        (vec![("system.network.aero.wind".to_owned(), "{\"sum\": []}")], "wind/sum", "at least one"),
        (
            vec![(
                "system.network.aero.wind".to_owned(),
                "{\"sum\": [[0, 0, 1], {\"gust\": {\"velocity\": [1, 0, 0], \"start\": 0, \"duration\": 0}}]}",
            )],
            "wind/sum/1/gust/duration",
            "above 0",
        ),
        (
            vec![("system.network.aero.wind".to_owned(), "{\"profile\": [[10, 0, 0, 1], [0, 0, 0, 1]]}")],
            "wind/profile/1",
            "heights strictly",
        ),
        (
            vec![("system.network.aero.wind".to_owned(), "{\"file\": \"no-such.csv\"}")],
            "wind/file",
            "separated by commas",
        ),
    ];
    for (sets, pointer, words) in rows {
        let sets: Vec<(String, String)> = sets.into_iter().map(|(k, v)| (k, v.to_owned())).collect();
        let made = Case::from_text(SMALL.case(1.7, 4.0, 6.0).to_string(), "test.json", "".into(), &sets);
        let message = made.err().unwrap_or_else(|| panic!("{sets:?} was taken")).to_string();
        assert!(message.contains(&format!("{pointer}:")) && message.contains(words), "{sets:?}: {message}");
    }
}

/// What is no canopy in a mesh of the user's own is refused where the case says it, with the mesh's numbers.
#[test]
fn meshes_that_are_no_canopies_are_refused() {
    const MESH: &str = "system.network.mesh.explicit";
    let skirt = SMALL.skirt();
    // The edges of the mesh along the skirt.
    let (nodes, edges, triangles) = SMALL.mesh(0.0);
    let along = (0..edges.len()).filter(|&edge| edges[edge].iter().all(|node| skirt.contains(node)));
    let along: Vec<usize> = along.collect();
    assert_eq!(along.len(), 8);
    let set = |key: &str, value: Value| (key.to_owned(), value.to_string());
    let (mut turned, mut at_apex, mut loose) = (triangles, nodes.clone(), nodes.clone());
    turned[9].swap(0, 1);
    at_apex[SMALL.payload()] = nodes[0];
    loose.push([0.0, 0.0, -9.0]);
    let mut masses = vec![0.0; nodes.len() + 1];
    masses[SMALL.payload()..].fill(4.0);
    let ring = json!([
        [0, 0, 0],
        [1, 0, 0],
        [1, 1, 0],
        [0, 1, 0],
        [0.1, 0.1, 0],
        [0.9, 0.1, 0],
        [0.9, 0.9, 0],
        [0.1, 0.9, 0],
        [0.5, 0.5, -1]
    ]);
    let around = json!([[0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]]);
    let joined = json!([
        [0, 1],
        [1, 2],
        [2, 3],
        [3, 0],
        [0, 4],
        [1, 5],
        [2, 6],
        [3, 7],
        [4, 5],
        [5, 6],
        [6, 7],
        [7, 4],
        [0, 8],
        [1, 8],
        [2, 8],
        [3, 8]
    ]);
    let rows = [
        (vec![set(&format!("{MESH}.triangles"), json!(turned))], "canopy/on", "turn opposite ways"),
        (vec![set(&format!("{MESH}.triangles"), json!(turned))], "canopy/on", "triangles 8 and 9 of the canopy"),
        (
            vec![set(&format!("{MESH}.groups"), json!({"skirt": {"edges": along[1..]}}))],
            "canopy/on",
            "the skirt is no closed loop: 1 of its edges",
        ),
        (
            vec![set(&format!("{CANOPY}.skirt"), json!({"ids": [0, skirt[0]]}))],
            "canopy/skirt",
            "one closed loop of the canopy's boundary",
        ),
        (vec![set(&format!("{MESH}.nodes"), json!(at_apex))], "canopy/confluence", "the canopy has no axis"),
        (
            vec![
                set(&format!("{MESH}.nodes"), json!(loose)),
                set(&format!("{MESH}.groups"), json!({"payload": {"nodes": [nodes.len()]}})),
                set("system.network.mass.nodal", json!(masses)),
            ],
            "aero/canopy",
            "the payload has no line",
        ),
        // Lines without springs hold nothing.
        (
            vec![
                set(&format!("{MESH}.groups"), json!({"payload": {"nodes": [SMALL.payload()]}})),
                set("system.network.springs.0.on", json!({"ids": [0]})),
                set("system.network.springs.1.on", json!("boundary")),
                set("system.network.mass.nodal", json!(0.1)),
            ],
            "aero/canopy",
            "the payload has no line",
        ),
        (
            vec![
                set(MESH, json!({"nodes": ring, "springs": joined, "triangles": around})),
                set("system.network.mass.nodal", json!(1)),
                set(&format!("{CANOPY}.confluence"), json!({"ids": [8]})),
            ],
            "canopy/on",
            "more vent than canopy",
        ),
    ];
    for (sets, pointer, words) in rows {
        let made = Case::from_text(SMALL.case(1.7, 4.0, 6.0).to_string(), "test.json", "".into(), &sets);
        let message = made.err().unwrap_or_else(|| panic!("{pointer}, {words}: was taken")).to_string();
        assert!(message.contains(&format!("{pointer}:")) && message.contains(words), "{words}: {message}");
    }
}

/// Rings with slots between them: the filling time takes D0 of cloth, slots and vent.
#[test]
fn filling_knows_the_nominal_diameter_of_rings() {
    let case = json!({
        "name": "rings",
        "system": {"network": {
            "mesh": {"parachute": {
                "type": "ringslot", "nominal_diameter": 3.0, "gores": 12, "vent_diameter": 0.3, "radial_segments": 4,
                "rings": 4, "slot_porosity": 0.15, "lines": {"length": 3.0}
            }},
            "mass": {"areal_density": 0.05, "points": [{"on": {"group": "payload"}, "mass": 5}]},
            "springs": [{"on": "all", "stiffness": 100}],
            "aero": {"canopy": {
                "on": {"group": "canopy"},
                "schedule": {"drag_area": 4.0, "filling_constant": 8, "exponent": 2, "speed": 10}
            }}
        }},
        "time": {"end": 1.0, "method": "velocity-verlet", "step": 1e-4}
    });
    let filling = network(&case_of(&case, &[])).canopies[0].air.stages()[0];
    assert!((filling.duration / (8.0 * 3.0 / 10.0) - 1.0).abs() < 1e-12, "{}", filling.duration);
}

/// Two canopies over one payload, in a list: each has its own speed and axis.
#[test]
fn a_cluster_has_an_air_speed_for_each_canopy() {
    let one = run(&case_of(&SMALL.case(1.7, 4.0, 6.0), &[("time.end", "0.1")]));
    let case = cluster(2, &SMALL);
    let both = run(&case_of(&case, &[("time.end", "0.1")]));
    let n = one.positions.len();
    for (i, position) in one.positions.iter().enumerate() {
        for copy in 0..2 {
            let found = both.positions[copy * n + i];
            let shift = 10.0 * copy as f64;
            for c in 0..3 {
                let expected = position[c] + if c == 0 { shift } else { 0.0 };
                assert!((found[c] - expected).abs() < 1e-9, "canopy {copy}, node {i}: {found:?}, {position:?}");
            }
        }
    }
}

#[test]
fn a_triangle_is_one_of_one_canopy_only() {
    let mut case = SMALL.case(1.7, 4.0, 6.0);
    let one = case["system"]["network"]["aero"]["canopy"].clone();
    case["system"]["network"]["aero"]["canopy"] = json!([one, one]);
    let message = Case::from_text(case.to_string(), "test.json", "".into(), &[]).expect_err("refused").to_string();
    assert!(message.contains("canopy/1/on") && message.contains("which an earlier canopy has"), "{message}");
}

/// Parachutes side by side that know nothing of each other, each a canopy of a list.
fn cluster(count: usize, parachute: &Parachute) -> Value {
    let mut case = parachute.case(1.7, 4.0, 6.0);
    let (mut nodes, mut edges, mut triangles, mut canopies) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut masses = Vec::new();
    for copy in 0..count {
        let (more, springs, corners) = parachute.mesh(10.0 * copy as f64);
        let first = nodes.len();
        let ids: Vec<usize> = (triangles.len()..triangles.len() + corners.len()).collect();
        canopies.push(json!({
            "on": {"ids": ids}, "table": {"pressure_coefficient": 1.7},
            "confluence": {"ids": [first + parachute.payload()]}
        }));
        masses.extend((0..more.len()).map(|i| if i == parachute.payload() { 4.0 } else { 0.0 }));
        nodes.extend(more);
        edges.extend(springs.into_iter().map(|ends| ends.map(|i| i + first)));
        triangles.extend(corners.into_iter().map(|ends| ends.map(|i| i + first)));
    }
    let network = &mut case["system"]["network"];
    network["mesh"]["explicit"] = json!({"nodes": nodes, "springs": edges, "triangles": triangles});
    network["mass"]["nodal"] = json!(masses);
    network["aero"]["canopy"] = json!(canopies);
    case
}

/// A scene of several blocks of nodes: the same bytes with one thread and with two.
#[test]
fn threads_change_no_bits() {
    let large = Parachute { gores: 48, rings: 40, line_segments: 12, ..SMALL };
    let case = case_of(&cluster(2, &large), &[("time.end", "0.0005"), ("time.step", "1e-5")]);
    for method in ["velocity-verlet", "rk4", "newmark"] {
        let case = changed(&case, &[("time.method", method)]);
        let [one, two] = [1, 2].map(|threads| run_with(&case, threads).state);
        assert_eq!((one.x, one.v), (two.x, two.v), "{method}");
    }
}

/// Long implicit steps converge to the stated residual, whichever tangent is used.
#[test]
fn newton_converges_in_long_steps() {
    for strategy in ["auto", "full", "quasi", "modified"] {
        let sets = [
            ("time.method", "newmark"),
            ("time.step", "0.02"),
            ("time.end", "2"),
            ("solver", &format!("{{\"newton\": {{\"strategy\": \"{strategy}\"}}}}")),
        ];
        let ran = run(&case_of(&SMALL.case(1.7, 4.0, 6.0), &sets));
        assert!(ran.outcome.status == canopy_fem::drive::Status::Completed, "{strategy}: {:?}", ran.outcome);
        println!("{strategy}: at most {} iterations, {:?}", ran.most_iterations, ran.outcome);
    }
}

/// Explicit and implicit methods take the apparent mass, and agree; the ledger closes on what the growing mass takes.
#[test]
fn every_kind_of_method_takes_the_apparent_mass() {
    let mut case = SMALL.case(1.7, 4.0, 6.0);
    case["system"]["network"]["aero"]["canopy"]["apparent_mass"] = json!(1.0);
    let case = case_of(&case, &[("time.end", "0.2")]);
    let accurate = run(&changed(&case, &[("time.method", "rk4"), ("time.step", "2e-5")]));
    let without = changed(&case, &[(&format!("{CANOPY}.apparent_mass"), "null")]);
    let without = run(&changed(&without, &[("time.method", "rk4"), ("time.step", "2e-5")]));
    assert!(apart(&without, &accurate) > 1e-2, "{}", apart(&without, &accurate));
    for (method, step, tolerance) in [
        ("velocity-verlet", "2e-5", 1e-5),
        ("improved-euler-pec", "1e-5", 1e-5),
        ("euler-cromer", "1e-5", 1e-3),
        ("newmark", "2e-4", 1e-3),
        ("hht", "2e-4", 1e-3),
        ("backward-euler", "2e-5", 1e-2),
    ] {
        let ran = run(&changed(&case, &[("time.method", method), ("time.step", step)]));
        assert!(ran.outcome.status == canopy_fem::drive::Status::Completed, "{method}: {:?}", ran.outcome);
        let off = apart(&ran, &accurate);
        println!("{method}: {off}, energy error {}, {} iterations", ran.outcome.energy_error, ran.most_iterations);
        assert!(off < tolerance, "{method}: {off}");
        assert!(ran.outcome.energy_error < 1e-2, "{method}: {}", ran.outcome.energy_error);
    }
    let adaptive =
        changed(&case, &[("time.step", "null"), ("time.tolerance", "{\"relative\": 1e-5, \"absolute\": 1e-7}")]);
    assert!(apart(&run(&adaptive), &accurate) < 1e-3);
}

/// Long implicit steps with an apparent mass many times that of the cloth.
#[test]
fn newton_converges_with_an_apparent_mass() {
    for strategy in ["auto", "full", "quasi"] {
        let mut case = SMALL.case(1.7, 4.0, 6.0);
        case["system"]["network"]["aero"]["canopy"]["apparent_mass"] = json!(1.0);
        let sets = [
            ("time.method", "newmark"),
            ("time.step", "0.02"),
            ("time.end", "2"),
            ("solver", &format!("{{\"newton\": {{\"strategy\": \"{strategy}\"}}}}")),
        ];
        let ran = run(&case_of(&case, &sets));
        println!("{strategy}: at most {} iterations, {:?}", ran.most_iterations, ran.outcome.counters);
        assert!(ran.outcome.status == canopy_fem::drive::Status::Completed, "{strategy}: {:?}", ran.outcome);
    }
}
