//! Every method tried along the way of one run.

use super::beginning::{Beginning, beginning};
use super::budget::Budget;
use super::cost::{ForceCost, TangentCost};
use super::estimate::{Basis, Estimate};
use super::sample::{Attempted, COLD, PATIENCE, Sample, SampleError, sample};
use super::states::{Probe, SampledStates};
use super::{Candidate, ForecastSpec, tolerance_of};
use crate::analysis::critical::{has_limit, plainly_stable};
use crate::drive::Snapshot;
use crate::drive::clock::{FixedSteps, Step};
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::{Family, MethodChoice};
use crate::integrate::stepper::Stepper;
use crate::scene::Scene;
use crate::study::bench::nominal_step;

/// [s] What a probe may take.
const PROBE: f64 = 0.3;
/// [-] part of the run that the first probe must come through, or another, with longer steps, is sent.
const FAR: f64 = 0.5;
/// States that a method is tried from.
const STATES: usize = 3;
/// [s] What a method may take from one state, with fixed steps and with adaptive ones.
const ALLOWANCE: [f64; 2] = [0.015, 0.03];
/// States for what adaptive steps leave of a run that was made from its start, and what a trial from one of them may
/// take [s].
const MANY: usize = 8;
const BEYOND: f64 = 0.012;
/// [s] What makes a probe dear: a single Newton iteration, or ten force passes; a method is tried from fewer states
/// long before that.
const COSTLY: f64 = 0.03;
/// [s] A single Newton iteration, or the setting up of its solver, that takes longer is tried with one method only.
const DEAR: f64 = 0.15;
/// Newton iterations and force passes a step where nothing is known: one iteration, and a look whether it was enough.
const UNTRIED: [f64; 2] = [2.0, 3.0];
/// Steps of a trial from one state, and times as many that a trial of adaptive steps makes.
const STEPS: f64 = 8.0;
const ADAPTIVE: f64 = 4.0;
/// [s] What an adaptive run may take from its start, and the part of it that must be seen to conclude on a rest that no
/// trial tells.
const BEGINNING: f64 = 0.4;
const PART: f64 = 0.1;
/// [s] A run with fixed steps that nominally takes less is made whole.
const WHOLE: f64 = 0.06;
/// [s] What a run may take from its start that has failed in a trial.
const FAILING: f64 = 0.1;
/// Steps that adaptive steps take at least: none is longer than a tenth of the run.
const FEWEST: f64 = 10.0;

/// The trials of a scene.
pub struct Trials<'a> {
    scene: &'a dyn Scene,
    solver: SolverSpec,
    end: f64,
    frames_every: Option<f64>,
    force: &'a ForceCost,
    tangent: Option<&'a TangentCost>,
    states: Vec<Snapshot>,
    /// for what is left of adaptive runs
    many: Vec<Snapshot>,
    /// [s]
    reached: f64,
    /// what dear implicit steps needed, by whether they were fixed
    learnt: [Option<Sample>; 2],
    budget: &'a Budget,
}

impl<'a> Trials<'a> {
    /// Sends probes ahead.
    pub fn along(spec: &ForecastSpec<'a>, force: &'a ForceCost, tangent: Option<&'a TangentCost>) -> Self {
        let ForecastSpec { scene, problem, accuracy, .. } = *spec;
        let end = problem.time.end;
        let (solver, tolerance) = (problem.solver, tolerance_of(accuracy));
        let follow = |name: &str| {
            let method = MethodChoice::with_defaults(name).ok()?;
            Some(SampledStates::follow(scene, Probe { method: &method, solver, end, tolerance, budget: PROBE }))
        };
        let mut way = follow("velocity-verlet").unwrap_or_default();
        let cheap = tangent.is_some_and(|t| t.measured && t.iteration_seconds().max(t.analysis_seconds) < COSTLY);
        if way.reached < FAR * end && cheap {
            way = follow("newmark").filter(|other| other.reached > way.reached).unwrap_or(way);
        }
        let dear = 100.0 * force.pass_seconds > COSTLY * 10.0;
        let [states, many] = [STATES, MANY].map(|count| way.states(if dear { 1 } else { count }));
        Trials {
            scene,
            solver,
            end,
            frames_every: problem.output.frames_every,
            force,
            tangent,
            states,
            many,
            reached: way.reached,
            learnt: [None; 2],
            budget: spec.budget,
        }
    }

