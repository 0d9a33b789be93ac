//! Cavities in the case file: what is refused, and how runs of them behave.

use crate::common::parachute::Parachute;
use crate::common::run::{apart, case_of, changed, network, run, run_with};
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::model::gauge::CANOPY_QUANTITIES;
use canopy_fem::model::observables::Observables;
use canopy_fem::model::spec::{CanopyAir, CavitySpec, ClothSpec, NetworkSpec};
use canopy_fem::model::system::System;
use canopy_fem::scene::{BuildError, build_network};
use serde_json::{Value, json};

const SMALL: Parachute = Parachute { gores: 8, rings: 4, line_segments: 2, nominal_diameter: 2.0, line_length: 2.0 };
const CANOPY: &str = "system.network.aero.canopy";

/// A parachute that fills: line stretch with the skirt at a tenth of D0, cloth that lets air through.
fn filling(parachute: &Parachute) -> Value {
    let mut case = parachute.case(1.7, 4.0, 6.0);
    let network = &mut case["system"]["network"];
    network["aero"]["canopy"]["table"] = Value::Null;
    network["aero"]["canopy"]["cavity"] = json!({
        "inflow": 0.5, "outer_pressure_coefficient": -0.6,
        "law": {"permeable": {"a": 1.6e6, "b": 4.8e5, "thickness": 1e-4}}
    });
    let start = parachute.stretched(0.05 * parachute.nominal_diameter);
    network["initial"]["displacement"] = json!(parachute.displaced_to(&start));
    case
}

#[test]
fn a_cavity_without_a_meaning_is_refused() {
    let key = |key: &str| format!("{CANOPY}.cavity.{key}");
    let table = "{\"pressure_coefficient\": 1.7}";
    let schedule = "{\"drag_area\": 3, \"filling_constant\": 8, \"speed\": 20}";
    let rows = [
        (vec![(key("inflow"), "0")], "canopy/cavity/inflow", "above 0"),
        (vec![(key("inflow"), "-0.4")], "canopy/cavity/inflow", "above 0"),
        (vec![(key("inflow"), "null")], "canopy/cavity/inflow", "required"),
        (vec![(key("outer_pressure_coefficient"), "1")], "canopy/cavity/outer_pressure_coefficient", "below 1"),
        (vec![(key("outer_pressure_coefficient"), "2.5")], "canopy/cavity/outer_pressure_coefficient", "about -0.6"),
        (vec![(key("inflo"), "1")], "canopy/cavity/inflo", "did you mean \"inflow\""),
        (vec![(key("law.permeable.a"), "-1")], "canopy/cavity/law/permeable/a", "0 or more"),
        (
            vec![(key("law"), "{\"permeable\": {\"a\": 0, \"b\": 0, \"thickness\": 1e-4}}")],
            "cavity/law/permeable",
            "a or b above 0",
        ),
        (
            vec![(key("law"), "{\"pressure_coefficient\": {\"cp\": 1}}")],
            "canopy/cavity/law/pressure_coefficient",
            "ergun, permeable",
        ),
        (vec![(format!("{CANOPY}.table"), table)], "aero/canopy", "a canopy with table and cavity"),
        (vec![(format!("{CANOPY}.schedule"), schedule)], "aero/canopy", "a canopy with schedule and cavity"),
        (
            vec![(format!("{CANOPY}.table"), table), (format!("{CANOPY}.schedule"), schedule)],
            "aero/canopy",
            "a canopy with table and schedule and cavity",
        ),
        (vec![(format!("{CANOPY}.skirt"), "{\"ids\": [1, 2]}")], "canopy/skirt", "one closed loop"),
    ];
    for (sets, pointer, words) in rows {
        let sets: Vec<(String, String)> = sets.into_iter().map(|(k, v)| (k, v.to_owned())).collect();
        let made = Case::from_text(filling(&SMALL).to_string(), "test.json", "".into(), &sets);
        let message = made.err().unwrap_or_else(|| panic!("{sets:?} was taken")).to_string();
        assert!(message.contains(&format!("{pointer}:")) && message.contains(words), "{sets:?}: {message}");
    }
}

