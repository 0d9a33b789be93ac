//! The workspace of force passes, and the parts of it and of the node sums to which one thread writes for its node
//! blocks.

use crate::force::kernel::element_block::SceneValues;
use crate::force::kernel::local_buffer::PaddedVec3;
use crate::force::schedule::partition::Partition;
use crate::force::schedule::threads::SUMS;
use crate::force::schedule::wavefront::Wavefronts;
use crate::model::forces::Tally;
use crate::model::step_block::NodeSums;
use nalgebra::Vector3;
use std::ops::Range;

/// Buffers that are kept from pass to pass.
#[derive(Debug, Default)]
pub(in crate::force) struct Workspace {
    /// halo sums of each sum
    halo: [Vec<PaddedVec3>; SUMS],
    /// of the pass
    terms: usize,
    levels: usize,
    /// block after block, level after level, term after term
    tallies: Vec<Tally>,
    /// [-] largest l^2/l0^2 of springs, block after block, level after level
    stretches: Vec<f64>,
    /// node block after node block, level after level
    nodes: Vec<NodeSums>,
    /// forces of the terms of position only, block after block, where they are kept
    kept: Vec<PaddedVec3>,
    /// by node, where they are kept
    aside: [Vec<Vector3<f64>>; ASIDE],
    pub wavefronts: Wavefronts,
    /// by term of the pass
    pub scene_numbers: Vec<SceneValues>,
}

/// The sizes that passes need.
#[derive(Clone, Copy, Debug)]
pub(in crate::force) struct WorkspaceSize {
    pub terms: usize,
    pub levels: usize,
    /// threads that may work on several levels side by side
    pub threads: usize,
    /// whether forces of terms of position only are kept
    pub keeps: bool,
    /// which nodal vectors are kept
    pub aside: [bool; ASIDE],
}

impl WorkspaceSize {
    /// The sizes of a single pass.
    pub(crate) fn of_a_pass(terms: usize) -> Self {
        WorkspaceSize { terms, levels: 1, threads: 1, keeps: false, aside: [false; ASIDE] }
    }
}

/// Nodal vectors that are kept within a step: positions [m] at its start, kicked velocities [m/s].
pub(in crate::force) const ASIDE: usize = 2;

