//! Euler-Cromer, or symplectic Euler (thesis Eq. 15-16; Cromer 1981). Order 1, one evaluation a step.
//!
//! ```text
//! v_{n+1} = v_n + h M^-1 f(t_n, x_n, v_n)
//! x_{n+1} = x_n + h v_{n+1}
//! ```
//! Symplectic, not energy-conserving: on an oscillator it keeps v^2 + w^2 x^2 - w^2 h x v. Limit w h < 2 undamped,
//! 2 (sqrt(1 + zeta^2) - zeta) with damping ratio zeta.

use super::updates::{Sizes, kick_and_drift};
use super::{Counters, Integrator, StepError, StepInput, StepReport};
use crate::model::point::Point;
use crate::model::system::System;

/// Euler-Cromer; carries nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct EulerCromer;

impl Integrator<dyn System> for EulerCromer {
    fn start(&mut self, _system: &dyn System, _at: &Point) -> Result<(), StepError> {
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        to.state.t = t_next;
        kick_and_drift(system, &mut to.state, from, Sizes { kick: h, drift: h });
        counters.evaluate(system, to.state.as_ref(), &mut to.forces);
        Ok(StepReport { forces_at_end: true, ..Default::default() })
    }
}
