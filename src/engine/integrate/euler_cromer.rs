//! Euler-Cromer, or symplectic Euler (thesis Eq. 15-16; Cromer 1981). Order 1, one evaluation a step.
//!
//! ```text
//! v_{n+1} = v_n + h M^-1 f(t_n, x_n, v_n)
//! x_{n+1} = x_n + h v_{n+1}
//! ```
//! Symplectic, not energy-conserving: on an oscillator it keeps v^2 + w^2 x^2 - w^2 h x v. Limit w h < 2 undamped,
//! 2 (sqrt(1 + zeta^2) - zeta) with damping ratio zeta.

use super::kick_drift::KickDrift;
use crate::model::step_block::KickDriftScheme;

/// Euler-Cromer.
pub const EULER_CROMER: KickDrift =
    KickDrift { step: |h, _| KickDriftScheme { begin: h, drift: h, end: None, predicts: false }, lags: false };
