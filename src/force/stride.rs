//! Force passes of one step, or of several steps at once, each a few strips behind the one before it (time skewing).
//!
//! The strips of every level ([`super::fronts`]) are done in rounds. A round can begin as soon as all nodes that its
//! elements reach are complete in the level before, and were moved on, or their velocities corrected. Since elements
//! belong to the strip of their smallest node, the level before does not need those nodes any more: all happens in
//! place, and sums of a level overwrite those of the level before.

use super::NodeState;
use super::around::Moving;
use super::between::Between;
use super::fronts::{Front, LEVELS};
use super::room::{Needs, Part, Room};
use super::sweep::{Job, Sweep, Terms, wants};
use super::threads::{SUMS, Threads};
use super::tiling::{Beyond, Tiling};
use super::told::Told;
use crate::model::stride::{Kicks, LONGEST, Passed};
use crate::model::workers::{ALONE, Workers};
use bytemuck::cast_slice;
use glam::DVec3;
use std::ops::Range;

/// Strips in a round for each of several threads that share a front, enough that none waits long for another: in one
/// step, and in several, where a cache is to hold those of all levels.
const STRIPS: [usize; 2] = [4, 2];

/// So many seams are gone over side by side, fewer one after the other by all threads.
const SIDE_BY_SIDE: usize = 3;

/// What follows a level.
#[derive(Clone, Copy)]
pub(super) enum Then<'a> {
    /// nothing
    Done,
    /// the same positions again, with the velocities that what came after has left; after that nothing
    Again,
    /// the next step, or where steps predict, the same positions again and then the next
    Next(Between<'a>, Kicks, &'a [Passed]),
}

/// One step, or several levels with something between them.
pub(super) struct Steps<'a, T: ?Sized> {
    pub terms: &'a T,
    pub then: Then<'a>,
    pub threads: &'a Threads,
}

/// What is done at a level.
struct Doing {
    told: Told,
    /// [s]
    t: f64,
    /// whether the largest stretch is looked for
    stretch: bool,
}

impl<T: Terms + ?Sized> Steps<'_, T> {
    fn at(&self, level: usize, t: f64) -> Doing {
        match self.then {
            Then::Done => Doing { told: Told::All, t, stretch: false },
            Then::Again if level == 0 => Doing { told: Told::First, t, stretch: false },
            Then::Again if self.terms.still() => Doing { told: Told::AllWithKept, t, stretch: false },
            Then::Again => Doing { told: Told::All, t, stretch: false },
            Then::Next(_, kicks, passed) => {
                let Passed { t, stretch_wanted, .. } = passed[level / kicks.passes()];
                match level % kicks.passes() {
                    0 if kicks.predicts => Doing { told: Told::First, t, stretch: stretch_wanted },
                    0 => Doing { told: Told::All, t, stretch: stretch_wanted },
                    _ => Doing { told: Told::AllWithKept, t, stretch: false },
                }
            }
        }
    }
}

