//! Strides: several steps on end ([`crate::model::stride`]), of schemes that kick, drift and kick, and of Runge-Kutta
//! methods.

use super::{Counters, StepInput};
use crate::model::point::Point;
use crate::model::stride::{Kicks, Passed, Stages};
use crate::model::system::{Around, Onward, System};
use std::ops::Range;

/// See [`super::Integrator::stride`].
pub(super) fn stride(
    (first, kicks): (&dyn Around, Kicks),
    StepInput { system, from, t_next, .. }: StepInput<'_, dyn System>,
    to: &mut Point,
    passed: &mut [Passed],
    counters: &mut Counters,
) -> bool {
    debug_assert!(passed.last().is_none_or(|last| last.t == t_next));
    to.state.t = t_next;
    counters.stride(system, to, &Stride { first, from, kicks }, passed)
}

/// The same of steps by stages.
pub(super) fn stride_by_stages(
    stages: Stages<'_>,
    StepInput { system, from, t_next, .. }: StepInput<'_, dyn System>,
    to: &mut Point,
    passed: &mut [Passed],
    counters: &mut Counters,
) -> bool {
    debug_assert!(passed.last().is_none_or(|last| last.t == t_next));
    to.state.t = t_next;
    counters.stride_by_stages(system, to, (from, stages), passed)
}

/// The first step is made as one alone; then nodes are moved by kicks.
struct Stride<'a> {
    first: &'a dyn Around,
    from: &'a Point,
    kicks: Kicks,
}

impl Around for Stride<'_> {
    fn before(&self, dofs: Range<usize>, x: &mut [f64], v: &mut [f64]) {
        self.first.before(dofs, x, v);
    }

    fn after(&self, dofs: Range<usize>, v: &mut [f64], f: &[f64]) {
        self.first.after(dofs, v, f);
    }
}

impl Onward for Stride<'_> {
    fn kicks(&self) -> Kicks {
        self.kicks
    }

    fn from(&self) -> &Point {
        self.from
    }
}
