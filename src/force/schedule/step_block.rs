//! Force passes of one step, or of a block of steps, each a few strips behind the one before it (time skewing). What
//! the scheme does to nodes before and after a pass is done in the same way through them.
//!
//! A node is moved before the first round whose elements reach it, and the scheme goes on with the nodes of a round's
//! own strips as soon as their forces are complete. So a large scene is read from memory once a step, or once a block.
//!
//! The strips of every level ([`crate::force::schedule::wavefront`]) are done in rounds. A round can begin as soon as all nodes that its
//! elements reach are complete in the level before, and were moved on, or their velocities corrected. Since elements
//! belong to the strip of their smallest node, the level before does not need those nodes any more: all happens in
//! place, and sums of a level overwrite those of the level before.

use crate::force::NodeState;
use crate::force::schedule::partition::{Beyond, Tiling};
use crate::force::schedule::pass_kind::Told;
use crate::force::schedule::step_boundary::StepBoundary;
use crate::force::schedule::sweep::{Job, Sweep, Terms, wants};
use crate::force::schedule::threads::{SUMS, Threads};
use crate::force::schedule::wavefront::{Front, LEVELS};
use crate::force::schedule::workspace::{Needs, Part, Room};
use crate::model::forces::Tally;
use crate::model::stride::{LONGEST, Passed};
use crate::model::workers::{ALONE, Workers};
use bytemuck::cast_slice;
use glam::DVec3;
use std::ops::Range;

/// Strips in a round for each of several threads that share a front, enough that none waits long for another: in one
/// step, and in several, where a cache is to hold those of all levels.
const STRIPS: [usize; 2] = [4, 2];

/// So many seams are gone over side by side, fewer one after the other by all threads.
const SIDE_BY_SIDE: usize = 3;

/// Where a pass is to find nodes.
pub struct Moving<'a> {
    /// [s]
    pub t: f64,
    /// number of the first node
    pub first: usize,
    /// [m]
    pub x: &'a mut [f64],
    /// [m/s]
    pub v: &'a mut [f64],
}

impl Moving<'_> {
    /// Of the nodes that are here.
    fn state(&self) -> NodeState<'_> {
        NodeState { t: self.t, x: cast_slice(self.x), v: cast_slice(self.v) }
    }

    /// Some of the nodes.
    fn within(&mut self, nodes: Range<usize>) -> Moving<'_> {
        let dofs = 3 * (nodes.start - self.first)..3 * (nodes.end - self.first);
        let (x, v) = (&mut self.x[dofs.clone()], &mut self.v[dofs]);
        Moving { t: self.t, first: nodes.start, x, v }
    }

    /// The nodes before one, and the others.
    fn split(self, at: usize) -> [Self; 2] {
        let Moving { t, first, x, v } = self;
        let ((x, x_after), (v, v_after)) = (x.split_at_mut(3 * (at - first)), v.split_at_mut(3 * (at - first)));
        [Moving { t, first, x, v }, Moving { t, first: at, x: x_after, v: v_after }]
    }
}

/// The steps of a block.
struct Steps<'a, T: ?Sized> {
    terms: &'a T,
    boundary: StepBoundary<'a>,
    /// empty for a single step of which no summary is made
    passed: &'a [Passed],
    threads: &'a Threads,
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
    fn at(&self, level: usize, t_end: f64) -> Doing {
        let scheme = self.boundary.block.scheme;
        let (t, wanted) =
            self.passed.get(level / scheme.passes()).map_or((t_end, false), |step| (step.t, step.stretch_wanted));
        match level % scheme.passes() {
            0 if scheme.predicts => Doing { told: Told::First, t, stretch: wanted },
            0 => Doing { told: Told::All, t, stretch: wanted },
            _ if self.terms.still() => Doing { told: Told::AllWithKept, t, stretch: false },
            _ => Doing { told: Told::All, t, stretch: false },
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

    /// Makes as many steps as there are entries of `passed`, or a single one of which no summary is made. Sums, state,
    /// tallies and summaries have the bits of steps made one by one.
    pub fn advance<T: Terms + ?Sized>(
        &self,
        (terms, moving): (&T, Moving<'_>),
        boundary: StepBoundary<'_>,
        threads: &Threads,
        out: [&mut [DVec3]; SUMS],
        (tallies, passed): (&mut [Tally], &mut [Passed]),
    ) {
        if self.resides() && passed.len() > 1 {
            self.advance_single_block((terms, moving), boundary, threads, out, passed);
        } else {
            let scheme = boundary.block.scheme;
            let works = !passed.is_empty() && out[1..].iter().any(|sum| !sum.is_empty());
            let (several, still) = (passed.len() > 1, terms.still());
            let needs = Needs {
                terms: terms.count(),
                levels: scheme.passes() * passed.len().max(1),
                threads: if several { threads.count() } else { 1 },
                keeps: scheme.predicts && still,
                aside: [works && several, scheme.predicts && several],
            };
            let mut room = self.room(needs, &out);
            self.steps((Steps { terms, boundary, passed, threads }, moving), out, &mut room);
            // Terms of the first sum are gone over once a step if they are still, and then tell their energies.
            let told_at = if still { 0 } else { scheme.passes() - 1 };
            for (step, passed) in passed.iter_mut().enumerate() {
                let first = scheme.passes() * step;
                passed.tallies.resize(terms.count(), Tally::default());
                room.add_up(first + told_at, &mut passed.tallies);
                passed.largest_stretch = room.largest_stretch(first);
                passed.nodes = room.node_sums(first + scheme.passes() - 1);
            }
            if passed.is_empty() {
                room.add_up(told_at, tallies);
            }
        }
        if let Some(last) = passed.last() {
            tallies.copy_from_slice(&last.tallies);
        }
    }

    /// A step for every level of `room`.
    fn steps<T: Terms + ?Sized>(
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
                steps.boundary.begin(span.moving.within(moved), workers);
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
        let (boundary, summarized) = (&steps.boundary, !steps.passed.is_empty());
        match (*told, *level) {
            (Told::First, 0) => boundary.kick_again(&part, moving),
            (Told::First, _) => boundary.correct(&part, moving),
            _ if summarized => boundary.end(*level, part, moving),
            (_, 0) => boundary.kick_again(&part, moving),
            // A single step that predicts: its second pass ends it.
            _ => {}
        }
    }
}

#[cfg(test)]
pub(in crate::force) mod tests;
