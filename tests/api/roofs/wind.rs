//! Pressure coefficients by zone: forces by hand, what is refused, and every method.

use super::{applied, close, every_method_agrees};
use crate::common::run::{at_rest, case_of};
use canopy_fem::case::Case;
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::path::PathBuf;

/// A gable roof over 4 m by 6 m whose ridge along y is 1.5 m above the eaves: 1.5 by 2 on either side.
const GABLE: [[f64; 3]; 6] =
    [[0.0, 0.0, 3.0], [2.0, 0.0, 4.5], [4.0, 0.0, 3.0], [0.0, 6.0, 3.0], [2.0, 6.0, 4.5], [4.0, 6.0, 3.0]];

fn gable(aero: &Value) -> Value {
    json!({"name": "gable", "system": {"network": {
        "mesh": {"explicit": {
            "nodes": GABLE,
            "triangles": [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]],
            "groups": {"windward": {"triangles": [0, 1]}, "lee": {"triangles": [2, 3]}, "ridge": {"nodes": [1, 4]}}
        }},
        "mass": {"areal_density": 1.0},
        "membranes": [{"on": "all", "thickness": 1e-3, "modulus": 1e8, "poisson": 0.3}],
        "supports": [{"on": {"ids": [0, 2, 3, 5]}, "fix": "xyz"}],
        "aero": aero
    }}, "time": {"end": 0.02, "method": "velocity-verlet", "step": 1e-4}})
}

/// \[Pa\] of 30 m/s at sea level
const Q: f64 = 0.5 * 1.225 * 900.0;

/// cp q A along each normal: the area vectors of the sides are (-9, 0, 12) and (9, 0, 12).
#[test]
fn zones_are_pushed_along_their_normals() {
    let force =
        |law: Value| applied(&case_of(&gable(&json!({"wind": [30, 0, 0], "law": {"surface_pressure": law}})), &[]));
    close(force(json!({"windward": 0.6, "lee": -0.5})), [(0.6 * 9.0 + 0.5 * 9.0) * Q, 0.0, (-0.6 + 0.5) * 12.0 * Q]);
    close(force(json!({"lee": -0.5})), [0.5 * 9.0 * Q, 0.0, 0.5 * 12.0 * Q]);
    // Suction lifts the whole roof.
    close(force(json!({"all": -0.7})), [0.0, 0.0, 0.7 * 24.0 * Q]);
    // The wind meets the windward side at the angle between (-3, 0, 4)/5 and (-1, 0, 0), the lee side at pi less that.
    let angle = 0.6_f64.acos();
    let table = json!([[0.0, 1.0], [PI, 1.0 - PI]]);
    let [a, b] = [angle, PI - angle].map(|angle| 1.0 - angle);
    close(force(json!({"windward": table, "lee": table})), [(a - b) * 9.0 * Q, 0.0, -(a + b) * 12.0 * Q]);
}

/// The wind is that at the middle of each triangle and of the time, in the air of that height.
#[test]
fn wind_and_density_are_those_of_the_height() {
    let air = json!({
        "wind": {"sum": [{"profile": [[0, 0, 0, 0], [10, 20, 0, 0]]}, {"table": [[0, 5, 0, 0], [1, 9, 0, 0]]}]},
        "atmosphere": {"exponential": {"density": 1.3, "scale_height": 50.0}}, "altitude": 2.0,
        "law": {"surface_pressure": {"windward": 1.0}}
    });
    let side = |z: f64| {
        let (speed, density) = (5.0 + 2.0 * (2.0 + z), 1.3 * (-(2.0 + z) / 50.0).exp());
        0.5 * density * speed * speed
    };
    // Triangles (0, 1, 4) and (0, 4, 3) have two corners at the ridge, and one.
    let q = 0.5 * (side(4.0) + side(3.5));
    close(applied(&case_of(&gable(&air), &[])), [9.0 * q, 0.0, -12.0 * q]);
}

#[test]
fn every_method_has_zones() {
    let law = json!({"windward": [[0, 0.8], [1.0, 0.2], [1.6, -0.8]], "lee": -0.5});
    every_method_agrees(gable(&json!({"wind": [30, 0, 0], "law": {"surface_pressure": law}})), 0.05);
}

/// A square net of 10 m under suction bulges upwards and hangs on its supports with 0.7 q A.
#[test]
fn a_flat_roof_is_lifted() {
    let case = json!({"name": "flat", "system": {"network": {
        "mesh": {"rectangle": {"width": 10.0, "height": 10.0, "columns": 6, "rows": 6}},
        "mass": {"areal_density": 1.0},
        "membranes": [{"on": "all", "thickness": 1e-3, "modulus": 1e8, "poisson": 0.3}],
        "supports": [{"on": "outer", "fix": "xyz"}],
        "aero": {"wind": [30, 0, 0], "law": {"surface_pressure": {"all": -0.7}}}
    }}, "time": {"end": 1.0, "method": "newmark", "step": 1e-2}});
    let rest = at_rest(&case_of(&case, &[]));
    let highest = rest.positions.iter().map(|x| x[2]).fold(0.0, f64::max);
    assert!(highest > 0.1, "{highest}");
    let lift: f64 = rest.reactions.iter().map(|f| f[2]).sum();
    assert!((-lift / (0.7 * Q * 100.0) - 1.0).abs() < 1e-7, "{lift}");
}

#[test]
fn zones_that_are_none_are_refused() {
    let words = |aero: Value| {
        let read = Case::from_text(gable(&aero).to_string(), "case.json", PathBuf::new(), &[]);
        read.err().map_or_else(String::new, |error| error.to_string())
    };
    let zones = |zones: Value| words(json!({"wind": [30, 0, 0], "law": {"surface_pressure": zones}}));
    for (found, expected) in [
        (zones(json!({"winward": 0.8})), "did you mean \"windward\""),
        (zones(json!({"ridge": 0.8})), "a group with triangles"),
        (zones(json!({})), "at least one group with its coefficient"),
        (zones(json!({"all": 0.8, "lee": -0.5})), "which the zone \"all\" has too"),
        (zones(json!({"lee": [[0, 1], [90, -0.5]]})), "give radians: 90 degrees are 1.57"),
        (zones(json!({"lee": [[1, 1], [0.5, -0.5]]})), "angles strictly increasing"),
        (zones(json!({"lee": "x"})), "surface_pressure"),
        (
            words(json!({"law": {"pressure_coefficient": {"cp": 1}}, "altitude": 3})),
            "only with canopy, drag or surface_pressure",
        ),
    ] {
        assert!(found.contains(expected), "no \"{expected}\" in \"{found}\"");
    }
}
