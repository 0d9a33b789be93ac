//! Euler-Cromer, or symplectic Euler (thesis Eq. 15-16; Cromer 1981). Order 1, one evaluation a step.
//!
//! ```text
//! v_{n+1} = v_n + h M^-1 f(t_n, x_n, v_n)
//! x_{n+1} = x_n + h v_{n+1}
//! ```
//! Symplectic, not energy-conserving: on an oscillator it keeps v^2 + w^2 x^2 - w^2 h x v. Limit w h < 2 undamped,
//! 2 (sqrt(1 + zeta^2) - zeta) with damping ratio zeta.

use super::strides::stride;
use super::updates::{BeforeAndAfter, Product, Sizes, kick_then_drift, nothing};
use super::{Counters, Integrator, StepError, StepInput, StepReport};
use crate::model::point::Point;
use crate::model::stride::{Kicks, Passed};
use crate::model::system::{Around, System};
use std::ops::Range;

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
        counters.evaluate_around(system, to, &around(system, from, h));
        Ok(StepReport { forces_at_end: true, ..Default::default() })
    }

    fn stride(
        &mut self,
        step: StepInput<'_, dyn System>,
        to: &mut Point,
        passed: &mut [Passed],
        counters: &mut Counters,
    ) -> bool {
        let kicks = Kicks { begin: step.h, drift: step.h, end: None, predicts: false };
        stride((&around(step.system, step.from, step.h), kicks), step, to, passed, counters)
    }
}

/// What a step does before its force pass.
fn around<'a>(system: &'a dyn System, from: &'a Point, h: f64) -> impl Around + 'a {
    let (n, a_n) = (&from.state, Product { inverse_mass: system.inverse_mass(), f: &from.forces.total });
    let before = move |r: Range<usize>, x: &mut [f64], v: &mut [f64]| {
        let from = (&n.x[r.clone()], &n.v[r.clone()]);
        kick_then_drift((x, v), from, a_n.of(r), Sizes { kick: h, drift: h });
    };
    BeforeAndAfter { before, after: nothing }
}
