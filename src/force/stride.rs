//! Force passes of one step, or of several steps at once, each a few strips behind the one before it (time skewing).
//!
//! The strips of every level ([`super::fronts`]) are done in rounds. A round can begin as soon as all nodes that its elements reach are complete in the level before,
//! and were moved on. Since elements belong to the strip of their smallest node, the level before does not need those nodes any more: all happens in
//! place, and sums of a level overwrite those of the level before.

use super::around::Moving;
use super::fronts::{Ahead, Front, most_levels};
use super::room::{Needs, Part, Room};
use super::sweep::{Still, Sweep, Terms, Work, by_node, wants};
use super::threads::{SUMS, Threads};
use super::tiling::{Beyond, Tiling};
use crate::model::stride::{Kicks, LONGEST, NodeSums, Nodes, Passed};
use crate::model::workers::{ALONE, Workers};
use bytemuck::cast_slice_mut;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Strips in a round for each of several threads that share a front, enough that none waits long for another: in one step, and in several, where a cache is to hold those
/// of all levels.
const STRIPS: [usize; 2] = [4, 2];

/// So many seams are gone over side by side, fewer one after the other by all threads.
const SIDE_BY_SIDE: usize = 3;

/// What is to be done where one step of several ends.
#[derive(Clone, Copy)]
pub struct Between<'a> {
    /// moves nodes on to the next step
    pub kicks: Kicks,
    /// [kg] one a node
    pub mass: &'a [f64],
    /// [1/kg] by degree of freedom, 0 at fixed ones
    pub inverse_mass: &'a [f64],
}

/// What follows a level.
#[derive(Clone, Copy)]
pub(super) enum Then<'a> {
    /// nothing
    Done,
    /// the same positions again, with the velocities that what came after has left; after that nothing
    Again,
    /// the next step
    Next(Between<'a>),
}

/// One step, or several levels with something between them.
pub(super) struct Steps<'a, T: ?Sized> {
    pub terms: &'a T,
    pub then: Then<'a>,
    pub threads: &'a Threads,
}

impl<T: Terms + ?Sized> Steps<'_, T> {
    /// What a level does with forces that its velocities cannot change.
    fn still(&self, level: usize) -> Still {
        match self.then {
            Then::Again if self.terms.still() => [Still::Kept, Still::Taken][level.min(1)],
            _ => Still::Found,
        }
    }
}

/// Some strips, and the state of their nodes.
struct Span<'a> {
    part: Part<'a>,
    moving: Moving<'a>,
}

impl Span<'_> {
    fn within(&mut self, tiling: &Tiling, strips: Range<usize>) -> Span<'_> {
        let moving = self.moving.within(tiling.nodes_of(strips.clone()));
        Span { part: self.part.within(tiling, strips), moving }
    }

    /// The strips before one, and the others.
    fn split(self, tiling: &Tiling, at: usize) -> [Self; 2] {
        let [before, after] = self.moving.split(tiling.nodes_of(at..at).start);
        let [part, others] = self.part.split(tiling, at);
        [Span { part, moving: before }, Span { part: others, moving: after }]
    }
}

impl Sweep {
    /// How many steps a stride may have that is worth while.
    pub fn longest_stride<T: Terms + ?Sized>(&self, terms: &T, threads: &Threads) -> usize {
        if self.resides(terms) { LONGEST } else { most_levels(&self.tiling, threads.count()) }
    }

