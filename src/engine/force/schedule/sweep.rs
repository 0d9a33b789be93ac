//! Passes over the blocks of a scene, with the same bits for every number of threads.
//!
//! For each node block, mostly one block, the pass fills the local buffers, and all terms add to them while they are in
//! cache. Then it stores the sums of the node block's own nodes: no sum is zeroed in memory or read back. Halo sums are
//! kept apart, and are added in the order of the node blocks when all of them (in `step_block`: those of a round) are
//! done. The same holds for energies and powers. So no sum depends on the thread that did a node block.

use crate::force::NodeState;
use crate::force::kernel::batch::{BlockForces, BufferReads};
use crate::force::kernel::element_block::{ElementBlock, MOST_NUMBERS, NodeVectors, PassNumbers, SceneValues};
use crate::force::kernel::local_buffer::{LocalBuffer, PaddedVec3, Records, add_rows, copy_rows, rows, store_rows};
use crate::force::schedule::buffer_pool::{BufferPool, Pooled};
use crate::force::schedule::partition::{BlockPlan, Halo, Partition};
use crate::force::schedule::pass_kind::{PassKind, Sums};
use crate::force::schedule::terms::{Term, Terms};
use crate::force::schedule::threads::{LocalBuffers, SUMS, Threads};
use crate::force::schedule::workspace::{Workspace, WorkspaceSize, WorkspaceView};
use crate::model::forces::Tally;
use crate::model::workers::Workers;
use nalgebra::Vector3;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// The blocks of a scene and the buffers of a pass.
#[derive(Debug)]
pub(crate) struct Sweep {
    pub(in crate::force) partition: Arc<Partition>,
    workspace: BufferPool<Workspace>,
    /// buffers of a sum over node blocks
    parts: BufferPool<Vec<f64>>,
}

/// The specification of a pass.
pub(in crate::force) struct PassSpec<'a, T: ?Sized> {
    pub terms: &'a T,
    pub reads: BufferReads,
    /// whether the largest stretch is computed
    pub stretch: bool,
    pub kind: PassKind,
    pub numbers: PassNumbers<'a>,
    /// level of the energies and powers
    pub level: usize,
    /// the state of nodes from a first one on, as many as elements reach
    pub at: NodeState<'a>,
    /// its number
    pub first: usize,
    pub threads: &'a Threads,
    /// all threads, or the present one
    pub workers: &'a Workers,
    pub partition: &'a Partition,
}

impl Sweep {
    /// Cuts `nodes` nodes into blocks and assigns to every term its elements.
    pub(crate) fn new(nodes: usize, forces: &mut [&mut dyn BlockForces]) -> Self {
        Sweep::of(Partition::new(nodes, forces))
    }

    pub(in crate::force) fn of(partition: Partition) -> Self {
        Sweep::over(Arc::new(partition))
    }

    fn over(partition: Arc<Partition>) -> Self {
        Sweep { partition, workspace: BufferPool::default(), parts: BufferPool::default() }
    }

    /// The same blocks for another run, which has its own buffers.
    pub(crate) fn again(&self) -> Self {
        Sweep::over(self.partition.clone())
    }

    /// Overwrites every sum [N] with the forces of its terms; the first also gets those of the others. A sum may be
    /// empty only if no term adds to it. Writes the energy [J] or power [W] of every term to `tallies`.
    pub(crate) fn pass<T: Terms + ?Sized>(
        &self,
        terms: &T,
        at: NodeState<'_>,
        threads: &Threads,
        out: [&mut [Vector3<f64>]; SUMS],
        tallies: &mut [Tally],
    ) {
        let parts = || (0..terms.count()).flat_map(|i| terms.term(i).parts).flatten();
        debug_assert!(parts().all(|part| !out[part.sum].is_empty()) || at.x.is_empty());
        let mut workspace = self.workspace(WorkspaceSize::of_a_pass(terms.tallies()), &out);
        let mut found = std::mem::take(&mut workspace.scene_numbers);
        let numbers = self.scene_numbers(terms, at, &mut found);
        let (partition, workers) = (&self.partition, threads.workers());
        let (kind, level, first, stretch) = (PassKind::Full, 0, 0, false);
        let reads = reads(terms, kind);
        let job = PassSpec { terms, reads, stretch, kind, numbers, level, at, first, threads, workers, partition };
        let (mut all, _) = workspace.parts(partition, out);
        job.run(all.within(partition, partition.node_blocks()));
        for (out, sums) in all.out.into_iter().zip(all.halo).filter(|(out, _)| !out.is_empty()) {
            partition.add_halo_by(workers, 0..partition.blocks().len(), Halo { first: 0, sums }, (0, out));
        }
        workspace.add_up(0, tallies);
        workspace.scene_numbers = found;
    }