/// What a program asks for without a case is checked too.
#[test]
fn a_specification_of_a_cavity_is_checked() {
    let good = network(&case_of(&filling(&SMALL), &[]));
    let refused = |change: &dyn Fn(&mut NetworkSpec, CavitySpec) -> CavitySpec| {
        let mut spec = good.clone();
        let CanopyAir::Cavity(cavity) = spec.canopies[0].air else { panic!("a cavity") };
        spec.canopies[0].air = CanopyAir::Cavity(change(&mut spec, cavity));
        build_network(spec, Threads::one()).err().unwrap_or_else(|| panic!("it was taken"))
    };
    let reasons = [
        refused(&|_, cavity| CavitySpec { inflow: 0.0, ..cavity }),
        refused(&|_, cavity| CavitySpec { outer_pressure_coefficient: 1.0, ..cavity }),
        refused(&|_, cavity| CavitySpec { cloth: Some(ClothSpec { linear: 0.0, quadratic: 0.0 }), ..cavity }),
    ];
    assert!(reasons.iter().all(|error| matches!(error, BuildError::Cavity { .. })), "{reasons:?}");
    let nowhere = refused(&|spec, cavity| {
        spec.canopies[0].skirt = vec![1];
        cavity
    });
    assert_eq!(nowhere, BuildError::Mouth { loops: 0 });
    let closed = refused(&|spec, cavity| {
        let skirt: Vec<u32> = spec.canopies[0].skirt.clone();
        for node in skirt {
            let (from, to) = (spec.mesh.nodes[node as usize], &mut spec.displacement[node as usize]);
            *to = [-from[0], -from[1], -1.0 - from[2]];
        }
        cavity
    });
    assert_eq!(closed, BuildError::ClosedMouth);
}

/// Explicit, implicit and adaptive methods agree on a canopy that fills, with and without the air that it takes along;
/// the ledger closes.
#[test]
fn every_kind_of_method_takes_a_cavity() {
    for apparent in ["null", "1.0"] {
        let sets = [("time.end", "0.1"), (&format!("{CANOPY}.apparent_mass"), apparent)];
        let case = case_of(&filling(&SMALL), &sets);
        let accurate = run(&changed(&case, &[("time.method", "rk4"), ("time.step", "2e-5")]));
        assert!(accurate.outcome.status == Status::Completed, "{:?}", accurate.outcome);
        for (method, step, tolerance) in [
            ("velocity-verlet", "2e-5", 1e-5),
            ("euler-cromer", "1e-5", 1e-3),
            ("newmark", "2e-4", 1e-3),
            ("hht", "2e-4", 1e-3),
            ("generalized-alpha", "2e-4", 1e-3),
            ("backward-euler", "2e-5", 1e-2),
        ] {
            let ran = run(&changed(&case, &[("time.method", method), ("time.step", step)]));
            assert!(ran.outcome.status == Status::Completed, "{method}: {:?}", ran.outcome);
            let off = apart(&ran, &accurate);
            println!("{method}: {off}, energy error {}, {} iterations", ran.outcome.energy_error, ran.most_iterations);
            assert!(off < tolerance, "{method}: {off}");
            assert!(ran.outcome.energy_error < 1e-2, "{method}: {}", ran.outcome.energy_error);
        }
        for method in ["newmark", "dormand-prince"] {
            let tolerance = "{\"relative\": 1e-5, \"absolute\": 1e-7}";
            let sets = [("time.method", method), ("time.step", "null"), ("time.tolerance", tolerance)];
            let off = apart(&run(&changed(&case, &sets)), &accurate);
            assert!(off < 1e-3, "{method} with adaptive steps: {off}");
        }
    }
}

/// Long implicit steps converge to the stated residual, whichever tangent is used.
#[test]
fn newton_converges_in_long_steps() {
    for strategy in ["auto", "full", "quasi", "modified"] {
        let sets = [
            ("time.method", "newmark"),
            ("time.step", "0.01"),
            ("time.end", "2"),
            ("solver", &format!("{{\"newton\": {{\"strategy\": \"{strategy}\"}}}}")),
        ];
        let ran = run(&case_of(&filling(&SMALL), &sets));
        println!("{strategy}: at most {} iterations, {:?}", ran.most_iterations, ran.outcome.counters);
        assert!(ran.outcome.status == Status::Completed, "{strategy}: {:?}", ran.outcome);
    }
}

