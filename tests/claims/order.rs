//! The order of every method, measured two-sided on [`crate::rich_net`] from positions and velocities at the end, and
//! what parameters do to it. The declared order is the one the registry tells the program's users.

use crate::claim::Claim;
use crate::common::run::{case_of, changed, run};
use crate::linear_theory::method_name;
use crate::rich_net::net;
use canopy_fem::drive::Status;
use canopy_fem::integrate::registry::methods;
use serde_json::{Value, json};

/// [-] At these steps the next term of the error still bends the slopes, by 0.02 as measured; a method that loses an
/// order, even at one parameter or on one term only, is off by 1.
const TOLERANCE: f64 = 0.1;

/// The quadratic law v|v| has a jump in its second derivative where the flow through a triangle turns round; there the
/// local error of any method is of third order. Methods of order 4 and less do not see it at these steps, but for
/// esdirk4, whose own error is a tenth of that of rk4; those of higher order see little else.
#[derive(Clone, Copy, PartialEq)]
enum Air {
    Quadratic,
    Linear,
}

/// [-] Positions and velocities at the end; `-log2` of the step.
fn end_state(air: Air, method: &Value, refinement: i32) -> Vec<f64> {
    let step = format!("{:e}", (-f64::from(refinement)).exp2());
    let mut net = net();
    if air == Air::Linear {
        net["system"]["network"]["aero"]["law"]["permeable"]["b"] = json!(0.0);
    }
    let run = run(&changed(&case_of(&net, &[]), &[("time.method", &method.to_string()), ("time.step", &step)]));
    assert_eq!(run.outcome.status, Status::Completed, "{method} at {step}: {:?}", run.outcome.failure);
    run.positions.iter().chain(&run.velocities).flatten().copied().collect()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
}

struct Reference {
    air: Air,
    state: Vec<f64>,
    /// its own error: the distance to half as fine a solution, less the factor 2^4 of a method of order 4; or to that
    /// of a method of order 5
    error: f64,
}

fn reference() -> Reference {
    let air = Air::Quadratic;
    let (coarse, state) = (end_state(air, &json!("rk4"), 11), end_state(air, &json!("rk4"), 12));
    let error = distance(&coarse, &state) / 15.0;
    Reference { air, state, error }
}

fn smooth_reference() -> Reference {
    let air = Air::Linear;
    let (other, state) = (end_state(air, &json!("dormand-prince"), 10), end_state(air, &json!("dop853"), 8));
    let error = distance(&other, &state);
    Reference { air, state, error }
}

/// Steps 2^-first, 2^-(first+1), 2^-(first+2): the mean of two slopes.
fn slope(reference: &Reference, method: &Value, first: i32) -> f64 {
    let errors: Vec<f64> =
        (first..first + 3).map(|k| distance(&end_state(reference.air, method, k), &reference.state)).collect();
    assert!(errors[2] > 100.0 * reference.error, "{method}: {errors:?} against {:e}", reference.error);
    let slopes = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).log2()];
    0.5 * (slopes[0] + slopes[1])
}

/// Coarsest step of a measurement, as `-log2`: deep enough for the tolerance, coarse enough for the reference.
fn first_refinement(order: u32) -> i32 {
    match order {
        1 => 11,
        2 => 8,
        3..=4 => 7,
        5..=7 => 6,
        _ => 3,
    }
}

pub fn claims() -> Vec<Claim> {
    let (reference, smooth) = (reference(), smooth_reference());
    // Rounding of 4096 steps takes over below this; a coarser reference than that would be a defect.
    let mut claims = vec![Claim::below("the reference's own error [m, m/s]", reference.error.max(smooth.error), 1e-12)];
    let registered = methods().iter().map(|m| (m.order, json!(m.name)));
    for (order, method) in registered.chain(with_parameters()) {
        let accurate = method == "esdirk4";
        let reference = if order > 4 || accurate { &smooth } else { &reference };
        let slope = slope(reference, &method, first_refinement(order) - i32::from(accurate));
        claims.push(Claim::absolute(format!("{}: order", method_name(&method)), slope, f64::from(order), TOLERANCE));
    }
    claims
}

/// Parameters change the order where theory says so, and nowhere else: numerical damping costs Newmark one order and
/// HHT and generalised alpha none; dissipation inside of elements costs one.
fn with_parameters() -> [(u32, Value); 18] {
    [
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
        (1, json!({"energy-momentum": {"dissipation": 0.2}})),
        (1, json!({"energy-momentum": {"dissipation": 1.0}})),
        (1, json!({"xpbd": {"substeps": 1, "iterations": 1}})),
        (1, json!({"xpbd": {"substeps": 2, "iterations": 3}})),
        (1, json!({"vbd": {"iterations": 2}})),
    ]
}
