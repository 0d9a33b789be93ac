//! A force pass with what a scheme does to nodes just before and just after it, in one sweep through the nodes.
//!
//! The strips are done in rounds. A node is moved before the first round whose elements reach it, and the scheme goes
//! on with the nodes of a round's own strips as soon as their forces are complete. No later round of the pass reads
//! those nodes, since elements belong to the strip of their smallest node. So a large scene is read from memory once a
//! step. All sums are those of `Sweep::pass`, in the same order, but for the first of two passes, which adds all forces
//! to one sum.

use super::NodeState;
use super::room::Needs;
use super::stride::{Steps, Then};
use super::sweep::{Sweep, Terms};
use super::threads::{SUMS, Threads};
use crate::model::forces::Tally;
use crate::model::system::Around;
use crate::model::workers::Workers;
use bytemuck::cast_slice;
use glam::DVec3;
use std::ops::Range;

/// Where a pass is to find nodes, and what moves them there.
pub struct Moving<'a> {
    /// [s]
    pub t: f64,
    /// number of the first node
    pub first: usize,
    /// [m]
    pub x: &'a mut [f64],
    /// [m/s]
    pub v: &'a mut [f64],
    /// what comes before and after
    pub around: &'a dyn Around,
}

impl Moving<'_> {
    /// Moves some of the nodes.
    pub(super) fn before(&mut self, nodes: Range<usize>, workers: &Workers) {
        let Moving { first, x, v, around, .. } = self.within(nodes);
        workers.both((x, v), |r, x, v| around.before(3 * first + r.start..3 * first + r.end, x, v));
    }

    /// Of the nodes that are here.
    pub(super) fn state(&self) -> NodeState<'_> {
        NodeState { t: self.t, x: cast_slice(self.x), v: cast_slice(self.v) }
    }

    /// Some of the nodes.
    pub(super) fn within(&mut self, nodes: Range<usize>) -> Moving<'_> {
        let dofs = 3 * (nodes.start - self.first)..3 * (nodes.end - self.first);
        let (x, v) = (&mut self.x[dofs.clone()], &mut self.v[dofs]);
        Moving { t: self.t, first: nodes.start, x, v, around: self.around }
    }

    /// The nodes before one, and the others.
    pub(super) fn split(self, at: usize) -> [Self; 2] {
        let Moving { t, first, x, v, around } = self;
        let ((x, x_after), (v, v_after)) = (x.split_at_mut(3 * (at - first)), v.split_at_mut(3 * (at - first)));
        [Moving { t, first, x, v, around }, Moving { t, first: at, x: x_after, v: v_after, around }]
    }
}

