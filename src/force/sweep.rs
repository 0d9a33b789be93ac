//! Passes over the tiles of a scene, with the same bits for every number of threads.
//!
//! Strip by strip, mostly a tile each, windows are filled, all terms add to them while they are in cache, and what the strip's own nodes get is stored:
//! no sum is zeroed in memory or read back. What lies beyond the strip is kept apart and added when all strips (`around`: of a round) are done, in their order, as are energies
//! and powers. So no sum depends on which thread did which strip.

use super::NodeState;
use super::batch::{Summand, Wants};
use super::threads::{SUMS, Threads, Windows};
use super::tile::Tile;
use super::tiling::{Plan, Tiling};
use super::window::{Padded, RECORD, Records, Window, add_rows, copy_rows, plus_rows, rows, store_rows};
use crate::model::forces::Tally;
use glam::DVec3;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What a pass adds up.
pub trait Terms: Sync {
    /// How many there are.
    fn count(&self) -> usize;

    /// A term, and which of the pass's sums it adds to: 0, 1 or 2.
    fn term(&self, i: usize) -> (&dyn Summand, usize);
}

/// All add to the only sum.
impl<S: Summand> Terms for [S] {
    fn count(&self) -> usize {
        self.len()
    }

    fn term(&self, i: usize) -> (&dyn Summand, usize) {
        (&self[i], 0)
    }
}

/// The tiles of a scene and the room a pass needs.
#[derive(Debug)]
pub struct Sweep {
    pub(super) tiling: Tiling,
    room: Mutex<Room>,
}

#[derive(Debug, Default)]
pub(super) struct Room {
    /// what each sum gets beyond the strips' ends
    pub beyond: [Vec<Padded>; SUMS],
    /// of the pass
    terms: usize,
    /// tile after tile, term after term
    tallies: Vec<Tally>,
}

/// What a pass reads, and with which threads.
pub(super) struct Work<'a, T: ?Sized> {
    pub terms: &'a T,
    pub wants: Wants,
    pub at: NodeState<'a>,
    pub threads: &'a Threads,
    pub tiling: &'a Tiling,
}

/// The nodes of some strips, and tiles that hold all whose elements reach them.
pub(super) struct Round {
    pub nodes: Range<usize>,
    pub tiles: Range<usize>,
}

