//! Gas in closed volumes: p V^gamma, the work that fills one, what is refused, every method.

use super::every_method_agrees;
use crate::common::octahedron;
use crate::common::run::{at_rest, case_of, follow, network};
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::model::observables::Observables;
use canopy_fem::model::state::StateRef;
use canopy_fem::model::system::System;
use canopy_fem::scene::build_network;
use serde_json::{Value, json};
use std::path::PathBuf;

/// \[m\] of the octahedron
const R: f64 = 0.7;

/// A bag of springs around a gas.
fn bag(gas: &Value) -> Value {
    let mut network = octahedron();
    network["gas"] = gas.clone();
    json!({"name": "bag", "system": {"network": network},
        "time": {"end": 0.02, "method": "velocity-verlet", "step": 1e-4}})
}

/// \[Pa\] The pressure on a bag that is `scale` times as large as at the start, as frames show it.
fn pressure(gas: &Value, scale: f64, t: f64) -> f64 {
    let scene = build_network(network(&case_of(&bag(gas), &[])), Threads::one()).expect("a sound scene");
    let mut state = scene.initial_state();
    state.x.iter_mut().for_each(|x| *x *= scale);
    let mut found = vec![0.0; 8];
    let at = StateRef { t, x: &state.x, v: &state.v };
    scene.air().expect("it shows pressures").triangle_pressure(at, &mut found);
    assert!(found.iter().all(|p| *p == found[0]), "{found:?}");
    found[0]
}

/// (p + p_a) V^gamma is constant to 1e-10 of p + p_a, between half and twice the volume.
#[test]
fn the_pressure_is_isentropic() {
    for (gamma, ambient) in [(1.4, 101_325.0), (1.0, 101_325.0), (1.667, 7e4)] {
        let gas = json!({"on": "all", "pressure": 2000.0, "gamma": gamma, "ambient": ambient});
        for volume in [0.5, 0.9, 1.0, 1.001, 2.0_f64] {
            let absolute = pressure(&gas, volume.cbrt(), 0.0) + ambient;
            let expected = (2000.0 + ambient) * volume.powf(-gamma);
            assert!((absolute / expected - 1.0).abs() < 1e-10, "{gamma} {volume}: {absolute} {expected}");
        }
    }
}

/// By amount: what fits in at the pressure outside pushes on nothing; twice as much has 2^gamma of it. A table of
/// pressures is that in the volume at the start.
#[test]
fn gas_is_filled_over_time() {
    let start = 4.0 / 3.0 * R.powi(3);
    let by_amount = json!({"on": "all", "amount": {"table": [[0, start], [2, 3.0 * start]]}});
    for (t, expected) in [(0.0, 0.0), (1.0, 101_325.0 * (2.0_f64.powf(1.4) - 1.0))] {
        let found = pressure(&by_amount, 1.0, t);
        assert!((found - expected).abs() < 1e-10 * 101_325.0, "{t}: {found} {expected}");
    }
    let by_pressure = json!({"on": "all", "pressure": {"table": [[0, 0], [2, 900]]}, "gamma": 1.0});
    assert!((pressure(&by_pressure, 1.0, 1.0) - 450.0).abs() < 1e-9);
    assert!((pressure(&by_pressure, 2.0_f64.cbrt(), 1.0) - (0.5 * (101_325.0 + 450.0) - 101_325.0)).abs() < 1e-9);
    // A volume beside what is enclosed stays: here as much again.
    let beside = json!({"on": "all", "pressure": 0.0, "volume": 2.0 * start, "gamma": 1.0});
    let found = pressure(&beside, 2.0_f64.cbrt(), 0.0);
    assert!((found - 101_325.0 * (2.0 / 3.0 - 1.0)).abs() < 1e-9, "{found}");
}

/// What a pump does is external work, and the rest of the account is in balance, to the error of the steps.
#[test]
fn the_work_of_filling_is_accounted_for() {
    let gas = json!({"on": "all", "pressure": {"table": [[0, 0], [0.03, 3000]]}, "ambient": 1000.0});
    for (method, share) in [("rk4", 1e-5), ("newmark", 1e-3), ("velocity-verlet", 1e-3), ("energy-momentum", 1e-3)] {
        let case = case_of(&bag(&gas), &[("time.method", &format!("\"{method}\""))]);
        let mut last = Default::default();
        let outcome = follow(&case, |state| last = state.ledger);
        assert_eq!(outcome.status, Status::Completed, "{method}: {:?}", outcome.failure);
        assert!(last.external_work > 10.0, "{method}: {last:?}");
        assert!(outcome.energy_error < share, "{method}: {}", outcome.energy_error);
    }
}

#[test]
fn every_method_has_gas() {
    every_method_agrees(bag(&json!({"on": "all", "pressure": 500.0, "ambient": 1000.0})), 0.05);
}