impl Sweep {
    /// [`Sweep::pass`] at the state that `moving.around` makes before it. What comes after sees the first sum.
    pub fn pass_around<T: Terms + ?Sized>(
        &self,
        (terms, moving): (&T, Moving<'_>),
        threads: &Threads,
        out: [&mut [DVec3]; SUMS],
        tallies: &mut [Tally],
    ) {
        let mut room = self.room(Needs::of_a_step(terms.count(), 1, false), &out);
        self.steps((Steps { terms, then: Then::Done, threads }, moving), out, &mut room);
        room.add_up(0, tallies);
    }

    /// [`Sweep::pass_around`], then [`Sweep::pass`] at the velocities that it leaves. What the first sum's own terms
    /// give to the first is kept for the second, if they are [still](Terms::still).
    pub fn pass_twice<T: Terms + ?Sized>(
        &self,
        (terms, moving): (&T, Moving<'_>),
        threads: &Threads,
        out: [&mut [DVec3]; SUMS],
        tallies: &mut [Tally],
    ) {
        let keeps = terms.still();
        let mut room = self.room(Needs::of_a_step(terms.count(), 2, keeps), &out);
        self.steps((Steps { terms, then: Then::Again, threads }, moving), out, &mut room);
        room.add_up(if keeps { 0 } else { 1 }, tallies);
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::force::batch::{Records, Summand, Wants};
    use crate::force::edges::EdgeBatch;
    use crate::force::edges::links::{LinkData, Links};
    use crate::force::relative_dashpot::{RelativeDashpots, RelativeData};
    use crate::force::spring::{Coefficient, SpringData, Springs};
    use crate::force::tile::Tile;
    use crate::force::tiling::{Limits, Tiling};
    use crate::model::spec::Slack;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::{Arc, Mutex};

    pub const NODES: usize = 800;

    /// Dashpots to the node after the next 30 in the first sum, links to the next node in the first or in the last.
    pub struct Pairs {
        dashpots: RelativeDashpots,
        links: Links,
        sum_of_links: usize,
    }

    impl Terms for Pairs {
        fn count(&self) -> usize {
            2
        }

        fn term(&self, i: usize) -> (&dyn Summand, usize) {
            [(&self.dashpots as &dyn Summand, 0), (&self.links, self.sum_of_links)][i]
        }
    }

    pub fn terms(limits: Limits) -> (Pairs, Sweep) {
        terms_with(limits, 2)
    }

    pub fn terms_with(limits: Limits, sum_of_links: usize) -> (Pairs, Sweep) {
        let apart = |by: u32| (0..NODES as u32 - by).map(|i| [i, i + by]).collect();
        let data = RelativeData { nodes: apart(31), coefficient: Coefficient::Uniform(2.0) };
        let links = LinkData { nodes: apart(1), weight: 0.5 };
        let mut terms = Pairs { dashpots: EdgeBatch::new(data), links: EdgeBatch::new(links), sum_of_links };
        let tiling = Tiling::within(limits, NODES, &mut [&mut terms.dashpots, &mut terms.links]);
        (terms, Sweep::of(tiling))
    }

    /// Moves everything by a number of its own, then kicks velocities; remembers what it was called for.
    #[derive(Default)]
    struct Recorded {
        before: Mutex<Vec<usize>>,
        after: Mutex<Vec<usize>>,
    }

    impl Around for Recorded {
        fn before(&self, dofs: Range<usize>, x: &mut [f64], v: &mut [f64]) {
            assert_eq!((x.len(), v.len()), (dofs.len(), dofs.len()));
            for ((x, v), i) in x.iter_mut().zip(v).zip(dofs.clone()) {
                *x += (i as f64).sin();
                *v -= (i as f64).cos();
            }
            self.before.lock().expect("no panic").extend(dofs);
        }

        fn after(&self, dofs: Range<usize>, v: &mut [f64], f: &[f64]) {
            assert_eq!((f.len(), v.len()), (dofs.len(), dofs.len()));
            v.iter_mut().zip(f).for_each(|(v, f)| *v += 0.1 * f);
            self.after.lock().expect("no panic").extend(dofs);
        }
    }

    type Found = ([Vec<DVec3>; 3], [Tally; 2], Vec<f64>, Vec<f64>);

    #[derive(Clone, Copy)]
    enum Way {
        /// what comes before and after for all nodes at once, apart from the pass
        Apart,
        Around,
        /// a pass of its own after it, at the same positions
        AroundAndAgain,
        Twice,
    }

    /// Sums, tallies and state after a pass, or two.
    fn found<T: Terms>((terms, sweep): &(T, Sweep), threads: &Threads, way: Way) -> (Found, Recorded) {
        let start = |phase: f64| (0..3 * NODES).map(|i| (0.37 * i as f64 + phase).sin()).collect::<Vec<_>>();
        let (mut x, mut v, around) = (start(0.0), start(1.0), Recorded::default());
        let mut sums = [0; 3].map(|_| vec![DVec3::NAN; NODES]);
        sums[1].clear();
        let mut tallies = [Tally { energy: f64::NAN, power: f64::NAN }; 2];
        if let Way::Apart = way {
            around.before(0..3 * NODES, &mut x, &mut v);
        } else {
            let moving = Moving { t: 0.0, first: 0, x: &mut x, v: &mut v, around: &around };
            let out = sums.each_mut().map(Vec::as_mut_slice);
            match way {
                Way::Twice => sweep.pass_twice((terms, moving), threads, out, &mut tallies),
                _ => sweep.pass_around((terms, moving), threads, out, &mut tallies),
            }
        }
        if let Way::Apart | Way::AroundAndAgain = way {
            let at = NodeState { t: 0.0, x: cast_slice(&x), v: cast_slice(&v) };
            sweep.pass((terms, at), threads, sums.each_mut().map(Vec::as_mut_slice), &mut tallies);
        }
        if let Way::Apart = way {
            around.after(0..3 * NODES, &mut v, cast_slice(&sums[0]));
        }
        ((sums, tallies, x, v), around)
    }

    /// Several callers of one scene find what each finds alone, whichever pass they make, on threads of the pool and on
    /// others.
    #[test]
    fn callers_do_not_meet() {
        let scene = terms(Limits { strip: 16, records: 60 });
        let threads = Threads::new(2).expect("threads");
        let alone = [Way::Apart, Way::Around].map(|way| found(&scene, &Threads::one(), way).0);
        assert!(alone[0].0[0].iter().chain(&alone[0].0[2]).all(|f| f.is_finite()));
        let pass = |i: usize| {
            let found = found(&scene, &threads, [Way::Apart, Way::Around][i]).0;
            assert!(found == alone[i]);
        };
        std::thread::scope(|scope| {
            for i in 0..4 {
                scope.spawn(move || (0..300).for_each(|_| pass(usize::from(i > 0))));
            }
            (0..300).for_each(|i| pass(i % 2));
        });
    }

    /// Springs in the first sum, which count the tiles they are asked for, and dashpots in the last.
    pub struct Damped {
        springs: Counted,
        dashpots: RelativeDashpots,
        still: bool,
    }

    struct Counted(Springs, AtomicUsize);

    impl Summand for Counted {
        fn elements(&self) -> usize {
            self.0.elements()
        }

        fn wants(&self) -> Wants {
            self.0.wants()
        }

        fn element(&self, number: usize) -> Option<&[u32]> {
            self.0.element(number)
        }

        fn take(&mut self, tile: usize, elements: Range<usize>, place: &dyn Fn(u32) -> u16) {
            self.0.take(tile, elements, place);
        }

        fn add(&self, tile: &Tile<'_>, f: &mut Records) -> Tally {
            self.1.fetch_add(1, Ordering::Relaxed);
            self.0.add(tile, f)
        }
    }

    impl Terms for Damped {
        fn count(&self) -> usize {
            2
        }

        fn term(&self, i: usize) -> (&dyn Summand, usize) {
            [(&self.springs as &dyn Summand, 0), (&self.dashpots, 2)][i]
        }

        fn still(&self) -> bool {
            self.still
        }
    }

    pub fn damped(limits: Limits, still: bool) -> (Damped, Sweep) {
        let nodes: Arc<[[u32; 2]]> = (0..NODES as u32 - 31).map(|i| [i, i + 31]).collect();
        let data = SpringData {
            rest_length: vec![0.3; nodes.len()].into(),
            nodes: nodes.clone(),
            stiffness: Coefficient::Uniform(5.0),
            slack: Slack::None,
        };
        let springs = Counted(EdgeBatch::new(data), AtomicUsize::new(0));
        let dashpots = EdgeBatch::new(RelativeData { nodes, coefficient: Coefficient::Uniform(2.0) });
        let mut terms = Damped { springs, dashpots, still };
        let tiling = Tiling::within(limits, NODES, &mut [&mut terms.springs, &mut terms.dashpots]);
        (terms, Sweep::of(tiling))
    }

    /// The largest difference of two results, in terms of what is there.
    fn apart(a: &Found, b: &Found) -> f64 {
        let numbers = |(sums, tallies, x, v): &Found| {
            let sums = sums.iter().flat_map(|sum| cast_slice::<DVec3, f64>(sum).to_vec());
            let tallies = tallies.iter().flat_map(|tally| [tally.energy, tally.power]);
            sums.chain(tallies).chain(x.iter().chain(v).copied()).collect::<Vec<f64>>()
        };
        let off = |(a, b): (f64, f64)| (a - b).abs() / (1.0 + b.abs());
        numbers(a).into_iter().zip(numbers(b)).map(off).fold(0.0, f64::max)
    }

    /// Whatever the tiles and threads, the second of two passes at the same positions finds what one of its own does
    /// (in the first, forces are added in another order), and still terms are not asked again.
    #[test]
    fn a_second_pass_goes_over_what_velocities_change() {
        for (strip, records) in [(NODES, 900), (16, 300), (16, 60), (40, 50)] {
            for (threads, still) in [1, 2, 3].into_iter().flat_map(|n| [(n, true), (n, false)]) {
                let scene = damped(Limits { strip, records }, still);
                let threads = Threads::new(threads).expect("threads");
                let counted = |way: Way| {
                    scene.0.springs.1.store(0, Ordering::Relaxed);
                    let found = found(&scene, &threads, way).0;
                    assert!(found.0[0].iter().all(|f| f.is_finite()));
                    (found, scene.0.springs.1.load(Ordering::Relaxed))
                };
                let ((again, asked_apart), (twice, asked)) = (counted(Way::AroundAndAgain), counted(Way::Twice));
                let off = apart(&twice, &again);
                assert!(off < 1e-14, "strips of {strip}, {threads:?}, still: {still}: {off:e}");
                assert!(twice == found(&scene, &Threads::one(), Way::Twice).0, "strips of {strip}, {threads:?}");
                assert_eq!(asked * if still { 2 } else { 1 }, asked_apart);
                // Of the second pass itself every bit, so that a run can go on from where it ends.
                let (sums, tallies, x, v) = &twice;
                let at = NodeState { t: 0.0, x: cast_slice(x), v: cast_slice(v) };
                let (mut alone, mut told) = (sums.clone(), [Tally::default(); 2]);
                scene.1.pass((&scene.0, at), &threads, alone.each_mut().map(Vec::as_mut_slice), &mut told);
                assert!((&alone, &told) == (sums, tallies), "strips of {strip}, {threads:?}, still: {still}");
            }
        }
    }

    /// Whatever the tiles and threads, the bits are those of one thing after the other, and every degree of freedom has
    /// its turn once.
    #[test]
    fn the_way_through_changes_nothing() {
        for (strip, records) in [(NODES, 900), (16, 300), (16, 60), (40, 50)] {
            let scene = terms(Limits { strip, records });
            let (expected, _) = found(&scene, &Threads::one(), Way::Apart);
            for threads in [1, 2, 3] {
                let (found, calls) = found(&scene, &Threads::new(threads).expect("threads"), Way::Around);
                assert!(found == expected, "strips of {strip}, {threads} threads");
                for calls in [calls.before, calls.after] {
                    let mut calls = calls.into_inner().expect("no panic");
                    calls.sort_unstable();
                    assert!(calls.into_iter().eq(0..3 * NODES), "strips of {strip}, {threads} threads");
                }
            }
        }
    }
}
