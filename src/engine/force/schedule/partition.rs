//! Cuts a scene into blocks, so that a force pass works in the first caches.
//!
//! A node block is a contiguous range of nodes with the elements whose smallest node is in it. Forces on nodes beyond
//! its end are summed apart, and added to those nodes when all node blocks that reach them are done. So no two node
//! blocks write to one place. A node block is one block, or several where its elements reach too many nodes for the
//! local buffers of one.

use crate::force::kernel::batch::BlockForces;
use crate::force::kernel::local_buffer::{PaddedVec3, RECORD, add_rows};
use crate::force::schedule::tuning::{LEAST_NODES, MOST_NODES, NODE_BLOCKS_WANTED};
use crate::model::workers::Workers;
use bytemuck::cast_slice_mut;
use nalgebra::Vector3;
use std::ops::Range;

/// Records in a local buffer at most: as many as 16 bits can address.
const RECORDS: usize = (u16::MAX as usize + 1) / RECORD;

/// The blocks of a scene.
#[derive(Debug)]
pub(in crate::force) struct Partition {
    /// nodes of the scene and of a node block
    nodes: usize,
    node_block: usize,
    blocks: Vec<BlockPlan>,
    /// every node block's first block, and the number of blocks
    first_block: Vec<usize>,
    /// halo nodes, beyond the ends of node blocks, block after block
    halo: Vec<u32>,
    /// end of the nodes that the first k node blocks reach, for k = 0, 1, ... all
    reach: Vec<usize>,
}

/// The nodes of one block.
#[derive(Debug)]
pub(in crate::force) struct BlockPlan {
    pub own: Range<usize>,
    /// whether it is the first block of its node block, and so stores the node sums
    pub opens_node_block: bool,
    /// its part of the list of halo nodes
    pub halo: Range<usize>,
    /// records of all blocks before
    pub records_before: usize,
    /// the first halo node, if they are contiguous
    pub run: Option<usize>,
    /// from the first halo node to the last; empty, at the end of the node block, if there is none
    pub reach: Range<usize>,
}

impl BlockPlan {
    /// Records in the block's local buffers.
    pub(in crate::force) fn records(&self) -> usize {
        self.own.len() + self.halo.len()
    }
}

/// Sums of some blocks for their halo nodes.
#[derive(Clone, Copy)]
pub(in crate::force) struct Halo<'a> {
    /// index of the first in the list of all halo sums
    pub first: usize,
    pub sums: &'a [PaddedVec3],
}

/// Number of nodes of a node block. Two node blocks, or a multiple of four (up to some 500, above which one more or
/// less matters little), give several threads equal work.
fn node_block_size(nodes: usize) -> usize {
    let node_blocks = nodes.div_ceil(nodes.div_ceil(NODE_BLOCKS_WANTED).clamp(LEAST_NODES, MOST_NODES));
    match node_blocks {
        0..=1 => LEAST_NODES,
        _ => nodes.div_ceil(node_blocks.next_multiple_of(node_blocks.min(4).next_multiple_of(2))).next_multiple_of(8),
    }
}

/// How large blocks may be.
#[derive(Clone, Copy, Debug)]
pub(in crate::force) struct Limits {
    pub node_block: usize,
    pub records: usize,
}

impl Partition {
    /// Cuts `nodes` nodes into blocks and assigns to every term its elements.
    pub(in crate::force) fn new(nodes: usize, terms: &mut [&mut dyn BlockForces]) -> Self {
        let node_block = node_block_size(nodes);
        Partition::within(Limits { node_block, records: RECORDS }, nodes, terms)
    }

    pub(in crate::force) fn within(limits: Limits, nodes: usize, terms: &mut [&mut dyn BlockForces]) -> Self {
        let (node_block, blocks, halo) = (limits.node_block, Vec::new(), Vec::new());
        let mut partition = Partition { nodes, node_block, blocks, first_block: vec![0], halo, reach: vec![0] };
        let mut cutter =
            PartitionBuilder { next: vec![0; terms.len()], place: vec![None; nodes], records: limits.records };
        for start in (0..nodes).step_by(limits.node_block) {
            let own = start..(start + limits.node_block).min(nodes);
            let mut opens_node_block = true;
            while cutter.cut(own.clone(), opens_node_block, &mut partition, terms) {
                opens_node_block = false;
            }
            let (before, first) =
                (partition.reach_of(partition.node_blocks().end), partition.first_block[partition.node_blocks().end]);
            partition.reach.push(partition.blocks[first..].iter().fold(before, |most, plan| most.max(plan.reach.end)));
            partition.first_block.push(partition.blocks.len());
        }
        partition
    }