/// Some strips and where their sums go.
pub(super) struct Part<'a> {
    strips: Range<usize>,
    out: [&'a mut [DVec3]; SUMS],
    beyond: [&'a mut [Padded]; SUMS],
    tallies: &'a mut [Tally],
}

impl Sweep {
    /// Cuts `nodes` nodes into tiles and tells every summand its elements.
    pub fn new(nodes: usize, summands: &mut [&mut dyn Summand]) -> Self {
        Sweep::of(Tiling::new(nodes, summands))
    }

    pub(super) fn of(tiling: Tiling) -> Self {
        Sweep { tiling, room: Mutex::default() }
    }

    /// Overwrites every sum with what its terms give [N]; the first gets those of the others too. A sum may be empty
    /// only if no term adds to it. Tells every term's energy [J] or power [W] in `tallies`.
    pub fn pass<T: Terms + ?Sized>(
        &self,
        (terms, at): (&T, NodeState<'_>),
        threads: &Threads,
        mut out: [&mut [DVec3]; SUMS],
        tallies: &mut [Tally],
    ) {
        debug_assert!((0..terms.count()).all(|i| !out[terms.term(i).1].is_empty()) || at.x.is_empty());
        let mut room = self.room(terms.count(), &out);
        let work = Work { terms, wants: wants(terms), at, threads, tiling: &self.tiling };
        work.run(self.part(self.tiling.strips(), &mut out, &mut room));
        let all = Round { nodes: self.tiling.nodes_of(self.tiling.strips()), tiles: 0..self.tiling.tiles().len() };
        for (out, beyond) in out.iter_mut().zip(&room.beyond) {
            self.add_beyond(&all, threads, beyond, out);
        }
        room.add_up(tallies);
    }

    /// Adds to a sum, unless it is empty, what a round's nodes get from beyond the strips of its tiles.
    pub(super) fn add_beyond(
        &self,
        Round { nodes, tiles }: &Round,
        threads: &Threads,
        beyond: &[Padded],
        out: &mut [DVec3],
    ) {
        if !out.is_empty() {
            threads.workers().each(bytemuck::cast_slice_mut(&mut out[nodes.clone()]), |dofs, out| {
                self.tiling.add_beyond(tiles.clone(), beyond, (nodes.start + dofs.start / 3, by_node(out)));
                0.0
            });
        }
    }

    /// Room for a pass of some terms into sums of these sizes.
    pub(super) fn room(&self, terms: usize, out: &[&mut [DVec3]; SUMS]) -> MutexGuard<'_, Room> {
        let mut room = self.room.lock().unwrap_or_else(PoisonError::into_inner);
        for (beyond, _) in room.beyond.iter_mut().zip(out).filter(|(_, out)| !out.is_empty()) {
            beyond.resize(self.tiling.beyond().len(), Padded::default());
        }
        room.terms = terms;
        room.tallies.resize(self.tiling.tiles().len() * terms, Tally::default());
        room
    }

    /// The places of some strips.
    pub(super) fn part<'a>(
        &self,
        strips: Range<usize>,
        out: &'a mut [&mut [DVec3]; SUMS],
        room: &'a mut Room,
    ) -> Part<'a> {
        let (nodes, tiles) = (self.tiling.nodes_of(strips.clone()), self.tiling.tiles_of(strips.clone()));
        let beyond = self.tiling.beyond_of(tiles.clone());
        Part {
            out: out.each_mut().map(|out| if out.is_empty() { &mut **out } else { &mut out[nodes.clone()] }),
            beyond: room.beyond.each_mut().map(|sums| sums.get_mut(beyond.clone()).unwrap_or_default()),
            tallies: &mut room.tallies[tiles.start * room.terms..tiles.end * room.terms],
            strips,
        }
    }
}

impl Room {
    /// Adds up energies and powers of every term, tile after tile.
    pub(super) fn add_up(&self, tallies: &mut [Tally]) {
        tallies.fill(Tally::default());
        for by_tile in self.tallies.chunks(self.terms.max(1)) {
            tallies.iter_mut().zip(by_tile).for_each(|(total, tally)| *total += *tally);
        }
    }
}

pub(super) fn by_node(dofs: &mut [f64]) -> &mut [DVec3] {
    bytemuck::cast_slice_mut(dofs)
}

/// What any of the terms wants.
pub(super) fn wants<T: Terms + ?Sized>(terms: &T) -> Wants {
    (0..terms.count()).map(|i| terms.term(i).0.wants()).fold(Wants::default(), Wants::or)
}

