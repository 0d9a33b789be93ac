//! Central differences, the explicit step of finite-element codes (Belytschko et al. 2014, Box 5.1; Hallquist 2006).
//! One evaluation a step, with dashpots too.
//!
//! ```text
//! v_h = v_n + h/2 a_n
//! x_{n+1} = x_n + h v_h
//! a_{n+1} = M^-1 f(t_{n+1}, x_{n+1}, v_h)
//! v_{n+1} = v_h + h/2 a_{n+1}
//! ```
//! The velocities that forces see lag behind by half a step, as v_h is all there is when a_{n+1} is made. So the order
//! is 2 for what depends on positions and 1 for what depends on velocities, and damping shortens the step:
//! w h < 2 (sqrt(1 + zeta^2) - zeta), as of Euler-Cromer, of which this is the centred form. Without velocity-dependent
//! forces it is velocity Verlet, bit for bit. Where a program changes values at t_n, a_n is found again with them at
//! v_h = v_n - h/2 a_n of the step before.

use super::kick_drift::KickDrift;
use crate::model::step_block::KickDriftScheme;

/// Central differences; a_n is the force of the point a step starts from.
pub const CENTRAL_DIFFERENCE: KickDrift = KickDrift {
    step: |h, _| KickDriftScheme { begin: 0.5 * h, drift: h, end: Some(0.5 * h), predicts: false },
    lags: true,
};
