//! The springs that limit explicit steps most, as a network of their own nodes.
//!
//! The springs and dashpots at a node, bounded by its elements ([`super::bound`]), allow steps of central differences
//! up to h = 4/(c + sqrt(c^2 + 4 k)), with k and c the largest eigenvalues of these bounds on K and C, over its mass.
//! Springs count as taut, in the directions that they have at t = 0. A spring is stiff if a node at one of its ends
//! allows less than some number of times the shortest of these steps.

use super::acting::{Acting, SpringBatch};
use super::bound::{FORM, largest_by_node};
use super::events::Phases;
use super::network::{Built, Network, node_state};
use super::numbering::Numbering;
use crate::force::ForceTerm;
use crate::force::law::damped_springs::{DampedSprings, Dashpots};
use crate::force::law::spring::Coefficient;
use crate::force::{TangentSink, outer};
use crate::format_number::counted;
use crate::mesh::Mesh;
use crate::model::at_dof::AtDof;
use crate::model::forces::Role;
use crate::model::spec::DashpotKind;
use crate::model::state::StateRef;
use crate::model::system::{BesideStiff, StiffPart, StiffSprings, System, Weights};
use nalgebra::Matrix3;
use std::collections::BTreeSet;
use std::sync::Arc;

impl StiffSprings for Network {
    fn stiff_part(&self, ratio: f64) -> Option<StiffPart> {
        let is_short = self.short_nodes(ratio);
        let is_stiff = |nodes: &[u32; 2]| nodes.iter().any(|&node| is_short(node));
        let carrying: Vec<_> = self.carrying().collect();
        let all = carrying.iter().flat_map(|batch| batch.data.nodes.iter());
        let mut nodes: Vec<u32> = all.filter(|nodes| is_stiff(nodes)).flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        if nodes.is_empty() {
            return None;
        }
        let place = |node: u32| nodes.partition_point(|&before| before < node) as u32;
        let stiff = |batch: &SpringBatch| -> Vec<usize> {
            (0..batch.edges.len()).filter(|&i| is_stiff(&batch.data.nodes[i])).collect()
        };
        let parts = carrying.iter().map(|batch| batch.part(&stiff(batch), place));
        let springs: Vec<SpringBatch> = parts.filter(|batch| !batch.edges.is_empty()).collect();
        let count: usize = springs.iter().map(|batch| batch.data.nodes.len()).sum();
        let share = count as f64 / self.acting.terms.iter().map(|term| term.elements()).sum::<usize>() as f64;
        let dofs = nodes.iter().flat_map(|&node| 3 * node..3 * node + 3).collect();
        log::info!(
            "stiff springs: {} at {}, {:.0} % of all elements",
            counted(count as u64, "spring", "springs"),
            counted(nodes.len() as u64, "node", "nodes"),
            100.0 * share
        );
        Some(StiffPart { dofs, share, system: Box::new(self.of_springs(springs, &nodes)) })
    }

    fn beside_stiff(&self, ratio: f64, at: StateRef<'_>) -> Option<BesideStiff> {
        let is_short = self.short_nodes(ratio);
        let is_stiff = |nodes: &[u32; 2]| nodes.iter().any(|&node| is_short(node));
        if !self.carrying().any(|batch| batch.data.nodes.iter().any(is_stiff)) {
            return None;
        }
        // Springs are the first terms, one a batch.
        let (springs, others) = self.acting.terms.split_at(self.acting.springs.len());
        let bound = |w: Weights| {
            self.bound_in_rounds(|sink| {
                let mut rest = Rest { is_stiff: &is_stiff, sink };
                springs.iter().for_each(|term| term.tangent(node_state(at), w, FORM, &mut rest));
                others.iter().for_each(|term| term.tangent(node_state(at), w, FORM, rest.sink));
                self.emit_law_tangents(at, w, FORM, rest.sink);
            })
        };
        let elastic = others.iter().filter(|term| term.parts().iter().any(|part| part.role == Role::Elastic));
        let mut elements = elastic.flat_map(|term| (0..term.elements()).filter_map(|i| term.element(i)));
        Some(BesideStiff {
            stiffness: bound(Weights { m: 0.0, c: 0.0, k: 1.0 }),
            damping: match self.velocity_dependent() {
                true => bound(Weights { m: 0.0, c: 1.0, k: 0.0 }),
                false => AtDof::default(),
            },
            on_short_nodes: elements.any(|nodes| nodes.iter().any(|&node| is_short(node))),
        })
    }
}

