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
//! Eq. 39 is implicit in v when there is damping; a* at the predicted velocity makes it explicit and keeps order 2.
//! Carrying a* over to the next step instead of a_{n+1} would save an evaluation but lose stability (w h < 1.64 instead
//! of 1.84 at damping ratio 0.1). Both stand at x_{n+1}, so that springs and weight are found once for the two. Without
//! velocity-dependent forces a* = a_{n+1}. Limit w h < 2 undamped.

use super::strides::stride;
use super::updates::{BeforeAndAfter, Product, Sizes, accumulate_product, add_product, kick_then_drift};
use super::{Counters, Integrator, StepError, StepInput, StepReport};
use crate::model::point::Point;
use crate::model::stride::{Kicks, Passed};
use crate::model::system::{Around, System};
use std::ops::Range;

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
        to.state.t = t_next;
        let around = around(system, from, h);
        match system.velocity_dependent() {
            false => counters.evaluate_around(system, to, &around),
            true => counters.evaluate_twice(system, to, &around),
        }
        Ok(StepReport { forces_at_end: true, ..Default::default() })
    }

    fn stride(
        &mut self,
        step: StepInput<'_, dyn System>,
        to: &mut Point,
        passed: &mut [Passed],
        counters: &mut Counters,
    ) -> bool {
        let (h, predicts) = (step.h, step.system.velocity_dependent());
        let kicks = Kicks { begin: 0.5 * h, drift: h, end: Some(0.5 * h), predicts };
        stride((&around(step.system, step.from, h), kicks), step, to, passed, counters)
    }
}

/// What a step does before its force pass and after it or, where forces depend on velocity, between both.
fn around<'a>(system: &'a dyn System, from: &'a Point, h: f64) -> impl Around + 'a {
    let (n, a_n) = (&from.state, Product { inverse_mass: system.inverse_mass(), f: &from.forces.total });
    let predicts = system.velocity_dependent();
    let before = move |r: Range<usize>, x: &mut [f64], v: &mut [f64]| {
        let (x_n, v_n) = (&n.x[r.clone()], &n.v[r.clone()]);
        kick_then_drift((x, v), (x_n, v_n), a_n.of(r.clone()), Sizes { kick: 0.5 * h, drift: h });
        if predicts {
            // a* is taken at v_n + h a_n ...
            add_product(v, v_n, h, a_n.of(r));
        }
    };
    let after = move |r: Range<usize>, v: &mut [f64], f: &[f64]| {
        if predicts {
            // ... and added to v_h.
            add_product(v, &n.v[r.clone()], 0.5 * h, a_n.of(r.clone()));
        }
        accumulate_product(v, 0.5 * h, Product { inverse_mass: &a_n.inverse_mass[r], f });
    };
    BeforeAndAfter { before, after }
}
