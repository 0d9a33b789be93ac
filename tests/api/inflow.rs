//! The loss of the air that enters a canopy with `table` or `schedule`: its pressure, its work, and what a cut reefing
//! line does.

use crate::common::parachute::Parachute;
use crate::common::run::{apart, case_of, changed, follow, network, run};
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::model::gauge::CANOPY_QUANTITIES;
use canopy_fem::model::observables::Observables;
use canopy_fem::model::system::System;
use canopy_fem::scene::{BuildError, build_network};
use serde_json::{Value, json};
use std::f64::consts::FRAC_PI_4;

const SMALL: Parachute = Parachute { gores: 8, rings: 4, line_segments: 2, nominal_diameter: 2.0, line_length: 2.0 };
const CANOPY: &str = "system.network.aero.canopy";
const LOSS: &str = "system.network.aero.canopy.inflow_loss";
/// [m] of the skirt at the start
const RADIUS: f64 = 0.3;

/// A parachute at line stretch with a wide tube.
fn tube() -> Value {
    let mut case = SMALL.case(1.7, 4.0, 6.0);
    let start = SMALL.stretched(RADIUS);
    case["system"]["network"]["initial"]["displacement"] = json!(SMALL.displaced_to(&start));
    case
}

/// A canopy that grows by s x, so that Vol' = 3 s Vol, has -k rho u|u|/2 more pressure, times the coefficient of a
/// table. One that shrinks has less, one that only moves the same.
#[test]
fn the_pressure_falls_with_the_square_of_the_inflow() {
    let schedule = [
        (format!("{CANOPY}.table"), "null"),
        (format!("{CANOPY}.schedule"), "{\"drag_area\": 1.5, \"filling_time\": 1, \"start\": -0.5}"),
    ];
    let schedule: Vec<(&str, &str)> = schedule.iter().map(|(key, value)| (key.as_str(), *value)).collect();
    for (way, coefficient) in [(&[][..], 1.7), (&schedule[..], 1.0)] {
        for growth in [4.0, -3.0, 0.0] {
            let values = |loss: &str| {
                let mut spec = network(&case_of(&tube(), &[way, &[(LOSS, loss)]].concat()));
                spec.velocity = (0..spec.mesh.nodes.len())
                    .map(|i| {
                        let [at, moved] = [spec.mesh.nodes[i], spec.displacement[i]];
                        let place = [0, 1, 2].map(|axis| growth * (at[axis] + moved[axis]));
                        [place[0], place[1], place[2] - 6.0]
                    })
                    .collect();
                let scene = build_network(spec, Threads::one()).expect("a sound scene");
                let values = scene.air().expect("air").canopy_values(0, scene.initial_state().as_ref());
                let of = |name| CANOPY_QUANTITIES.iter().position(|quantity| quantity.name == name).expect("known");
                ["pressure", "volume"].map(|name| values[of(name)])
            };
            let ([without, volume], [with, _]) = (values("0"), values("1.5"));
            let mouth = 4.0 * RADIUS * RADIUS * FRAC_PI_4.sin();
            let u = 3.0 * growth * volume / mouth;
            let expected = -coefficient * 1.5 * 0.5 * 1.225 * u * u.abs();
            let off = (with - without - expected).abs();
            assert!(off < 1e-10 * (1.0 + expected.abs()), "{way:?} {growth}: {} {expected}", with - without);
        }
    }
}

/// The loss takes energy, which the ledger has: explicit, implicit and adaptive methods agree.
#[test]
fn every_kind_of_method_takes_a_loss() {
    let case = case_of(&tube(), &[("time.end", "0.1"), (LOSS, "1")]);
    let accurate = run(&changed(&case, &[("time.method", "rk4"), ("time.step", "2e-5")]));
    assert!(accurate.outcome.status == Status::Completed, "{:?}", accurate.outcome);
    for (method, step, tolerance) in [
        ("velocity-verlet", "2e-5", 1e-5),
        ("newmark", "2e-4", 1e-3),
        ("generalized-alpha", "2e-4", 1e-3),
        ("backward-euler", "2e-5", 1e-2),
    ] {
        let ran = run(&changed(&case, &[("time.method", method), ("time.step", step)]));
        assert!(ran.outcome.status == Status::Completed, "{method}: {:?}", ran.outcome);
        let off = apart(&ran, &accurate);
        println!("{method}: {off}, energy error {}", ran.outcome.energy_error);
        assert!(off < tolerance, "{method}: {off}");
        assert!(ran.outcome.energy_error < 1e-2, "{method}: {}", ran.outcome.energy_error);
    }
    let tolerance = "{\"relative\": 1e-5, \"absolute\": 1e-7}";
    let sets = [("time.method", "newmark"), ("time.step", "null"), ("time.tolerance", tolerance)];
    let off = apart(&run(&changed(&case, &sets)), &accurate);
    assert!(off < 1e-3, "adaptive steps: {off}");
}

