//! The classical Runge-Kutta method (thesis Eq. 42-51; Kutta 1901). Order 4, four evaluations a step.
//!
//! ```text
//!   0  |
//!  1/2 | 1/2
//!  1/2 |  0   1/2                 y = (x, v),   k_i = (v_i, M^-1 f(t_i, x_i, v_i))
//!   1  |  0    0    1             y_{n+1} = y_n + h/6 (k_1 + 2 k_2 + 2 k_3 + k_4)
//! -----+--------------------
//!      | 1/6  1/3  1/3  1/6
//! ```
//! Limit on the imaginary axis w h < 2 sqrt 2.

use super::updates::{Slopes, accumulate_slopes, follow, follow_on, power, weigh};
use super::{Counters, Integrator, StageWork, StepError, StepInput, StepReport};
use crate::model::forces::Forces;
use crate::model::point::Point;
use crate::model::state::State;
use crate::model::system::System;

/// Stages from the second on: c_i, the only nonzero a_ij of the row, and weight b_i.
const STAGES: [(f64, f64); 3] = [(0.5, 1.0 / 3.0), (0.5, 1.0 / 3.0), (1.0, 1.0 / 6.0)];

/// The classical Runge-Kutta method; carries nothing.
#[derive(Clone, Debug, Default)]
pub struct Rk4 {
    stage: State,
    forces: Forces,
}

impl Integrator<dyn System> for Rk4 {
    fn start(&mut self, system: &dyn System, at: &Point) -> Result<(), StepError> {
        self.stage = at.state.clone();
        self.forces = system.new_forces();
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        let n = &from.state;
        to.state.t = t_next;
        let (x_n, v_n, times) = (n.x.as_slice(), n.v.as_slice(), [n.t, t_next]);
        let first = Slopes { u: v_n, f: &from.forces.total };
        follow(system, (&mut to.state.x, &mut to.state.v), (x_n, v_n), h / 6.0, first);
        let mut powers =
            [power(system, times, &from.forces), StageWork::default(), StageWork::default(), StageWork::default()];

        for (i, (c, b)) in STAGES.into_iter().enumerate() {
            let s = &mut self.stage;
            s.t = if c == 1.0 { t_next } else { n.t + c * h };
            match i {
                0 => follow(system, (&mut s.x, &mut s.v), (x_n, v_n), c * h, first),
                _ => follow_on(system, (&mut s.x, &mut s.v), (x_n, v_n), c * h, &self.forces.total),
            }
            counters.evaluate(system, s.as_ref(), &mut self.forces);
            let slopes = Slopes { u: &s.v, f: &self.forces.total };
            accumulate_slopes(system, (&mut to.state.x, &mut to.state.v), b * h, slopes);
            powers[i + 1] = power(system, times, &self.forces);
        }
        counters.evaluate(system, to.state.as_ref(), &mut to.forces);
        let [p1, p2, p3, p4] = powers;
        let work = weigh([(h / 6.0, p1), (h / 3.0, p2), (h / 3.0, p3), (h / 6.0, p4)]);
        Ok(StepReport { work: Some(work), forces_at_end: true, ..Default::default() })
    }
}
