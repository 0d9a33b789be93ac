//! Central differences with several steps of stiff springs in one step of everything else: subcycling in finite-element
//! codes, r-RESPA in molecular dynamics (Tuckerman, Berne & Martyna 1992).
//!
//! ```text
//! f = g + s                                         s: forces of stiff springs, g: all others
//! v = v_n + H/2 M^-1 g_n                            all nodes
//! m times, at nodes of stiff springs, h = H/m:
//!     v += h/2 M^-1 s,   x += h v,   s = s(x, v),   v += h/2 M^-1 s
//! x_{n+1} = x_n + H v                               all other nodes
//! g_{n+1} = f(t_{n+1}, x_{n+1}, v) - s(x_{n+1}, v)
//! v_{n+1} = v + H/2 M^-1 g_{n+1}
//! ```
//! Both parts are made by [`central differences`](super::central_difference): order 2 for what depends on positions, 1
//! for what depends on velocities. Without stiff springs, or with m = 1, these are the steps of that scheme. One pass
//! over all forces a step, which has g and the forces for the ledger, and m passes over the stiff springs on their
//! nodes alone, with dashpots one more for g. Limit: m times that of central differences where springs set it, and the
//! limit of g. A step near half a period of a stiff spring may gain energy by resonance with forces in g on the same
//! nodes (Ma, Izaguirre & Skeel 2003).
//!
//! Where a program changes values, g and s are found again at the velocities that they had, which follow from those of
//! the end: v_{n+1} - H/2 M^-1 g_{n+1} and, for the last s of the short steps, h/2 M^-1 s less.

use super::central_difference::CENTRAL_DIFFERENCE;
use super::updates::{Product, add_product};
use super::{CarriedState, Counters, Integrator, LawChange, StageWork, StepError, StepInput, StepReport, reeling_work};
use crate::model::forces::Forces;
use crate::model::point::Point;
use crate::model::state::State;
use crate::model::step_block::{StepStart, StepSummary};
use crate::model::system::{KickDriftBlock, StiffPart, System, advance, longest_block};

/// The scheme; carries the forces of the stiff springs.
#[derive(Debug)]
pub struct Multirate {
    /// m
    substeps: u32,
    stiff: Option<StiffSprings>,
    /// degrees of freedom
    size: usize,
    /// [s] size of the last accepted step, 0 before the first, and of the last attempt
    last: f64,
    attempted: f64,
    /// [m/s] after a change of values, the velocities of g `[n_dof]`, and those of the last s; else empty
    velocities: [Vec<f64>; 2],
}

/// The stiff springs of a scene.
#[derive(Debug)]
struct StiffSprings {
    part: StiffPart,
    /// s at the last accepted state, at the velocities of the last short step
    lagging: Forces,
    /// s there at the velocities of g
    beside: Forces,
    /// the same at the end of the step attempted last
    next_beside: Forces,
    /// their nodes at both ends of a block of short steps; after the last, `at` is its end
    at: Point,
    next: Point,
    summaries: Vec<StepSummary>,
}

impl Multirate {
    /// With m short steps in a long one.
    pub fn new(substeps: u32) -> Self {
        Multirate { substeps, stiff: None, size: 0, last: 0.0, attempted: 0.0, velocities: Default::default() }
    }

    /// The vectors that it carries, those that there are.
    fn carried(&self) -> impl Iterator<Item = &Vec<f64>> {
        let forces = self.stiff.iter().flat_map(|StiffSprings { lagging, beside, .. }| [lagging, beside]);
        let vectors = forces.flat_map(|forces| [&forces.total, &forces.external, &forces.dissipative]);
        vectors.chain(&self.velocities).filter(|vector| !vector.is_empty())
    }

    fn carried_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        let Multirate { stiff, velocities, .. } = self;
        let forces = stiff.iter_mut().flat_map(|StiffSprings { lagging, beside, .. }| [lagging, beside]);
        let vectors = forces.flat_map(|Forces { total, external, dissipative, .. }| [total, external, dissipative]);
        vectors.chain(velocities).filter(|vector| !vector.is_empty())
    }
}