    pub(in crate::force) fn node_blocks(&self) -> Range<usize> {
        0..self.first_block.len() - 1
    }

    /// The nodes of some node blocks.
    pub(in crate::force) fn nodes_of(&self, node_blocks: Range<usize>) -> Range<usize> {
        (self.node_block * node_blocks.start).min(self.nodes)..(self.node_block * node_blocks.end).min(self.nodes)
    }

    /// Numbers of the blocks of some node blocks.
    pub(in crate::force) fn blocks_of(&self, node_blocks: Range<usize>) -> Range<usize> {
        self.first_block[node_blocks.start]..self.first_block[node_blocks.end]
    }

    /// End of the nodes that the first node blocks, this many, reach or own.
    pub(in crate::force) fn reach_of(&self, node_blocks: usize) -> usize {
        self.reach[node_blocks]
    }

    /// The first node block that reaches beyond the beginning of another; the number of node blocks, if none does.
    pub(in crate::force) fn first_beyond(&self, node_block: usize) -> usize {
        let limit = self.nodes_of(node_block..node_block).start;
        self.reach[1..].partition_point(|&reach| reach <= limit)
    }

    /// The first node block that no node block before another one reaches.
    pub(in crate::force) fn first_unreached(&self, node_block: usize) -> usize {
        self.reach[node_block].div_ceil(self.node_block)
    }

    pub(in crate::force) fn blocks(&self) -> &[BlockPlan] {
        &self.blocks
    }

    /// The halo nodes of all blocks.
    pub(in crate::force) fn halo(&self) -> &[u32] {
        &self.halo
    }

    /// Adds the halo sums of blocks to the nodes from `first` on, block after block.
    pub(in crate::force) fn add_halo(
        &self,
        blocks: Range<usize>,
        halo: Halo<'_>,
        (first, out): (usize, &mut [Vector3<f64>]),
    ) {
        let end = first + out.len();
        for plan in self.blocks[blocks].iter().filter(|plan| plan.reach.start < end && first < plan.reach.end) {
            let nodes = &self.halo[plan.halo.clone()];
            let below = |limit: usize| nodes.partition_point(|&node| (node as usize) < limit);
            let [from, to] = [below(first), below(end)];
            let sums = &halo.sums[plan.halo.start - halo.first..][from..to];
            match plan.run {
                Some(run) => add_rows(sums, &mut out[(run + from).saturating_sub(first)..][..sums.len()]),
                None => {
                    for (&node, sum) in nodes[from..to].iter().zip(sums) {
                        out[node as usize - first] += Vector3::new(sum[0], sum[1], sum[2]);
                    }
                }
            }
        }
    }

    /// The same on several threads.
    pub(in crate::force) fn add_halo_by(
        &self,
        workers: &Workers,
        blocks: Range<usize>,
        halo: Halo<'_>,
        (first, out): (usize, &mut [Vector3<f64>]),
    ) {
        workers.set(cast_slice_mut(out), |dofs, out| {
            self.add_halo(blocks.clone(), halo, (first + dofs.start / 3, cast_slice_mut(out)));
        });
    }

    /// The part of some blocks in the list of all blocks' records.
    pub(in crate::force) fn records_of(&self, blocks: Range<usize>) -> Range<usize> {
        let end = self.blocks.last().map_or(0, |plan| plan.records_before + plan.records());
        let start = |block: usize| self.blocks.get(block).map_or(end, |plan| plan.records_before);
        start(blocks.start)..start(blocks.end)
    }

    /// The part of some blocks in the list of halo nodes.
    pub(in crate::force) fn halo_of(&self, blocks: Range<usize>) -> Range<usize> {
        let start = |block: usize| self.blocks.get(block).map_or(self.halo.len(), |plan| plan.halo.start);
        start(blocks.start)..start(blocks.end)
    }
}

