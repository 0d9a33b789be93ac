//! Every force law of a case against its closed form, at one state by hand.
//!
//! The probe is explicit Euler, x1 = x0 + h v0, v1 = v0 + h f(t0, x0, v0)/m: what a step adds to the velocity is the
//! force at its start, and the second step has its force where x0 + h v0 is. Steps and masses are powers of two, so
//! that nothing is rounded on the way but the force itself.

mod springs;
mod surface;

use crate::claim::Claim;
use crate::common::run::{case_of, follow};
use canopy_fem::drive::Status;
use nalgebra::Vector3;
use serde_json::{Value, json};

/// [s]
const H: f64 = 0.125;
/// [kg] of every node
const MASS: f64 = 1.0;
/// [-] Some ten operations, of which subtractions of coordinates up to 7 lose a digit.
const ROUNDING: f64 = 2e-14;

/// [N] Forces on all nodes at the start of each of the first `steps` steps.
fn forces(mut network: Value, steps: u32) -> Vec<Vec<Vector3<f64>>> {
    network["mass"] = json!({"nodal": MASS});
    let time = json!({"end": H * f64::from(steps), "method": "explicit-euler", "step": H});
    let mut velocities: Vec<Vec<Vector3<f64>>> = Vec::new();
    let case = case_of(&json!({"name": "force", "system": {"network": network}, "time": time}), &[]);
    let outcome = follow(&case, |seen| velocities.push(seen.velocities.iter().map(|&v| Vector3::from(v)).collect()));
    assert_eq!(outcome.status, Status::Completed, "{network}");
    let force = |(v0, v1): (&Vector3<f64>, &Vector3<f64>)| (v1 - v0) * (MASS / H);
    velocities.windows(2).map(|w| w[0].iter().zip(&w[1]).map(force).collect()).collect()
}

/// A row: how far a force is off the closed form, as a share of it; of 1 N where it is zero.
fn agrees(what: &str, found: Vector3<f64>, expected: Vector3<f64>) -> Claim {
    let size = expected.norm();
    let scale = if size > 0.0 { size } else { 1.0 };
    let what = format!("{what}: {size:.4} N, force off");
    Claim::below(what, (found - expected).norm() / scale, ROUNDING)
}

pub fn claims() -> Vec<Claim> {
    let mut claims = springs::claims();
    claims.extend(surface::claims());
    claims
}
