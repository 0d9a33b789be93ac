//! The order in which the node blocks of a scene go through the levels.
//!
//! A level is a force pass: that of the first step of a block, of the next one, or the second pass of the same step.
//! One wavefront goes over all node blocks. Several threads have one wavefront each, over parts of the scene that share
//! no data, so they need not wait for each other before the block ends. A part begins each level further to the right,
//! and ends it further to the left, than the level before, so that its elements reach only its own nodes. The rest
//! between two parts is a seam, which is done after both parts (trapezoids: Frigo & Strumpen 2005).
//!
//! ```text
//! level 2      |  part  /     seam     \  part  |
//! level 1      |       /                \       |
//! first level  |______/__________________\______|     nodes
//! ```

use crate::force::schedule::partition::Partition;
use crate::force::schedule::tuning::SEAMS;
use std::ops::Range;

/// The state of one level of a wavefront.
#[derive(Clone, Debug, Default)]
pub(in crate::force) struct Level {
    /// the remaining node blocks
    pub node_blocks: Range<usize>,
    /// node blocks whose nodes this wavefront has still to complete. A part leaves those at its left edge, which
    /// elements of earlier node blocks reach, to the seam
    pub open: Range<usize>,
    /// the next level may reach nodes up to this one
    pub complete: usize,
    /// the first block that may still add to the remaining nodes
    pub oldest: usize,
}

/// A wavefront over some node blocks.
#[derive(Clone, Debug, Default)]
pub(in crate::force) struct Wavefront {
    /// all that it reads and writes
    pub node_blocks: Range<usize>,
    /// nodes still to be moved before the first level
    pub unmoved: Range<usize>,
    pub levels: Vec<Level>,
}

/// The node blocks to do next in a level of a wavefront.
pub(in crate::force) struct NextBlocks {
    pub level: usize,
    pub node_blocks: Range<usize>,
    /// node blocks whose nodes are complete after these
    pub completed: Range<usize>,
    /// end of the nodes that their elements reach
    pub reach: usize,
}

/// The wavefronts of a block.
#[derive(Debug, Default)]
pub(in crate::force) struct Wavefronts {
    parts: Vec<Wavefront>,
    others: Vec<Wavefront>,
    /// number of both in use; the others keep their buffers
    used: [usize; 2],
}

impl Wavefront {
    /// A wavefront over all node blocks, before its first round.
    fn begin(&mut self, partition: &Partition, levels: usize) {
        self.node_blocks = partition.node_blocks();
        self.unmoved = partition.nodes_of(partition.node_blocks());
        self.levels.clear();
        self.levels.resize(
            levels,
            Level { node_blocks: partition.node_blocks(), open: partition.node_blocks(), ..Level::default() },
        );
    }

    /// Makes this the seam between two parts, given the ends of their levels.
    fn between(&mut self, partition: &Partition, boundary: usize, left: &mut Wavefront, right: &mut Wavefront) {
        let first = partition.nodes_of(boundary..boundary).start;
        (left.node_blocks.end, right.node_blocks.start) = (boundary, boundary);
        (left.unmoved.end, right.unmoved.start) = (first, first);
        let mut edges = edges(partition, boundary).peekable();
        for ((level, left), right) in self.levels.iter_mut().zip(&mut left.levels).zip(&mut right.levels) {
            let (Some(now), Some(next)) = (edges.next(), edges.peek().cloned()) else { return };
            (left.node_blocks.end, left.open.end) = (now.start, now.start);
            (right.node_blocks.start, right.open.start) = (now.end, next.end);
            (level.node_blocks, level.open) = (now.clone(), now.start..next.end);
            right.oldest = partition.blocks_of(now.end..now.end).start;
            level.oldest = partition.blocks_of(next.start..next.start).start;
            self.node_blocks = next;
        }
        self.unmoved = partition.reach_of(left.levels[0].node_blocks.end)..first;
    }

