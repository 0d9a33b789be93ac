//! A network's springs as a graph, for schemes that filter along it.

use super::network::{Network, SpringBatch};
use crate::force::coefficient::Coefficient;
use crate::force::neighbours::Neighbours;
use crate::model::forces::Role;
use crate::model::system::{SpringGraph, Viscosity};
use glam::DVec3;
use std::ops::Range;

/// Every node's neighbours along springs.
#[derive(Debug)]
pub(super) struct Graph {
    /// by stiffness
    springs: Neighbours,
    /// by the coefficients c = k h of dashpots that the filter contains, where it does not contain all that is dissipative
    step_dashpots: Neighbours,
}

impl Graph {
    fn new(nodes: usize, springs: &[SpringBatch], viscosity: Viscosity) -> Self {
        fn links<'a>(b: &'a SpringBatch, weights: &'a Coefficient) -> (&'a [[u32; 2]], &'a Coefficient) {
            (&b.data.nodes, weights)
        }
        let some = springs.iter().filter(|b| b.in_filter && viscosity == Viscosity::Some);
        Graph {
            springs: Neighbours::new(nodes, springs.iter().map(|b| links(b, &b.data.stiffness))),
            step_dashpots: Neighbours::new(nodes, some.map(|b| links(b, &b.dashpot))),
        }
    }
}

/// c/k if it is the same for all springs.
fn seconds(springs: &[SpringBatch]) -> Option<f64> {
    let mut ratios = springs.iter().flat_map(|b| (0..b.edges.len()).map(|i| b.dashpot.at(i) / b.data.stiffness.at(i)));
    let first = ratios.next().filter(|r| r.is_finite() && *r > 0.0)?;
    ratios.all(|r| (r - first).abs() <= 4.0 * f64::EPSILON * first).then_some(first)
}

impl Network {
    fn graph(&self) -> &Graph {
        self.graph.get_or_init(|| Graph::new(self.mass.len(), &self.springs, self.viscosity()))
    }
}

impl SpringGraph for Network {
    fn stiffness_sums(&self) -> Vec<f64> {
        self.graph().springs.weights().take(self.mass.len()).collect()
    }

    fn weight(&self) -> Vec<f64> {
        let g = self.gravity.unwrap_or(DVec3::ZERO);
        self.mass.iter().flat_map(|&m| (m * g).to_array()).collect()
    }

    fn viscosity(&self) -> Viscosity {
        let dissipative = self.infos.iter().filter(|i| i.role == Role::Dissipative).count();
        let inside = self.springs.iter().filter(|b| b.in_filter).count();
        match (inside, seconds(&self.springs)) {
            (0, _) => Viscosity::None,
            (n, Some(seconds)) if n == dissipative && n == self.springs.len() => Viscosity::All { seconds },
            _ => Viscosity::Some,
        }
    }

    fn step_dashpots(&self, v: &[f64], dofs: Range<usize>, out: &mut [f64]) {
        self.graph().step_dashpots.differences(v, dofs, out);
    }

    fn neighbour_sums(&self, u: &[f64], dofs: Range<usize>, out: &mut [f64]) {
        self.graph().springs.sums(u, dofs, out);
    }

    fn neighbour_differences(&self, u: &[f64], dofs: Range<usize>, out: &mut [f64]) {
        self.graph().springs.differences(u, dofs, out);
    }
}
