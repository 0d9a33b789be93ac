//! The classical Runge-Kutta method (thesis Eq. 42-51; Kutta 1901). Order 4, four evaluations a step.
//!
//! ```text
//!   0  |
//!  1/2 | 1/2
//!  1/2 |  0   1/2                 y = (x, v),   k_i = (v_i, M^-1 f(t_i, x_i, v_i))
//!   1  |  0    0    1             y_{n+1} = y_n + h/6 (k_1 + 2 k_2 + 2 k_3 + k_4)
//! -----+--------------------
//!      | 1/6  1/3  1/3  1/6
//! ```
//! Limit on the imaginary axis w h < 2 sqrt 2.

use super::runge_kutta::{Stage, Tableau};

pub(super) static TABLEAU: Tableau = Tableau {
    stages: &[
        Stage { c: 1.0 / 2.0, a: &[1.0 / 2.0] },
        Stage { c: 1.0 / 2.0, a: &[0.0, 1.0 / 2.0] },
        Stage { c: 1.0, a: &[0.0, 0.0, 1.0] },
    ],
    b: &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
    pair: None,
};
