//! The cost of a run with each method, from a few of its steps at states along one run.

use super::cost::{ForceCost, TangentCost};
use super::estimate::{Basis, Estimate};
use super::sample::{COLD, PATIENCE, Sample, SampleError, StartSample, sample, sample_start};
use super::states::SampledStates;
use super::work::Work;
use super::{Candidate, ForecastSpec, tolerance_of};
use crate::analysis::critical::{has_limit, plainly_stable};
use crate::analysis::taut::AllTaut;
use crate::drive::Snapshot;
use crate::drive::clock::{FixedSteps, Step};
use crate::experiment::Experiment;
use crate::integrate::registry::{Family, MethodChoice};
use crate::prepared_case::nominal_step;
use crate::scene::Scene;

/// [s] Time limit of a probe, the run from which states are sampled.
const PROBE: f64 = 0.3;
/// [-] If the first probe covers less than this part of the run, a second one with longer steps is made.
const FAR: f64 = 0.5;
/// Number of states from which a method is tried.
const STATES: usize = 3;
/// [s] Time limit of a trial from one state, with fixed steps and with adaptive ones.
const ALLOWANCE: [f64; 2] = [0.015, 0.03];
/// Number of states for the part of an adaptive run that was not made, and the time limit of a trial from one of them
/// [s].
const MANY: usize = 8;
const BEYOND: f64 = 0.012;
/// [s] A probe is expensive if a single Newton iteration, or ten force passes, take longer than this. Far below it, a
/// method is tried from fewer states already.
const COSTLY: f64 = 0.03;
/// [s] If a single Newton iteration, or setting up its solver, takes longer, only one implicit method is tried.
const DEAR: f64 = 0.15;
/// Newton iterations and force passes assumed per step of an implicit method that was not tried.
const UNTRIED: [f64; 2] = [2.0, 3.0];
/// Steps of a trial from one state, and times as many that a trial of adaptive steps makes.
const STEPS: f64 = 8.0;
const ADAPTIVE: f64 = 4.0;
/// [s] Time limit of an adaptive run from its start, and the smallest part of it from which the rest is concluded [-].
const FROM_START: f64 = 0.4;
const PART: f64 = 0.1;
/// [s] A run with fixed steps whose nominal cost is less is made to its end.
const WHOLE: f64 = 0.06;
/// [s] Time limit of a run from its start, made after a failed trial.
const FAILING: f64 = 0.1;
/// Steps that adaptive steps take at least: none is longer than a tenth of the run.
const FEWEST: f64 = 10.0;

/// The trials of a scene.
pub(super) struct Trials<'a> {
    spec: ForecastSpec<'a>,
    force: &'a ForceCost,
    tangent: Option<&'a TangentCost>,
    /// what methods are tried from
    states: Vec<Snapshot>,
    /// the same for what is left of adaptive runs
    many: Vec<Snapshot>,
    /// what dear implicit steps needed, by whether they were fixed
    learnt: [Option<Sample>; 2],
}

impl<'a> Trials<'a> {
    /// Samples states along runs that cost little a step.
    pub(super) fn along(spec: &ForecastSpec<'a>, force: &'a ForceCost, tangent: Option<&'a TangentCost>) -> Self {
        let end = spec.problem.time.end;
        let follow = |name: &str| {
            let method = MethodChoice::with_defaults(name).ok()?;
            let step = Step::Adaptive(tolerance_of(spec.accuracy.share()));
            let probe = Experiment::new(spec.scene, &method, spec.problem.solver, step, end);
            Some(SampledStates::follow(probe, PROBE))
        };
        let mut way = follow("velocity-verlet").unwrap_or_default();
        let cheap = tangent.is_some_and(|t| t.measured && t.iteration_seconds().max(t.analysis_seconds) < COSTLY);
        if way.reached < FAR * end && cheap {
            way = follow("newmark").filter(|other| other.reached > way.reached).unwrap_or(way);
        }
        let dear = 100.0 * force.pass_seconds > COSTLY * 10.0;
        let [states, many] = [STATES, MANY].map(|count| way.states(if dear { 1 } else { count }));
        Trials { spec: *spec, force, tangent, states, many, learnt: [None; 2] }
    }

