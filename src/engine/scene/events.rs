//! Events: supports that are released, supports whose velocity changes ([`super::motion`]), and springs that are cut or
//! break. Supports stay what they are through a phase, which may hold several changes of velocity, and so do springs
//! but for those that break, of which there may be thousands.

use super::acting::SpringBatch;
use super::motion::{Moved, Support};
use super::network::Network;
use super::numbering::Numbering;
use crate::model::abilities::Events;
use crate::model::spec::{EventSpec, MotionSpec, NetworkSpec, ReleaseSpec, ascending};
use crate::model::state::{State, StateRef};
use crate::model::system::System;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::OnceLock;
use std::sync::atomic::Ordering;

/// The phases of a scene, in order; the first begins at t = 0.
#[derive(Debug)]
pub(super) struct Phases {
    /// [s] events, ascending
    times: Vec<f64>,
    /// number of the phase after each number of events
    phase: Vec<usize>,
    all: Vec<Phase>,
    /// [s] when each of `all` begins
    begun: Vec<f64>,
    /// what phases are made of, where events that wait for a state begin some
    source: Option<Source>,
    /// those, in the order in which runs first met them
    later: OnceLock<Box<Later>>,
}

/// A phase that an event began in some run of the scene.
#[derive(Debug)]
struct Later {
    /// the phase by time, and which of the events that divide have happened
    key: (usize, Vec<bool>),
    phase: Phase,
    next: OnceLock<Box<Later>>,
}

/// What phases are made of.
#[derive(Debug)]
struct Source {
    /// by the user's node
    fixed: Vec<[bool; 3]>,
    releases: Vec<ReleaseSpec>,
    /// [s] when each batch of springs is cut, and by which event
    cuts: Vec<(Option<f64>, Option<usize>)>,
    supports: Vec<Support>,
    /// [kg]
    mass: Vec<f64>,
    /// user's number of every node
    user: Vec<u32>,
    /// events that begin a phase, ascending
    dividing: Vec<usize>,
}

/// What holds between two events.
#[derive(Debug)]
pub(super) struct Phase {
    /// which of x, y, z is fixed, by internal node
    pub fixed: Vec<[bool; 3]>,
    /// [1/kg] by degree of freedom, 0 where it is fixed
    pub inverse_mass: Vec<f64>,
    /// which of the degrees of freedom that are fixed at t = 0 are free now; empty if none is
    pub released: Vec<bool>,
    /// which batches of springs are cut; empty if none is
    cut: Vec<bool>,
    /// supports that move at some time, and hold their nodes now
    pub moved: Moved,
}

impl Default for Phases {
    /// A single phase of no nodes.
    fn default() -> Self {
        Phases::lasting(Vec::new(), &[], Vec::new())
    }
}

impl Phases {
    /// Those of a specification; `mass` [kg] is by internal node. Groups without edges have no batch.
    pub(super) fn new(spec: &NetworkSpec, mass: &[f64], numbering: &Numbering, springs: &[SpringBatch]) -> Self {
        let (times, divisions) = (spec.events(), spec.divisions());
        let mut dividing: Vec<usize> = springs.iter().filter_map(|batch| batch.cut_by).collect();
        dividing.extend(spec.releases.iter().filter_map(|release| release.event));
        dividing.sort_unstable();
        dividing.dedup();
        let source = Source {
            fixed: spec.fixed.clone(),
            releases: spec.releases.clone(),
            cuts: springs.iter().map(|batch| (batch.cut_at, batch.cut_by)).collect(),
            supports: Support::all(spec, numbering),
            mass: mass.to_vec(),
            user: numbering.user.clone(),
            dividing,
        };
        let mut all: Vec<Phase> = Vec::with_capacity(divisions.len() + 1);
        let begun: Vec<f64> = std::iter::once(0.0).chain(divisions.iter().copied()).collect();
        for &begun in &begun {
            all.push(source.phase(begun, &|_| false, all.first()));
        }
        let passed = |t: &f64| divisions.partition_point(|division| division <= t);
        let phase = std::iter::once(0).chain(times.iter().map(passed)).collect();
        let source = (!source.dividing.is_empty()).then_some(source);
        Phases { times, phase, all, begun, source, later: OnceLock::new() }
    }

    /// A single phase without events, of nodes of these masses [kg]; supports that are moved from outside hold `moved`.
    pub(super) fn lasting(fixed: Vec<[bool; 3]>, mass: &[f64], moved: Vec<u32>) -> Self {
        let phase = Phase {
            inverse_mass: inverse_mass(&fixed, mass),
            moved: Moved::from_outside(moved, &fixed),
            fixed,
            released: Vec::new(),
            cut: Vec::new(),
        };
        let (phase, all, begun) = (vec![0], vec![phase], vec![0.0]);
        Phases { times: Vec::new(), phase, all, begun, source: None, later: OnceLock::new() }
    }

