//! Passes over the tiles of a scene, with the same bits for every number of threads.
//!
//! Strip by strip, mostly a tile each, windows are filled, all terms add to them while they are in cache, and what the
//! strip's own nodes get is stored: no sum is zeroed in memory or read back. What lies beyond the strip is kept apart
//! and added when all strips (`step_block`: of a round) are done, in their order, as are energies and powers. So no sum
//! depends on which thread did which strip.

use crate::force::NodeState;
use crate::force::kernel::batch::{Summand, Wants};
use crate::force::kernel::element_block::Tile;
use crate::force::kernel::local_buffer::{Padded, Records, Window, add_rows, copy_rows, rows, store_rows};
use crate::force::schedule::buffer_pool::{Shelf, Taken};
use crate::force::schedule::partition::{Beyond, Plan, Tiling};
use crate::force::schedule::pass_kind::{Sums, Told};
use crate::force::schedule::threads::{SUMS, Threads, Windows};
use crate::force::schedule::workspace::{Needs, Part, Room};
use crate::model::forces::Tally;
use crate::model::workers::Workers;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// What a pass adds up.
pub trait Terms: Sync {
    /// How many there are.
    fn count(&self) -> usize;

    /// A term, and which of the pass's sums it adds to: 0, 1 or 2.
    fn term(&self, i: usize) -> (&dyn Summand, usize);

    /// Whether all terms of the first sum are still: their forces follow from positions alone, so that other velocities
    /// change nothing.
    fn still(&self) -> bool {
        false
    }

    /// [-] Largest l^2/l0^2 of all springs of a tile, if it is wanted; else and without springs -inf.
    fn largest_stretch(&self, tile: &Tile<'_>, wanted: bool) -> f64 {
        let terms = if wanted { 0..self.count() } else { 0..0 };
        terms.map(|i| self.term(i).0.largest_stretch(tile)).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// The tiles of a scene and the room a pass needs.
#[derive(Debug)]
pub struct Sweep {
    pub(in crate::force) tiling: Tiling,
    room: Shelf<Room>,
    /// of a sum over strips
    parts: Shelf<Vec<f64>>,
}

/// What a pass reads, and with which threads.
pub(in crate::force) struct Job<'a, T: ?Sized> {
    pub terms: &'a T,
    pub wants: Wants,
    /// whether the largest stretch is looked for
    pub stretch: bool,
    pub told: Told,
    /// in which level energies and powers are told
    pub level: usize,
    /// of nodes from one of them on, as many as elements reach
    pub at: NodeState<'a>,
    /// its number
    pub first: usize,
    pub threads: &'a Threads,
    /// all of them, or the one that this is done by
    pub workers: &'a Workers,
    pub tiling: &'a Tiling,
}

impl Sweep {
    /// Cuts `nodes` nodes into tiles and tells every summand its elements.
    pub fn new(nodes: usize, summands: &mut [&mut dyn Summand]) -> Self {
        Sweep::of(Tiling::new(nodes, summands))
    }

    pub(in crate::force) fn of(tiling: Tiling) -> Self {
        Sweep { tiling, room: Shelf::default(), parts: Shelf::default() }
    }

    /// Overwrites every sum with what its terms give [N]; the first gets those of the others too. A sum may be empty
    /// only if no term adds to it. Tells every term's energy [J] or power [W] in `tallies`.
    pub fn pass<T: Terms + ?Sized>(
        &self,
        (terms, at): (&T, NodeState<'_>),
        threads: &Threads,
        out: [&mut [DVec3]; SUMS],
        tallies: &mut [Tally],
    ) {
        debug_assert!((0..terms.count()).all(|i| !out[terms.term(i).1].is_empty()) || at.x.is_empty());
        let mut room = self.room(Needs::of_a_pass(terms.count()), &out);
        let (tiling, workers) = (&self.tiling, threads.workers());
        let (told, level, first, stretch) = (Told::All, 0, 0, false);
        let wants = wants(terms, told);
        let job = Job { terms, wants, stretch, told, level, at, first, threads, workers, tiling };
        let (mut all, _) = room.parts(tiling, out);
        job.run(all.within(tiling, tiling.strips()));
        for (out, sums) in all.out.into_iter().zip(all.beyond).filter(|(out, _)| !out.is_empty()) {
            tiling.add_beyond_by(workers, 0..tiling.tiles().len(), Beyond { first: 0, sums }, (0, out));
        }
        room.add_up(0, tallies);
    }

    /// A sum over the nodes, strip after strip.
    pub fn by_strips(&self, threads: &Threads, of: impl Fn(Range<usize>) -> f64 + Sync) -> f64 {
        let strips = self.tiling.strips();
        let of = |strip: usize| of(self.tiling.nodes_of(strip..strip + 1));
        match threads.workers().pool().filter(|_| strips.len() > 1) {
            None => strips.map(of).sum(),
            Some(pool) => {
                let mut parts = self.parts.take();
                parts.resize(strips.len(), 0.0);
                let parts = &mut **parts;
                pool.install(|| parts.par_iter_mut().zip(strips).for_each(|(part, strip)| *part = of(strip)));
                parts.iter().sum()
            }
        }
    }

    /// Room for passes into sums of these sizes.
    pub(in crate::force) fn room(&self, needs: Needs, out: &[&mut [DVec3]; SUMS]) -> Taken<'_, Room> {
        let mut room = self.room.take();
        room.fit(&self.tiling, needs, out);
        room
    }
}

pub(in crate::force) fn by_node(dofs: &mut [f64]) -> &mut [DVec3] {
    bytemuck::cast_slice_mut(dofs)
}

/// What any of the terms wants that a pass goes over.
pub(in crate::force) fn wants<T: Terms + ?Sized>(terms: &T, told: Told) -> Wants {
    let terms = (0..terms.count()).map(|i| terms.term(i)).filter(|(_, sum)| told.goes_over(*sum));
    terms.map(|(term, _)| term.wants()).fold(Wants::default(), Wants::or)
}

impl<T: Terms + ?Sized> Job<'_, T> {
    /// Fills the places of some strips.
    pub(in crate::force) fn run(&self, part: Part<'_>) {
        match self.workers.pool().filter(|_| part.strips.len() > 1) {
            None => self.in_order(part),
            Some(pool) => pool.install(|| self.side_by_side(part)),
        }
    }

