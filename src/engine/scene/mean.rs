//! The forces of a step of an energy-momentum method: elastic ones as means over the step, all others in its middle.

use super::network::Network;
use crate::force::schedule::terms::{Term, Terms};
use crate::force::schedule::threads::SUMS;
use crate::force::{MeanStep, TangentForm, TangentSink};
use crate::model::forces::Tally;
use crate::model::system::Weights;
use nalgebra::Vector3;

impl Network {
    /// A pass over the terms, then over the elements whose forces [N] are means: in one thread and one order.
    pub(super) fn mean_pass(&self, step: MeanStep<'_>, sums: [&mut [Vector3<f64>]; SUMS], tallies: &mut [Tally]) {
        let [total, external, dissipative] = sums;
        let others = [&mut *total, external, dissipative];
        self.sweep.pass(&WithoutMeans(self), step.at, &self.threads, others, tallies);
        for (term, parts) in self.acting.terms.iter().zip(&self.arrangement.parts) {
            if let (Some(mean), Some(part)) = (term.mean(), parts[0]) {
                tallies[part.tally] = mean.add_mean(step, total);
            }
        }
    }

    /// As `emit_tangents`, with elastic forces that are means over a step.
    pub(super) fn emit_mean_tangents(
        &self,
        step: MeanStep<'_>,
        w: Weights,
        form: TangentForm,
        sink: &mut dyn TangentSink,
    ) {
        for term in &self.acting.terms {
            match term.mean() {
                Some(mean) => mean.mean_tangent(step, w, form, sink),
                None => term.tangent(step.at, w, form, sink),
            }
        }
    }
}

/// The terms without the parts that are means.
struct WithoutMeans<'a>(&'a Network);

impl Terms for WithoutMeans<'_> {
    fn count(&self) -> usize {
        self.0.count()
    }

    fn tallies(&self) -> usize {
        self.0.tallies()
    }

    fn term(&self, i: usize) -> Term<'_> {
        let Term { forces, mut parts } = self.0.term(i);
        if self.0.acting.terms[i].mean().is_some() {
            parts[0] = None;
        }
        Term { forces, parts }
    }
}
