//! Euler-Richardson, the midpoint rule (thesis Eq. 17-22). Order 2, two evaluations a step.
//!
//! ```text
//!   0  |
//!  1/2 | 1/2         v_m = v_n + h/2 a_n,   x_m = x_n + h/2 v_n,   a_m = M^-1 f(t_n + h/2, x_m, v_m)
//! -----+--------     v_{n+1} = v_n + h a_m
//!      |  0   1      x_{n+1} = x_n + h v_m
//! ```
//! Undamped oscillations grow by (w h)^4/8 a step.

use super::runge_kutta::{Stage, Tableau};

pub(super) static TABLEAU: Tableau =
    Tableau { stages: &[Stage { c: 1.0 / 2.0, a: &[1.0 / 2.0] }], b: &[0.0, 1.0], pair: None };
