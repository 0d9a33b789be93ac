//! Central differences with several steps of stiff springs in one step of everything else: subcycling in finite-element
//! codes, r-RESPA in molecular dynamics (Tuckerman, Berne & Martyna 1992).
//!
//! ```text
//! f = g + s                                         s: forces of stiff springs, g: all others
//! v = v_n + H/2 M^-1 g_n                            all nodes
//! m times, at nodes of stiff springs, h = H/m:
//!     v += h/2 M^-1 s,   x += h v,   s = s(x, v),   v += h/2 M^-1 s
//! x_{n+1} = x_n + H v                               all other nodes
//! f_{n+1} = f(t_{n+1}, x_{n+1}, v*),   g_{n+1} = f_{n+1} - s        v*: before the last kick by s
//! v_{n+1} = v + H/2 M^-1 g_{n+1}
//! ```
//! Each part is made by [`central differences`](super::central_difference): order 2 for what depends on positions, 1
//! for what depends on velocities; without stiff springs, or with m = 1, these are the steps of that scheme. One pass
//! over all forces a step, which has g and the forces for the ledger, and m passes over the stiff springs, on their
//! nodes alone. Limit: m times that of central differences where springs set it, and the limit of g. A step near half
//! a period of a stiff spring may gain energy by resonance with g (Ma, Izaguirre & Skeel 2003).

use super::central_difference::CENTRAL_DIFFERENCE;
use super::euler_cromer::EULER_CROMER;
use super::kick_drift::KickDrift;
use super::{CarriedState, Counters, Integrator, StageWork, StepError, StepInput, StepReport};
use crate::model::forces::Forces;
use crate::model::point::Point;
use crate::model::state::State;
use crate::model::step_block::{KickDriftScheme, StepStart, StepSummary};
use crate::model::system::{KickDriftBlock, StiffPart, System};

/// The scheme; carries the forces of the stiff springs.
#[derive(Debug)]
pub struct Multirate {
    /// m
    substeps: u32,
    /// of the long steps and of the short ones
    scheme: KickDrift,
    stiff: Option<StiffSprings>,
}

/// The stiff springs of a scene.
#[derive(Debug)]
struct StiffSprings {
    part: StiffPart,
    /// s at the last accepted state, at the velocities v*
    carried: Forces,
    /// their nodes at both ends of a block of short steps; after the last, `at` is its end
    at: Point,
    next: Point,
    summaries: Vec<StepSummary>,
}

impl Multirate {
    /// With m short steps in a long one.
    pub fn new(substeps: u32) -> Self {
        Multirate { substeps, scheme: CENTRAL_DIFFERENCE, stiff: None }
    }

    /// The same with velocities at half steps: the step is then a map of the state alone, with the same eigenvalues.
    pub fn at_half_steps(substeps: u32) -> Self {
        Multirate { scheme: EULER_CROMER, ..Multirate::new(substeps) }
    }

    /// The vectors that it carries, those that the scene has.
    fn carried(&self) -> impl Iterator<Item = &Vec<f64>> {
        let forces = self.stiff.iter().map(|stiff| &stiff.carried);
        forces.flat_map(|forces| [&forces.total, &forces.dissipative]).filter(|vector| !vector.is_empty())
    }
}

impl Integrator<dyn System> for Multirate {
    fn start(&mut self, system: &dyn System, at: &Point) -> Result<(), StepError> {
        let part = if self.substeps > 1 { system.stiff_part(f64::from(self.substeps)) } else { None };
        self.stiff = part.map(StiffSprings::of);
        self.stiff.iter_mut().for_each(|stiff| stiff.evaluate_at(&at.state));
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        let inverse_mass = system.inverse_mass();
        let [long, short] = [h, h / f64::from(self.substeps)].map(|h| (self.scheme.step)(h, true));
        let start = |dofs| StepStart::of(from, inverse_mass, dofs);
        to.state.t = t_next;
        system.workers().both((&mut to.state.x, &mut to.state.v), |dofs, x, v| long.begin(start(dofs), x, v));
        let mut dissipated = 0.0;
        if let Some(stiff) = &mut self.stiff {
            stiff.begin((from, &to.state), long, inverse_mass);
            dissipated = stiff.advance(self.substeps, short, t_next, counters);
            stiff.end(&mut to.state, short, inverse_mass);
        }
        counters.evaluate(system, to.state.as_ref(), &mut to.forces);
        let Point { state: State { x, v, .. }, forces } = to;
        long.kick_again(start(0..v.len()), v, &forces.total);
        let Some(stiff) = &self.stiff else { return Ok(StepReport { forces_at_end: true, ..Default::default() }) };
        stiff.kick_again(v, [long, short], inverse_mass);
        let way = [&from.state.x[..], x];
        let work = |of: fn(&Forces) -> &[f64]| system.work([of(&from.forces), of(forces)], way);
        let reeling = |forces: &Forces| 0.5 * h * system.reeling_power([from.state.t, t_next], &forces.tallies);
        let work = StageWork {
            external: work(|f| &f.external) + reeling(&from.forces) + reeling(forces),
            dissipated: dissipated + stiff.work_by_ends(way) - work(|f| &f.dissipative),
        };
        Ok(StepReport { work: Some(work), forces_at_end: true, ..Default::default() })
    }

    fn accept(&mut self) {
        if let Some(StiffSprings { carried, at, .. }) = &mut self.stiff {
            std::mem::swap(carried, &mut at.forces);
        }
    }

