//! Strides of schemes that kick, drift and kick: several steps on end, in place from the second on ([`crate::model::stride`]).
//!
//! Predictions for forces that depend on velocities have no place here: no system has strides where there are any.

use super::updates::{Product, Sizes, kick_then_drift};
use super::{Counters, StepInput};
use crate::model::point::Point;
use crate::model::stride::{Kicks, Passed};
use crate::model::system::{Around, Onward, System};
use std::ops::Range;

/// See [`super::Integrator::stride`].
pub(super) fn stride(
    kicks: Kicks,
    StepInput { system, from, t_next, .. }: StepInput<'_, dyn System>,
    to: &mut Point,
    passed: &mut [Passed],
    counters: &mut Counters,
) -> bool {
    to.state.t = t_next;
    counters.stride(system, to, &Start { from, kicks, inverse_mass: system.inverse_mass() }, passed)
}

/// The first step begins at a point; between steps nodes are moved by kicks.
struct Start<'a> {
    from: &'a Point,
    kicks: Kicks,
    inverse_mass: &'a [f64],
}

impl Around for Start<'_> {
    fn before(&self, dofs: Range<usize>, x: &mut [f64], v: &mut [f64]) {
        let (n, f) = (&self.from.state, &self.from.forces.total[dofs.clone()]);
        let from = (&n.x[dofs.clone()], &n.v[dofs.clone()]);
        let sizes = Sizes { kick: self.kicks.begin, drift: self.kicks.drift };
        kick_then_drift((x, v), from, Product { inverse_mass: &self.inverse_mass[dofs], f }, sizes);
    }
}

impl Onward for Start<'_> {
    fn kicks(&self) -> Kicks {
        self.kicks
    }
}
