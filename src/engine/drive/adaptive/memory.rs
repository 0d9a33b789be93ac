//! How long a scene remembers an error.
//!
//! Damping makes an error of velocity e decay at the rate lambda/2, where lambda is the Rayleigh quotient (e.C e)/(e.M
//! e). If all errors of a run of duration T decayed at that rate, their sum at its end would be smaller by a factor
//! 2/(lambda T). But the quotient is dominated by motions that decay fast, and does not show those that decay slowly,
//! so only the square root of that factor is used.

use serde::{Deserialize, Serialize};

use crate::model::state::StateRef;
use crate::model::system::Weights;
use crate::scene::Scene;

/// Accepted steps between two quotients; each quotient costs a product with C.
const INTERVAL: u32 = 16;

/// The rate at which errors are forgotten; part of a checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// [1/s] lambda
    rate: f64,
    /// accepted steps since it was found
    age: u32,
}

impl Memory {
    /// [-] Sum of the local errors of a run of `end` [s] over the error at its end.
    pub fn forgetting(&self, end: f64) -> f64 {
        (0.5 * self.rate * end).max(1.0).sqrt()
    }

    /// After an accepted step that ended at `at` with the local error `e` [m/s] `[n_dof]`; `product` `[n_dof]` is the
    /// buffer for C e.
    pub fn refresh(&mut self, scene: &dyn Scene, at: StateRef<'_>, e: &[f64], product: &mut [f64]) {
        self.age = (self.age + 1) % INTERVAL;
        if self.age != 1 || !scene.velocity_dependent() {
            return;
        }
        scene.tangent_times(at, Weights { m: 0.0, c: 1.0, k: 0.0 }, e, product);
        let damped: f64 = e.iter().zip(&*product).map(|(e, c)| e * c).sum();
        let found = damped / (2.0 * scene.kinetic_energy(e));
        if found.is_finite() && found > 0.0 {
            self.rate = if self.rate > 0.0 { (self.rate * found).sqrt() } else { found };
        }
    }
}