    /// The scene numbers of a pass over all nodes, kept in `found`.
    fn scene_numbers<'a, T: Terms + ?Sized>(
        &self,
        terms: &T,
        NodeState { t, x, v }: NodeState<'_>,
        found: &'a mut Vec<SceneValues>,
    ) -> PassNumbers<'a> {
        if self.is_single_block() {
            return PassNumbers::InBlock;
        }
        let [x, v] = [x, v].map(NodeVectors::Nodes);
        found.resize(terms.count(), [0.0; MOST_NUMBERS]);
        for (i, values) in found.iter_mut().enumerate() {
            if let Some(numbers) = terms.term(i).forces.scene_numbers() {
                numbers.find(t, x, v, values);
            }
        }
        PassNumbers::Found(found)
    }

    /// Sums over the nodes, node block after node block.
    pub(crate) fn by_node_blocks(&self, threads: &Threads, of: impl Fn(Range<usize>) -> f64 + Sync) -> f64 {
        let node_blocks = self.partition.node_blocks();
        let of = |node_block: usize| of(self.partition.nodes_of(node_block..node_block + 1));
        match threads.workers().pool().filter(|_| node_blocks.len() > 1) {
            None => node_blocks.map(of).sum(),
            Some(pool) => {
                let mut parts = self.parts.take();
                parts.resize(node_blocks.len(), 0.0);
                let parts = &mut **parts;
                pool.install(|| {
                    parts.par_iter_mut().zip(node_blocks).for_each(|(part, node_block)| *part = of(node_block))
                });
                parts.iter().sum()
            }
        }
    }

    /// Workspace for passes into sums of these sizes.
    pub(in crate::force) fn workspace(
        &self,
        needs: WorkspaceSize,
        out: &[&mut [Vector3<f64>]; SUMS],
    ) -> Pooled<'_, Workspace> {
        let mut workspace = self.workspace.take();
        workspace.fit(&self.partition, needs, out);
        workspace
    }
}

/// The buffers that the terms of a pass read.
pub(in crate::force) fn reads<T: Terms + ?Sized>(terms: &T, kind: PassKind) -> BufferReads {
    let reads = (0..terms.count()).map(|i| terms.term(i)).filter_map(|Term { forces, parts }| {
        let parts = parts.map(|part| part.is_some_and(|part| kind.goes_over(part.sum)));
        parts.contains(&true).then(|| forces.reads(parts))
    });
    reads.fold(BufferReads::default(), BufferReads::or)
}

