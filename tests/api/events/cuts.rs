//! Springs that are cut one after another by a table.

use super::*;
use canopy_fem::case::Case;
use canopy_fem::simulation::Simulation;
use std::path::PathBuf;

/// Ten springs side by side from held nodes to masses, cut by a table.
fn side_by_side(cut: &Value) -> Value {
    let nodes: Vec<[f64; 3]> = (0..20).map(|i| [f64::from(i / 2), 0.0, -f64::from(i % 2)]).collect();
    let springs: Vec<[u32; 2]> = (0..10).map(|i| [2 * i, 2 * i + 1]).collect();
    let held: Vec<u32> = (0..10).map(|i| 2 * i).collect();
    json!({
        "name": "side-by-side",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
            "mass": {"nodal": 1.0},
            "springs": [{"on": "all", "stiffness": 1000.0, "cut": cut}],
            "supports": [{"on": {"ids": held}, "fix": "xyz"}],
            "gravity": [0, 0, -G]
        }},
        "time": {"end": 1.0, "method": "newmark", "step": 0.01}
    })
}

/// The times at which the springs are cut are those of the table's closed form, linear between its rows, with jumps,
/// for springs one by one and together.
#[test]
fn the_table_says_when_each_spring_is_cut() {
    let ramp = |k: usize| 0.1 + 0.5 * (k + 1) as f64 / 10.0;
    type Times<'a> = &'a dyn Fn(usize) -> Option<f64>;
    let rows: [(Value, Times); 5] = [
        (json!({"table": [[0.1, 0.0], [0.6, 1.0]]}), &|k| Some(ramp(k))),
        (json!({"table": [[0.1, 0.0], [0.6, 1.0]], "together": 4}), &|k| Some(ramp([3, 7, 9][k / 4]))),
        // Five at a jump, the others never.
        (json!({"table": [[0.3, 0.0], [0.3, 0.5]]}), &|k| (k < 5).then_some(0.3)),
        // Some at the first row; three later; the last two hold.
        (json!({"table": [[0.2, 0.5], [0.5, 0.5], [0.8, 0.8]]}), &|k| match k {
            0..5 => Some(0.2),
            5..8 => Some(0.5 + 0.1 * (k - 4) as f64),
            _ => None,
        }),
        (json!(0.7), &|_| Some(0.7)),
    ];
    for (cut, expected) in rows {
        let case = case_of(&side_by_side(&cut), &[]);
        let mut found = [None; 10];
        let groups = network(&case).springs;
        for group in &groups {
            group.edges.iter().for_each(|&edge| found[edge as usize] = Some(group.cut));
            assert_eq!(group.edges.len(), group.rest_length.len());
        }
        for (k, found) in found.iter().enumerate() {
            let found = found.unwrap_or_else(|| panic!("{cut}: spring {k} is in no group"));
            match (found, expected(k)) {
                (Some(found), Some(expected)) => {
                    assert!((found - expected).abs() < 1e-12, "{cut}: spring {k} is cut at {found}, not {expected} s");
                }
                (found, expected) => assert_eq!(found, expected, "{cut}: spring {k}"),
            }
        }
        let times: std::collections::BTreeSet<String> = groups.iter().map(|g| format!("{:?}", g.cut)).collect();
        assert_eq!(times.len(), groups.len(), "{cut}: springs of one time are one group");
    }
}

/// What is cut falls freely from then on, what is not hangs; a run that is put back to a state between two cuts has
/// the same bits.
#[test]
fn springs_let_go_in_their_order() {
    let case = case_of(&side_by_side(&json!({"table": [[0.1, 0.0], [0.6, 1.0]], "together": 5})), &[]);
    let mut simulation = Simulation::from_case(case.problem(), 1).expect("a scene");
    simulation.run_until(0.5).expect("it goes on");
    let snapshot = simulation.snapshot().expect("a state");
    let speed = |simulation: &Simulation, spring: usize| simulation.velocities()[2 * spring + 1][2];
    let swing = (G * G * 1.0 / 1000.0).sqrt();
    for spring in 0..10 {
        let free = speed(&simulation, spring) < -swing - 0.1;
        assert_eq!(free, spring < 5, "spring {spring} at 0.5 s: {} m/s", speed(&simulation, spring));
    }
    simulation.run_until(1.0).expect("it goes on");
    assert!((5..10).all(|spring| speed(&simulation, spring) < -swing - 0.1));
    let mut other = Simulation::from_case(case.problem(), 1).expect("a scene");
    other.restore(&snapshot).expect("a state");
    other.run_until(1.0).expect("it goes on");
    assert_eq!(simulation.positions(), other.positions());
}

/// Tables that cannot be are refused at their rows.
#[test]
fn bad_tables_of_cuts_are_refused() {
    let rows = [
        (json!({"table": [[0.1, 0.5], [0.2, 0.4]]}), "/cut/table/1", "share 0.4 after 0.5"),
        (json!({"table": [[0.2, 0.0], [0.1, 0.4]]}), "/cut/table/1", "time 0.1 after 0.2"),
        (json!({"table": [[0.1, 1.5]]}), "/cut/table/0/1", "a share from 0 to 1"),
        (json!({"table": [[-0.1, 0.5]]}), "/cut/table/0/0", "0 or more"),
        (json!({"table": [[0.0, 0.5]]}), "/cut/table/0", "0 at the time 0"),
        (json!({"table": []}), "/cut/table", "at least one row"),
        (json!({"table": [[0.1, 0.5]], "together": 0}), "/cut/together", "1 or more"),
        (json!("late"), "/cut", "number"),
    ];
    let refused = |case: &Value| {
        let error = Case::from_text(case.to_string(), "test.json", PathBuf::new(), &[]).err();
        error.unwrap_or_else(|| panic!("{case} passes"))
    };
    for (cut, at, words) in rows {
        let error = refused(&side_by_side(&cut));
        let hit = error.faults().iter().find(|fault| fault.pointer.ends_with(at));
        let hit = hit.unwrap_or_else(|| panic!("{cut}: no fault at {at}, but {error}"));
        assert!(hit.to_string().contains(words), "{cut}: \"{words}\" is not in\n{hit}");
    }
    let table = json!({"table": [[0.1, 0.5]]});
    for (key, value) in [("strength", json!(10.0)), ("when", json!({"time": 0.5}))] {
        let mut case = side_by_side(&table);
        case["system"]["network"]["springs"][0][key] = value;
        let error = refused(&case);
        assert!(error.faults().iter().any(|fault| fault.pointer.ends_with(key)), "{key}: {error}");
    }
}