/// Some node blocks and the buffers for their sums, of all levels.
pub(in crate::force) struct WorkspaceView<'a> {
    pub node_blocks: Range<usize>,
    pub out: [&'a mut [Vector3<f64>]; SUMS],
    pub halo: [&'a mut [PaddedVec3]; SUMS],
    pub tallies: &'a mut [Tally],
    pub stretches: &'a mut [f64],
    pub nodes: &'a mut [NodeSums],
    /// empty if nothing is kept
    pub kept: &'a mut [PaddedVec3],
    pub aside: [&'a mut [Vector3<f64>]; ASIDE],
    pub levels: usize,
}

impl Workspace {
    /// Sizes the buffers for passes into these sums, and resets the wavefronts.
    pub(crate) fn fit(&mut self, partition: &Partition, needs: WorkspaceSize, out: &[&mut [Vector3<f64>]; SUMS]) {
        let WorkspaceSize { terms, levels, threads, keeps, aside } = needs;
        for (halo, _) in self.halo.iter_mut().zip(out).filter(|(_, out)| !out.is_empty()) {
            halo.resize(partition.halo().len(), PaddedVec3::default());
        }
        let blocks = partition.blocks().len();
        (self.terms, self.levels) = (terms, levels);
        self.tallies.resize(blocks * levels * terms, Tally::default());
        self.stretches.resize(blocks * levels, f64::NEG_INFINITY);
        self.nodes.resize(partition.node_blocks().len() * levels, NodeSums::default());
        self.wavefronts.plan(partition, levels, threads);
        if keeps {
            self.kept.resize(partition.records_of(0..blocks).len(), PaddedVec3::default());
        }
        for (vector, _) in self.aside.iter_mut().zip(aside).filter(|(_, kept)| *kept) {
            vector.resize(partition.nodes_of(partition.node_blocks()).len(), Vector3::zeros());
        }
    }

    /// All node blocks, and the wavefronts.
    pub(crate) fn parts<'a>(
        &'a mut self,
        partition: &Partition,
        out: [&'a mut [Vector3<f64>]; SUMS],
    ) -> (WorkspaceView<'a>, &'a mut Wavefronts) {
        let Workspace { halo, tallies, stretches, nodes, kept, aside, wavefronts, levels, .. } = self;
        let (halo, node_blocks) = (halo.each_mut().map(Vec::as_mut_slice), partition.node_blocks());
        let aside = aside.each_mut().map(Vec::as_mut_slice);
        (WorkspaceView { node_blocks, out, halo, tallies, stretches, nodes, kept, aside, levels: *levels }, wavefronts)
    }

    /// Adds up energies and powers of every term, block after block, in one of the levels.
    pub(crate) fn add_up(&self, level: usize, tallies: &mut [Tally]) {
        tallies.fill(Tally::default());
        let terms = self.terms.max(1);
        for by_block in self.tallies.chunks(terms).skip(level).step_by(self.levels) {
            tallies.iter_mut().zip(by_block).for_each(|(total, tally)| *total += *tally);
        }
    }

    /// The node sums of one of the levels, node block after node block.
    pub(crate) fn node_sums(&self, level: usize) -> NodeSums {
        let of_level = self.nodes.iter().skip(level).step_by(self.levels);
        of_level.fold(NodeSums::default(), |sums, next| sums.and(*next))
    }

    /// [-] The largest stretch in one of the levels.
    pub(crate) fn largest_stretch(&self, level: usize) -> f64 {
        self.stretches.iter().skip(level).step_by(self.levels).copied().fold(f64::NEG_INFINITY, f64::max)
    }
}

impl WorkspaceView<'_> {
    /// Some of the node blocks.
    pub(crate) fn within(&mut self, partition: &Partition, node_blocks: Range<usize>) -> WorkspaceView<'_> {
        let all = WorkspaceView {
            node_blocks: self.node_blocks.clone(),
            out: self.out.each_mut().map(|out| &mut **out),
            halo: self.halo.each_mut().map(|halo| &mut **halo),
            tallies: self.tallies,
            stretches: self.stretches,
            nodes: self.nodes,
            kept: self.kept,
            aside: self.aside.each_mut().map(|vector| &mut **vector),
            levels: self.levels,
        };
        let [_, from] = all.split(partition, node_blocks.start);
        let [within, _] = from.split(partition, node_blocks.end);
        within
    }

    /// Splits the node blocks at one of them.
    pub(crate) fn split(self, partition: &Partition, at: usize) -> [Self; 2] {
        let WorkspaceView { node_blocks, out, halo, tallies, stretches, nodes, kept, aside, levels } = self;
        let (before, after) = (node_blocks.start..at, at..node_blocks.end);
        let (blocks, terms) = (partition.blocks_of(before.clone()), tallies.len() / stretches.len().max(1));
        let (out, out_after) = halves(out, partition.nodes_of(before.clone()).len());
        let (halo, beyond_after) = halves(halo, partition.halo_of(blocks.clone()).len());
        let (tallies, tallies_after) = tallies.split_at_mut(blocks.len() * levels * terms);
        let (stretches, stretches_after) = stretches.split_at_mut(blocks.len() * levels);
        let (nodes, nodes_after) = nodes.split_at_mut(before.len() * levels);
        let (aside, aside_after) = halves(aside, partition.nodes_of(before.clone()).len());
        let (kept, kept_after) = kept.split_at_mut(partition.records_of(blocks).len().min(kept.len()));
        [
            WorkspaceView { node_blocks: before, out, halo, tallies, stretches, nodes, kept, aside, levels },
            WorkspaceView {
                node_blocks: after,
                out: out_after,
                halo: beyond_after,
                tallies: tallies_after,
                stretches: stretches_after,
                nodes: nodes_after,
                kept: kept_after,
                aside: aside_after,
                levels,
            },
        ]
    }
}

/// Splits a slice at an index; an empty slice gives two empty ones.
fn halves<T, const N: usize>(slices: [&mut [T]; N], at: usize) -> ([&mut [T]; N], [&mut [T]; N]) {
    let mut halves = slices.map(|slice| slice.split_at_mut(at.min(slice.len())));
    (halves.each_mut().map(|(before, _)| std::mem::take(before)), halves.map(|(_, after)| after))
}
