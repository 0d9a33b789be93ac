//! Events: supports that are released, supports whose velocity changes ([`super::motion`]), and springs that are cut.
//! Supports and springs stay what they are through a phase, which may hold several changes of velocity.

use super::acting::SpringBatch;
use super::graph::Graph;
use super::motion::{Moved, Support};
use super::network::Network;
use super::numbering::Numbering;
use crate::model::abilities::Events;
use crate::model::spec::{MotionSpec, NetworkSpec, SpringGroup};
use crate::model::state::State;
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
    /// made when a scheme first asks for it
    pub graph: OnceLock<Graph>,
}

impl Default for Phases {
    /// A single phase of no nodes.
    fn default() -> Self {
        Phases::lasting(Vec::new(), &[], Vec::new())
    }
}

impl Phases {
    /// Those of a specification; `mass` [kg] is by internal node. Groups without edges have no batch.
    pub(super) fn new(spec: &NetworkSpec, mass: &[f64], numbering: &Numbering) -> Self {
        let (times, divisions) = (spec.events(), spec.divisions());
        let mut all: Vec<Phase> = Vec::with_capacity(divisions.len() + 1);
        let supports = Support::all(spec, numbering);
        for begun in std::iter::once(0.0).chain(divisions.iter().copied()) {
            let mut of_user = spec.fixed.clone();
            spec.releases.iter().filter(|release| release.t <= begun).for_each(|release| release.apply(&mut of_user));
            let fixed: Vec<[bool; 3]> = numbering.user.iter().map(|&node| of_user[node as usize]).collect();
            let inverse_mass = inverse_mass(&fixed, mass);
            let released = all.first().map(|first| {
                let before = first.fixed.as_flattened().iter().zip(fixed.as_flattened()).filter(|(held, _)| **held);
                before.map(|(_, held)| !held).collect()
            });
            let groups = spec.springs.iter().filter(|group| !group.edges.is_empty());
            let any_cut = spec.springs.iter().any(|group| group.cut.is_some());
            let is_cut = |group: &SpringGroup| group.cut.is_some_and(|t| t <= begun);
            let cut = if any_cut { groups.map(is_cut).collect() } else { Vec::new() };
            let (released, graph) = (released.unwrap_or_default(), OnceLock::new());
            let moved = Moved::new(&supports, &fixed, all.first().map_or(&fixed, |first| &first.fixed));
            all.push(Phase { fixed, inverse_mass, released, cut, moved, graph });
        }
        let begun = |t: &f64| divisions.partition_point(|division| division <= t);
        let phase = std::iter::once(0).chain(times.iter().map(begun)).collect();
        Phases { times, phase, all }
    }

    /// A single phase without events, of nodes of these masses [kg]; supports that are moved from outside hold `moved`.
    pub(super) fn lasting(fixed: Vec<[bool; 3]>, mass: &[f64], moved: Vec<u32>) -> Self {
        let phase = Phase {
            inverse_mass: inverse_mass(&fixed, mass),
            moved: Moved::from_outside(moved, &fixed),
            fixed,
            released: Vec::new(),
            cut: Vec::new(),
            graph: OnceLock::new(),
        };
        Phases { times: Vec::new(), phase: vec![0], all: vec![phase] }
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
}

/// [1/kg] of every degree of freedom, 0 where it is fixed.
fn inverse_mass(fixed: &[[bool; 3]], mass: &[f64]) -> Vec<f64> {
    fixed.iter().zip(mass).flat_map(|(f, &m)| f.map(|f| if f { 0.0 } else { 1.0 / m })).collect()
}

impl Network {
    pub(super) fn phase(&self) -> &Phase {
        self.built.phases.after(self.passed())
    }

    /// Number of events that this run has passed, at most all.
    pub(super) fn passed(&self) -> usize {
        self.passed.load(Ordering::Relaxed).min(self.built.phases.times.len())
    }

    /// Springs that carry force now.
    pub(super) fn carrying(&self) -> impl Iterator<Item = &SpringBatch> + Clone {
        self.acting.springs.iter().filter(|batch| !batch.cut.get())
    }

    /// Begins the phase after `passed` events. Returns whether it is another than before.
    pub(super) fn begin_phase(&self, passed: usize) -> bool {
        let phase_before = self.built.phases.phase[self.passed()];
        self.passed.store(passed, Ordering::Relaxed);
        let cut = &self.phase().cut;
        for (i, batch) in self.acting.springs.iter().enumerate() {
            batch.cut.set(cut.get(i).copied().unwrap_or(false));
        }
        phase_before != self.built.phases.phase[self.passed()]
    }
}

impl Events for Network {
    fn event_times(&self) -> &[f64] {
        self.built.phases.times()
    }

    fn corners(&self) -> Vec<f64> {
        self.built.corners.clone()
    }

    fn sample_tables(&self, h: Option<f64>) {
        self.acting.tables.iter().for_each(|table| table.sample(h));
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

    fn put_supports(&self, state: &mut State, share: f64) -> bool {
        self.put_moved(state, share)
    }
}
