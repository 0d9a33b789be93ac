//! The pair of Dormand & Prince (1980, J. Comp. Appl. Math. 6, 19-26), known as RK5(4)7M or DOPRI5. Order 5, six
//! evaluations a step.
//!
//! ```text
//!   0   |
//!  1/5  | 1/5
//!  3/10 | 3/40         9/40
//!  4/5  | 44/45       -56/15        32/9
//!  8/9  | 19372/6561  -25360/2187   64448/6561  -212/729
//!   1   | 9017/3168   -355/33       46732/5247   49/176   -5103/18656
//! ------+-----------------------------------------------------------------
//!   b   | 35/384       0            500/1113     125/192  -2187/6784     11/84
//!   e   | 71/57600     0           -71/16695     71/1920  -17253/339200  22/525  -1/40
//! ```
//! The seventh slope is that of the new point; the result is the solution of order 5, the estimate its difference from
//! that of order 4 (Hairer, Norsett & Wanner 1993, Table II.5.2). On linear problems a step is R(z) = sum over k <= 5
//! of z^k/k! + z^6/600, with
//! |R(iy)| = 1 - y^6/3600 + ...: undamped oscillations die out slowly up to w h = 0.997 and grow slowly above.

use super::PairInfo;
use super::runge_kutta::{Estimate, Pair, Stage, Tableau};

/// [-] R - e^z over e and over z: z^6/3600 and -97/120000 z^5. A controller of order 5 settles lower than one of order
/// 4, which is why steps get 1.5 times as much (`tests/claims/tolerance.rs`).
pub(super) const LINEAR: f64 = (1.0 / 3600.0) / (97.0 / 120_000.0);

pub(super) static TABLEAU: Tableau = Tableau {
    stages: &[
        Stage { c: 1.0 / 5.0, a: &[1.0 / 5.0] },
        Stage { c: 3.0 / 10.0, a: &[3.0 / 40.0, 9.0 / 40.0] },
        Stage { c: 4.0 / 5.0, a: &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0] },
        Stage { c: 8.0 / 9.0, a: &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0] },
        Stage { c: 1.0, a: &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0] },
    ],
    b: &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
    pair: Some(Pair {
        estimate: Estimate::One(&[
            71.0 / 57600.0,
            0.0,
            -71.0 / 16695.0,
            71.0 / 1920.0,
            -17253.0 / 339_200.0,
            22.0 / 525.0,
            -1.0 / 40.0,
        ]),
        info: PairInfo { leading: LINEAR / 1.5 },
    }),
};