impl<T: Terms + ?Sized> Work<'_, T> {
    /// Fills the places of some strips.
    pub(super) fn run(&self, part: Part<'_>) {
        match self.threads.workers().pool().filter(|_| part.strips.len() > 1) {
            None => self.in_order(part),
            Some(pool) => pool.install(|| self.side_by_side(part)),
        }
    }

    fn in_order(&self, mut part: Part<'_>) {
        while part.strips.len() > 1 {
            let next = part.strips.start + 1;
            let [one, others] = self.split(part, next);
            self.strip(one, &mut self.threads.windows(0));
            part = others;
        }
        self.strip(part, &mut self.threads.windows(0));
    }

    fn side_by_side(&self, part: Part<'_>) {
        if part.strips.len() <= 1 {
            return self.strip(part, &mut self.threads.windows(rayon::current_thread_index().unwrap_or(0)));
        }
        let middle = part.strips.start + part.strips.len() / 2;
        let [left, right] = self.split(part, middle);
        rayon::join(|| self.side_by_side(left), || self.side_by_side(right));
    }

    fn split<'p>(&self, part: Part<'p>, at: usize) -> [Part<'p>; 2] {
        let Part { strips, out, beyond, tallies } = part;
        let before = strips.start..at;
        let tiles = self.tiling.tiles_of(before.clone());
        let (out, out_after) = halves(out, self.tiling.nodes_of(before.clone()).len());
        let (beyond, beyond_after) = halves(beyond, self.tiling.beyond_of(tiles.clone()).len());
        let (tallies, tallies_after) = tallies.split_at_mut(tiles.len() * self.terms.count());
        [
            Part { strips: before, out, beyond, tallies },
            Part { strips: at..strips.end, out: out_after, beyond: beyond_after, tallies: tallies_after },
        ]
    }

    fn strip(&self, part: Part<'_>, windows: &mut Windows) {
        let Part { strips, mut out, mut beyond, tallies } = part;
        let numbers = self.tiling.tiles_of(strips);
        let first = self.tiling.beyond_of(numbers.clone()).start;
        let count = self.terms.count();
        for (number, i) in numbers.zip(0..) {
            let plan = &self.tiling.tiles()[number];
            self.tile(number, windows, &out, &mut tallies[i * count..(i + 1) * count]);
            let place = plan.beyond.start - first..plan.beyond.end - first;
            for ((out, beyond), sums) in out.iter_mut().zip(&mut beyond).zip(&mut windows.sums) {
                if !out.is_empty() {
                    let (own, others) = rows(sums.records(), plan.records()).split_at(plan.own.len());
                    if plan.opens_strip {
                        store_rows(own, out)
                    } else {
                        add_rows(own, out)
                    }
                    beyond[place.clone()].copy_from_slice(others);
                }
            }
        }
    }

    /// Leaves in the windows what the terms add to the nodes of a tile, in every sum that is not empty.
    fn tile(&self, number: usize, windows: &mut Windows, out: &[&mut [DVec3]; SUMS], tallies: &mut [Tally]) {
        let plan = &self.tiling.tiles()[number];
        let Windows { x, v, sums } = windows;
        let (x, v) = (x.records(), v.records());
        if self.wants.x {
            self.load(plan, self.at.x, x);
        }
        if self.wants.v {
            self.load(plan, self.at.v, v);
        }
        let sums = sums.each_mut().map(Window::records);
        let mut present = sums.into_iter().zip(out).map(|(sum, out)| (!out.is_empty()).then_some(sum));
        let mut sums: [Option<&mut Records>; SUMS] = std::array::from_fn(|_| present.next().flatten());
        for sum in sums.iter_mut().flatten() {
            sum[..RECORD * plan.records()].fill(0.0);
        }
        let own = if plan.opens_strip { plan.own.clone() } else { 0..0 };
        let tile = Tile { number, own, at: self.at, x, v };
        for (i, tally) in tallies.iter_mut().enumerate() {
            let (term, sum) = self.terms.term(i);
            *tally = sums[sum].as_deref_mut().map_or_else(Tally::default, |sum| term.add(&tile, sum));
        }
        if let [Some(total), others @ ..] = &mut sums {
            for other in others.iter_mut().flatten() {
                plus_rows(rows(other, plan.records()), rows(total, plan.records()));
            }
        }
    }

    /// Copies a nodal vector into a tile's window.
    fn load(&self, plan: &Plan, from: &[DVec3], to: &mut Records) {
        let (own, others) = rows(to, plan.records()).split_at_mut(plan.own.len());
        copy_rows(&from[plan.own.clone()], own);
        match plan.run {
            Some(first) => copy_rows(&from[first..first + others.len()], others),
            None => {
                for (to, &node) in others.iter_mut().zip(&self.tiling.beyond()[plan.beyond.clone()]) {
                    let from = from[node as usize];
                    *to = [from.x, from.y, from.z, 0.0];
                }
            }
        }
    }
}

/// What comes before a place and what comes after; nothing of what is empty.
fn halves<T>(slices: [&mut [T]; SUMS], at: usize) -> ([&mut [T]; SUMS], [&mut [T]; SUMS]) {
    let [a, b, c] = slices.map(|slice| slice.split_at_mut(at.min(slice.len())));
    ([a.0, b.0, c.0], [a.1, b.1, c.1])
}

#[cfg(test)]
mod tests;