/// Strips whose nodes are complete in a level.
struct Completed<'a> {
    level: usize,
    told: Told,
    /// what gives something to these nodes
    tiles: Range<usize>,
    beyond: [Beyond<'a>; SUMS],
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
    /// How many steps a stride may have that is worth while, with so many force passes each.
    pub fn longest_stride(&self, passes: usize) -> usize {
        if self.resides() { LONGEST } else { LEVELS / passes }
    }

    /// As many steps as there are entries of `passed`, from the state that `moving.around` makes before the first.
    /// Sums, state and what is told of every step have the bits of steps made one by one. Where steps predict, terms of
    /// the first sum have to be [still](Terms::still). (A scene in windows begins by the scheme's point and kicks in
    /// place of what it does before and after: they are the same.)
    pub fn stride<T: Terms + ?Sized>(
        &self,
        (terms, moving): (&T, Moving<'_>),
        between: Between<'_>,
        threads: &Threads,
        out: [&mut [DVec3]; SUMS],
        passed: &mut [Passed],
    ) {
        debug_assert!(!between.scheme.kicks().predicts || terms.still());
        if self.resides() {
            return self.stride_in_windows((terms, moving), between, threads, out, passed);
        }
        let (kicks, works) = (between.scheme.kicks(), out[1..].iter().any(|sum| !sum.is_empty()));
        let (levels, threads_of) = (kicks.passes() * passed.len(), threads.count());
        let aside = [works, kicks.predicts];
        let needs = Needs { terms: terms.count(), levels, threads: threads_of, keeps: kicks.predicts, aside };
        let mut room = self.room(needs, &out);
        let then = Then::Next(between, kicks, passed);
        self.steps((Steps { terms, then, threads }, moving), out, &mut room);
        for (step, passed) in passed.iter_mut().enumerate() {
            let first = kicks.passes() * step;
            passed.tallies.resize(terms.count(), Default::default());
            room.add_up(first, &mut passed.tallies);
            passed.largest_stretch = room.largest_stretch(first);
            passed.nodes = room.node_sums(first + kicks.passes() - 1);
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
            let Doing { told, t, stretch } = steps.at(level, span.moving.t);
            let job = Job {
                terms: steps.terms,
                wants: wants(steps.terms, told),
                stretch,
                told,
                // Energies of what was kept are told already.
                level: if told == Told::AllWithKept { level - 1 } else { level },
                at: NodeState { t, ..span.moving.state() },
                first: span.moving.first,
                threads: steps.threads,
                workers,
                tiling,
            };
            job.run(span.part.within(tiling, ahead.strips.clone()));
            let tiles = front.advance(tiling, &ahead);
            let first = tiling.beyond_of(tiling.tiles_of(span.part.strips.clone())).start;
            let beyond = std::mem::take(&mut span.part.beyond);
            let sums = beyond.each_ref().map(|sums| Beyond { first, sums });
            let completed = Completed { level, told, tiles, beyond: sums };
            self.complete(steps, &completed, span.within(tiling, ahead.completed), workers);
            span.part.beyond = beyond;
        }
    }

    /// Adds what came from other strips to the sums of nodes, and does what comes after, strip by strip.
    fn complete<T: Terms + ?Sized>(
        &self,
        steps: &Steps<'_, T>,
        completed: &Completed<'_>,
        mut span: Span<'_>,
        workers: &Workers,
    ) {
        let strips = span.part.strips.clone();
        match workers.pool().filter(|_| strips.len() > 1) {
            None => {
                for strip in strips {
                    self.complete_strip(steps, completed, span.within(&self.tiling, strip..strip + 1));
                }
            }
            Some(_) => {
                let [left, right] = span.split(&self.tiling, strips.start + strips.len() / 2);
                rayon::join(
                    || self.complete(steps, completed, left, workers),
                    || self.complete(steps, completed, right, workers),
                );
            }
        }
    }

    fn complete_strip<T: Terms + ?Sized>(
        &self,
        steps: &Steps<'_, T>,
        Completed { level, told, tiles, beyond }: &Completed<'_>,
        Span { mut part, moving }: Span<'_>,
    ) {
        let nodes = self.tiling.nodes_of(part.strips.clone());
        for (out, beyond) in part.out.iter_mut().zip(beyond).take(told.sums()) {
            if !out.is_empty() {
                self.tiling.add_beyond(tiles.clone(), *beyond, (nodes.start, out));
            }
        }
        let dofs = 3 * nodes.start..3 * nodes.end;
        match steps.then {
            Then::Again if *level > 0 => {}
            Then::Again | Then::Done => moving.around.after(dofs, moving.v, cast_slice(part.out[0])),
            Then::Next(between, kicks, _) if *told != Told::First => between.end(kicks, *level, part, moving),
            Then::Next(..) if *level == 0 => moving.around.after(dofs, moving.v, cast_slice(part.out[0])),
            Then::Next(between, kicks, _) => {
                kicks.correct(
                    moving.v,
                    cast_slice(part.aside[1]),
                    &between.inverse_mass[dofs],
                    cast_slice(part.out[0]),
                );
            }
        }
    }
}

#[cfg(test)]
mod tests;
