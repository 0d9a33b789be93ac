//! Strides of schemes that kick, drift and kick: several steps on end, in place from the second on ([`crate::model::stride`]).
//!
//! Predictions for forces that depend on velocities have no place here: no system has strides where there are any.

use super::updates::{Product, Sizes, accumulate_product, kick_and_drift, kick_then_drift};
use super::{Counters, StepInput};
use crate::model::point::Point;
use crate::model::stride::Passed;
use crate::model::system::{Around, Onward, System};
use std::ops::Range;

/// A step v += k M^-1 f, x += h v, then with the new forces v += l M^-1 f.
#[derive(Clone, Copy)]
pub(super) struct KickDriftKick {
    /// [s] k and h
    pub first: Sizes,
    /// [s] l, if there is a second kick
    pub second: Option<f64>,
}

impl KickDriftKick {
    /// See [`super::Integrator::stride`].
    pub fn stride(
        self,
        StepInput { system, from, t_next, .. }: StepInput<'_, dyn System>,
        to: &mut Point,
        passed: &mut [Passed],
        counters: &mut Counters,
    ) -> bool {
        to.state.t = t_next;
        counters.stride(system, to, &Kicks { steps: self, from, inverse_mass: system.inverse_mass() }, passed)
    }
}

struct Kicks<'a> {
    steps: KickDriftKick,
    from: &'a Point,
    inverse_mass: &'a [f64],
}

impl Around for Kicks<'_> {
    fn before(&self, dofs: Range<usize>, x: &mut [f64], v: &mut [f64]) {
        let (n, f) = (&self.from.state, &self.from.forces.total[dofs.clone()]);
        let from = (&n.x[dofs.clone()], &n.v[dofs.clone()]);
        kick_then_drift((x, v), from, Product { inverse_mass: &self.inverse_mass[dofs], f }, self.steps.first);
    }

    fn after(&self, dofs: Range<usize>, v: &mut [f64], f: &[f64]) {
        if let Some(l) = self.steps.second {
            accumulate_product(v, l, Product { inverse_mass: &self.inverse_mass[dofs], f });
        }
    }
}

impl Onward for Kicks<'_> {
    fn onward(&self, dofs: Range<usize>, x: &mut [f64], v: &mut [f64], f: &[f64]) {
        kick_and_drift((x, v), Product { inverse_mass: &self.inverse_mass[dofs], f }, self.steps.first);
    }
}
