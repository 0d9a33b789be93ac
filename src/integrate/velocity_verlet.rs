//! Velocity Verlet (thesis Eq. 37-40; Swope et al. 1982). Order 2, damped too; one evaluation a step, two if a force
//! depends on velocity.
//!
//! ```text
//! v_h = v_n + h/2 a_n
//! x_{n+1} = x_n + h v_h
//! a* = M^-1 f(t_{n+1}, x_{n+1}, v_n + h a_n)
//! v_{n+1} = v_h + h/2 a*
//! a_{n+1} = M^-1 f(t_{n+1}, x_{n+1}, v_{n+1})
//! ```
//! Eq. 39 is implicit in v when there is damping; a* at the predicted velocity makes it explicit and keeps order 2. Carrying
//! a* over to the next step instead of a_{n+1} would save an evaluation but lose stability (w h < 1.64 instead of 1.84 at damping
//! ratio 0.1). Without velocity-dependent forces a* = a_{n+1}. Limit w h < 2 undamped.

use super::updates::{Sizes, accumulate_kick, kick, kick_and_drift};
use super::{Counters, Integrator, StepError, StepInput, StepReport};
use crate::model::point::Point;
use crate::model::system::System;

/// Velocity Verlet; carries nothing (a_n is the force of the point it starts from).
#[derive(Clone, Copy, Debug, Default)]
pub struct VelocityVerlet;

impl Integrator<dyn System> for VelocityVerlet {
    fn start(&mut self, _system: &dyn System, _at: &Point) -> Result<(), StepError> {
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        let (n, f_n) = (&from.state, &from.forces.total);
        to.state.t = t_next;
        kick_and_drift(system, &mut to.state, from, Sizes { kick: 0.5 * h, drift: h });
        if system.velocity_dependent() {
            kick(system, &mut to.state.v, &n.v, h, f_n);
            counters.evaluate(system, to.state.as_ref(), &mut to.forces);
            kick(system, &mut to.state.v, &n.v, 0.5 * h, f_n);
            accumulate_kick(system, &mut to.state.v, 0.5 * h, &to.forces.total);
            counters.evaluate(system, to.state.as_ref(), &mut to.forces);
        } else {
            counters.evaluate(system, to.state.as_ref(), &mut to.forces);
            accumulate_kick(system, &mut to.state.v, 0.5 * h, &to.forces.total);
        }
        Ok(StepReport { forces_at_end: true, ..Default::default() })
    }
}
