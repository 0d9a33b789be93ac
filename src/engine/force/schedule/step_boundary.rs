//! The updates of nodes between the force passes of a block of steps.
//!
//! Work is summed in halves: when a step ends, the work over this step of the forces at its end; when the next step
//! begins, their work over that step.

use crate::force::NodeState;
use crate::force::schedule::workspace::WorkspaceView;
use crate::model::forces::Forces;
use crate::model::point::Point;
use crate::model::step_block::BoundarySums;
use crate::model::step_block::{NodeSums, Nodes, StepStart, Work, Working};
use crate::model::system::KickDriftBlock;
use crate::model::workers::Workers;
use bytemuck::{cast_slice, cast_slice_mut};
use nalgebra::Vector3;
use std::ops::Range;

/// The state of a range of nodes, to be moved.
pub(crate) struct NodeStateMut<'a> {
    /// [s]
    pub t: f64,
    /// number of the first node
    pub first: usize,
    /// [m]
    pub x: &'a mut [f64],
    /// [m/s]
    pub v: &'a mut [f64],
}

impl NodeStateMut<'_> {
    /// The state, read-only.
    pub(super) fn state(&self) -> NodeState<'_> {
        NodeState { t: self.t, x: cast_slice(self.x), v: cast_slice(self.v) }
    }

    /// Some of the nodes.
    pub(super) fn within(&mut self, nodes: Range<usize>) -> NodeStateMut<'_> {
        let dofs = 3 * (nodes.start - self.first)..3 * (nodes.end - self.first);
        let (x, v) = (&mut self.x[dofs.clone()], &mut self.v[dofs]);
        NodeStateMut { t: self.t, first: nodes.start, x, v }
    }

    /// Splits the nodes at one of them.
    pub(super) fn split(self, at: usize) -> [Self; 2] {
        let NodeStateMut { t, first, x, v } = self;
        let ((x, x_after), (v, v_after)) = (x.split_at_mut(3 * (at - first)), v.split_at_mut(3 * (at - first)));
        [NodeStateMut { t, first, x, v }, NodeStateMut { t, first: at, x: x_after, v: v_after }]
    }
}

/// The scheme of the steps, and its data of nodes.
#[derive(Clone, Copy)]
pub(crate) struct StepBoundary<'a> {
    /// the scheme, and the point at which the first step begins
    pub block: KickDriftBlock<'a>,
    /// [kg] `[n_nodes]`
    pub mass: &'a [f64],
    /// [1/kg] by degree of freedom, 0 at fixed ones
    pub inverse_mass: &'a [f64],
}

impl StepBoundary<'_> {
    /// Moves nodes to the positions of the first force pass.
    pub(in crate::force) fn begin(&self, NodeStateMut { first, x, v, .. }: NodeStateMut<'_>, workers: &Workers) {
        let scheme = self.block.scheme;
        workers.both(x, v, |r, x, v| scheme.begin(self.start(3 * first + r.start..3 * first + r.end), x, v));
    }

    /// The kick after the first force pass.
    pub(in crate::force) fn kick_again(
        &self,
        part: &WorkspaceView<'_>,
        NodeStateMut { first, v, .. }: NodeStateMut<'_>,
    ) {
        let start = self.start(3 * first..3 * first + v.len());
        self.block.scheme.kick_again(start, v, cast_slice(part.out[0]));
    }

    /// The same after the first force pass of a later step, whose kicked velocities are kept.
    pub(in crate::force) fn correct(&self, part: &WorkspaceView<'_>, NodeStateMut { first, v, .. }: NodeStateMut<'_>) {
        let inverse_mass = &self.inverse_mass[3 * first..3 * first + v.len()];
        self.block.scheme.correct(v, cast_slice(part.aside[1]), inverse_mass, cast_slice(part.out[0]));
    }

    fn start(&self, dofs: Range<usize>) -> StepStart<'_> {
        StepStart::of(self.block.from, self.inverse_mass, dofs)
    }

    /// Ends a step in a node block, and begins the next.
    pub(in crate::force) fn end(
        &self,
        level: usize,
        part: WorkspaceView<'_>,
        NodeStateMut { first, x, v, .. }: NodeStateMut<'_>,
    ) {
        let KickDriftBlock { scheme, from } = self.block;
        let WorkspaceView { out: [total, out @ ..], nodes: sums, aside: [before, kicked], levels, .. } = part;
        let (dofs, passes) = (3 * first..3 * first + x.len(), scheme.passes());
        let another = level + 1 < levels;
        let forces = out.each_ref().map(|sum| cast_slice::<Vector3<f64>, f64>(sum));
        let works = forces.iter().any(|sum| !sum.is_empty());
        let begun = if works && level + 1 == passes {
            let Point { state, forces: Forces { external, dissipative, .. } } = from;
            before.copy_from_slice(cast_slice(&state.x[dofs.clone()]));
            let forces = [external, dissipative].map(|sum| sum.get(dofs.clone()).unwrap_or_default());
            Work::of::<3>(forces, cast_slice(before), x)
        } else {
            sums[level + 1 - passes].work
        };
        let nodes = Nodes::<3> {
            mass: &self.mass[dofs.start / 3..dofs.end / 3],
            inverse_mass: &self.inverse_mass[dofs],
            x,
            v,
            kicked: cast_slice_mut(kicked),
            f: cast_slice_mut(total),
            works: works.then(|| Working { forces, before: cast_slice_mut(before) }),
        };
        let BoundarySums { nodes: ended, next } = scheme.end(nodes, another);
        sums[level] = NodeSums { work: begun.and(ended.work).halved(), ..ended };
        if another {
            // Kept at the level of the next step's first pass, until that step ends.
            sums[level + 1].work = next;
        }
    }
}
