//! Improved Euler as printed, Heun's method (thesis Eq. 23-24; Heun 1900). Order 2, two evaluations a step.
//!
//! ```text
//!  0 |
//!  1 |  1              x~ = x_n + h v_n,   v~ = v_n + h a_n,   a~ = M^-1 f(t_n + h, x~, v~)
//! ---+---------        x_{n+1} = x_n + h/2 (v_n + v~)
//!    | 1/2  1/2        v_{n+1} = v_n + h/2 (a_n + a~)
//! ```
//! Undamped oscillations grow by (w h)^4/8 a step.

use super::runge_kutta::{Stage, Tableau};

pub(super) static TABLEAU: Tableau =
    Tableau { stages: &[Stage { c: 1.0, a: &[1.0] }], b: &[1.0 / 2.0, 1.0 / 2.0], pair: None };