impl Network {
    /// These springs alone, of which node `i` is `nodes[i]` here.
    fn of_springs(&self, springs: Vec<SpringBatch>, nodes: &[u32]) -> Network {
        let of = |node: &u32| *node as usize;
        let mass: Arc<[f64]> = nodes.iter().map(|node| self.built.mass[of(node)]).collect();
        let fixed: Vec<[bool; 3]> = nodes.iter().map(|node| self.phase().fixed[of(node)]).collect();
        let all_moved: BTreeSet<u32> = self.phase().moved.dofs.iter().copied().collect();
        let dofs = (0..).zip(nodes.iter().flat_map(|node| 3 * node..3 * node + 3));
        let moved = dofs.filter(|(_, dof)| all_moved.contains(dof)).map(|(own, _)| own).collect();
        let built = Built {
            numbering: Numbering { user: nodes.to_vec(), internal: Vec::new() },
            phases: Phases::lasting(fixed, &mass, moved),
            weighed: mass.clone(),
            mass,
            start: nodes.iter().map(|node| self.built.start[of(node)]).collect(),
            ..Built::default()
        };
        let terms = springs.iter().map(|batch| Box::new(springs_of(batch)) as Box<dyn ForceTerm>).collect();
        Network::new(built, Acting { terms, springs, ..Acting::default() }, None, Mesh::default(), self.threads.again())
    }

    /// Which nodes allow less than `ratio` times the shortest step.
    fn short_nodes(&self, ratio: f64) -> impl Fn(u32) -> bool + use<> {
        let steps = self.allowed_steps();
        let limit = ratio * steps.iter().copied().fold(f64::INFINITY, f64::min);
        move |node| steps[node as usize] < limit
    }

    /// [s] The step that the springs at each node allow, infinite where there are none.
    fn allowed_steps(&self) -> Vec<f64> {
        let fixed = &self.phase().fixed;
        // All directions for a spring without one.
        let along = |[a, b]: [u32; 2]| {
            let n = (self.built.start[b as usize] - self.built.start[a as usize]).try_normalize(0.0);
            n.map_or(Matrix3::identity(), |n| outer(n, n))
        };
        let by_node = |block: &dyn Fn(&SpringBatch, usize) -> Matrix3<f64>| {
            largest_by_node(fixed, |sink| {
                for batch in self.carrying() {
                    batch.data.nodes.iter().enumerate().for_each(|(i, &nodes)| sink.edge(nodes, block(&batch, i)));
                }
            })
        };
        let stiffness = by_node(&|batch, i| along(batch.data.nodes[i]) * batch.data.stiffness.at(i));
        let damping = by_node(&|batch, i| match batch.axial {
            true => along(batch.data.nodes[i]) * batch.dashpot.at(i),
            false => Matrix3::from_diagonal_element(batch.dashpot.at(i)),
        });
        let rates = stiffness.iter().zip(&damping).zip(self.built.mass.iter()).zip(fixed);
        let step = |(((k, c), m), fixed): (((&f64, &f64), &f64), &[bool; 3])| {
            let held = *fixed == [true; 3];
            if held { f64::INFINITY } else { 4.0 / (c / m + ((c / m).powi(2) + 4.0 * k / m).sqrt()) }
        };
        rates.map(step).collect()
    }
}

/// Takes the tangents of springs that are not stiff.
struct Rest<'a, F> {
    is_stiff: &'a F,
    sink: &'a mut dyn TangentSink,
}

impl<F: Fn(&[u32; 2]) -> bool> TangentSink for Rest<'_, F> {
    fn pair(&mut self, nodes: [u32; 2], block: Matrix3<f64>) {
        self.sink.pair(nodes, block);
    }

    fn edge(&mut self, nodes: [u32; 2], block: Matrix3<f64>) {
        if !(self.is_stiff)(&nodes) {
            self.sink.edge(nodes, block);
        }
    }

    fn segment(&mut self, nodes: [u32; 2], blocks: &[[Matrix3<f64>; 2]; 2]) {
        self.sink.segment(nodes, blocks);
    }

    fn triangle(&mut self, nodes: [u32; 3], blocks: &[[Matrix3<f64>; 3]; 3]) {
        self.sink.triangle(nodes, blocks);
    }

    fn none(&mut self, nodes: &[u32]) {
        self.sink.none(nodes);
    }

    fn few(&mut self, nodes: &[u32], blocks: &[[Matrix3<f64>; 4]; 4]) {
        self.sink.few(nodes, blocks);
    }
}

fn springs_of(batch: &SpringBatch) -> DampedSprings {
    let kind = if batch.axial { DashpotKind::Axial } else { DashpotKind::Relative };
    let coefficient = batch.dashpot.clone();
    let dashpots = (!matches!(coefficient, Coefficient::Uniform(0.0))).then_some(Dashpots { kind, coefficient });
    DampedSprings::new(batch.data.clone(), dashpots).cut_with(batch.cut.clone())
}
