//! Real runs of a scene from its start, as far as is affordable, against a reference: what error a step or a tolerance
//! makes.
//!
//! How local errors accumulate (as a phase error, or damped by the motion) cannot be predicted, so the error is
//! measured. The length of the runs is decided by nominal costs and their work is counted: the same case gives the same
//! errors on every machine.

use super::estimate::Estimate;
use super::nominal::{Budget, NominalCosts};
use super::sample::Sample;
use super::{Candidate, ForecastSpec};
use crate::drive::clock::Step;
use crate::drive::{Outcome, Status};
use crate::experiment::{Event, Experiment, Start};
use crate::frames::{Distance, Frames, Sampler};
use crate::integrate::registry::MethodChoice;
use crate::prepared_case::{interval, nominal_step, reference_tolerance};
use crate::process::Stopwatch;

/// The scheme of the reference.
const METHOD: &str = "dop853";
/// [s] Nominal cost limit of the reference.
const REFERENCE: f64 = 0.6;
/// [-] Number of steps of an adaptive run over the number at its stability limit.
const SLOWER: f64 = 1.5;
/// [-] Tolerance of the reference over the accuracy that is wanted, and its bounds.
const FINER: f64 = 3e-3;
const TOLERANCES: [f64; 2] = [1e-9, 1e-5];
/// [-] Smallest part of the run from which an error is concluded.
const FEW: f64 = 0.03;
/// Smallest number of frames of a shortened run.
const FRAMES: f64 = 10.0;
/// [-] Largest power of time with which an error is extrapolated beyond the part that was run.
const GROWTH: f64 = 1.5;

/// A reference and what is needed to compare with it.
pub struct CoarseReference<'a> {
    pub(super) spec: ForecastSpec<'a>,
    /// [s] end of the runs that are compared
    pub span: f64,
    /// [s] end of the run they stand for
    pub whole: f64,
    /// [s] interval of the frames
    every: f64,
    frames: Frames,
    /// budget that its runs are charged to; `None` if they are charged elsewhere
    budget: Option<&'a Budget>,
}

/// A run that was compared with a reference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeasuredRun {
    /// [-] error at the end of the whole run, relative to the motion
    pub error: f64,
    /// [-] force passes that the run made for its account alone
    pub account_passes: f64,
    /// the part that was run; its seconds decide nothing
    pub sample: Sample,
}

/// The limits of a run, as counted work.
#[derive(Clone, Copy, Debug)]
pub struct RunBudget {
    /// steps
    pub steps: u64,
    /// [s] work, nominally, at these costs; `None` where a step always costs the same
    pub work: Option<(NominalCosts, f64)>,
}

impl<'a> CoarseReference<'a> {
    /// Makes the reference for an accuracy; `None` if only a small part is affordable, or nothing moves.
    pub fn of(spec: &ForecastSpec<'a>) -> Option<Self> {
        let ForecastSpec { scene, problem, candidates, accuracy, budget, .. } = *spec;
        let affordable = REFERENCE.min(budget.left());
        let Candidate { method, limit } = candidates.iter().find(|c| c.method.info.name == METHOD)?;
        let whole = problem.time.end;
        let frames = interval(problem, scene);
        let limit = limit.map_or(f64::INFINITY, |limit| limit.step);
        let cost = nominal_step(scene, method);
        let needed = SLOWER * whole / frames.min(limit) * cost;
        let span = whole * (affordable / needed).min(1.0);
        if span < FEW * whole {
            return None;
        }
        let every = if span < whole { frames.min(span / FRAMES) } else { frames };
        let relative = (FINER * accuracy).clamp(TOLERANCES[0], TOLERANCES[1]);
        let blank =
            CoarseReference { spec: *spec, span, whole, every, frames: Frames::default(), budget: Some(budget) };
        let most = RunBudget { steps: (2.0 * affordable / cost) as u64, work: None };
        let (reference, _, status) =
            blank.made_by(method, Step::Adaptive(reference_tolerance(scene, relative)), most)?;
        let far = matches!(status, Status::Completed | Status::Interrupted) && reference.span >= FEW * whole;
        (far && reference.frames.motion.squares > 0.0).then_some(reference)
    }

    /// A complete run of any method as a reference, and its work; `None` if it does not reach the end, or nothing
    /// moves. Neither it nor the runs compared with it are charged to the budget of the forecast.
    pub fn by(
        spec: &ForecastSpec<'a>,
        method: &MethodChoice,
        step: Step,
        most: RunBudget,
    ) -> Option<(Self, MeasuredRun)> {
        let whole = spec.problem.time.end;
        let every = interval(spec.problem, spec.scene).max(whole / FRAMES);
        let blank = CoarseReference { spec: *spec, span: whole, whole, every, frames: Frames::default(), budget: None };
        let (reference, made, status) = blank.made_by(method, step, most)?;
        (status == Status::Completed && reference.frames.motion.squares > 0.0).then_some((reference, made))
    }