    fn restart(&mut self, _system: &dyn System, at: &Point) {
        self.stiff.iter_mut().for_each(|stiff| stiff.evaluate_at(&at.state));
    }

    fn lags(&self, system: &dyn System) -> bool {
        system.velocity_dependent()
    }

    fn save(&self) -> CarriedState {
        CarriedState { vectors: self.carried().cloned().collect(), ..CarriedState::default() }
    }

    fn save_into(&self, to: &mut CarriedState) {
        to.vectors.resize(self.carried().count(), Vec::new());
        to.vectors.iter_mut().zip(self.carried()).for_each(|(to, from)| to.clone_from(from));
    }

    fn restore(&mut self, saved: &CarriedState) -> Result<(), StepError> {
        let Some(StiffSprings { carried: Forces { total, dissipative, .. }, .. }) = &mut self.stiff else {
            return saved.take_into(&mut []);
        };
        match dissipative.is_empty() {
            true => saved.take_into(&mut [total]),
            false => saved.take_into(&mut [total, dissipative]),
        }
    }
}

impl StiffSprings {
    fn of(part: StiffPart) -> Self {
        let at = Point { state: part.system.initial_state(), forces: part.system.new_forces() };
        StiffSprings { carried: at.forces.clone(), next: at.clone(), at, summaries: Vec::new(), part }
    }

    /// Finds the forces at a state of the scene, to be carried.
    fn evaluate_at(&mut self, state: &State) {
        let StiffSprings { part, carried, at: Point { state: own, .. }, .. } = self;
        own.t = state.t;
        part.gather(&state.x, &mut own.x);
        part.gather(&state.v, &mut own.v);
        part.system.evaluate(own.as_ref(), carried);
    }

    /// The start of the short steps: x_n, and the velocities of all nodes after the long kick without that of s.
    fn begin(&mut self, (from, to): (&Point, &State), long: KickDriftScheme, inverse_mass: &[f64]) {
        let StiffSprings { part, carried, at: Point { state: State { t, x, v }, forces }, .. } = self;
        *t = from.state.t;
        forces.copy_from(carried);
        part.gather(&from.state.x, x);
        for ((v, s), &dof) in v.iter_mut().zip(&carried.total).zip(&part.dofs) {
            let dof = dof as usize;
            *v = to.v[dof] - long.begin * (inverse_mass[dof] * s);
        }
    }

    /// Makes the short steps, in blocks as long as possible. Returns the energy [J] that the stiff springs take.
    fn advance(&mut self, substeps: u32, short: KickDriftScheme, t_next: f64, counters: &mut Counters) -> f64 {
        let StiffSprings { part: StiffPart { system, share, .. }, at, next, summaries, .. } = self;
        let (begun, longest) = (at.state.t, system.longest_block() as u32);
        let time = |step: u32| begun + (t_next - begun) * (f64::from(step) / f64::from(substeps));
        let (mut made, mut dissipated) = (0, 0.0);
        while made < substeps {
            let steps = (substeps - made).min(longest.max(1));
            summaries.resize(if longest < 2 { 0 } else { steps as usize }, StepSummary::default());
            for (summary, step) in summaries.iter_mut().zip(made + 1..) {
                summary.t = time(step);
            }
            made += steps;
            next.state.t = time(made);
            let block = KickDriftBlock { scheme: short, from: at };
            system.advance(&mut next.state, &mut next.forces, block, summaries);
            dissipated -= if summaries.is_empty() {
                system.work([&at.forces.dissipative, &next.forces.dissipative], [&at.state.x, &next.state.x])
            } else {
                summaries.iter().map(|summary| summary.nodes.work.dissipative).sum()
            };
            std::mem::swap(at, next);
        }
        counters.force_evaluations += (*share * f64::from(substeps)).ceil() as u64;
        dissipated
    }

    /// Gives the scene the nodes at the end of the short steps, with the velocities v*.
    fn end(&self, to: &mut State, short: KickDriftScheme, inverse_mass: &[f64]) {
        let StiffSprings { part, at: Point { state: State { x, v, .. }, forces }, .. } = self;
        let last = short.end.unwrap_or_default();
        for (((x, v), s), &dof) in x.iter().zip(v).zip(&forces.total).zip(&part.dofs) {
            let dof = dof as usize;
            to.x[dof] = *x;
            to.v[dof] = v - last * (inverse_mass[dof] * s);
        }
    }

    /// The last kicks, where all forces have made that of the long step: the short one by s.
    fn kick_again(&self, v: &mut [f64], [long, short]: [KickDriftScheme; 2], inverse_mass: &[f64]) {
        let less = short.end.unwrap_or_default() - long.end.unwrap_or_default();
        for (s, &dof) in self.at.forces.total.iter().zip(&self.part.dofs) {
            let dof = dof as usize;
            v[dof] += less * (inverse_mass[dof] * s);
        }
    }

    /// [J] Work of the dissipative part of s over the long step by its ends, 1/2 (s_n + s_{n+1}) . (x_{n+1} - x_n).
    fn work_by_ends(&self, [x_n, x]: [&[f64]; 2]) -> f64 {
        let forces = self.carried.dissipative.iter().zip(&self.at.forces.dissipative);
        let works = forces.zip(&self.part.dofs).map(|((s_n, s), &dof)| {
            let dof = dof as usize;
            0.5 * (s_n + s) * (x[dof] - x_n[dof])
        });
        works.sum()
    }
}
