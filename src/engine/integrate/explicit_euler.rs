//! Explicit Euler (thesis Eq. 11-12; Euler 1768). Order 1, one evaluation a step.
//!
//! ```text
//! x_{n+1} = x_n + h v_n
//! v_{n+1} = v_n + h M^-1 f(t_n, x_n, v_n)
//! ```
//! Undamped oscillations grow for every h: the amplitude by sqrt(1 + (w h)^2) a step. With damping ratio zeta the limit
//! is w h < 2 zeta (oscillating case).

use super::updates::{Product, add_product, add_scaled};
use super::{Counters, Integrator, StepError, StepInput, StepReport};
use crate::model::point::Point;
use crate::model::system::System;

/// Explicit Euler; carries nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExplicitEuler;

impl Integrator<dyn System> for ExplicitEuler {
    fn start(&mut self, _system: &dyn System, _at: &Point) -> Result<(), StepError> {
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        let (n, a_n) = (&from.state, Product { inverse_mass: system.inverse_mass(), f: &from.forces.total });
        to.state.t = t_next;
        system.workers().both((&mut to.state.x, &mut to.state.v), |r, x, v| {
            let v_n = &n.v[r.clone()];
            add_scaled(x, &n.x[r.clone()], h, v_n);
            add_product(v, v_n, h, a_n.of(r));
        });
        counters.evaluate(system, to.state.as_ref(), &mut to.forces);
        Ok(StepReport { forces_at_end: true, ..Default::default() })
    }
}
