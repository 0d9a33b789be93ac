//! Elastic forces as means over a step: discrete gradients of their energies (Greenspan 1984; Simo & Tarnow 1992;
//! Gonzalez 1996).
//!
//! ```text
//! x_0 = x - h/2 v,   x_1 = x + h/2 v                        the ends of a step with the middle x, v
//! -f . (x_1 - x_0) = V(x_1) - V(x_0) + D,   D >= 0          sum f = 0,  sum x f^T symmetric
//! ```
//! D = 0 without dissipation. With chi > 0, chi/2 of the change of the stress s over the step is added to its mean
//! (Armero & Romero 2001, their internal dissipation of first order): D = chi/2 (s_1 - s_0) . (e_1 - e_0), which is
//! never negative, as the stress grows with the strain e.

use super::{NodeState, RankOne, TangentForm, TangentSink};
use crate::model::forces::Tally;
use crate::model::system::{StepMean, Weights};
use nalgebra::Vector3;

/// A step, by the state in its middle.
#[derive(Clone, Copy, Debug)]
pub struct MeanStep<'a> {
    /// the middle
    pub at: NodeState<'a>,
    /// the size of the step, and its dissipation
    pub mean: StepMean,
}

impl MeanStep<'_> {
    /// [m] The vectors from node `a` to node `b`: at the start, in the middle and at the end.
    pub(in crate::force) fn sides(&self, [a, b]: [u32; 2]) -> [Vector3<f64>; 3] {
        let NodeState { x, v, .. } = self.at;
        let [a, b] = [a, b].map(|node| node as usize);
        let (middle, change) = (x[b] - x[a], (v[b] - v[a]) * self.mean.half);
        [middle - change, middle, middle + change]
    }
}

/// The elastic part of a term, its first part, as a mean over a step.
pub trait MeanForce {
    /// Adds the force [N] to `f` `[n_nodes]`. For springs whose rest lengths change, returns their
    /// [power](Tally::power).
    fn add_mean(&self, step: MeanStep<'_>, f: &mut [Vector3<f64>]) -> Tally;

    /// As [`ForceTerm::tangent`](super::ForceTerm::tangent), for all parts. -df/dx is that of a middle which moves
    /// while x_0 stays; other parts than the elastic one have that in the middle.
    fn mean_tangent(&self, step: MeanStep<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink);

    /// As [`ForceTerm::rank_one`](super::ForceTerm::rank_one), of -df/dx as `mean_tangent` has it.
    fn mean_rank_one(&self, which: usize, step: MeanStep<'_>, w: Weights, part: RankOne<'_>) {
        let _ = (which, step, w);
        part.u.fill(Vector3::zeros());
        part.g.fill(Vector3::zeros());
    }
}
