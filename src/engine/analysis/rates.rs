//! The fastest rates of a linearised scene.

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
