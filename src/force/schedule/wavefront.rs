//! Ways through the strips of a scene, level after level.
//!
//! A level is a force pass: that of the first step of a stride, of the next one, or the second pass of the same step.
//! One front goes over all strips. Several threads have a front each, over parts of the scene that share nothing, so
//! that they need not meet before the stride ends: a part begins every level further to the right and ends it further
//! to the left than the one before, where the nodes that its elements reach are its own. What is left between two parts
//! is a seam, which is gone over when both are done (trapezoids: Frigo & Strumpen 2005).
//!
//! ```text
//! level 2      |  part  /     seam     \  part  |
//! level 1      |       /                \       |
//! first level  |______/__________________\______|     nodes
//! ```

use crate::force::schedule::partition::Tiling;
use std::ops::Range;

/// Levels at most of a front: what they all work on still fits into a third-level cache.
pub(in crate::force) const LEVELS: usize = 8;

/// Seams take a part of all work that is no larger than one in so many: they are gone over when only they are left.
const SEAMS: usize = 3;

/// How far one level of a front has come.
#[derive(Clone, Debug, Default)]
pub(in crate::force) struct Level {
    /// the strips that are left
    pub strips: Range<usize>,
    /// strips whose nodes this front completes and has not yet. A part leaves those at its left edge, which elements of
    /// strips before it reach, to the seam
    pub open: Range<usize>,
    /// up to this node the next level may reach
    pub complete: usize,
    /// the first tile that may still give something to the nodes that are left
    pub oldest: usize,
}

/// A way through some strips.
#[derive(Clone, Debug, Default)]
pub(in crate::force) struct Front {
    /// all that it reads and writes
    pub strips: Range<usize>,
    /// nodes that are left to be moved before the first level
    pub unmoved: Range<usize>,
    pub levels: Vec<Level>,
}

/// Some strips that come next in a level of a front.
pub(in crate::force) struct Ahead {
    pub level: usize,
    pub strips: Range<usize>,
    /// strips whose nodes are complete after these
    pub completed: Range<usize>,
    /// where the nodes end that their elements reach
    pub reach: usize,
}

/// The fronts of a stride.
#[derive(Debug, Default)]
pub(in crate::force) struct Fronts {
    parts: Vec<Front>,
    others: Vec<Front>,
    /// how many of both are used; the others keep their room
    used: [usize; 2],
}

impl Front {
    /// At the beginning of a way over all strips.
    fn begin(&mut self, tiling: &Tiling, levels: usize) {
        self.strips = tiling.strips();
        self.unmoved = tiling.nodes_of(tiling.strips());
        self.levels.clear();
        self.levels.resize(levels, Level { strips: tiling.strips(), open: tiling.strips(), ..Level::default() });
    }

    /// Makes this what is left between two parts, whose levels end and begin where they have to.
    fn between(&mut self, tiling: &Tiling, boundary: usize, (left, right): (&mut Front, &mut Front)) {
        let first = tiling.nodes_of(boundary..boundary).start;
        (left.strips.end, right.strips.start) = (boundary, boundary);
        (left.unmoved.end, right.unmoved.start) = (first, first);
        let mut edges = edges(tiling, boundary).peekable();
        for ((level, left), right) in self.levels.iter_mut().zip(&mut left.levels).zip(&mut right.levels) {
            let (Some(now), Some(next)) = (edges.next(), edges.peek().cloned()) else { return };
            (left.strips.end, left.open.end) = (now.start, now.start);
            (right.strips.start, right.open.start) = (now.end, next.end);
            (level.strips, level.open) = (now.clone(), now.start..next.end);
            right.oldest = tiling.tiles_of(now.end..now.end).start;
            level.oldest = tiling.tiles_of(next.start..next.start).start;
            self.strips = next;
        }
        self.unmoved = tiling.reach_of(left.levels[0].strips.end)..first;
    }