    fn in_order(&self, mut part: Part<'_>) {
        while part.strips.len() > 1 {
            let next = part.strips.start + 1;
            let [one, others] = part.split(self.tiling, next);
            self.strip(one);
            part = others;
        }
        self.strip(part);
    }

    fn side_by_side(&self, part: Part<'_>) {
        if part.strips.len() <= 1 {
            return self.strip(part);
        }
        let middle = part.strips.start + part.strips.len() / 2;
        let [left, right] = part.split(self.tiling, middle);
        rayon::join(|| self.side_by_side(left), || self.side_by_side(right));
    }

    fn strip(&self, part: Part<'_>) {
        let Part { strips, mut out, mut beyond, tallies, stretches, mut kept, levels, .. } = part;
        let windows = &mut *self.threads.windows(rayon::current_thread_index().unwrap_or(0));
        let numbers = self.tiling.tiles_of(strips);
        let first = self.tiling.beyond_of(numbers.clone()).start;
        let count = self.terms.count();
        for (number, i) in numbers.zip(0..) {
            let plan = &self.tiling.tiles()[number];
            let (own_kept, others_kept) =
                std::mem::take(&mut kept).split_at_mut_checked(plan.records()).unwrap_or_default();
            kept = others_kept;
            let level = i * levels + self.level;
            let tallies = &mut tallies[level * count..(level + 1) * count];
            let stretch = self.tile((number, own_kept), windows, &out, tallies);
            // Springs whose forces were kept have been looked at.
            if self.told != Told::AllWithKept {
                stretches[level] = stretch;
            }
            let place = plan.beyond.start - first..plan.beyond.end - first;
            for ((out, beyond), sums) in out.iter_mut().zip(&mut beyond).zip(&mut windows.sums).take(self.told.sums()) {
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

    /// Leaves in the windows what the terms add to the nodes of a tile, in every sum that is not empty. Tells its
    /// largest stretch, if that is looked for.
    fn tile(
        &self,
        (number, kept): (usize, &mut [Padded]),
        windows: &mut Windows,
        out: &[&mut [DVec3]; SUMS],
        tallies: &mut [Tally],
    ) -> f64 {
        let plan = &self.tiling.tiles()[number];
        let Windows { x, v, sums, .. } = windows;
        let (x, v) = (x.records(), v.records());
        if self.wants.x {
            self.load(plan, self.at.x, x);
        }
        if self.wants.v {
            self.load(plan, self.at.v, v);
        }
        let sums = sums.each_mut().map(Window::records);
        let n = plan.records();
        if self.told.goes_over(0) {
            rows(sums[0], n).fill(Padded::default());
        }
        let own = if plan.opens_strip { plan.own.clone() } else { 0..0 };
        let tile = Tile { number, own, t: self.at.t, x, v };
        let present = out.each_ref().map(|sum| !sum.is_empty());
        Sums { n, sums, present, kept }.add(self.terms, self.told, &tile, tallies);
        self.terms.largest_stretch(&tile, self.stretch)
    }

    /// Copies a nodal vector into a tile's window.
    fn load(&self, plan: &Plan, from: &[DVec3], to: &mut Records) {
        let first = self.first;
        let (own, others) = rows(to, plan.records()).split_at_mut(plan.own.len());
        copy_rows(&from[plan.own.start - first..plan.own.end - first], own);
        match plan.run {
            Some(run) => copy_rows(&from[run - first..][..others.len()], others),
            None => {
                for (to, &node) in others.iter_mut().zip(&self.tiling.beyond()[plan.beyond.clone()]) {
                    let from = from[node as usize - first];
                    *to = [from.x, from.y, from.z, 0.0];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