    /// [s] The events.
    pub(super) fn times(&self) -> &[f64] {
        &self.times
    }

    /// [s] The events that begin another phase.
    pub(super) fn divisions(&self) -> impl Iterator<Item = f64> {
        let pairs = self.times.iter().zip(self.phase.windows(2));
        pairs.filter(|(_, phases)| phases[0] != phases[1]).map(|(t, _)| *t)
    }

    /// [s] Beginnings and ends of the changes of supports, and of springs that are cut.
    pub(super) fn changing<'a>(&'a self, motions: &'a [MotionSpec]) -> impl Iterator<Item = [f64; 2]> + 'a {
        let moved = motions.iter().flat_map(|motion| motion.displacement.changing());
        moved.chain(self.divisions().map(|t| [t, t]))
    }

    /// Whether supports move at some time.
    pub(super) fn move_supports(&self) -> bool {
        self.all.iter().any(|phase| !phase.moved.dofs.is_empty())
    }

    /// [s] The last of so many events that are passed, and the next; infinite where there is none.
    pub(super) fn around(&self, passed: usize) -> [f64; 2] {
        let before = passed.checked_sub(1).and_then(|last| self.times.get(last));
        [before.map_or(f64::NEG_INFINITY, |t| *t), self.times.get(passed).map_or(f64::INFINITY, |t| *t)]
    }

    /// That after so many events, at most all.
    pub(super) fn after(&self, passed: usize) -> &Phase {
        &self.all[self.phase[passed]]
    }

    /// The phase that events began, by its number, counted from 1.
    fn begun_by_event(&self, number: usize) -> Option<&Phase> {
        let all = std::iter::successors(self.later.get(), |later| later.next.get());
        all.zip(1..).find(|(_, i)| *i == number).map(|(later, _)| &later.phase)
    }

    /// The number of the phase after so many events by time, where some of the others have happened; 0 for one that no
    /// event began. It is made where no run has met it before.
    fn number_of(&self, passed: usize, happened: &dyn Fn(usize) -> bool) -> usize {
        let Some(source) = &self.source else { return 0 };
        let by_time = self.phase[passed];
        let key = (by_time, source.dividing.iter().map(|event| happened(*event)).collect::<Vec<bool>>());
        if !key.1.contains(&true) {
            return 0;
        }
        let (mut place, mut number) = (&self.later, 1);
        loop {
            let found = place.get_or_init(|| {
                let phase = source.phase(self.begun[by_time], happened, self.all.first());
                Box::new(Later { key: key.clone(), phase, next: OnceLock::new() })
            });
            if found.key == key {
                return number;
            }
            (place, number) = (&found.next, number + 1);
        }
    }
}

impl Source {
    /// The phase that began at a time [s], after the events that have happened; `first` is that at the start.
    fn phase(&self, begun: f64, happened: &dyn Fn(usize) -> bool, first: Option<&Phase>) -> Phase {
        let mut of_user = self.fixed.clone();
        let over = |release: &&ReleaseSpec| release.event.map_or(release.t <= begun, happened);
        self.releases.iter().filter(over).for_each(|release| release.apply(&mut of_user));
        let fixed: Vec<[bool; 3]> = self.user.iter().map(|&node| of_user[node as usize]).collect();
        let inverse_mass = inverse_mass(&fixed, &self.mass);
        let released = first.map(|first| {
            let before = first.fixed.as_flattened().iter().zip(fixed.as_flattened()).filter(|(held, _)| **held);
            before.map(|(_, held)| !held).collect()
        });
        let any_cut = self.cuts.iter().any(|(at, by)| at.is_some() || by.is_some());
        let is_cut =
            |(at, by): &(Option<f64>, Option<usize>)| at.is_some_and(|t| t <= begun) || by.is_some_and(happened);
        let cut = if any_cut { self.cuts.iter().map(is_cut).collect() } else { Vec::new() };
        let moved = Moved::new(&self.supports, &fixed, first.map_or(&fixed, |first| &first.fixed));
        Phase { fixed, inverse_mass, released: released.unwrap_or_default(), cut, moved }
    }
}

/// [1/kg] of every degree of freedom, 0 where it is fixed.
fn inverse_mass(fixed: &[[bool; 3]], mass: &[f64]) -> Vec<f64> {
    fixed.iter().zip(mass).flat_map(|(f, &m)| f.map(|f| if f { 0.0 } else { 1.0 / m })).collect()
}