    /// [-] Part of the run that the states cover.
    pub fn seen(&self) -> f64 {
        (self.reached / self.end).min(1.0)
    }

    /// Whether `solve` looks for a critical step before such a run.
    pub fn searches(&self, candidate: &Candidate, step: Step) -> bool {
        let plain = |h| plainly_stable(self.scene, self.scene.initial_state().as_ref(), &candidate.method, h).is_some();
        has_limit(&candidate.method) && !step.fixed().is_some_and(plain)
    }

    /// A whole run of a method, without output.
    ///
    /// # Errors
    /// Why there is none, in words.
    pub fn predict(&mut self, candidate: &Candidate, step: Step) -> Result<Estimate, String> {
        let steps = step.fixed().map(|h| FixedSteps::new(h, self.end).count());
        let implicit = candidate.method.info.family == Family::Implicit;
        if !implicit && !self.budget.affords(self.beyond(&candidate.method, steps.is_none(), self.states.len())) {
            return self.by_passes(&candidate.method, steps);
        }
        let dear = self.tangent.is_none_or(|t| !t.measured || t.iteration_seconds().max(t.analysis_seconds) > COSTLY);
        let affordable = !implicit || !dear;
        if let Some(estimate) =
            (steps.is_none() && affordable).then(|| self.as_it_begins(&candidate.method, step)).flatten()
        {
            return Ok(estimate);
        }
        let Some(tangent) = self.tangent.filter(|_| implicit) else {
            return self.by_steps(&candidate.method, step, self.states.len(), steps);
        };
        let iteration = tangent.iteration_seconds() + self.force.pass_seconds;
        let slot = usize::from(steps.is_some());
        let count = match iteration.max(tangent.analysis_seconds) {
            spent if spent > 0.4 * COSTLY => 1,
            spent if spent > 0.05 * COSTLY => 2,
            _ => self.states.len(),
        };
        let trial = self.beyond(&candidate.method, false, count);
        if !tangent.measured || self.learnt[slot].is_some() || !self.budget.affords(trial) {
            return self.by_counts(iteration, self.learnt[slot], steps);
        }
        let estimate = self.by_steps(&candidate.method, step, count, steps)?;
        if iteration.max(2.0 * tangent.analysis_seconds) > DEAR {
            self.learnt[slot] = Some(Sample {
                steps: estimate.steps,
                simulated: self.end,
                seconds: estimate.step_seconds * estimate.steps,
                work: estimate.work(),
            });
        }
        Ok(estimate)
    }

    /// Adaptive steps from the start, as far as they come, and from states beyond: their size is found on the way and
    /// differs from one part of the run to the next. Where only a small part was made and a trial of the rest fails,
    /// nothing is said here.
    fn as_it_begins(&self, method: &MethodChoice, step: Step) -> Option<Estimate> {
        let mut stepper = Stepper::bind(method.scheme(self.solver), self.scene.abilities()).ok()?;
        let tried = Attempted {
            method,
            solver: self.solver,
            step,
            end: self.end,
            frames_every: self.frames_every,
            allowance: BEGINNING,
        };
        let made = beginning(self.scene, &mut stepper, tried).ok()?;
        let short = made.sample.simulated < PART * self.end;
        let mut later = Vec::new();
        for sampled in self.many.iter().filter(|sampled| sampled.t > made.sample.simulated) {
            match sample(self.scene, &mut stepper, Attempted { allowance: BEYOND, ..tried }, sampled) {
                Ok(found) => later.push(found),
                Err(_) if short => return None,
                Err(_) => {}
            }
        }
        (!short || !later.is_empty()).then(|| Estimate::begun(&made, &later, self.end))
    }

