//! Events: supports that are released and springs that are cut. Between two events a scene is in one phase.

use super::graph::Graph;
use super::network::{Network, SpringBatch};
use crate::model::spec::NetworkSpec;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The phases of a scene, in order; the first begins at t = 0.
#[derive(Debug)]
pub(super) struct Phases {
    /// [s] when each but the first begins, ascending
    times: Vec<f64>,
    all: Vec<Phase>,
    current: AtomicUsize,
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
    /// made when a scheme first asks for it
    pub graph: OnceLock<Graph>,
}

impl Phases {
    /// Those of a specification; `mass` [kg] and `user` numbers are by internal node. Groups without edges have no
    /// batch.
    pub fn new(spec: &NetworkSpec, mass: &[f64], user: &[u32]) -> Self {
        let times = spec.events();
        let mut all: Vec<Phase> = Vec::with_capacity(times.len() + 1);
        for begun in std::iter::once(0.0).chain(times.iter().copied()) {
            let mut of_user = spec.fixed.clone();
            spec.releases.iter().filter(|release| release.t <= begun).for_each(|release| release.apply(&mut of_user));
            let fixed: Vec<[bool; 3]> = user.iter().map(|&node| of_user[node as usize]).collect();
            let inverse = fixed.iter().zip(mass).flat_map(|(f, &m)| f.map(|f| if f { 0.0 } else { 1.0 / m }));
            let inverse_mass = inverse.collect();
            let released = all.first().map(|first| {
                let before = first.fixed.as_flattened().iter().zip(fixed.as_flattened()).filter(|(held, _)| **held);
                before.map(|(_, held)| !held).collect()
            });
            let groups = spec.springs.iter().enumerate().filter(|(_, group)| !group.edges.is_empty());
            let is_cut = |group: usize| spec.cuts.iter().any(|cut| cut.group == group && cut.t <= begun);
            let cut = if spec.cuts.is_empty() { Vec::new() } else { groups.map(|(group, _)| is_cut(group)).collect() };
            let (released, graph) = (released.unwrap_or_default(), OnceLock::new());
            all.push(Phase { fixed, inverse_mass, released, cut, graph });
        }
        Phases { times, all, current: AtomicUsize::new(0) }
    }

    /// [s] When each phase but the first begins.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The present one.
    pub fn current(&self) -> &Phase {
        &self.all[self.current.load(Ordering::Relaxed).min(self.all.len() - 1)]
    }
}

impl Network {
    pub(super) fn phase(&self) -> &Phase {
        self.phases.current()
    }

    /// Springs that carry force now.
    pub(super) fn carrying(&self) -> impl Iterator<Item = &SpringBatch> + Clone {
        self.springs.iter().filter(|batch| !batch.cut.get())
    }

    /// Begins the phase after `passed` events.
    pub(super) fn begin_phase(&self, passed: usize) {
        self.phases.current.store(passed.min(self.phases.times.len()), Ordering::Relaxed);
        let cut = &self.phase().cut;
        for (i, batch) in self.springs.iter().enumerate() {
            batch.cut.set(cut.get(i).copied().unwrap_or(false));
        }
    }
}
