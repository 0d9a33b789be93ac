//! Whether a scene buckles: a negative eigenvalue of its stiffness, and where.

use super::lanczos;
use super::operators::Linearised;
use crate::model::state::StateRef;
use crate::model::stop::Stop;
use crate::model::system::Weights;
use crate::scene::Scene;

/// Share of the largest eigenvalue below which a negative one is rounding.
const ROUNDING: f64 = 1e-9;

/// A mode that grows under compression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Buckling {
    /// [1/s] rate at which it grows
    pub rate: f64,
    /// degree of freedom that moves most in it
    pub dof: usize,
}

/// The fastest growing mode at a state, if the stiffness has a negative eigenvalue. Takes some tens to hundreds of
/// tangent products (Lanczos). Exact for symmetric scenes; else from the symmetric part.
pub fn fastest(scene: &dyn Scene, at: StateRef<'_>, stop: Stop<'_>) -> Option<Buckling> {
    let linear = Linearised::of(scene, at, stop);
    let mut p = vec![0.0; linear.root.len()];
    let mut along = |sign: f64| {
        let w = Weights { m: 0.0, c: 0.0, k: sign };
        lanczos::largest(linear.start(), stop, |q, y| linear.times(w, q, &mut p, y))
    };
    let (stiffest, softest) = (along(1.0)?, along(-1.0)?);
    if !(softest.value > ROUNDING * stiffest.value.abs() && softest.value.is_finite()) {
        return None;
    }
    Some(Buckling { rate: softest.value.sqrt(), dof: linear.most_moving_dof(&softest.vector) })
}