    fn by_steps(
        &self,
        method: &MethodChoice,
        step: Step,
        count: usize,
        steps: Option<u64>,
    ) -> Result<Estimate, String> {
        let bound = Stepper::bind(method.scheme(self.solver), self.scene.abilities());
        let mut stepper = bound.map_err(|e| e.to_string())?;
        let allowance = ALLOWANCE[usize::from(steps.is_none())];
        let tried =
            Attempted { method, solver: self.solver, step, end: self.end, frames_every: self.frames_every, allowance };
        if let Some(steps) = steps
            && steps as f64 * nominal_step(self.scene, method) < WHOLE
        {
            let tried = Attempted { allowance: PATIENCE * WHOLE, ..tried };
            let Beginning { sample, .. } = beginning(self.scene, &mut stepper, tried).map_err(|e| e.to_string())?;
            if sample.steps >= steps as f64 {
                return Ok(Estimate::from_one(&sample, self.end, sample.steps));
            }
        }
        // Of fewer states those in the middle.
        let skip = (self.states.len() - count.min(self.states.len())) / 2;
        let mut samples = Vec::new();
        for sampled in self.states.iter().skip(skip).take(count) {
            let failed = |why| self.at_first(tried, why).to_string();
            samples.push(sample(self.scene, &mut stepper, tried, sampled).map_err(failed)?);
        }
        Estimate::of(&samples, self.end, steps).ok_or_else(|| "no state to try it from".to_owned())
    }

    /// What fails on the way mostly fails soon after its own start, which is when `solve` will tell it to.
    fn at_first(&self, tried: Attempted<'_>, why: SampleError) -> SampleError {
        let bound = Stepper::bind(tried.method.scheme(self.solver), self.scene.abilities());
        let (SampleError::OnTheWay { .. }, Ok(mut stepper)) = (&why, bound) else { return why };
        match beginning(self.scene, &mut stepper, Attempted { allowance: FAILING, ..tried }) {
            Err(own @ SampleError::Failed { .. }) => own,
            _ => why,
        }
    }

    /// [s] What trials of a method from so many states nominally take, where its steps are too dear for what trials are
    /// allowed.
    fn beyond(&self, method: &MethodChoice, adaptive: bool, states: usize) -> f64 {
        let [step, allowed] = [nominal_step(self.scene, method), ALLOWANCE[usize::from(adaptive)]];
        let times = if adaptive { ADAPTIVE } else { states.max(1) as f64 };
        if step < allowed / STEPS { 0.0 } else { times * step * (PATIENCE * allowed / step).clamp(COLD as f64, STEPS) }
    }

    /// An explicit run from its force passes.
    fn by_passes(&self, method: &MethodChoice, steps: Option<u64>) -> Result<Estimate, String> {
        let passes = f64::from(method.info.evaluations[usize::from(self.scene.velocity_dependent())]);
        if steps.is_none() {
            return Err("not tried: adaptive steps of a scene this large cost more than a forecast may".to_owned());
        }
        let (seconds, work) = (passes * self.force.pass_seconds, [passes, 0.0, 0.0, 0.0, 0.0]);
        let sample = Sample { steps: 1.0, simulated: 1.0, seconds, work };
        let made = Estimate::of(&[sample], self.end, steps).ok_or_else(|| "no state to try it from".to_owned())?;
        Ok(Estimate { basis: Basis::Counts, ..made })
    }

    /// From the iterations another method needed, or from two a step.
    fn by_counts(&self, iteration: f64, learnt: Option<Sample>, steps: Option<u64>) -> Result<Estimate, String> {
        let sample = match (learnt, steps) {
            (Some(sample), _) => sample,
            (None, Some(_)) => {
                let [iterations, passes] = UNTRIED;
                let seconds = iterations * iteration + (passes - iterations) * self.force.pass_seconds;
                let simulated = 1.0;
                Sample {
                    steps: 1.0,
                    simulated,
                    seconds,
                    work: [passes, iterations, iterations, iterations, iterations],
                }
            }
            (None, None) => {
                return Err(format!(
                    "not tried: one Newton iteration would take about {iteration:.1} s, the fewest steps that are allowed at least {:.0} s",
                    FEWEST * iteration
                ));
            }
        };
        let made = Estimate::of(&[sample], self.end, steps).ok_or_else(|| "no state to try it from".to_owned())?;
        Ok(Estimate { basis: Basis::Counts, ..made })
    }
}
