//! Backward Euler (Baraff & Witkin 1998 for cloth, here with full Newton iterations). Order 1, damps everything.
//!
//! ```text
//! x_{n+1} = x_n + h v_{n+1}
//! v_{n+1} = v_n + h M^-1 f(t_{n+1}, x_{n+1}, v_{n+1})
//! ```

use super::implicit::ImplicitScheme;
use super::stage::StageMap;

/// Backward Euler.
#[derive(Clone, Copy, Debug)]
pub struct BackwardEuler;

impl ImplicitScheme for BackwardEuler {
    fn map(&self, h: f64) -> StageMap {
        StageMap { cv: 1.0 / h, ca: 1.0 / (h * h), av: -1.0 / h, ..Default::default() }
    }
}