/// State of the partition while it is built.
struct PartitionBuilder {
    /// next element of every term
    next: Vec<usize>,
    /// index of the record of a halo node in the present block
    place: Vec<Option<u16>>,
    records: usize,
}

impl PartitionBuilder {
    /// Adds a block; returns whether the node block needs another.
    fn cut(
        &mut self,
        own: Range<usize>,
        opens_node_block: bool,
        partition: &mut Partition,
        terms: &mut [&mut dyn BlockForces],
    ) -> bool {
        let begin = partition.halo.len();
        let mut ends = self.next.clone();
        let mut full = false;
        for (term, end) in terms.iter().zip(&mut ends) {
            while let Some(nodes) = term.element(*end).filter(|nodes| begins_in(nodes, &own)) {
                let new = |node: &&u32| **node as usize >= own.end && self.place[**node as usize].is_none();
                if own.len() + partition.halo.len() - begin + nodes.iter().filter(new).count() > self.records {
                    full = true;
                    break;
                }
                for &node in nodes.iter().filter(|&&node| node as usize >= own.end) {
                    if self.place[node as usize].replace(0).is_none() {
                        partition.halo.push(node);
                    }
                }
                *end += 1;
            }
        }
        let halo = &mut partition.halo[begin..];
        halo.sort_unstable();
        for (record, &node) in (own.len()..).zip(halo.iter()) {
            self.place[node as usize] = Some(crate::force::kernel::element_block::place(record));
        }
        let place = |node: u32| {
            let of_own = || crate::force::kernel::element_block::place((node as usize).saturating_sub(own.start));
            self.place[node as usize].unwrap_or_else(of_own)
        };
        for (term, (next, end)) in terms.iter_mut().zip(self.next.iter_mut().zip(&ends)) {
            term.assign_block(partition.blocks.len(), *next..*end, &place);
            *next = *end;
        }
        halo.iter().for_each(|&node| self.place[node as usize] = None);
        let follow = halo.windows(2).all(|pair| pair[1] == pair[0] + 1);
        let run = halo.first().filter(|_| follow).map(|&node| node as usize);
        let reach = match (halo.first(), halo.last()) {
            (Some(&first), Some(&last)) => first as usize..last as usize + 1,
            _ => own.end..own.end,
        };
        let records_before = partition.records_of(0..partition.blocks.len()).end;
        let halo = begin..partition.halo.len();
        partition.blocks.push(BlockPlan { own, opens_node_block, halo, records_before, run, reach });
        full
    }
}

