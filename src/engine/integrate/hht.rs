//! Hilber, Hughes and Taylor's alpha method (1977, Eq. 1-5), alpha in [-1/3, 0]. Order 2, unconditionally stable on
//! linear problems, damps high frequencies.
//!
//! ```text
//! r = M a_{n+1} - (1 + alpha) f_{n+1} + alpha f_n
//! beta = (1 - alpha)^2/4,   gamma = 1/2 - alpha,   x and v as Newmark's
//! ```
//! Static equilibrium is x = F/K for every alpha (thesis Eq. 41's weights do not sum to one). Where a program sets
//! forces at t_n, f_n are those with the new values, and a_n goes on with its lag ([`implicit`](super::implicit)).

use super::implicit::ImplicitScheme;
use super::stage::{NewmarkParameters, StageMap};

/// The HHT method.
#[derive(Clone, Copy, Debug)]
pub struct Hht {
    /// [-] alpha in [-1/3, 0]
    pub alpha: f64,
}

impl ImplicitScheme for Hht {
    fn map(&self, h: f64) -> StageMap {
        let alpha = self.alpha;
        let newmark = NewmarkParameters { beta: (1.0 - alpha) * (1.0 - alpha) / 4.0, gamma: 0.5 - alpha };
        StageMap { af: -alpha, ..StageMap::newmark(newmark, h) }
    }
}
