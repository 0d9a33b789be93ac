//! The fastest rates of a linearised scene.

use crate::model::at_dof::AtDof;

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
    /// whether masses are scaled, which no implicit method takes
    pub scaled_masses: bool,
}

impl Rates {
    /// The rates whose bounds are the largest eigenvalues of M^-1 K [1/s^2] and of M^-1 C [1/s].
    pub(super) fn of_bounds(stiffness: AtDof, damping: AtDof, scaled_masses: bool) -> Self {
        Rates {
            frequency: stiffness.value.sqrt(),
            frequency_dof: stiffness.dof,
            damping: damping.value,
            damping_dof: damping.dof,
            scaled_masses,
        }
    }
}
