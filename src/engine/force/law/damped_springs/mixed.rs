//! The springs of Newton's mixed iteration (`solve/mixed`): their tensions are unknowns, so the matrix has those in
//! place of the tensions that their lengths give.
//!
//! ```text
//! B = (t/l)(I - n n^T) + k n n^T          with an axial dashpot k = dT/dl + c dldot/dl
//! ```
//! The part of an axial dashpot that is not symmetric, (c/l) n [(I - n n^T)(vb - va)]^T, is left out.

use super::{DampedSprings, Dashpots};
use crate::force::law::curve::Bar;
use crate::force::law::slack::{TensionLaw, with_law};
use crate::force::law::spring::SpringsAt;
use crate::force::{NodeState, SpringTerm, TangentSink};
use crate::model::spec::DashpotKind;
use crate::model::spring_state::{SpringState, SpringTangent};
use crate::model::system::Weights;
use nalgebra::Matrix3;

impl DampedSprings {
    /// The axial dashpot of spring `i` [N s/m]; 0 without.
    fn axial_coefficient(&self, i: usize) -> f64 {
        match &self.dashpots {
            Some(Dashpots { kind: DashpotKind::Axial, coefficient }) => coefficient.at(i),
            _ => 0.0,
        }
    }

    fn state(
        &self,
        law: &impl TensionLaw,
        (springs_at, at): (SpringsAt<'_>, NodeState<'_>),
        i: usize,
        cv: f64,
    ) -> SpringState {
        let nodes = self.springs.nodes[i];
        let stretch = self.springs.stretch(springs_at, i);
        let bar: Bar = self.springs.bar(springs_at, i);
        let c = self.axial_coefficient(i);
        let [a, b] = nodes.map(|node| node as usize);
        let viscous = if c > 0.0 { c * stretch.n.dot(&(at.v[b] - at.v[a])) } else { 0.0 };
        let elastic = law.at(bar, stretch.elongation);
        let both_ways = SpringState {
            nodes,
            n: stretch.n,
            length: stretch.length,
            tension: elastic.force + viscous,
            taut: elastic.force + viscous,
            stiffness: elastic.slope + c * cv,
            least: f64::NEG_INFINITY,
        };
        match law.bounds(bar, stretch.elongation) {
            Some((taut, [lower, upper])) if lower.is_finite() || upper.is_finite() => {
                let sum = taut.force + viscous;
                let tension = sum.max(lower).min(upper);
                if upper.is_finite() {
                    return SpringState { tension, taut: tension, ..both_ways };
                }
                SpringState { tension, taut: sum, stiffness: taut.slope + c * cv, least: lower, ..both_ways }
            }
            _ => both_ways,
        }
    }
}

impl SpringTerm for DampedSprings {
    fn count(&self) -> usize {
        self.springs.nodes.len()
    }

    fn measure(&self, at: NodeState<'_>, cv: f64, out: &mut [SpringState]) {
        let springs_at = self.springs.at(at.t, at.x);
        with_law!(&self.springs.curve, self.springs.slack, law => {
            out.iter_mut().enumerate().for_each(|(i, out)| {
                *out = match self.cut.is_cut(i) {
                    true => SpringState::idle(self.springs.nodes[i]),
                    false => self.state(&law, (springs_at, at), i, cv),
                };
            });
        });
    }

    fn mixed_tangent(&self, at: NodeState<'_>, w: Weights, tangents: &[SpringTangent], sink: &mut dyn TangentSink) {
        let springs_at = self.springs.at(at.t, at.x);
        for ((i, &nodes), tangent) in self.springs.nodes.iter().enumerate().zip(tangents) {
            if self.cut.is_cut(i) {
                sink.edge(nodes, Matrix3::zeros());
                continue;
            }
            let stretch = self.springs.stretch(springs_at, i);
            let mut block = stretch.block(tangent.tension, tangent.stiffness) * w.k;
            if let Some(Dashpots { kind: DashpotKind::Relative, coefficient }) = &self.dashpots {
                block += Matrix3::from_diagonal_element(w.c * coefficient.at(i));
            }
            sink.edge(nodes, block);
        }
    }
}