impl<T: Terms + ?Sized> PassSpec<'_, T> {
    /// Computes the sums of some node blocks.
    pub(in crate::force) fn run(&self, part: WorkspaceView<'_>) {
        match self.workers.pool().filter(|_| part.node_blocks.len() > 1) {
            None => self.in_order(part),
            Some(pool) => pool.install(|| self.side_by_side(part)),
        }
    }

    fn in_order(&self, mut part: WorkspaceView<'_>) {
        while part.node_blocks.len() > 1 {
            let next = part.node_blocks.start + 1;
            let [one, others] = part.split(self.partition, next);
            self.node_block(one);
            part = others;
        }
        self.node_block(part);
    }

    fn side_by_side(&self, part: WorkspaceView<'_>) {
        if part.node_blocks.len() <= 1 {
            return self.node_block(part);
        }
        let middle = part.node_blocks.start + part.node_blocks.len() / 2;
        let [left, right] = part.split(self.partition, middle);
        rayon::join(|| self.side_by_side(left), || self.side_by_side(right));
    }

    fn node_block(&self, part: WorkspaceView<'_>) {
        let WorkspaceView { node_blocks, mut out, mut halo, tallies, stretches, mut kept, levels, .. } = part;
        let local_buffers = &mut *self.threads.local_buffers(rayon::current_thread_index().unwrap_or(0));
        let numbers = self.partition.blocks_of(node_blocks);
        let first = self.partition.halo_of(numbers.clone()).start;
        let count = self.terms.tallies();
        for (number, i) in numbers.zip(0..) {
            let plan = &self.partition.blocks()[number];
            let (own_kept, others_kept) =
                std::mem::take(&mut kept).split_at_mut_checked(plan.records()).unwrap_or_default();
            kept = others_kept;
            let level = i * levels + self.level;
            let tallies = &mut tallies[level * count..(level + 1) * count];
            let stretch = self.block(number, own_kept, local_buffers, &out, tallies);
            // The stretch of springs whose forces were kept is already included.
            if self.kind != PassKind::ReusePosition {
                stretches[level] = stretch;
            }
            let place = plan.halo.start - first..plan.halo.end - first;
            for ((out, halo), sums) in out.iter_mut().zip(&mut halo).zip(&mut local_buffers.sums).take(self.kind.sums())
            {
                if !out.is_empty() {
                    let (own, others) = rows(sums.records(), plan.records()).split_at(plan.own.len());
                    if plan.opens_node_block {
                        store_rows(own, out)
                    } else {
                        add_rows(own, out)
                    }
                    halo[place.clone()].copy_from_slice(others);
                }
            }
        }
    }

    /// Writes the sums of the terms for the nodes of a block to the local buffers, for every sum that is not empty.
    /// Returns its largest stretch, if wanted.
    fn block(
        &self,
        number: usize,
        kept: &mut [PaddedVec3],
        local_buffers: &mut LocalBuffers,
        out: &[&mut [Vector3<f64>]; SUMS],
        tallies: &mut [Tally],
    ) -> f64 {
        let plan = &self.partition.blocks()[number];
        let LocalBuffers { x, v, sums, .. } = local_buffers;
        let (x, v) = (x.records(), v.records());
        if self.reads.x {
            self.load(plan, self.at.x, x);
        }
        if self.reads.v {
            self.load(plan, self.at.v, v);
        }
        let sums = sums.each_mut().map(LocalBuffer::records);
        let n = plan.records();
        if self.kind.goes_over(0) {
            rows(sums[0], n).fill(PaddedVec3::default());
        }
        let own = if plan.opens_node_block { plan.own.clone() } else { 0..0 };
        let block = ElementBlock { number, own, t: self.at.t, x, v, scene_numbers: &[] };
        let present = out.each_ref().map(|sum| !sum.is_empty());
        Sums { n, sums, present, kept, numbers: self.numbers }.add(self.terms, self.kind, &block, tallies);
        self.terms.largest_stretch(&block, self.stretch)
    }

    /// Copies a nodal vector into a block's local buffer.
    fn load(&self, plan: &BlockPlan, from: &[Vector3<f64>], to: &mut Records) {
        let first = self.first;
        let (own, others) = rows(to, plan.records()).split_at_mut(plan.own.len());
        copy_rows(&from[plan.own.start - first..plan.own.end - first], own);
        match plan.run {
            Some(run) => copy_rows(&from[run - first..][..others.len()], others),
            None => {
                for (to, &node) in others.iter_mut().zip(&self.partition.halo()[plan.halo.clone()]) {
                    let from = from[node as usize - first];
                    *to = [from.x, from.y, from.z, 0.0];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