impl Integrator<dyn System> for Multirate {
    fn start(&mut self, system: &dyn System, at: &Point) -> Result<(), StepError> {
        let part = if self.substeps > 1 { system.stiff() } else { None };
        let part = part.and_then(|stiff| stiff.stiff_part(f64::from(self.substeps)));
        self.stiff = part.map(StiffSprings::of);
        self.stiff.iter_mut().for_each(|stiff| stiff.evaluate_at(&at.state));
        (self.last, self.size) = (0.0, at.state.v.len());
        self.velocities.iter_mut().for_each(Vec::clear);
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        let (inverse_mass, half) = (system.inverse_mass(), 0.5 * h);
        self.attempted = h;
        let long = (CENTRAL_DIFFERENCE.step)(h, true);
        let start = |dofs| StepStart::of(from, inverse_mass, dofs);
        to.state.t = t_next;
        system.workers().both(&mut to.state.x, &mut to.state.v, |dofs, x, v| long.begin(start(dofs), x, v));
        let mut made = StageWork::default();
        if let Some(stiff) = &mut self.stiff {
            stiff.begin(from, &to.state, half, inverse_mass);
            made = stiff.advance(self.substeps, t_next, counters);
            stiff.end(&mut to.state);
        }
        counters.evaluate(system, to.state.as_ref(), &mut to.forces);
        let Point { state: State { x, v, .. }, forces } = to;
        long.kick_again(start(0..v.len()), v, &forces.total);
        let Some(stiff) = &self.stiff else { return Ok(StepReport { forces_at_end: true, ..Default::default() }) };
        stiff.take_back(v, half, inverse_mass);
        let (way, times) = ([&from.state.x[..], x], [from.state.t, t_next]);
        let all = StageWork::by_ends(system, [&from.forces, forces], way, times);
        let of_stiff = stiff.work_by_ends(way, times);
        let work = StageWork {
            external: all.external - of_stiff.external + made.external,
            dissipated: all.dissipated - of_stiff.dissipated + made.dissipated,
        };
        Ok(StepReport { work: Some(work), forces_at_end: true, ..Default::default() })
    }

    fn accept(&mut self) {
        if let Some(StiffSprings { lagging, beside, next_beside, at, .. }) = &mut self.stiff {
            std::mem::swap(lagging, &mut at.forces);
            std::mem::swap(beside, next_beside);
        }
        self.last = self.attempted;
        self.velocities.iter_mut().for_each(Vec::clear);
    }

    fn restart(&mut self, _system: &dyn System, at: &Point) {
        self.stiff.iter_mut().for_each(|stiff| stiff.evaluate_at(&at.state));
    }

    fn keep_over_change(&mut self, system: &dyn System, at: &Point) -> bool {
        let [of_g, of_s] = &mut self.velocities;
        if of_g.is_empty() {
            let (inverse_mass, half) = (system.inverse_mass(), 0.5 * self.last);
            of_g.resize(at.state.v.len(), 0.0);
            add_product(of_g, &at.state.v, -half, Product { inverse_mass, f: &at.forces.total });
            if let Some(stiff) = &self.stiff {
                stiff.add_kick(of_g, half, inverse_mass);
                of_s.resize(stiff.part.dofs.len(), 0.0);
                stiff.velocities_of_last(of_g, of_s, half / f64::from(self.substeps), inverse_mass);
            }
        }
        true
    }

    fn force_velocities(&self) -> Option<&[f64]> {
        Some(&*self.velocities[0]).filter(|v| !v.is_empty())
    }

    fn laws_changed(&mut self, system: &dyn System, at: &Point, change: LawChange) -> Result<(), StepError> {
        if change != LawChange::Loads && self.stiff.is_some() {
            let [of_g, of_s] = &self.velocities;
            let part = system.stiff().and_then(|stiff| stiff.stiff_part(f64::from(self.substeps)));
            self.stiff = part.map(StiffSprings::of);
            self.stiff.iter_mut().for_each(|stiff| stiff.evaluate_with(&at.state, of_g, of_s));
        }
        Ok(())
    }