    /// The next node blocks to do: those of the highest level that can continue, whose nodes are still in cache.
    pub(crate) fn ahead(&self, partition: &Partition, node_blocks: usize) -> Option<NextBlocks> {
        (0..self.levels.len()).rev().find_map(|number| {
            let Level { node_blocks: left, open, .. } = &self.levels[number];
            let node_blocks = left.start..(left.start + node_blocks).min(left.end);
            let reach = partition.reach_of(node_blocks.end);
            let can_go_on = number == 0 || reach <= self.levels[number - 1].complete;
            let completed =
                open.start..if node_blocks.end == left.end { open.end } else { node_blocks.end.max(open.start) };
            (!node_blocks.is_empty() && can_go_on).then_some(NextBlocks {
                level: number,
                node_blocks,
                completed,
                reach,
            })
        })
    }

    /// The nodes to move before these node blocks are done; marks them as moved.
    pub(crate) fn move_for(&mut self, ahead: &NextBlocks) -> Range<usize> {
        let Range { start, end } = self.unmoved;
        self.unmoved.start = if ahead.level > 0 { start } else { ahead.reach.clamp(start, end) };
        start..self.unmoved.start
    }

    /// Marks node blocks as done; returns the blocks that add to the nodes that are now complete.
    pub(crate) fn advance(&mut self, partition: &Partition, ahead: &NextBlocks) -> Range<usize> {
        let level = &mut self.levels[ahead.level];
        let first = partition.nodes_of(ahead.completed.clone()).start;
        let end = partition.blocks_of(0..ahead.completed.end).end;
        let blocks = partition.blocks();
        while level.oldest < end && blocks[level.oldest].reach.end <= first {
            level.oldest += 1;
        }
        level.node_blocks.start = ahead.node_blocks.end;
        level.open.start = ahead.completed.end;
        let of = if level.node_blocks.is_empty() { &self.node_blocks } else { &ahead.node_blocks };
        level.complete = partition.nodes_of(of.clone()).end;
        level.oldest..end
    }
}

impl Wavefronts {
    /// Wavefronts for this number of threads.
    pub(crate) fn plan(&mut self, partition: &Partition, levels: usize, threads: usize) {
        let parts = if divides(partition, levels, threads) { threads } else { 0 };
        // Without parts, one wavefront over all node blocks.
        self.used = [parts, parts.saturating_sub(1).max(1)];
        for (wavefronts, used) in [&mut self.parts, &mut self.others].into_iter().zip(self.used) {
            wavefronts.resize_with(used.max(wavefronts.len()), Wavefront::default);
        }
        let [of_parts, others] = self.all();
        of_parts.iter_mut().chain(&mut *others).for_each(|wavefront| wavefront.begin(partition, levels));
        for number in 1..parts {
            let (left, right) = of_parts.split_at_mut(number);
            let (left, right, at) = (&mut left[number - 1], &mut right[0], boundary(partition, parts, number));
            others[number - 1].between(partition, at, left, right);
        }
    }

    /// The parts, if there are any, and the wavefronts to do after them: their seams, or else the whole scene.
    pub(crate) fn all(&mut self) -> [&mut [Wavefront]; 2] {
        [&mut self.parts[..self.used[0]], &mut self.others[..self.used[1]]]
    }
}

/// Whether the scene can be divided into parts for this number of threads, with seams that are not too wide.
fn divides(partition: &Partition, levels: usize, parts: usize) -> bool {
    if levels < 2 || parts < 2 || parts > partition.node_blocks().len() {
        return false;
    }
    let (mut in_seams, mut before) = (0, 0);
    for number in 1..parts {
        let edges = || edges(partition, boundary(partition, parts, number));
        let Some(last) = edges().nth(levels).filter(|last| before <= last.start) else { return false };
        in_seams += edges().take(levels).map(|edges| edges.len()).sum::<usize>();
        before = last.end;
    }
    in_seams * SEAMS <= levels * partition.node_blocks().len()
}

/// The node block that a part begins with.
fn boundary(partition: &Partition, parts: usize, number: usize) -> usize {
    number * partition.node_blocks().len() / parts
}

/// The node blocks that the parts on both sides of a boundary leave to the seam, level after level.
fn edges(partition: &Partition, boundary: usize) -> impl Iterator<Item = Range<usize>> {
    let next = |of: &Range<usize>| Some(partition.first_beyond(of.start)..partition.first_unreached(of.end));
    std::iter::successors(Some(partition.first_beyond(boundary)..boundary), next)
}

#[cfg(test)]
mod tests;
