//! Snow: its sum is that of the plan, whatever the shape; what is refused; every method.

use super::{applied, close, every_method_agrees};
use crate::common::run::{at_rest, case_of};
use canopy_fem::case::Case;
use serde_json::{Value, json};
use std::path::PathBuf;

/// A shed roof of 4 m by 6 m that rises by 3 m along x, with a valley of 1.5 m on its lower side.
fn shed(loads: &Value) -> Value {
    json!({"name": "shed", "system": {"network": {
        "mesh": {"explicit": {
            "nodes": [[0, 0, 3], [1.5, 0, 3.5], [4, 0, 6], [0, 6, 3], [1.5, 6, 3.5], [4, 6, 6]],
            "triangles": [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]],
            "groups": {"valley": {"triangles": [0, 1]}, "roof": {"triangles": [2, 3]}}
        }},
        "mass": {"areal_density": 1.0},
        "membranes": [{"on": "all", "thickness": 1e-3, "modulus": 1e8, "poisson": 0.3}],
        "supports": [{"on": {"ids": [0, 2, 3, 5]}, "fix": "xyz"}],
        "loads": loads
    }}, "time": {"end": 0.02, "method": "velocity-verlet", "step": 1e-4}})
}

/// s times shape times the plan, downwards; along gravity where that is another direction.
#[test]
fn snow_is_that_of_the_plan() {
    let force = |loads: Value, sets: &[(&str, &str)]| applied(&case_of(&shed(&loads), sets));
    let all = json!([{"on": "all", "snow": 750.0}]);
    close(force(all.clone(), &[]), [0.0, 0.0, -750.0 * 24.0]);
    let groups = json!([
        {"on": {"group": "valley"}, "snow": 750.0, "shape": 1.6},
        {"on": {"group": "roof"}, "snow": 750.0, "shape": 0.8}
    ]);
    close(force(groups, &[]), [0.0, 0.0, -750.0 * (1.6 * 9.0 + 0.8 * 15.0)]);
    // Seen along -x it is 6 m by 3 m; the weight of the free nodes is another load.
    let [x, ..] = force(all, &[("system.network.gravity", "[-1e-9, 0, 0]")]);
    assert!((x + 750.0 * 18.0).abs() < 1e-6, "{x}");
    let table = json!([{"on": "all", "snow": 750.0, "table": [[0, 0.25], [10, 1]]}]);
    close(force(table, &[]), [0.0, 0.0, -0.25 * 750.0 * 24.0]);
}

/// It stays the same where the roof sags under it.
#[test]
fn supports_carry_all_snow() {
    let rest = at_rest(&case_of(&shed(&json!([{"on": "all", "snow": 750.0}])), &[]));
    assert!(rest.positions[1][2] < 3.49, "it sags: {:?}", rest.positions[1]);
    let carried: f64 = rest.reactions.iter().map(|f| f[2]).sum();
    assert!((carried / (750.0 * 24.0) - 1.0).abs() < 1e-7, "{carried}");
}

#[test]
fn every_method_has_snow() {
    every_method_agrees(shed(&json!([{"on": "all", "snow": 750.0, "table": [[0, 0], [0.02, 1]]}])), 0.05);
}

#[test]
fn snow_is_a_load_of_its_own() {
    for (load, expected) in [
        (json!({"on": "all", "snow": 1.0, "pressure": 2.0}), "a load with pressure and snow"),
        (json!({"on": "all", "snow": 1.0, "direction": [0, 0, 1]}), "snow acts along gravity"),
        (json!({"on": "all", "snow": 1.0, "kind": "dead"}), "only with pressure"),
        (json!({"on": "all", "pressure": 1.0, "shape": 0.8}), "only with snow"),
        (json!({"on": "all", "snow": -1.0}), "0 or more"),
        (json!({"on": "outer", "snow": 1.0}), "selects nodes"),
    ] {
        let read = Case::from_text(shed(&json!([load])).to_string(), "case.json", PathBuf::new(), &[]);
        let found = read.err().map_or_else(String::new, |error| error.to_string());
        assert!(found.contains(expected), "no \"{expected}\" in \"{found}\"");
    }
}
