//! What a gauge of contact measures at rest: the weight of what lies on something, with its direction.
//! ```text
//! on a slope, held by friction:   F = m g          P = m g cos a
//! on a held triangle:             F = m g on it, -m g from it;      of a contact with itself F = 0, P = m g
//! ```

use super::{G, ground, share_of_gap};
use crate::claim::Claim;
use crate::common::run::case_of;
use canopy_fem::output::gauge_rows::{ColumnName, GaugeRows};
use canopy_fem::simulation::{bind, build_scene};
use serde_json::{Value, json};
use std::sync::atomic::AtomicBool;

/// The force [N] on the second side of contact 0 and the sum of pressures [N] at the end of a run.
fn at_end(case: &Value) -> ([f64; 3], f64) {
    let mut case = case.clone();
    case["output"] = json!({"gauges": [{"name": "load", "on": {"contact": 0}, "of": "contact"}]});
    let mut problem = case_of(&case, &[]).into_problem();
    let scene = build_scene(problem.take_system(), 1).expect("the case is good");
    let columns = ["contact_x", "contact_y", "contact_z", "contact_total", "contact_pressure"]
        .map(|column| ColumnName { gauge: "load".to_owned(), column: column.to_owned() });
    let mut rows = GaugeRows::new(&*scene, &problem.output, problem.time.end, &columns).expect("the gauge is there");
    let mut stepper = bind(&problem, &*scene).expect("the method fits the scene");
    let stop = AtomicBool::new(false);
    let outcome = canopy_fem::drive::run(&*scene, &mut stepper, &problem.run_spec(), &mut [&mut rows], &stop);
    assert!(outcome.expect("it starts").failure.is_none());
    let last = |i: usize| rows.values[i].last().copied().unwrap_or(f64::NAN);
    let force = [last(0), last(1), last(2)];
    assert!((last(3) - force.map(|f| f * f).iter().sum::<f64>().sqrt()).abs() < 1e-12 * (1.0 + last(3)));
    (force, last(4))
}

/// A net of 0.2 kg/m^2 that comes to rest on a slope, and is held by friction.
fn on_slope(angle: f64) -> Value {
    let ground = json!({"plane": {"point": [0, 0, -0.006], "normal": [0, 0, 1]}});
    json!({
        "name": "net",
        "system": {"network": {
            "mesh": {"rectangle": {"width": 0.4, "height": 0.5, "columns": 5, "rows": 5}},
            "mass": {"areal_density": 0.2},
            "springs": [{"on": "all", "stiffness": 50.0}],
            "gravity": [G * angle.sin(), 0.0, -G * angle.cos()],
            "contact": [{"between": ["all", ground], "gap": 0.01, "friction": 0.5}]
        }},
        "solver": {"newton": {"relative": 1e-11}},
        "time": {"end": 3.0, "method": "backward-euler", "step": 5e-3}
    })
}

/// A mass that begins where it rests on a slope.
fn lone(angle: f64, method: &str) -> Value {
    json!({
        "name": "lone",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0.0, 0.0, 1e-3 * share_of_gap(angle.cos())]]}},
            "mass": {"nodal": [2.0]},
            "gravity": [G * angle.sin(), 0.0, -G * angle.cos()],
            "contact": [{"between": ["all", ground()], "gap": 1e-3, "friction": 0.5}]
        }},
        "time": {"end": 0.1, "method": method, "step": 1e-4}
    })
}

/// [kg] of the upper triangle
const UPPER: f64 = 0.03;

/// A triangle that comes to rest on a held one.
fn on_held(between: &Value) -> Value {
    json!({
        "name": "stack",
        "system": {"network": {
            "mesh": {"explicit": {
                "nodes": [[-1, -1, 0], [1, -1, 0], [0, 1, 0], [-0.1, -0.1, 6e-3], [0.1, -0.1, 6e-3], [0, 0.1, 6e-3]],
                "triangles": [[0, 1, 2], [3, 4, 5]],
                "groups": {"lower": {"triangles": [0]}, "upper": {"triangles": [1]}}
            }},
            "mass": {"nodal": UPPER / 3.0},
            "springs": [{"on": "all", "stiffness": 50.0}],
            "supports": [{"on": {"ids": [0, 1, 2]}, "fix": "xyz"}],
            "gravity": [0.0, 0.0, -G],
            "contact": [{"between": between, "gap": 0.01}]
        }},
        "solver": {"newton": {"relative": 1e-11}},
        "time": {"end": 3.0, "method": "backward-euler", "step": 5e-3}
    })
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    let mut told = |what: &str, case: &Value, [force, pressure]: [[f64; 3]; 2], tolerance: f64| {
        let (found, pressed) = at_end(case);
        for (axis, (found, force)) in ["x", "y", "z"].into_iter().zip(found.into_iter().zip(force)) {
            claims.push(Claim::absolute(format!("{what}: force along {axis} [N]"), found, force, tolerance));
        }
        claims.push(Claim::absolute(format!("{what}: sum of pressures [N]"), pressed, pressure[0], tolerance));
    };
    let angle = 0.2_f64.atan();
    let along = |weight: f64| [[weight * angle.sin(), 0.0, -weight * angle.cos()], [weight * angle.cos(), 0.0, 0.0]];
    told("a net of 0.04 kg rests on a slope, mu = 0.5", &on_slope(angle), along(0.04 * G), 1e-6);
    for method in ["newmark", "hht", "backward-euler", "energy-momentum", "velocity-verlet", "rk4"] {
        // What begins to creep has its full friction after a few 0.1 ms, and pressures are those of a place in the gap.
        told(&format!("{method}: 2 kg rest on a slope, mu = 0.5"), &lone(angle, method), along(2.0 * G), 1e-6 * G);
    }
    let weight = UPPER * G;
    for (between, force) in
        [(json!(["upper", "lower"]), -weight), (json!(["lower", "upper"]), weight), (json!("self"), 0.0)]
    {
        let right = [[0.0, 0.0, force], [weight, 0.0, 0.0]];
        told(&format!("a triangle of 0.03 kg on a held one, {between}"), &on_held(&between), right, 1e-6);
    }
    claims
}
