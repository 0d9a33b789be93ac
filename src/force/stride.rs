//! Force passes of one step, or of several steps at once, each a few strips behind the one before it (time skewing).
//!
//! A level is one of these passes: that of the first step, of the next one, or the second pass of the same step. The strips of a level are done in rounds. A round can begin
//! as soon as all nodes that its elements reach are complete in the level before, and were moved on. Since elements belong to the strip of their smallest
//! node, the level before does not need those nodes any more: all happens in place, and sums of a level overwrite those of the level before. Of the levels
//! that can go on the highest goes first, so that it finds its nodes in cache.

use super::around::Moving;
use super::room::{Needs, Room};
use super::sweep::{Round, Still, Sweep, Terms, Work, by_node, wants};
use super::threads::{SUMS, Threads};
use crate::model::stride::{Kicks, NodeSums, Nodes, Passed};
use bytemuck::cast_slice_mut;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Strips in a round for each of several threads, enough that none waits long for another: in one step, and in several, where a cache is to hold those
/// of all levels.
const STRIPS: [usize; 2] = [4, 2];

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
pub(super) struct Steps<'a, 'm, T: ?Sized> {
    pub terms: &'a T,
    pub moving: Moving<'m>,
    pub then: Then<'a>,
    pub threads: &'a Threads,
}

impl<T: Terms + ?Sized> Steps<'_, '_, T> {
    /// What a level does with forces that its velocities cannot change.
    fn still(&self, level: usize) -> Still {
        match self.then {
            Then::Again if self.terms.still() => [Still::Kept, Still::Taken][level.min(1)],
            _ => Still::Found,
        }
    }
}

/// How far a step has come.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Level {
    /// the first strip that is left
    next: usize,
    /// nodes whose forces are complete
    complete: usize,
    /// the first tile that may still give something to the others
    oldest: usize,
    /// whether its largest stretch is asked for
    stretch: bool,
}

/// Some strips, their nodes and tiles, and where the nodes end that their elements reach.
struct Ahead {
    strips: Range<usize>,
    nodes: Range<usize>,
    tiles: Range<usize>,
    reach: usize,
}