/// A bag at rest: the pressure on a quarter of the octahedron is what its springs carry, in the volume that it has.
#[test]
fn a_bag_rests_where_its_springs_hold_the_gas() {
    let mut case = bag(&json!({"on": "all", "pressure": 8000.0}));
    case["system"]["network"]["supports"] = json!([
        {"on": {"ids": [0, 1]}, "fix": "yz"}, {"on": {"ids": [2, 3]}, "fix": "xz"}, {"on": {"ids": [4, 5]}, "fix": "xy"}
    ]);
    let rest = at_rest(&case_of(&case, &[]));
    let r = rest.positions[0][0];
    assert!(rest.positions.iter().flatten().all(|x| *x == 0.0 || (x.abs() - r).abs() < 1e-9), "{:?}", rest.positions);
    // A node has four springs of length r sqrt(2), which pull along the axis by 1/sqrt(2) of their tension each, and
    // four triangles whose area vectors have r^2/2 along the axis.
    let springs = 4.0 * 800.0 * (r - R) * 2.0_f64.sqrt() / 2.0_f64.sqrt();
    let pressure = (8000.0 + 101_325.0) * (R / r).powf(3.0 * 1.4) - 101_325.0;
    assert!((springs - pressure * 4.0 * r * r / 6.0).abs() < 1e-6, "{r}: {springs}, {pressure} Pa");
    assert!(r > R + 1e-3, "{r}");
}

/// Triangles that turn the other way enclose the same gas.
#[test]
fn a_surface_inside_out_is_the_same() {
    let gas = json!({"on": "all", "pressure": 500.0});
    let mut turned = bag(&gas);
    let triangles = turned["system"]["network"]["mesh"]["explicit"]["triangles"].as_array_mut().expect("a list");
    triangles.iter_mut().for_each(|corners| corners.as_array_mut().expect("three").swap(1, 2));
    let end = |case: &Value| {
        let mut last = Vec::new();
        follow(&case_of(case, &[]), |state| last = state.positions.to_vec());
        last
    };
    let ends = [end(&bag(&gas)), end(&turned)];
    let apart = ends[0].iter().flatten().zip(ends[1].iter().flatten()).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-12);
}

/// A gas has its energy and its pressure in a step of any size: nothing is made and nothing is lost.
#[test]
fn energy_momentum_keeps_the_energy_of_a_gas() {
    for (gas, step) in [
        (json!({"on": "all", "pressure": 5000.0}), 1e-3),
        (json!({"on": "all", "pressure": 5000.0, "gamma": 1.0, "ambient": 1000.0}), 4e-3),
        (json!({"on": "all", "pressure": -300.0, "gamma": 1.667, "ambient": 1000.0, "volume": 0.6}), 1e-2),
    ] {
        let mut case = bag(&gas);
        case["time"] = json!({"end": 200.5 * step, "method": "energy-momentum", "step": step});
        case["solver"] = json!({"newton": {"relative": 1e-13}});
        case["system"]["network"]["initial"] =
            json!({"velocity": [[1, 0, 0], [0, 2, 0], [0, 0, 0], [0, 0, 3], [0, 0, 1], [0, 0, 0]]});
        let mut exchanged = 0.0_f64;
        let outcome = follow(&case_of(&case, &[]), |state| exchanged = exchanged.max(state.ledger.kinetic));
        assert_eq!(outcome.status, Status::Completed, "{gas}: {:?}", outcome.failure);
        assert!(exchanged > 1.0 && outcome.energy_error < 1e-12, "{gas}: {} of {exchanged} J", outcome.energy_error);
    }
}

/// Two chambers with a wall between them, over a rim: a pillow with an inner sheet. Each gas has its own volume, and
/// the wall feels the difference.
#[test]
fn chambers_share_a_wall() {
    let mut case = pillow();
    let case_text = |case: &Value| Case::from_text(case.to_string(), "case.json", PathBuf::new(), &[]);
    let read = case_text(&case).unwrap_or_else(|e| panic!("{e}"));
    assert!(read.warnings().is_empty(), "{:?}", read.warnings());
    let scene = build_network(network(&read), Threads::one()).expect("a sound scene");
    let state = scene.initial_state();
    let air = scene.air().expect("it has gases");
    assert_eq!(air.gases(), 2);
    for (gas, expected) in [(0, [800.0, 1.0 / 3.0]), (1, [300.0, 2.0 / 3.0])] {
        let found = air.gas_values(gas, state.as_ref());
        assert!(found.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-12), "{found:?} {expected:?}");
    }
    let mut pressures = vec![0.0; 12];
    air.triangle_pressure(state.as_ref(), &mut pressures);
    assert!((pressures[4].abs() - 500.0).abs() < 1e-9, "the wall: {pressures:?}");
    // What has no inside is refused, although the rim is held.
    let refused = |case: &Value| case_text(case).err().map_or_else(String::new, |error| error.to_string());
    case["system"]["network"]["gas"] = json!({"on": "all", "pressure": 800.0});
    assert!(refused(&case).contains("3 triangles (0, 4, 8) at the edge 0-1"), "{}", refused(&case));
    case["system"]["network"]["gas"] =
        json!([{"on": {"group": "upper"}, "pressure": 800.0}, {"on": {"group": "upper"}, "pressure": 1.0}]);
    assert!(refused(&case).contains("the triangles of gas 0 again"), "{}", refused(&case));
    case = pillow();
    let triangles = &mut case["system"]["network"]["mesh"]["explicit"]["triangles"];
    (4..8).for_each(|i| triangles[i].as_array_mut().expect("corners").swap(0, 1));
    let found = refused(&case);
    assert!(found.contains("which turn opposite ways"), "{found}");
}

