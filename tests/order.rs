//! The order of every method, measured two-sided on a problem that hides nothing: large motion of a net with axial and
//! relative dashpots and Rayleigh damping, in a wind and under a load that change with time. The way in is the case file.
//!
//! Steps are powers of two and the rows of the tables fall on multiples of the largest, so that the force is smooth
//! within every step and the kinks of the tables cost no order.

mod common;

use canopy_fem::drive::Status;
use canopy_fem::integrate::registry::methods;
use common::run::{case_of, changed, run};
use serde_json::{Value, json};

/// [-] At these steps the next term of the error still bends the slopes, by 0.02 as measured; a method that loses an order,
/// even at one parameter or on one term only, is off by 1.
const TOLERANCE: f64 = 0.1;

/// A sheet of four triangles and six nodes, pulled far out of its plane.
fn net() -> Value {
    json!({
        "name": "order",
        "system": {"network": {
            "mesh": {"explicit": {
                "nodes": [[0, 0, 0], [1, 0, 0], [2.1, 0, 0.1], [0, 1, 0], [1, 1.2, 0], [2, 1, 0.2]],
                "springs": [[0, 1], [1, 2], [3, 4], [4, 5], [1, 4], [2, 5], [0, 4], [1, 5]],
                "triangles": [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]]
            }},
            "mass": {"nodal": [0.5, 0.4, 0.6, 0.5, 0.7, 0.45]},
            "springs": [
                {"on": {"ids": [0, 2, 4, 6]}, "stiffness": 20.0, "rest_scale": 0.9, "dashpot": {"axial": {"coefficient": 0.6}}},
                {"on": "all", "stiffness": 15.0, "rest_scale": 0.95, "dashpot": {"relative": {"time": 0.02}}}
            ],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [3]}, "fix": "xz"}],
            "gravity": [0, 0, -9.81],
            "aero": {
                "wind": {"table": [[0, 0.5, 0, 12], [0.25, 1, 1, 16], [0.75, 0, -1, 13], [1, 0, 0, 15]]},
                "law": {"permeable": {"a": 400.0, "b": 100.0, "thickness": 1e-3}}
            },
            "loads": [
                {"on": {"ids": [5]}, "force": [2, 1, 0.5], "table": [[0, 0], [0.5, 1.5], [1, 0.2]]},
                {"on": "all", "pressure": 1.5, "kind": "follower", "table": [[0, 1], [0.75, 2]]}
            ],
            "damping": {"rayleigh": {"mass": 0.3, "stiffness": 0.005}},
            "initial": {"displacement": [0.05, -0.03, 0.1], "velocity": [0.3, 0.2, -0.5]}
        }},
        "time": {"end": 1.0, "method": "rk4", "step": 0.015625},
        "solver": {"newton": {"relative": 1e-12}}
    })
}

/// [-] Positions and velocities at the end; `-log2` of the step.
fn end_state(method: &Value, refinement: i32) -> Vec<f64> {
    let step = format!("{:e}", (-f64::from(refinement)).exp2());
    let run = run(&changed(&case_of(&net(), &[]), &[("time.method", &method.to_string()), ("time.step", &step)]));
    assert_eq!(run.outcome.status, Status::Completed, "{method} at {step}: {:?}", run.outcome.failure);
    run.positions.iter().chain(&run.velocities).flatten().copied().collect()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
}

struct Reference {
    state: Vec<f64>,
    /// its own error: the distance to half as fine a solution, less the factor 2^4 of a method of order 4
    error: f64,
}

fn reference() -> Reference {
    let (coarse, state) = (end_state(&json!("rk4"), 11), end_state(&json!("rk4"), 12));
    let error = distance(&coarse, &state) / 15.0;
    // Rounding of 4096 steps takes over below this; a coarser reference than that would be a defect.
    assert!(error < 1e-12, "the reference is off by {error:e}");
    Reference { state, error }
}

/// Steps 2^-first, 2^-(first+1), 2^-(first+2): the mean of two slopes.
fn slope(reference: &Reference, method: &Value, first: i32) -> f64 {
    let errors: Vec<f64> = (first..first + 3).map(|k| distance(&end_state(method, k), &reference.state)).collect();
    assert!(errors[2] > 100.0 * reference.error, "{method}: {errors:?} against {:e}", reference.error);
    let slopes = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).log2()];
    println!("{method}: errors {errors:?}, slopes {slopes:?}");
    0.5 * (slopes[0] + slopes[1])
}

/// Coarsest step of a measurement, as `-log2`: deep enough for the tolerance, coarse enough for the reference.
fn first_refinement(order: u32) -> i32 {
    match order {
        1 => 11,
        2 => 8,
        _ => 7,
    }
}

/// Every registered method has the order that the registry tells its users.
#[test]
fn the_registered_order_is_the_measured_order() {
    let reference = reference();
    for method in methods() {
        let slope = slope(&reference, &json!(method.name), first_refinement(method.order));
        assert!((slope - f64::from(method.order)).abs() < TOLERANCE, "{}: {slope} for {}", method.name, method.order);
    }
}

/// Parameters change the order where theory says so, and nowhere else: numerical damping costs Newmark one order and HHT and
/// generalised alpha none.
#[test]
fn parameters_change_the_order_as_theory_says() {
    let reference = reference();
    let rows = [
        (1, json!({"newmark": {"gamma": 0.6, "beta": 0.3025}})),
        (1, json!({"newmark": {"gamma": 0.6}})),
        (1, json!({"newmark": {"gamma": 1.0, "beta": 0.5}})),
        (2, json!({"newmark": {"gamma": 0.5, "beta": 0.3}})),
        (2, json!({"newmark": {"gamma": 0.5, "beta": 1.0 / 6.0}})),
        (2, json!({"newmark": {"gamma": 0.5, "beta": 0.5}})),
        (2, json!({"hht": {"alpha": 0.0}})),
        (2, json!({"hht": {"alpha": -0.05}})),
        (2, json!({"hht": {"alpha": -0.3}})),
        (2, json!({"hht": {"alpha": -0.3333333333333333}})),
        (2, json!({"generalized-alpha": {"rho_inf": 0.0}})),
        (2, json!({"generalized-alpha": {"rho_inf": 0.3}})),
        (2, json!({"generalized-alpha": {"rho_inf": 1.0}})),
    ];
    for (order, method) in rows {
        let slope = slope(&reference, &method, first_refinement(order));
        assert!((slope - f64::from(order)).abs() < TOLERANCE, "{method}: {slope} for {order}");
    }
}