/// Where a balance of the air is there already, and where the mouth has no area, a loss is refused.
#[test]
fn a_loss_without_a_meaning_is_refused() {
    let cavity = "{\"inflow\": 0.5, \"outer_pressure_coefficient\": -0.6}";
    let rows = [
        (vec![(LOSS, "-1")], "inflow_loss", "0 or more"),
        (
            vec![
                (LOSS, "1"),
                ("system.network.aero.canopy.table", "null"),
                ("system.network.aero.canopy.cavity", cavity),
            ],
            "inflow_loss",
            "only beside table and schedule",
        ),
    ];
    for (sets, key, words) in rows {
        let sets: Vec<(String, String)> = sets.into_iter().map(|(k, v)| (k.to_owned(), v.to_owned())).collect();
        let made = Case::from_text(tube().to_string(), "test.json", "".into(), &sets);
        let message = made.err().unwrap_or_else(|| panic!("{sets:?} was taken")).to_string();
        assert!(message.contains(key) && message.contains(words), "{sets:?}: {message}");
    }
    let mut closed = network(&case_of(&tube(), &[(LOSS, "1")]));
    for node in closed.canopies[0].skirt.clone() {
        let [x, y, z] = closed.mesh.nodes[node as usize];
        closed.displacement[node as usize] = [-x, -y, -1.0 - z];
    }
    assert_eq!(build_network(closed, Threads::one()).err(), Some(BuildError::ClosedMouth));
}

/// A canopy of `table` whose reefing line is cut in full fall: with the loss the mouth takes several times as long to
/// open, and the lines feel less than half of the jerk.
#[test]
fn the_air_slows_a_canopy_whose_reefing_line_is_cut() {
    let opened = |loss: &str| {
        let mut value: Value =
            serde_json::from_str(include_str!("../../assets/cases/parachute/g12-reefed.json")).expect("a shipped case");
        let parachute = &mut value["system"]["network"]["mesh"]["parachute"];
        for (key, coarse) in [("gores", json!(16)), ("radial_segments", json!(6))] {
            parachute[key] = coarse;
        }
        parachute["lines"]["segments"] = json!(1);
        let springs = value["system"]["network"]["springs"].as_array_mut().expect("a list");
        for spring in springs {
            if spring.get("cut").is_some() {
                spring["cut"] = json!(0.6);
            }
        }
        let stages = "[{\"drag_area\": 65, \"filling_time\": 0.01, \"start\": -1}, \
                       {\"drag_area\": 224.1, \"filling_time\": 4, \"start\": 0.6}]";
        let sets = [
            ("time.end", "1.4"),
            ("system.network.initial.velocity", "[0, 0, -16]"),
            ("system.network.aero.canopy.schedule", stages),
            (LOSS, loss),
        ];
        let case = case_of(&value, &sets);
        let skirt = network(&case).canopies[0].skirt.clone();
        let radius = |positions: &[[f64; 3]]| {
            let sum: f64 = skirt.iter().map(|&i| positions[i as usize][0].hypot(positions[i as usize][1])).sum();
            sum / skirt.len() as f64
        };
        let mut radii = Vec::new();
        let outcome = follow(&case, |state| radii.push((state.t, radius(state.positions))));
        assert!(outcome.status == Status::Completed, "{outcome:?}");
        let reefed = radii.iter().find(|(t, _)| *t >= 0.6).map_or(f64::NAN, |(_, r)| *r);
        let opened = radii.iter().find(|(t, r)| *t > 0.6 && *r > 1.7 * reefed).map_or(f64::NAN, |(t, _)| *t);
        (reefed, opened - 0.6)
    };
    let ((reefed, fast), (same, slow)) = (opened("0"), opened("1"));
    println!("{reefed} {fast}, {same} {slow}");
    assert!((reefed - same).abs() < 0.01 * reefed && slow > 2.0 * fast, "{reefed} {fast}, {same} {slow}");
}
