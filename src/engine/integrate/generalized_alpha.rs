//! The generalised alpha method (Chung & Hulbert 1993, Eq. 15-18 and 25), set by the spectral radius at infinite
//! frequency. Order 2, unconditionally stable on linear problems.
//!
//! ```text
//! am = (2 r - 1)/(r + 1),  af = r/(r + 1),  gamma = 1/2 - am + af,  beta = (1 - am + af)^2/4,  r = rho_inf in [0, 1]
//! r = M [(1 - am) a_{n+1} + am a_n] - [(1 - af) f_{n+1} + af f_n],   x and v as Newmark's
//! ```
//! Forces are averaged as in HHT (not evaluated at an averaged state, which is another method on nonlinear problems).

use super::implicit::ImplicitScheme;
use super::stage::{NewmarkParameters, StageMap};

/// The generalised alpha method.
#[derive(Clone, Copy, Debug)]
pub struct GeneralizedAlpha {
    /// [-] spectral radius at infinite frequency, in [0, 1]
    pub rho_inf: f64,
}

impl ImplicitScheme for GeneralizedAlpha {
    fn map(&self, h: f64) -> StageMap {
        let r = self.rho_inf;
        let (am, af) = ((2.0 * r - 1.0) / (r + 1.0), r / (r + 1.0));
        let newmark = NewmarkParameters { beta: (1.0 - am + af).powi(2) / 4.0, gamma: 0.5 - am + af };
        StageMap { am, af, ..StageMap::newmark(newmark, h) }
    }
}
