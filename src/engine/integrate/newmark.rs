//! Newmark's method (Newmark 1959; thesis Eq. 25-26), with true Newton iterations on
//! r = M a_{n+1} - f(t_{n+1}, x_{n+1}, v_{n+1}). Order 2 at gamma = 1/2, else 1.
//!
//! ```text
//! x_{n+1} = x_n + h v_n + h^2 [(1/2 - beta) a_n + beta a_{n+1}]
//! v_{n+1} = v_n + h [(1 - gamma) a_n + gamma a_{n+1}]
//! ```
//! On linear problems stable for every h if 2 beta >= gamma >= 1/2; else for h/T <= 1/(pi sqrt2 sqrt(gamma - 2 beta))
//! (Eq. 27). The thesis' linear-incremental form (Eq. 28-36) has four misprints and drifts on nonlinear problems; it is
//! not implemented.

use super::implicit::ImplicitScheme;
use super::stage::{NewmarkParameters, StageMap};

/// Newmark's method with its parameters.
#[derive(Clone, Copy, Debug)]
pub struct Newmark(pub NewmarkParameters);

impl ImplicitScheme for Newmark {
    fn map(&self, h: f64) -> StageMap {
        StageMap::newmark(self.0, h)
    }
}
