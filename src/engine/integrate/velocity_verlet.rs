//! Velocity Verlet (thesis Eq. 37-40; Swope et al. 1982). Order 2, damped too; one evaluation a step, two if a force
//! depends on velocity.
//!
//! ```text
//! v_h = v_n + h/2 a_n
//! x_{n+1} = x_n + h v_h
//! a* = M^-1 f(t_{n+1}, x_{n+1}, v_n + h a_n)
//! v_{n+1} = v_h + h/2 a*
//! a_{n+1} = M^-1 f(t_{n+1}, x_{n+1}, v_{n+1})
//! ```
//! Eq. 39 is implicit in v when there is damping; a* at the predicted velocity makes it explicit and keeps order 2.
//! Carrying a* over to the next step instead of a_{n+1} would save an evaluation but lose stability (w h < 1.64 instead
//! of 1.84 at damping ratio 0.1). Both are at x_{n+1}, so springs and weight are evaluated once for the two. Without
//! velocity-dependent forces a* = a_{n+1}. Limit w h < 2 undamped.

use super::kick_drift::KickDrift;
use crate::model::step_block::KickDriftScheme;

/// Velocity Verlet; a_n is the force of the point a step starts from.
pub const VELOCITY_VERLET: KickDrift = KickDrift {
    step: |h, velocity_dependent| KickDriftScheme {
        begin: 0.5 * h,
        drift: h,
        end: Some(0.5 * h),
        predicts: velocity_dependent,
    },
    lags: false,
};