/// A square of 2 m in the x-y plane, held, with a tip 1/2 m above it, a sheet that is 1/4 m above it in its middle, and
/// one whose middle is 1/4 m below. Volumes are a third of the heights times 4 m^2.
fn pillow() -> Value {
    let over = |tip: u32| (0..4).map(move |i| [i, (i + 1) % 4, tip]);
    let under = |tip: u32| (0..4).map(move |i| [(i + 1) % 4, i, tip]);
    // The wall turns so that it closes the upper chamber; seen from the lower one all turn inwards.
    let triangles: Vec<[u32; 3]> = over(4).chain(under(5)).chain(over(6)).collect();
    json!({"name": "pillow", "system": {"network": {
        "mesh": {"explicit": {
            "nodes": [[1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0], [0, 0, 0.5], [0, 0, 0.25], [0, 0, -0.25]],
            "triangles": triangles,
            "groups": {"upper": {"triangles": [0, 1, 2, 3, 4, 5, 6, 7]}, "lower": {"triangles": [4, 5, 6, 7, 8, 9, 10, 11]}}
        }},
        "mass": {"areal_density": 0.5},
        "membranes": [{"on": "all", "thickness": 1e-4, "modulus": 1e8, "poisson": 0.3}],
        "supports": [{"on": {"ids": [0, 1, 2, 3]}, "fix": "xyz"}],
        "gas": [{"on": {"group": "upper"}, "pressure": 800.0}, {"on": {"group": "lower"}, "pressure": 300.0}]
    }}, "time": {"end": 0.02, "method": "velocity-verlet", "step": 1e-5}})
}

#[test]
fn what_encloses_no_gas_is_refused() {
    let words = |case: &Value| {
        let read = Case::from_text(case.to_string(), "case.json", PathBuf::new(), &[]);
        read.err().map_or_else(String::new, |error| error.to_string())
    };
    let mut open = bag(&json!({"on": {"ids": [0, 1, 2, 3]}, "pressure": 500.0}));
    let found = words(&open);
    assert!(found.contains("open at the nodes 0, 1, 2, 3, which can move"), "{found}");
    open["system"]["network"]["supports"] = json!([{"on": {"ids": [0, 1, 2, 3]}, "fix": "xyz"}]);
    assert_eq!(words(&open), "", "the ground closes it");
    open["system"]["network"]["supports"][0]["until"] = json!(0.01);
    assert!(words(&open).contains("which can move"));
    for (gas, expected) in [
        (json!({"on": "all"}), "exactly one of pressure and amount"),
        (json!({"on": "all", "pressure": 1.0, "amount": 1.0}), "exactly one of pressure and amount"),
        (json!({"on": "all", "amount": 0.0}), "amounts above 0"),
        (json!({"on": "all", "pressure": {"table": [[0, 1], [1, -2e5]]}}), "above that of a vacuum"),
        (json!({"on": "all", "pressure": 1.0, "gamma": 0.9}), "1 or more"),
    ] {
        let found = words(&bag(&gas));
        assert!(found.contains(expected), "no \"{expected}\" in \"{found}\"");
    }
    // Cloth that lies flat has no volume of its own.
    let mut flat = bag(&json!({"on": "all", "pressure": 500.0}));
    flat["system"]["network"]["mesh"]["explicit"]["nodes"] =
        json!([[R, 0, 0], [-R, 0, 0], [0, R, 0], [0, -R, 0], [0.1, 0.1, 0], [-0.1, 0, 0]]);
    let built = build_network(network(&case_of(&flat, &[])), Threads::one());
    let error = built.err().map_or_else(String::new, |error| error.to_string());
    assert!(error.contains("fills no volume at the start"), "{error}");
}