impl Sweep {
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
        let needs = Needs { terms: terms.count(), levels: passed.len(), keeps: false };
        let mut room = self.room(needs, &out);
        for (level, passed) in room.levels.iter_mut().zip(&*passed) {
            level.stretch = passed.stretch_wanted;
        }
        self.steps(Steps { terms, moving, then: Then::Next(between), threads }, out, &mut room);
        for (level, passed) in passed.iter_mut().enumerate() {
            passed.tallies.resize(terms.count(), Default::default());
            room.add_up(level, &mut passed.tallies);
            passed.largest_stretch = room.largest_stretch(level);
            passed.nodes = room.node_sums(level);
        }
    }

    /// A step for every level of `room`.
    pub(super) fn steps<T: Terms + ?Sized>(&self, steps: Steps<'_, '_, T>, out: [&mut [DVec3]; SUMS], room: &mut Room) {
        match steps.threads.workers().pool().filter(|_| self.tiling.strips().len() > 1) {
            None => self.rounds(steps, 1, out, room),
            Some(pool) => {
                let strips = STRIPS[usize::from(room.levels.len() > 1)] * pool.current_num_threads();
                pool.install(|| self.rounds(steps, strips, out, room));
            }
        }
    }

    fn rounds<T: Terms + ?Sized>(
        &self,
        mut steps: Steps<'_, '_, T>,
        strips: usize,
        mut out: [&mut [DVec3]; SUMS],
        room: &mut Room,
    ) {
        let (tiling, mut moved) = (&self.tiling, 0);
        let mut levels = std::mem::take(&mut room.levels);
        while let Some((number, ahead)) = self.next_round(&levels, strips) {
            let level = &mut levels[number];
            if number == 0 && ahead.reach > moved {
                steps.moving.before(moved..ahead.reach, steps.threads);
                moved = ahead.reach;
            }
            let (still, terms, threads) = (steps.still(number), steps.terms, steps.threads);
            let (wants, at) = (wants(terms, still), steps.moving.state());
            let work = Work { terms, wants, stretch: level.stretch, still, at, threads, tiling };
            // What is taken has its energies where they were left.
            let account = if still == Still::Taken { number - 1 } else { number };
            work.run(room.part(tiling, (account, ahead.strips.clone()), &mut out));
            while level.oldest < ahead.tiles.start && tiling.tiles()[level.oldest].reach.end <= ahead.nodes.start {
                level.oldest += 1;
            }
            (level.next, level.complete) = (ahead.strips.end, ahead.nodes.end);
            let round = Round { nodes: ahead.nodes, tiles: level.oldest..ahead.tiles.end };
            self.complete((round, ahead.strips), (number, levels.len()), &mut steps, &mut out, room);
        }
        room.levels = levels;
    }

    /// The highest level that can go on, and with what.
    fn next_round(&self, levels: &[Level], strips: usize) -> Option<(usize, Ahead)> {
        (0..levels.len()).rev().find_map(|number| {
            let ahead = self.ahead(&levels[number], strips)?;
            (number == 0 || ahead.reach <= levels[number - 1].complete).then_some((number, ahead))
        })
    }

    /// The next strips of a level; `None` at its end.
    fn ahead(&self, level: &Level, strips: usize) -> Option<Ahead> {
        let end = self.tiling.strips().end;
        let strips = level.next..(level.next + strips).min(end);
        if strips.is_empty() {
            return None;
        }
        let (nodes, tiles) = (self.tiling.nodes_of(strips.clone()), self.tiling.tiles_of(strips.clone()));
        let reach = self.tiling.tiles()[tiles.clone()].iter().fold(nodes.end, |most, plan| most.max(plan.reach.end));
        Some(Ahead { strips, nodes, tiles, reach })
    }

    /// Adds what came from other strips to the sums of a round's nodes, and does what comes after, strip by strip.
    fn complete<T: Terms + ?Sized>(
        &self,
        (round, strips): (Round, Range<usize>),
        (level, levels): (usize, usize),
        Steps { moving, then, threads, .. }: &mut Steps<'_, '_, T>,
        [total, others @ ..]: &mut [&mut [DVec3]; SUMS],
        room: &mut Room,
    ) {
        let [total_beyond, others_beyond @ ..] = &room.beyond;
        for (out, beyond) in others.iter_mut().zip(others_beyond) {
            self.add_beyond(&round, threads, beyond, out);
        }
        let Round { nodes, tiles } = round;
        let (around, then, dofs) = (moving.around, *then, 3 * nodes.start..3 * nodes.end);
        let strip = |i: usize, [f, x, v]: [&mut [f64]; 3], sums: &mut NodeSums| {
            let first = dofs.start + i * 3 * self.tiling.strip();
            let r = first..first + f.len();
            self.tiling.add_beyond(tiles.clone(), total_beyond, (first / 3, by_node(f)));
            match then {
                Then::Next(Between { kicks, mass, inverse_mass }) => {
                    let (mass, inverse_mass) = (&mass[r.start / 3..r.end / 3], &inverse_mass[r]);
                    *sums = kicks.end(Nodes::<3> { mass, inverse_mass, x, v, f }, level + 1 < levels);
                }
                Then::Again if level > 0 => {}
                Then::Again | Then::Done => around.after(r, v, f),
            }
        };
        let size = 3 * self.tiling.strip();
        let f: &mut [f64] = cast_slice_mut(&mut total[nodes.clone()]);
        let (x, v) = (&mut moving.x[dofs.clone()], &mut moving.v[dofs.clone()]);
        let sums = &mut room.nodes[level * self.tiling.strips().len()..][strips];
        match threads.workers().pool().filter(|_| sums.len() > 1) {
            None => {
                let parts = f.chunks_mut(size).zip(x.chunks_mut(size)).zip(v.chunks_mut(size)).zip(sums);
                parts.enumerate().for_each(|(i, (((f, x), v), sums))| strip(i, [f, x, v], sums));
            }
            Some(_) => {
                let parts = f.par_chunks_mut(size).zip(x.par_chunks_mut(size)).zip(v.par_chunks_mut(size)).zip(sums);
                parts.enumerate().for_each(|(i, (((f, x), v), sums))| strip(i, [f, x, v], sums));
            }
        }
    }
}

#[cfg(test)]
mod tests;
