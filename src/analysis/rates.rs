//! The fastest rates of a linearised scene, as limits of methods are asked for with
//! ([`Spectrum::rates`](super::critical::Spectrum::rates) finds them), and a step that a bound on them allows.

use super::critical::{DAMPING, STIFFNESS};
use crate::integrate::linear_step::Pencil;
use crate::model::state::StateRef;
use crate::scene::{BoundRoom, Scene};

/// Fastest rates at one state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rates {
    /// [rad/s] largest w of the tangent system
    pub frequency: f64,
    /// degree of freedom that moves most in that mode
    pub frequency_dof: usize,
    /// [1/s] largest eigenvalue of M^-1 C
    pub damping: f64,
    /// degree of freedom that moves most in that mode
    pub damping_dof: usize,
}

/// [s] The limit of Euler-Cromer were the element bounds on the rates reached: for other methods a measure that falls
/// as their limit does.
pub(crate) fn step_by_bounds(scene: &dyn Scene, at: StateRef<'_>, room: &mut BoundRoom) -> f64 {
    let (k, _) = scene.rate_bound(at, STIFFNESS, room);
    let c = match scene.velocity_dependent() {
        true => scene.rate_bound(at, DAMPING, room).0,
        false => 0.0,
    };
    Pencil::EULER_CROMER.singular_at(k, c)
}