fn begins_in(nodes: &[u32], own: &Range<usize>) -> bool {
    let least = nodes.iter().min().map(|&least| least as usize);
    debug_assert!(
        least.is_none_or(|least| own.start <= least),
        "elements come in ascending order of their smallest node"
    );
    least.is_some_and(|least| least < own.end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force::kernel::batch::BufferReads;
    use crate::force::kernel::element_block::ElementBlock;
    use crate::force::kernel::local_buffer::Records;
    use crate::model::forces::Tally;

    /// Elements, and what is known of each: its block and the places of its nodes.
    #[derive(Default)]
    struct RecordedTerm {
        elements: Vec<Vec<u32>>,
        block: Vec<usize>,
        places: Vec<Vec<u16>>,
        blocks: usize,
    }

    impl BlockForces for RecordedTerm {
        fn elements(&self) -> usize {
            self.elements.len()
        }

        fn reads(&self, _: [bool; 2]) -> BufferReads {
            BufferReads::default()
        }

        fn element(&self, number: usize) -> Option<&[u32]> {
            self.elements.get(number).map(Vec::as_slice)
        }

        fn assign_block(&mut self, block: usize, elements: Range<usize>, place: &dyn Fn(u32) -> u16) {
            assert_eq!(block, self.blocks);
            assert_eq!(elements.start, self.block.len(), "one after the other");
            for nodes in &self.elements[elements] {
                self.block.push(self.blocks);
                self.places.push(nodes.iter().map(|&n| place(n)).collect());
            }
            self.blocks += 1;
        }

        fn add(&self, _: &ElementBlock<'_>, _: [Option<&mut Records>; 2]) -> [Tally; 2] {
            Default::default()
        }
    }

    /// Every element has a block, and its nodes are where the block's local buffers have them.
    fn check(partition: &Partition, term: &RecordedTerm) {
        assert_eq!(term.block.len(), term.elements.len());
        assert_eq!(term.blocks, partition.blocks.len());
        for ((nodes, &block), places) in term.elements.iter().zip(&term.block).zip(&term.places) {
            let plan = &partition.blocks[block];
            let buffer: Vec<u32> = (plan.own.start as u32..plan.own.end as u32)
                .chain(partition.halo[plan.halo.clone()].iter().copied())
                .collect();
            let found: Vec<u32> = places.iter().map(|&p| buffer[p as usize / RECORD]).collect();
            assert_eq!(found, *nodes);
            if let Some(first) = plan.run {
                assert!(partition.halo[plan.halo.clone()].iter().zip(first..).all(|(&node, i)| node as usize == i));
            }
        }
        let owned: Vec<usize> =
            partition.blocks.iter().filter(|t| t.opens_node_block).flat_map(|t| t.own.clone()).collect();
        assert_eq!(owned, (0..partition.nodes).collect::<Vec<_>>());
    }

    fn limits(node_block: usize, records: usize) -> Limits {
        Limits { node_block, records }
    }

    #[test]
    fn a_chain_reaches_one_node_beyond_each_strip() {
        let mut term = RecordedTerm { elements: (0..99).map(|i| vec![i, i + 1]).collect(), ..RecordedTerm::default() };
        let mut none = RecordedTerm::default();
        let partition = Partition::within(limits(8, 100), 100, &mut [&mut term, &mut none]);
        check(&partition, &term);
        assert_eq!((partition.blocks.len(), partition.halo.len(), none.blocks), (13, 12, 13));
        assert_eq!(
            (partition.nodes_of(1..3), partition.nodes_of(12..13), partition.blocks_of(3..5)),
            (8..24, 96..100, 3..5)
        );
        assert_eq!((partition.halo_of(2..4), partition.halo_of(12..13)), (2..4, 12..12));
    }

    #[test]
    fn strips_of_a_scene_are_even() {
        let node_blocks = |nodes: usize| nodes.div_ceil(node_block_size(nodes));
        assert_eq!([1, 2048, 2049, 4096, 4097, 10_000, 65_537].map(node_blocks), [1, 1, 2, 2, 4, 8, 36]);
        assert_eq!([131_072, 131_073, 1_000_000].map(node_blocks), [64, 64, 392]);
        assert!(
            (2049..300_000).step_by(7).all(|nodes| node_blocks(nodes) % 2 == 0 && node_block_size(nodes) <= MOST_NODES)
        );
    }

    #[test]
    fn a_node_with_more_neighbours_than_a_window_has_records_takes_several_tiles() {
        let mut star = RecordedTerm { elements: (1..200).map(|i| vec![i, 0]).collect(), ..RecordedTerm::default() };
        let mut chain =
            RecordedTerm { elements: (0..199).map(|i| vec![i + 1, i]).collect(), ..RecordedTerm::default() };
        let partition = Partition::within(limits(10, 30), 200, &mut [&mut star, &mut chain]);
        check(&partition, &star);
        check(&partition, &chain);
        assert!(partition.blocks_of(0..1).len() >= 10, "{:?}", partition.blocks_of(0..1));
        assert_eq!(partition.blocks_of(1..2).len(), 1);
    }

    #[test]
    fn triangles_and_springs_share_their_windows() {
        let triangles = (0..50).map(|i| vec![i + 10, i, i + 1]).collect();
        let mut triangles = RecordedTerm { elements: triangles, ..RecordedTerm::default() };
        let mut springs =
            RecordedTerm { elements: (0..50).map(|i| vec![i, i + 10]).collect(), ..RecordedTerm::default() };
        let partition = Partition::within(limits(16, 64), 61, &mut [&mut triangles, &mut springs]);
        check(&partition, &triangles);
        check(&partition, &springs);
        assert_eq!(partition.halo_of(0..1).len(), 10);
        assert_eq!(partition.blocks[0].run, Some(16));
    }
}