    fn made_by(self, method: &MethodChoice, step: Step, most: RunBudget) -> Option<(Self, MeasuredRun, Status)> {
        let mut sampler = Sampler::keeping(self.spec.scene, self.every);
        let (outcome, made, _) = self.run(method, step, &mut sampler, most, u64::MAX)?;
        // The last state is a frame, wherever the run was stopped.
        Some((CoarseReference { span: outcome.t_end, frames: sampler.into_frames(), ..self }, made, outcome.status))
    }

    /// [-] Part of the run that is compared.
    pub fn seen(&self) -> f64 {
        (self.span / self.whole).min(1.0)
    }

    /// Frames that are compared.
    pub fn frames_compared(&self) -> u64 {
        self.frames.motion.frames
    }

    /// [s] Period of what moves most.
    pub fn period(&self) -> f64 {
        self.frames.motion.period()
    }

    /// Makes a run and compares it with the reference; `None` if it fails or exceeds its limits.
    pub fn measure(&self, method: &MethodChoice, step: Step, most: RunBudget) -> Option<MeasuredRun> {
        let mut sampler = Sampler::comparing(self.spec.scene, self.every, &self.frames, 0.0, Distance::default());
        let half = self.frames.motion.frames / 2;
        let (outcome, made, halfway) = self.run(method, step, &mut sampler, most, half)?;
        let [error, _] = sampler.distance().over(self.frames.motion)?;
        let error = error * self.growth(error, halfway);
        (outcome.status == Status::Completed).then_some(MeasuredRun { error, ..made })
    }

    /// Makes a run until its end or that of its budget. Returns also the distance once `half` frames were compared.
    fn run(
        &self,
        method: &MethodChoice,
        step: Step,
        sampler: &mut Sampler<'_>,
        most: RunBudget,
        half: u64,
    ) -> Option<(Outcome, MeasuredRun, Distance)> {
        let ForecastSpec { scene, problem, .. } = self.spec;
        let frames_every = Some(self.every);
        let experiment = Experiment { frames_every, ..Experiment::new(scene, method, problem.solver, step, self.span) };
        let (mut made, mut halfway) = (0, Distance::default());
        let clock = Stopwatch::default();
        let before = clock.seconds();
        let run = experiment.run(Start::Initial, Some(sampler), &mut |event, distance| match event {
            Event::Boundary(run) => {
                let cost = |costs: NominalCosts| costs.cost(run.step as f64, run.counters.into());
                most.work.is_some_and(|(costs, most)| cost(costs) > most)
            }
            Event::Step(_) => {
                if halfway.frames == 0 && distance.frames >= half {
                    halfway = distance;
                }
                made += 1;
                made >= most.steps
            }
            _ => false,
        });
        let outcome = run.ok()?;
        let seconds = clock.seconds() - before;
        let steps = outcome.steps as f64;
        if let Some(budget) = self.budget {
            budget.spend(steps * nominal_step(scene, method));
        }
        let sample = Sample { steps, simulated: outcome.t_end, seconds, work: outcome.counters.into() };
        let made = MeasuredRun { error: 0.0, account_passes: outcome.account_passes as f64, sample };
        Some((outcome, made, halfway))
    }

    /// [-] Factor from the error at the end of the shortened run to that at the end of the case, extrapolated from its
    /// growth since the middle of the shortened run.
    fn growth(&self, error: f64, halfway: Distance) -> f64 {
        let (half, all) = (halfway.frames as usize, self.frames.motion.frames as usize);
        if self.span >= self.whole || half >= all {
            return 1.0;
        }
        let moved = self.moved(half);
        if moved <= 0.0 {
            return 1.0;
        }
        let then = (halfway.squares / moved).sqrt();
        let power = (error / then).ln() / (all as f64 / half as f64).ln();
        let power = if power.is_finite() { power.clamp(0.0, GROWTH) } else { 1.0 };
        (self.whole / self.span).powf(power)
    }

    /// [m^2] Squares of the distances from the start, summed over the nodes of the first `count` frames.
    fn moved(&self, count: usize) -> f64 {
        let scene = self.spec.scene;
        let nodes = scene.reference().len();
        let (mut start, mut velocities) = (vec![[0.0; 3]; nodes], vec![[0.0; 3]; nodes]);
        scene.trace(scene.initial_state().as_ref(), &mut start, &mut velocities);
        let square = |(a, b): (&[f64; 3], &[f64; 3])| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        let frames = self.frames.positions.chunks_exact(nodes.max(1)).take(count);
        frames.map(|frame| frame.iter().zip(&start).map(square).sum::<f64>()).sum()
    }
}

impl MeasuredRun {
    /// The run to `whole` [s] in so many steps, from the work and the time of the part that was made.
    pub fn whole_run(&self, whole: f64, steps: f64) -> Estimate {
        Estimate::from_one(&Sample { steps: self.sample.steps.max(1.0), ..self.sample }, whole, steps)
    }
}