impl Network {
    pub(super) fn phase(&self) -> &Phase {
        let phases = &self.built.phases;
        let by_event = match self.later.load(Ordering::Relaxed) {
            0 => None,
            number => phases.begun_by_event(number),
        };
        by_event.unwrap_or_else(|| phases.after(self.passed()))
    }

    /// Numbers of the phase by time, and of that by events.
    fn phase_number(&self) -> [usize; 2] {
        [self.built.phases.phase[self.passed()], self.later.load(Ordering::Relaxed)]
    }

    /// Number of events that this run has passed, at most all.
    pub(super) fn passed(&self) -> usize {
        self.passed.load(Ordering::Relaxed).min(self.built.phases.times.len())
    }

    /// Springs that carry force now.
    pub(super) fn carrying(&self) -> impl Iterator<Item = Cow<'_, SpringBatch>> {
        self.acting.springs.iter().filter(|batch| !batch.cut.all()).map(|batch| batch.left())
    }

    /// Begins the phase after `passed` events, and breaks the springs whose events have happened. Returns whether
    /// springs or supports are others than before.
    pub(super) fn begin_phase(&self, passed: usize) -> bool {
        let before = self.phase_number();
        self.passed.store(passed, Ordering::Relaxed);
        let happened = |event: usize| self.acting.event_times.of(event)[0].is_finite();
        self.later.store(self.built.phases.number_of(self.passed(), &happened), Ordering::Relaxed);
        let (cut, mut others) = (&self.phase().cut, false);
        for (i, batch) in self.acting.springs.iter().enumerate() {
            others |= batch.cut.set_all(cut.get(i).copied().unwrap_or(false));
            others |= batch.cut.set_broken(batch.breaks.iter().map(|of| happened(of.event)));
        }
        if others {
            self.graph.forget();
        }
        others || before != self.phase_number()
    }
}

impl Events for Network {
    fn event_times(&self) -> &[f64] {
        self.built.phases.times()
    }

    fn corners(&self) -> Vec<f64> {
        let mut started: Vec<f64> = self.acting.stages.iter().flat_map(|stages| stages.changes()).flatten().collect();
        started.extend(self.acting.stream.iter().flat_map(|stream| stream.corners_begun()));
        if started.is_empty() {
            return self.built.corners.clone();
        }
        ascending(self.built.corners.iter().copied().chain(started).collect())
    }

    fn sample_tables(&self, h: Option<f64>) {
        self.acting.tables.iter().for_each(|table| table.sample(h));
        self.touches().into_iter().for_each(|touches| touches.set_step(h));
    }

    fn pass_events(&self, passed: usize) -> bool {
        self.begin_phase(passed)
    }

    fn changes(&self) -> Vec<f64> {
        let shortest = self.acting.springs.iter().filter_map(|batch| batch.data.rest_scale.as_ref()?.lowest_at());
        let mut times: Vec<f64> = self.built.phases.divisions().chain(shortest.filter(|t| *t > 0.0)).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        times
    }

    fn settled_after(&self, end: f64) -> f64 {
        let begun = self.built.changing.iter().filter(|[from, _]| *from < end);
        begun.fold(0.0, |last: f64, [_, until]| last.max(until.min(end)))
    }

    fn named(&self) -> &[EventSpec] {
        &self.built.triggers.events
    }

    fn margin(&self, event: usize, at: StateRef<'_>) -> f64 {
        self.margin_of(event, at)
    }

    fn breaks(&self) -> Range<usize> {
        self.built.triggers.breaks.clone()
    }

    fn break_margin(&self, at: StateRef<'_>) -> f64 {
        self.acting.springs.iter().map(|batch| batch.break_margin(at)).fold(f64::INFINITY, f64::min)
    }

    fn place_of(&self, event: usize, at: StateRef<'_>) -> [[f64; 3]; 2] {
        self.place_of_event(event, at)
    }

    fn wind_at(&self, t: f64, z: f64) -> [f64; 3] {
        self.acting.stream.as_ref().map_or([0.0; 3], |stream| stream.at(t, z).wind[0].into())
    }

    fn corners_after(&self, event: usize) -> Vec<f64> {
        self.acting.stream.as_ref().map_or_else(Vec::new, |stream| stream.corners_after(event).collect())
    }

    fn set_happened(&self, happened: &[[f64; 2]]) -> bool {
        let of = &self.acting.event_times;
        (0..of.count()).for_each(|event| of.set(event, happened.get(event).copied().unwrap_or([f64::INFINITY, 0.0])));
        self.acting.stream.iter().for_each(|stream| stream.set_happened(|event| of.of(event)[0]));
        self.begin_phase(self.passed())
    }

    fn put_supports(&self, state: &mut State, share: f64) -> bool {
        self.put_moved(state, share)
    }
}
