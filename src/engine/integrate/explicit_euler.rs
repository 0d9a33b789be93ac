//! Explicit Euler (thesis Eq. 11-12; Euler 1768). Order 1, one evaluation a step.
//!
//! ```text
//!  0 |
//! ---+---       x_{n+1} = x_n + h v_n
//!    | 1        v_{n+1} = v_n + h M^-1 f(t_n, x_n, v_n)
//! ```
//! Undamped oscillations grow for every h: the amplitude by sqrt(1 + (w h)^2) a step. With damping ratio zeta the limit
//! is w h < 2 zeta (oscillating case).

use super::runge_kutta::Tableau;

pub(super) static TABLEAU: Tableau = Tableau { stages: &[], b: &[1.0], pair: None };
