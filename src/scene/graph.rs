//! A network's springs as a graph, for schemes that filter along it.

use super::network::{Network, SpringBatch, by_node};
use crate::force::NodeState;
use crate::force::batch::Summand;
use crate::force::neighbours::{Links, Neighbours};
use crate::force::relative_dashpot::{RelativeDashpots, RelativeData};
use crate::force::spring::Coefficient;
use crate::force::sweep::Sweep;
use crate::model::forces::Role;
use crate::model::system::{SpringGraph, Viscosity};
use glam::DVec3;

/// Passes over the springs that are not forces of the scene.
#[derive(Debug)]
pub(super) struct Graph {
    sums: Batches<Neighbours>,
    /// dashpots with c = k
    differences: Batches<RelativeDashpots>,
    /// dashpots with c = k h, as the scene has them
    step_dashpots: Batches<RelativeDashpots>,
}

/// Batches that are summed together.
#[derive(Debug)]
struct Batches<S> {
    batches: Vec<S>,
    sweep: Sweep,
}

impl<S: Summand> Batches<S> {
    fn new(nodes: usize, batches: impl Iterator<Item = S>) -> Self {
        let mut batches: Vec<S> = batches.collect();
        let mut summands: Vec<&mut dyn Summand> = batches.iter_mut().map(|b| b as &mut dyn Summand).collect();
        let sweep = Sweep::new(nodes, &mut summands);
        Batches { batches, sweep }
    }
}

impl Graph {
    fn new(nodes: usize, springs: &[SpringBatch]) -> Self {
        let dashpots = |b: &SpringBatch, coefficient: &Coefficient| {
            RelativeDashpots::new(RelativeData { nodes: b.data.nodes.clone(), coefficient: coefficient.clone() })
        };
        let links = |b: &SpringBatch| Links { nodes: b.data.nodes.clone(), stiffness: b.data.stiffness.clone() };
        let in_filter = springs.iter().filter(|b| b.in_filter).map(|b| dashpots(b, &b.dashpot));
        Graph {
            sums: Batches::new(nodes, springs.iter().map(|b| Neighbours::new(links(b)))),
            differences: Batches::new(nodes, springs.iter().map(|b| dashpots(b, &b.data.stiffness))),
            step_dashpots: Batches::new(nodes, in_filter),
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
        self.graph.get_or_init(|| Graph::new(self.mass.len(), &self.springs))
    }

    /// `out =` what a pass gives at x = v = u.
    fn graph_pass<S: Summand>(&self, pass: &Batches<S>, u: &[f64], out: &mut [f64]) {
        let at = NodeState { t: 0.0, x: by_node(u), v: by_node(u) };
        let out = [bytemuck::cast_slice_mut(out), &mut [], &mut []];
        pass.sweep.pass((pass.batches.as_slice(), at), &self.threads, out, &mut []);
    }
}

impl SpringGraph for Network {
    fn stiffness_sums(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.mass.len()];
        for b in &self.springs {
            for (i, ends) in b.data.nodes.iter().enumerate() {
                for &node in ends {
                    sums[node as usize] += b.data.stiffness.at(i);
                }
            }
        }
        sums
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

    fn step_dashpots(&self, v: &[f64], out: &mut [f64]) {
        self.graph_pass(&self.graph().step_dashpots, v, out);
    }

    fn neighbour_sums(&self, u: &[f64], out: &mut [f64]) {
        self.graph_pass(&self.graph().sums, u, out);
    }

    fn neighbour_differences(&self, u: &[f64], out: &mut [f64]) {
        self.graph_pass(&self.graph().differences, u, out);
    }
}