/// Scenes of several blocks of nodes, and of two canopies: the same bytes with one thread and with two.
#[test]
fn threads_change_no_bits() {
    let large = Parachute { gores: 48, rings: 60, line_segments: 12, ..SMALL };
    let case = case_of(&filling(&large), &[("time.end", "0.0003"), ("time.step", "1e-5")]);
    for method in ["velocity-verlet", "rk4", "newmark"] {
        let case = changed(&case, &[("time.method", method)]);
        let [one, two] = [1, 2].map(|threads| run_with(&case, threads).state);
        assert_eq!((one.x, one.v), (two.x, two.v), "{method}");
    }
}

/// Two canopies of a cluster have a balance each: that of one alone.
#[test]
fn canopies_of_a_cluster_have_cavities_of_their_own() {
    let alone = filling(&SMALL);
    let (mut nodes, mut springs, triangles) = SMALL.mesh(0.0);
    let mut case = alone.clone();
    let network = &mut case["system"]["network"];
    let twice = |list: &Value| {
        let list = list.as_array().expect("a list");
        json!([list.clone(), list.clone()].concat())
    };
    let n = nodes.len();
    nodes.extend(SMALL.mesh(10.0).0);
    springs.extend(springs.clone().iter().map(|ends| ends.map(|i| i + n)));
    let mut both = triangles.clone();
    both.extend(triangles.iter().map(|corners| corners.map(|i| i + n)));
    network["mesh"]["explicit"] = json!({"nodes": nodes, "springs": springs, "triangles": both});
    network["mass"]["nodal"] = twice(&network["mass"]["nodal"]);
    network["initial"]["displacement"] = twice(&network["initial"]["displacement"]);
    let canopy = |copy: usize| {
        let ids: Vec<usize> = (copy * triangles.len()..(copy + 1) * triangles.len()).collect();
        let mut canopy = network["aero"]["canopy"].clone();
        (canopy["on"], canopy["confluence"]) = (json!({"ids": ids}), json!({"ids": [copy * n + SMALL.payload()]}));
        canopy
    };
    network["aero"]["canopy"] = json!([canopy(0), canopy(1)]);
    let [one, both] = [alone, case].map(|case| run(&case_of(&case, &[("time.end", "0.1")])));
    for (i, position) in one.positions.iter().enumerate() {
        for (copy, shift) in [[0.0; 3], [10.0, 0.0, 0.0]].into_iter().enumerate() {
            let found = both.positions[copy * n + i];
            let off = (0..3).map(|c| (found[c] - position[c] - shift[c]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9, "canopy {copy}, node {i}: {found:?}, {position:?}");
        }
    }
}

/// In steady flow of tight cloth the pressure is (1 - Cp) q, and the drag area the drag over q.
#[test]
fn gauges_show_the_pressure_in_a_cavity() {
    let spec = network(&case_of(&filling(&SMALL), &[(&format!("{CANOPY}.cavity.law"), "null")]));
    let scene = build_network(spec, Threads::one()).expect("a sound scene");
    let values = scene.air().expect("air").canopy_values(0, scene.initial_state().as_ref());
    let of = |name: &str| {
        let place = CANOPY_QUANTITIES.iter().position(|quantity| quantity.name == name).expect("a quantity");
        values[place]
    };
    let q = 0.5 * 1.225 * 36.0;
    let [pressure, drag, area] = ["pressure", "drag", "drag_area"].map(of);
    assert!((pressure - 1.6 * q).abs() < 1e-12 * q, "{pressure}");
    assert!((area - drag / q).abs() < 1e-12 * area, "{area}");
    let mouth = 0.5 * 8.0 * 0.01 * (0.25 * std::f64::consts::PI).sin();
    assert!((drag - 1.6 * q * mouth).abs() < 1e-12 * drag, "{drag}");
}