    /// Of the levels that can go on the highest, so that it finds its nodes in cache, and its next strips.
    pub fn ahead(&self, tiling: &Tiling, strips: usize) -> Option<Ahead> {
        (0..self.levels.len()).rev().find_map(|number| {
            let Level { strips: left, open, .. } = &self.levels[number];
            let strips = left.start..(left.start + strips).min(left.end);
            let reach = tiling.reach_of(strips.end);
            let can_go_on = number == 0 || reach <= self.levels[number - 1].complete;
            let completed = open.start..if strips.end == left.end { open.end } else { strips.end.max(open.start) };
            (!strips.is_empty() && can_go_on).then_some(Ahead { level: number, strips, completed, reach })
        })
    }

    /// The nodes that are to be moved before some strips are gone over; takes note of them.
    pub fn move_for(&mut self, ahead: &Ahead) -> Range<usize> {
        let Range { start, end } = self.unmoved;
        self.unmoved.start = if ahead.level > 0 { start } else { ahead.reach.clamp(start, end) };
        start..self.unmoved.start
    }

    /// Takes note of what was done; returns the tiles that give something to the nodes that are now complete.
    pub fn advance(&mut self, tiling: &Tiling, ahead: &Ahead) -> Range<usize> {
        let level = &mut self.levels[ahead.level];
        let first = tiling.nodes_of(ahead.completed.clone()).start;
        let end = tiling.tiles_of(0..ahead.completed.end).end;
        let tiles = tiling.tiles();
        while level.oldest < end && tiles[level.oldest].reach.end <= first {
            level.oldest += 1;
        }
        level.strips.start = ahead.strips.end;
        level.open.start = ahead.completed.end;
        let of = if level.strips.is_empty() { &self.strips } else { &ahead.strips };
        level.complete = tiling.nodes_of(of.clone()).end;
        level.oldest..end
    }
}

impl Fronts {
    /// Fronts for so many threads.
    pub fn plan(&mut self, tiling: &Tiling, levels: usize, threads: usize) {
        let parts = if divides(tiling, levels, threads) { threads } else { 0 };
        // Without parts one front over everything.
        self.used = [parts, parts.saturating_sub(1).max(1)];
        for (fronts, used) in [&mut self.parts, &mut self.others].into_iter().zip(self.used) {
            fronts.resize_with(used.max(fronts.len()), Front::default);
        }
        let [of_parts, others] = self.all();
        of_parts.iter_mut().chain(&mut *others).for_each(|front| front.begin(tiling, levels));
        for number in 1..parts {
            let (left, right) = of_parts.split_at_mut(number);
            let sides = (&mut left[number - 1], &mut right[0]);
            others[number - 1].between(tiling, boundary(tiling, parts, number), sides);
        }
    }

    /// Parts, if there are any, and what is to be gone over after them: their seams, or else the whole scene.
    pub fn all(&mut self) -> [&mut [Front]; 2] {
        [&mut self.parts[..self.used[0]], &mut self.others[..self.used[1]]]
    }
}

/// Whether the scene has parts for so many threads, with seams that are not too wide.
fn divides(tiling: &Tiling, levels: usize, parts: usize) -> bool {
    if levels < 2 || parts < 2 || parts > tiling.strips().len() {
        return false;
    }
    let (mut in_seams, mut before) = (0, 0);
    for number in 1..parts {
        let edges = || edges(tiling, boundary(tiling, parts, number));
        let Some(last) = edges().nth(levels).filter(|last| before <= last.start) else { return false };
        in_seams += edges().take(levels).map(|edges| edges.len()).sum::<usize>();
        before = last.end;
    }
    in_seams * SEAMS <= levels * tiling.strips().len()
}

/// The strip that a part begins with.
fn boundary(tiling: &Tiling, parts: usize, number: usize) -> usize {
    number * tiling.strips().len() / parts
}

/// The strips that are left by the parts on both sides of a boundary, level after level.
fn edges(tiling: &Tiling, boundary: usize) -> impl Iterator<Item = Range<usize>> {
    let next = |of: &Range<usize>| Some(tiling.first_beyond(of.start)..tiling.first_unreached(of.end));
    std::iter::successors(Some(tiling.first_beyond(boundary)..boundary), next)
}

#[cfg(test)]
mod tests;