    fn knows_contact(&self) -> bool {
        false
    }

    fn lags(&self, system: &dyn System) -> bool {
        system.velocity_dependent()
    }

    fn save(&self) -> CarriedState {
        let mut saved = CarriedState::default();
        self.save_into(&mut saved);
        saved
    }

    fn save_into(&self, to: &mut CarriedState) {
        to.vectors.resize(self.carried().count(), Vec::new());
        to.vectors.iter_mut().zip(self.carried()).for_each(|(to, from)| to.clone_from(from));
        (to.made_with, to.relative) = (self.last, !self.velocities[0].is_empty());
    }

    fn restore(&mut self, saved: &CarriedState) -> Result<(), StepError> {
        let stiff = self.stiff.as_ref().map_or(0, |stiff| stiff.part.dofs.len());
        for (own, size) in self.velocities.iter_mut().zip([self.size, stiff]) {
            own.clear();
            own.resize(if saved.relative { size } else { 0 }, 0.0);
        }
        self.last = saved.made_with;
        let length = self.carried().next().map_or(0, Vec::len);
        if !self.carried().map(Vec::len).eq(saved.vectors.iter().map(Vec::len)) {
            return Err(StepError::Carried { found: saved.vectors.len(), expected: self.carried().count(), length });
        }
        self.carried_mut().zip(&saved.vectors).for_each(|(own, saved)| own.copy_from_slice(saved));
        Ok(())
    }
}

impl StiffSprings {
    fn of(part: StiffPart) -> Self {
        let at = Point { state: part.system.initial_state(), forces: part.system.new_forces() };
        let [lagging, beside, next_beside] = [(); 3].map(|()| at.forces.clone());
        StiffSprings { lagging, beside, next_beside, next: at.clone(), at, summaries: Vec::new(), part }
    }

    /// Finds the forces at a state of the scene, to be carried.
    fn evaluate_at(&mut self, state: &State) {
        let StiffSprings { part, lagging, beside, at: Point { state: own, .. }, .. } = self;
        own.t = state.t;
        part.gather(&state.x, &mut own.x);
        part.gather(&state.v, &mut own.v);
        part.system.evaluate(own.as_ref(), beside);
        lagging.copy_from(beside);
    }

    /// The same with the velocities of g, of all nodes, and those of the last s, of their own.
    fn evaluate_with(&mut self, state: &State, of_g: &[f64], of_s: &[f64]) {
        let StiffSprings { part, lagging, beside, at: Point { state: own, .. }, .. } = self;
        own.t = state.t;
        part.gather(&state.x, &mut own.x);
        part.gather(of_g, &mut own.v);
        part.system.evaluate(own.as_ref(), beside);
        own.v.copy_from_slice(of_s);
        part.system.evaluate(own.as_ref(), lagging);
    }

    /// v += half M^-1 s, with s as it is beside g.
    fn add_kick(&self, v: &mut [f64], half: f64, inverse_mass: &[f64]) {
        for (s, &dof) in self.beside.total.iter().zip(&self.part.dofs) {
            v[dof as usize] += half * (inverse_mass[dof as usize] * s);
        }
    }

    /// The velocities of the last s, from those of g.
    fn velocities_of_last(&self, of_g: &[f64], of_s: &mut [f64], half: f64, inverse_mass: &[f64]) {
        for ((v, s), &dof) in of_s.iter_mut().zip(&self.lagging.total).zip(&self.part.dofs) {
            *v = of_g[dof as usize] - half * (inverse_mass[dof as usize] * s);
        }
    }

    /// The start of the short steps: x_n, and the velocities of all nodes after the long kick without that of s.
    fn begin(&mut self, from: &Point, to: &State, half: f64, inverse_mass: &[f64]) {
        let StiffSprings { part, lagging, beside, at: Point { state: State { t, x, v }, forces }, .. } = self;
        *t = from.state.t;
        forces.copy_from(lagging);
        part.gather(&from.state.x, x);
        for ((v, s), &dof) in v.iter_mut().zip(&beside.total).zip(&part.dofs) {
            let dof = dof as usize;
            *v = to.v[dof] - half * (inverse_mass[dof] * s);
        }
    }

