//! Euler-Richardson, the midpoint rule (thesis Eq. 17-22). Order 2, two evaluations a step.
//!
//! ```text
//! v_m = v_n + h/2 a_n,   x_m = x_n + h/2 v_n,   a_m = M^-1 f(t_n + h/2, x_m, v_m)
//! v_{n+1} = v_n + h a_m
//! x_{n+1} = x_n + h v_m
//! ```
//! Undamped oscillations grow by (w h)^4/8 a step.

use super::updates::{Slopes, follow, power, weigh};
use super::{Counters, Integrator, StepError, StepInput, StepReport};
use crate::model::forces::Forces;
use crate::model::point::Point;
use crate::model::state::State;
use crate::model::system::System;

/// Euler-Richardson; carries nothing, holds the midpoint.
#[derive(Clone, Debug, Default)]
pub struct EulerRichardson {
    middle: State,
    forces: Forces,
}

impl Integrator<dyn System> for EulerRichardson {
    fn start(&mut self, system: &dyn System, at: &Point) -> Result<(), StepError> {
        self.middle = at.state.clone();
        self.forces = system.new_forces();
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        let (n, m) = (&from.state, &mut self.middle);
        m.t = n.t + 0.5 * h;
        let from_n = (n.x.as_slice(), n.v.as_slice());
        follow(system, (&mut m.x, &mut m.v), from_n, 0.5 * h, Slopes { u: &n.v, f: &from.forces.total });
        counters.evaluate(system, m.as_ref(), &mut self.forces);

        to.state.t = t_next;
        let in_the_middle = Slopes { u: &m.v, f: &self.forces.total };
        follow(system, (&mut to.state.x, &mut to.state.v), from_n, h, in_the_middle);
        counters.evaluate(system, to.state.as_ref(), &mut to.forces);
        let work = weigh([(h, power(system, [n.t, t_next], &self.forces))]);
        Ok(StepReport { work: Some(work), forces_at_end: true, ..Default::default() })
    }
}
