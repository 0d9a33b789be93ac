//! Improved Euler as printed, Heun's method (thesis Eq. 23-24; Heun 1900). Order 2, two evaluations a step.
//!
//! ```text
//! x~ = x_n + h v_n,   v~ = v_n + h a_n,   a~ = M^-1 f(t_n + h, x~, v~)
//! x_{n+1} = x_n + h/2 (v_n + v~)
//! v_{n+1} = v_n + h/2 (a_n + a~)
//! ```
//! Undamped oscillations grow by (w h)^4/8 a step.

use super::updates::{Slopes, accumulate_slopes, follow, power, weigh};
use super::{Counters, Integrator, StepError, StepInput, StepReport};
use crate::model::forces::Forces;
use crate::model::point::Point;
use crate::model::state::State;
use crate::model::system::System;

/// Heun's method; carries nothing, holds the predicted state.
#[derive(Clone, Debug, Default)]
pub struct ImprovedEuler {
    predicted: State,
    forces: Forces,
}

impl Integrator<dyn System> for ImprovedEuler {
    fn start(&mut self, system: &dyn System, at: &Point) -> Result<(), StepError> {
        self.predicted = at.state.clone();
        self.forces = system.new_forces();
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        let (n, p) = (&from.state, &mut self.predicted);
        p.t = t_next;
        let (from_n, at_n) = ((n.x.as_slice(), n.v.as_slice()), Slopes { u: &n.v, f: &from.forces.total });
        follow(system, (&mut p.x, &mut p.v), from_n, h, at_n);
        counters.evaluate(system, p.as_ref(), &mut self.forces);

        to.state.t = t_next;
        follow(system, (&mut to.state.x, &mut to.state.v), from_n, 0.5 * h, at_n);
        let at_end = Slopes { u: &p.v, f: &self.forces.total };
        accumulate_slopes(system, (&mut to.state.x, &mut to.state.v), 0.5 * h, at_end);
        counters.evaluate(system, to.state.as_ref(), &mut to.forces);
        let [p1, p2] = [&from.forces, &self.forces].map(|forces| power(system, [n.t, t_next], forces));
        let work = weigh([(0.5 * h, p1), (0.5 * h, p2)]);
        Ok(StepReport { work: Some(work), forces_at_end: true, ..Default::default() })
    }
}
