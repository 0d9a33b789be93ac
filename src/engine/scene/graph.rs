//! A network's springs as a graph, for schemes that filter along it.

use super::acting::SpringBatch;
use super::network::{Network, node_state};
use crate::force::kernel::coefficient::Coefficient;
use crate::force::kernel::neighbours::Links;
use crate::force::kernel::neighbours::Neighbours;
use crate::force::law::one_sided::OneSided;
use crate::model::forces::Role;
use crate::model::links::{NoLinks, SpringLinks};
use crate::model::state::StateRef;
use crate::model::system::{SpringGraph, StepFilter, Viscosity};
use std::ops::Range;
use std::sync::{Arc, PoisonError, RwLock};

/// Every node's neighbours along springs.
#[derive(Debug)]
pub(super) struct Graph {
    /// by stiffness
    springs: Neighbours,
    /// by the coefficients c = k h of dashpots that the filter contains, where it does not contain all that is
    /// dissipative
    step_dashpots: Neighbours,
}

/// The graph of the springs that carry force where some do not, made when a scheme first asks for it.
#[derive(Debug, Default)]
pub(super) struct KnownGraph(RwLock<Option<Arc<Graph>>>);

impl KnownGraph {
    fn known(&self) -> Option<Arc<Graph>> {
        self.0.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Says that springs are others now.
    pub(super) fn forget(&self) {
        *self.0.write().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

impl Graph {
    fn new<'a>(nodes: usize, springs: impl Iterator<Item = &'a SpringBatch> + Clone, viscosity: Viscosity) -> Self {
        fn links<'a>(b: &'a SpringBatch, weights: &'a Coefficient) -> Links<'a> {
            Links { nodes: &b.data.nodes, weights }
        }
        let some = springs.clone().filter(|b| b.in_filter && viscosity == Viscosity::Some);
        Graph {
            springs: Neighbours::new(nodes, springs.map(|b| links(b, &b.data.stiffness))),
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
    fn graph(&self) -> Arc<Graph> {
        let make = || {
            let carrying: Vec<_> = self.carrying().collect();
            let springs = carrying.iter().map(|batch| &**batch);
            Arc::new(Graph::new(self.built.mass.len(), springs, self.viscosity()))
        };
        if !self.acting.springs.iter().any(|batch| batch.cut.some()) {
            return self.built.graph.get_or_init(make).clone();
        }
        self.graph.known().unwrap_or_else(|| {
            let made = make();
            *self.graph.0.write().unwrap_or_else(PoisonError::into_inner) = Some(made.clone());
            made
        })
    }
}

impl SpringGraph for Network {
    fn stiffness_sums(&self) -> Vec<f64> {
        self.graph().springs.weights().take(self.built.mass.len()).collect()
    }

    fn links(&self) -> Result<&dyn SpringLinks, NoLinks> {
        self.find_links()
    }

    fn weight(&self) -> Vec<f64> {
        let g = self.gravity();
        self.built.weighed.iter().flat_map(|&m| <[f64; 3]>::from(m * g)).collect()
    }

    fn viscosity(&self) -> Viscosity {
        let dissipative = self.arrangement.infos.iter().filter(|i| i.role == Role::Dissipative).count();
        let inside = self.acting.springs.iter().filter(|b| b.in_filter).count();
        match (inside, seconds(&self.acting.springs)) {
            (0, _) => Viscosity::None,
            (n, Some(seconds)) if n == dissipative && n == self.acting.springs.len() => Viscosity::All { seconds },
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

    fn step_filter(&self) -> Option<Box<dyn StepFilter>> {
        // A dashpot that was asked for acts along its spring, slack or not.
        let carrying: Vec<_> = self.carrying().collect();
        let members = carrying.iter().map(|batch| (&batch.data, !batch.in_filter));
        OneSided::new(self.built.mass.len(), members).map(|filter| Box::new(filter) as Box<dyn StepFilter>)
    }
}

impl StepFilter for OneSided {
    fn select(&mut self, from: StateRef<'_>, h: f64) -> bool {
        self.select(node_state(from), h)
    }

    fn stiffness_sums(&self, out: &mut [f64]) {
        self.stiffness_sums(out);
    }

    fn neighbour_sums(&self, u: &[f64], dofs: Range<usize>, out: &mut [f64]) {
        self.sums(u, dofs, out);
    }

    fn neighbour_differences(&self, u: &[f64], dofs: Range<usize>, out: &mut [f64]) {
        self.differences(u, dofs, out);
    }

    fn correction(&self) -> Option<&[f64]> {
        self.correction()
    }
}