    /// [s]
    fn end(&self) -> f64 {
        self.spec.problem.time.end
    }

    /// The case's run with another method and step.
    fn run<'m>(&self, method: &'m MethodChoice, step: Step) -> Experiment<'m>
    where
        'a: 'm,
    {
        let ForecastSpec { scene, problem, .. } = self.spec;
        let run = Experiment::new(scene, method, problem.solver, step, problem.time.end);
        Experiment { frames_every: problem.output.frames_every, ..run }
    }

    /// A whole run of a method, without output.
    ///
    /// # Errors
    /// Why there is none, in words.
    pub(super) fn predict(&mut self, Candidate { method, .. }: &Candidate, step: Step) -> Result<Estimate, String> {
        let steps = step.fixed().map(|h| FixedSteps::new(h, self.end()).count());
        let implicit = method.info.family == Family::Implicit;
        if !implicit && !self.spec.budget.affords(self.cost_of_dear(method, steps.is_none(), self.states.len())) {
            return self.by_passes(method, steps);
        }
        let dear = self.tangent.is_none_or(|t| !t.measured || t.iteration_seconds().max(t.analysis_seconds) > COSTLY);
        if steps.is_none()
            && !(implicit && dear)
            && let Some(estimate) = self.by_start(method, step)
        {
            return Ok(estimate);
        }
        let Some(tangent) = self.tangent.filter(|_| implicit) else {
            return self.by_steps(method, step, self.states.len());
        };
        let iteration = tangent.iteration_seconds() + self.force.pass_seconds;
        let slot = usize::from(steps.is_some());
        let count = match iteration.max(tangent.analysis_seconds) {
            spent if spent > 0.4 * COSTLY => 1,
            spent if spent > 0.05 * COSTLY => 2,
            _ => self.states.len(),
        };
        let trial = self.cost_of_dear(method, false, count);
        if !tangent.measured || self.learnt[slot].is_some() || !self.spec.budget.affords(trial) {
            return self.by_counts(iteration, self.learnt[slot], steps);
        }
        let estimate = self.by_steps(method, step, count)?;
        if iteration.max(2.0 * tangent.analysis_seconds) > DEAR {
            let seconds = estimate.step_seconds * estimate.steps;
            let sample = Sample { steps: estimate.steps, simulated: self.end(), seconds, work: estimate.work };
            self.learnt[slot] = Some(sample);
        }
        Ok(estimate)
    }

    /// Adaptive steps from the start until the time limit, and from states beyond: their size differs from one part of
    /// the run to the next. `None` if only a small part was made and a trial of the rest fails.
    fn by_start(&self, method: &MethodChoice, step: Step) -> Option<Estimate> {
        let run = self.run(method, step);
        let mut stepper = run.stepper().ok()?;
        let made = sample_start(run, &mut stepper, FROM_START).ok()?;
        let short = made.sample.simulated < PART * self.end();
        let mut later = Vec::new();
        for state in self.many.iter().filter(|state| state.t > made.sample.simulated) {
            match sample(run, &mut stepper, BEYOND, state) {
                Ok(found) => later.push(found),
                Err(_) if short => return None,
                Err(_) => {}
            }
        }
        (!short || !later.is_empty()).then(|| Estimate::begun(&made, &later, self.end()))
    }

    /// From steps at `count` of the states, or from the whole run where that is short.
    fn by_steps(&self, method: &MethodChoice, step: Step, count: usize) -> Result<Estimate, String> {
        let run = self.run(method, step);
        let mut stepper = run.stepper().map_err(|e| e.to_string())?;
        let steps = step.fixed().map(|h| FixedSteps::new(h, self.end()).count());
        if let Some(steps) = steps
            && steps as f64 * nominal_step(self.spec.scene, method) < WHOLE
        {
            let made = sample_start(run, &mut stepper, PATIENCE * WHOLE);
            let StartSample { sample, .. } = made.map_err(|e| e.to_string())?;
            if sample.steps >= steps as f64 {
                return Ok(Estimate::from_one(&sample, self.end(), sample.steps));
            }
        }
        let allowance = ALLOWANCE[usize::from(steps.is_none())];
        // Of fewer states those in the middle.
        let skip = (self.states.len() - count.min(self.states.len())) / 2;
        let samples = self
            .states
            .iter()
            .skip(skip)
            .take(count)
            .map(|state| sample(run, &mut stepper, allowance, state).map_err(|why| at_first(run, why).to_string()));
        self.estimate(&samples.collect::<Result<Vec<_>, _>>()?, steps)
    }

    fn estimate(&self, samples: &[Sample], steps: Option<u64>) -> Result<Estimate, String> {
        Estimate::of(samples, self.end(), steps).ok_or_else(|| "no state to try it from".to_owned())
    }

    /// [s] Nominal cost of the trials of a method from `states` states, if its steps are too expensive for the time
    /// limit of a trial; otherwise 0.
    fn cost_of_dear(&self, method: &MethodChoice, adaptive: bool, states: usize) -> f64 {
        let [step, allowed] = [nominal_step(self.spec.scene, method), ALLOWANCE[usize::from(adaptive)]];
        let times = if adaptive { ADAPTIVE } else { states.max(1) as f64 };
        if step < allowed / STEPS { 0.0 } else { times * step * (PATIENCE * allowed / step).clamp(COLD as f64, STEPS) }
    }

    /// An explicit run from its force passes.
    fn by_passes(&self, method: &MethodChoice, steps: Option<u64>) -> Result<Estimate, String> {
        let passes = f64::from(method.info.evaluations[usize::from(self.spec.scene.velocity_dependent())]);
        if steps.is_none() {
            return Err("not tried: adaptive steps of a scene this large cost more than a forecast may".to_owned());
        }
        let (seconds, work) = (passes * self.force.pass_seconds, Work::passes(passes));
        let made = self.estimate(&[Sample { steps: 1.0, simulated: 1.0, seconds, work }], steps)?;
        Ok(Estimate { basis: Basis::Counts, ..made })
    }

    /// From the iterations another method needed, or from two a step.
    fn by_counts(&self, iteration: f64, learnt: Option<Sample>, steps: Option<u64>) -> Result<Estimate, String> {
        let [iterations, passes] = UNTRIED;
        let untried = Sample {
            steps: 1.0,
            simulated: 1.0,
            seconds: iterations * iteration + (passes - iterations) * self.force.pass_seconds,
            work: Work { force_evaluations: passes, cg_iterations: 0.0, sweeps: 0.0, ..Work::each(|_| iterations) },
        };
        let sample = learnt.or(steps.map(|_| untried)).ok_or_else(|| {
            format!(
                "not tried: one Newton iteration would take about {iteration:.1} s, the fewest steps that are allowed at least {:.0} s",
                FEWEST * iteration
            )
        })?;
        Ok(Estimate { basis: Basis::Counts, ..self.estimate(&[sample], steps)? })
    }
}

/// Whether `solve` looks for a critical step before such a run.
pub fn searches(scene: &dyn Scene, candidate: &Candidate, step: Step) -> bool {
    let _all_taut = AllTaut::of(scene);
    let plain = |h| plainly_stable(scene, scene.initial_state().as_ref(), &candidate.method, h).is_some();
    has_limit(&candidate.method) && !step.fixed().is_some_and(plain)
}

/// A method that fails in a trial mostly fails soon after its own start too, where `solve` will fail: reports that
/// failure.
fn at_first(run: Experiment<'_>, why: SampleError) -> SampleError {
    let (SampleError::OnTheWay { .. }, Ok(mut stepper)) = (&why, run.stepper()) else { return why };
    match sample_start(run, &mut stepper, FAILING) {
        Err(own @ SampleError::Failed { .. }) => own,
        _ => why,
    }
}