    /// Makes the short steps, in blocks as long as possible, and finds s at their end for g. Returns their works.
    fn advance(&mut self, substeps: u32, t_next: f64, counters: &mut Counters) -> StageWork {
        let StiffSprings { part: StiffPart { system, share, .. }, at, next, next_beside, summaries, .. } = self;
        let (begun, longest) = (at.state.t, longest_block(&**system) as u32);
        let time = |step: u32| begun + (t_next - begun) * (f64::from(step) / f64::from(substeps));
        let scheme = (CENTRAL_DIFFERENCE.step)((t_next - begun) / f64::from(substeps), true);
        let (mut made, mut work) = (0, StageWork::default());
        while made < substeps {
            let steps = (substeps - made).min(longest.max(1));
            summaries.resize(if longest < 2 { 0 } else { steps as usize }, StepSummary::default());
            for (summary, step) in summaries.iter_mut().zip(made + 1..) {
                summary.t = time(step);
            }
            made += steps;
            next.state.t = time(made);
            let block = KickDriftBlock { scheme, from: at };
            advance(&**system, &mut next.state, &mut next.forces, block, summaries);
            if summaries.is_empty() {
                let (forces, way) = ([&at.forces, &next.forces], [&at.state.x[..], &next.state.x]);
                work.add(1.0, StageWork::by_ends(&**system, forces, way, [at.state.t, next.state.t]));
            }
            let (mut t, mut tallies) = (at.state.t, &at.forces.tallies);
            for summary in summaries.iter() {
                let reeled = reeling_work(&**system, [t, summary.t], [tallies, &summary.tallies]);
                let works = &summary.nodes.work;
                work.add(1.0, StageWork { external: works.external + reeled, dissipated: -works.dissipative });
                (t, tallies) = (summary.t, &summary.tallies);
            }
            std::mem::swap(at, next);
        }
        let again = system.velocity_dependent();
        if again {
            system.evaluate(at.state.as_ref(), next_beside);
        } else {
            next_beside.copy_from(&at.forces);
        }
        counters.force_evaluations += (*share * f64::from(substeps + u32::from(again))).ceil() as u64;
        work
    }

    /// Gives the scene the nodes at the end of the short steps.
    fn end(&self, to: &mut State) {
        let StiffSprings { part, at: Point { state: State { x, v, .. }, .. }, .. } = self;
        for ((x, v), &dof) in x.iter().zip(v).zip(&part.dofs) {
            (to.x[dof as usize], to.v[dof as usize]) = (*x, *v);
        }
    }

    /// Takes s out of the last long kick.
    fn take_back(&self, v: &mut [f64], half: f64, inverse_mass: &[f64]) {
        for (s, &dof) in self.next_beside.total.iter().zip(&self.part.dofs) {
            let dof = dof as usize;
            v[dof] -= half * (inverse_mass[dof] * s);
        }
    }

    /// The works of s over the long step by its ends, which those of all forces by their ends contain.
    fn work_by_ends(&self, [x_n, x]: [&[f64]; 2], times: [f64; 2]) -> StageWork {
        let StiffSprings { part: StiffPart { dofs, system, .. }, beside, next_beside, .. } = self;
        let work = |[f_n, f]: [&[f64]; 2]| -> f64 {
            let forces = f_n.iter().zip(f).zip(dofs);
            forces.map(|((f_n, f), &dof)| 0.5 * (f_n + f) * (x[dof as usize] - x_n[dof as usize])).sum()
        };
        let reeled = reeling_work(&**system, times, [&beside.tallies, &next_beside.tallies]);
        StageWork {
            external: work([&beside.external, &next_beside.external]) + reeled,
            dissipated: -work([&beside.dissipative, &next_beside.dissipative]),
        }
    }
}