    /// As many steps as there are entries of `passed`, from the state that `moving.around` makes before the first. Sums, state and what is told of every step
    /// have the bits of steps made one by one.
    pub fn stride<T: Terms + ?Sized>(
        &self,
        (terms, moving): (&T, Moving<'_>),
        between: Between<'_>,
        threads: &Threads,
        out: [&mut [DVec3]; SUMS],
        passed: &mut [Passed],
    ) {
        if self.resides(terms) {
            return self.stride_in_windows((terms, moving), between, threads, out, passed);
        }
        let needs = Needs { terms: terms.count(), levels: passed.len(), threads: threads.count(), keeps: false };
        let mut room = self.room(needs, &out);
        for (number, level) in room.fronts.levels() {
            level.stretch = passed[number].stretch_wanted;
        }
        self.steps((Steps { terms, then: Then::Next(between), threads }, moving), out, &mut room);
        for (level, passed) in passed.iter_mut().enumerate() {
            passed.tallies.resize(terms.count(), Default::default());
            room.add_up(level, &mut passed.tallies);
            passed.largest_stretch = room.largest_stretch(level);
            passed.nodes = room.node_sums(level);
        }
    }

    /// A step for every level of `room`.
    pub(super) fn steps<T: Terms + ?Sized>(
        &self,
        (steps, moving): (Steps<'_, T>, Moving<'_>),
        out: [&mut [DVec3]; SUMS],
        room: &mut Room,
    ) {
        let tiling = &self.tiling;
        let (part, fronts) = room.parts(tiling, out);
        let mut span = Span { part, moving };
        let pool = steps.threads.workers().pool().filter(|_| tiling.strips().len() > 1);
        let [parts, others] = fronts.all();
        let Some(pool) = pool else { return self.side_by_side(&steps, others, span) };
        pool.install(|| {
            self.side_by_side(&steps, parts, span.within(tiling, tiling.strips()));
            if others.len() >= SIDE_BY_SIDE {
                return self.side_by_side(&steps, others, span);
            }
            for front in others {
                let span = span.within(tiling, front.strips.clone());
                let strips = STRIPS[usize::from(front.levels.len() > 1)] * pool.current_num_threads();
                self.rounds(&steps, (front, strips), span, steps.threads.workers());
            }
        });
    }

    /// Every front by one thread, or all by the only one.
    fn side_by_side<T: Terms + ?Sized>(&self, steps: &Steps<'_, T>, fronts: &mut [Front], span: Span<'_>) {
        match fronts {
            [] => {}
            [front] => self.rounds(steps, (front, 1), span, &ALONE),
            _ => {
                let (left, right) = fronts.split_at_mut(fronts.len() / 2);
                let [before, after] = span.split(&self.tiling, right[0].strips.start);
                rayon::join(|| self.side_by_side(steps, left, before), || self.side_by_side(steps, right, after));
            }
        }
    }

    /// A front to its end, so many strips at once.
    fn rounds<T: Terms + ?Sized>(
        &self,
        steps: &Steps<'_, T>,
        (front, strips): (&mut Front, usize),
        mut span: Span<'_>,
        workers: &Workers,
    ) {
        let tiling = &self.tiling;
        while let Some(ahead) = front.ahead(tiling, strips) {
            let level = ahead.level;
            let moved = front.move_for(&ahead);
            if !moved.is_empty() {
                span.moving.before(moved, workers);
            }
            let (still, terms) = (steps.still(level), steps.terms);
            let work = Work {
                terms,
                wants: wants(terms, still),
                stretch: front.levels[level].stretch,
                still,
                // What is taken has its energies where they were left.
                level: if still == Still::Taken { level - 1 } else { level },
                at: span.moving.state(),
                first: span.moving.first,
                windows_alone: matches!(steps.then, Then::Next(_)),
                threads: steps.threads,
                workers,
                tiling,
            };
            work.run(span.part.within(tiling, ahead.strips.clone()));
            let tiles = front.advance(tiling, &ahead);
            self.complete(steps, (ahead, tiles), &mut span, workers);
        }
    }

    /// Adds what came from other strips to the sums of nodes, and does what comes after, strip by strip.
    fn complete<T: Terms + ?Sized>(
        &self,
        steps: &Steps<'_, T>,
        (Ahead { level, completed, .. }, tiles): (Ahead, Range<usize>),
        Span { part, moving }: &mut Span<'_>,
        workers: &Workers,
    ) {
        let tiling = &self.tiling;
        let nodes = tiling.nodes_of(completed.clone());
        let of_span = nodes.start - moving.first..nodes.end - moving.first;
        let first = tiling.beyond_of(tiling.tiles_of(part.strips.clone())).start;
        let [total_beyond, others_beyond @ ..] = part.beyond.each_ref().map(|sums| Beyond { first, sums });
        let [total, others @ ..] = &mut part.out;
        for (out, beyond) in others.iter_mut().zip(others_beyond).filter(|(out, _)| !out.is_empty()) {
            tiling.add_beyond_by(workers, tiles.clone(), beyond, (nodes.start, &mut out[of_span.clone()]));
        }
        let (around, then, dofs) = (moving.around, steps.then, 3 * of_span.start..3 * of_span.end);
        let (size, last) = (3 * tiling.strip(), level + 1 == part.levels);
        let strip = |i: usize, [f, x, v]: [&mut [f64]; 3], sums: &mut [NodeSums]| {
            let first = 3 * nodes.start + i * size;
            let r = first..first + f.len();
            tiling.add_beyond(tiles.clone(), total_beyond, (first / 3, by_node(f)));
            match then {
                Then::Next(Between { kicks, mass, inverse_mass }) => {
                    let (mass, inverse_mass) = (&mass[r.start / 3..r.end / 3], &inverse_mass[r]);
                    sums[level] = kicks.end(Nodes::<3> { mass, inverse_mass, x, v, f }, !last);
                }
                Then::Again if level > 0 => {}
                Then::Again | Then::Done => around.after(r, v, f),
            }
        };
        let f: &mut [f64] = cast_slice_mut(&mut total[of_span]);
        let (x, v) = (&mut moving.x[dofs.clone()], &mut moving.v[dofs]);
        let levels = part.levels;
        let of_part = completed.start - part.strips.start..completed.end - part.strips.start;
        let sums = &mut part.nodes[levels * of_part.start..levels * of_part.end];
        match workers.pool().filter(|_| completed.len() > 1) {
            None => {
                let parts =
                    f.chunks_mut(size).zip(x.chunks_mut(size)).zip(v.chunks_mut(size)).zip(sums.chunks_mut(levels));
                parts.enumerate().for_each(|(i, (((f, x), v), sums))| strip(i, [f, x, v], sums));
            }
            Some(_) => {
                let parts = f.par_chunks_mut(size).zip(x.par_chunks_mut(size)).zip(v.par_chunks_mut(size));
                let parts = parts.zip(sums.par_chunks_mut(levels)).enumerate();
                parts.for_each(|(i, (((f, x), v), sums))| strip(i, [f, x, v], sums));
            }
        }
    }
}

#[cfg(test)]
mod tests;
