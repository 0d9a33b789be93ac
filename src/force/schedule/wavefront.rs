//! Ways through the node blocks of a scene, level after level.
//!
//! A level is a force pass: that of the first step of a block, of the next one, or the second pass of the same step.
//! One wavefront goes over all node blocks. Several threads have a wavefront each, over parts of the scene that share
//! nothing, so that they need not meet before the block ends: a part begins every level further to the right and ends
//! it further to the left than the one before, where the nodes that its elements reach are its own. What is left
//! between two parts is a seam, which is gone over when both are done (trapezoids: Frigo & Strumpen 2005).
//!
//! ```text
//! level 2      |  part  /     seam     \  part  |
//! level 1      |       /                \       |
//! first level  |______/__________________\______|     nodes
//! ```

use crate::force::schedule::partition::Partition;
use crate::force::schedule::tuning::SEAMS;
use std::ops::Range;

/// How far one level of a wavefront has come.
#[derive(Clone, Debug, Default)]
pub(in crate::force) struct Level {
    /// the node blocks that are left
    pub node_blocks: Range<usize>,
    /// node blocks whose nodes this wavefront completes and has not yet. A part leaves those at its left edge, which
    /// elements of node blocks before it reach, to the seam
    pub open: Range<usize>,
    /// up to this node the next level may reach
    pub complete: usize,
    /// the first block that may still give something to the nodes that are left
    pub oldest: usize,
}

/// A way through some node blocks.
#[derive(Clone, Debug, Default)]
pub(in crate::force) struct Wavefront {
    /// all that it reads and writes
    pub node_blocks: Range<usize>,
    /// nodes that are left to be moved before the first level
    pub unmoved: Range<usize>,
    pub levels: Vec<Level>,
}

/// Some node blocks that come next in a level of a wavefront.
pub(in crate::force) struct NextBlocks {
    pub level: usize,
    pub node_blocks: Range<usize>,
    /// node blocks whose nodes are complete after these
    pub completed: Range<usize>,
    /// where the nodes end that their elements reach
    pub reach: usize,
}

/// The wavefronts of a block.
#[derive(Debug, Default)]
pub(in crate::force) struct Wavefronts {
    parts: Vec<Wavefront>,
    others: Vec<Wavefront>,
    /// how many of both are used; the others keep their room
    used: [usize; 2],
}

impl Wavefront {
    /// At the beginning of a way over all node blocks.
    fn begin(&mut self, partition: &Partition, levels: usize) {
        self.node_blocks = partition.node_blocks();
        self.unmoved = partition.nodes_of(partition.node_blocks());
        self.levels.clear();
        self.levels.resize(
            levels,
            Level { node_blocks: partition.node_blocks(), open: partition.node_blocks(), ..Level::default() },
        );
    }

    /// Makes this what is left between two parts, whose levels end and begin where they have to.
    fn between(&mut self, partition: &Partition, boundary: usize, (left, right): (&mut Wavefront, &mut Wavefront)) {
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

    /// Of the levels that can go on the highest, so that it finds its nodes in cache, and its next node blocks.
    pub fn ahead(&self, partition: &Partition, node_blocks: usize) -> Option<NextBlocks> {
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

    /// The nodes that are to be moved before some node blocks are gone over; takes note of them.
    pub fn move_for(&mut self, ahead: &NextBlocks) -> Range<usize> {
        let Range { start, end } = self.unmoved;
        self.unmoved.start = if ahead.level > 0 { start } else { ahead.reach.clamp(start, end) };
        start..self.unmoved.start
    }

    /// Takes note of what was done; returns the blocks that give something to the nodes that are now complete.
    pub fn advance(&mut self, partition: &Partition, ahead: &NextBlocks) -> Range<usize> {
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
    /// Wavefronts for so many threads.
    pub fn plan(&mut self, partition: &Partition, levels: usize, threads: usize) {
        let parts = if divides(partition, levels, threads) { threads } else { 0 };
        // Without parts one wavefront over everything.
        self.used = [parts, parts.saturating_sub(1).max(1)];
        for (wavefronts, used) in [&mut self.parts, &mut self.others].into_iter().zip(self.used) {
            wavefronts.resize_with(used.max(wavefronts.len()), Wavefront::default);
        }
        let [of_parts, others] = self.all();
        of_parts.iter_mut().chain(&mut *others).for_each(|wavefront| wavefront.begin(partition, levels));
        for number in 1..parts {
            let (left, right) = of_parts.split_at_mut(number);
            let sides = (&mut left[number - 1], &mut right[0]);
            others[number - 1].between(partition, boundary(partition, parts, number), sides);
        }
    }

    /// Parts, if there are any, and what is to be gone over after them: their seams, or else the whole scene.
    pub fn all(&mut self) -> [&mut [Wavefront]; 2] {
        [&mut self.parts[..self.used[0]], &mut self.others[..self.used[1]]]
    }
}

/// Whether the scene has parts for so many threads, with seams that are not too wide.
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

/// The node blocks that are left by the parts on both sides of a boundary, level after level.
fn edges(partition: &Partition, boundary: usize) -> impl Iterator<Item = Range<usize>> {
    let next = |of: &Range<usize>| Some(partition.first_beyond(of.start)..partition.first_unreached(of.end));
    std::iter::successors(Some(partition.first_beyond(boundary)..boundary), next)
}

#[cfg(test)]
mod tests;
