//! Real runs of a scene from its start, as far as is affordable, against a reference: what a step or a tolerance
//! delivers.
//!
//! What local errors come to is only known once they have added up (a phase that runs ahead, a motion that damps them),
//! so it is measured. How far runs go is decided by nominal costs alone, and what they need is counted: the same case
//! gives the same errors on every machine.

use std::cell::Cell;

use super::sample;
use super::timing::Clock;
use super::units::Units;
use super::{Candidate, ForecastSpec};
use crate::case::spec::Problem;
use crate::drive::clock::Step;
use crate::drive::{Outcome, Status};
use crate::integrate::Counters;
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::MethodChoice;
use crate::scene::Scene;
use crate::study::bench::{interval, nominal_step, reference_tolerance};
use crate::study::experiment::{Event, Experiment, Flow, Start};
use crate::study::frames::{Distance, Frames, Sampler};

/// The scheme of the reference.
const METHOD: &str = "dop853";
/// [s] What the reference may cost, nominally.
const REFERENCE: f64 = 0.6;
/// Steps of an adaptive run over those at its limit.
const SLOWER: f64 = 1.5;
/// [-] Tolerance of the reference over the accuracy that is wanted, and its bounds.
const FINER: f64 = 3e-3;
const TOLERANCES: [f64; 2] = [1e-9, 1e-5];
/// [-] Part of the run below which nothing is concluded from it.
const FEW: f64 = 0.03;
/// Frames at least, where the run is cut.
const FRAMES: f64 = 10.0;
/// Fastest growth of an error with time that is carried on beyond what was seen.
const GROWTH: f64 = 1.5;

/// A reference and what is needed to compare with it.
pub struct CoarseReference<'a> {
    /// what moves
    pub scene: &'a dyn Scene,
    /// [s] end of the runs that are compared
    pub span: f64,
    /// [s] end of the run they stand for
    pub whole: f64,
    solver: SolverSpec,
    every: f64,
    frames: Frames,
    /// [m^2] squares of the motion, added up to each frame
    motion: Vec<f64>,
    /// [s] what its runs have taken, nominally
    spent: Cell<f64>,
}

/// What a run came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Delivered {
    /// [-] error at the end of the whole run, relative to the motion
    pub error: f64,
    /// accepted steps, of the part that was run
    pub steps: f64,
    /// [-] force passes, assemblies, factorisations and solves, of the part that was run
    pub work: [f64; 4],
    /// force passes that the run made for its account alone
    pub account_passes: f64,
    /// Newton iterations
    pub newton_iterations: f64,
    /// [s] processor time it took; decides nothing
    pub seconds: f64,
}

/// What a run may take, by counts.
#[derive(Clone, Copy, Debug)]
pub struct RunBudget {
    /// steps
    pub steps: u64,
    /// [s] work, nominally, in these units; none where a step always costs the same
    pub work: Option<(Units, f64)>,
}

impl RunBudget {
    /// So many steps.
    pub fn of(steps: u64) -> RunBudget {
        RunBudget { steps, work: None }
    }
}

impl<'a> CoarseReference<'a> {
    /// Makes the reference for an accuracy; `None` where it is not affordable far enough, or nothing moves.
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
        let mut reference = CoarseReference::blank(scene, problem, (span, every));
        let run_budget = RunBudget::of((2.0 * affordable / cost) as u64);
        let (status, _) = reference.keep(method, Step::Adaptive(reference_tolerance(scene, relative)), run_budget)?;
        budget.spend(reference.spent());
        let far = matches!(status, Status::Completed | Status::Interrupted) && reference.span >= FEW * whole;
        (far && reference.frames.motion.squares > 0.0).then_some(reference)
    }

    /// A run of any method to the end as a reference, and what it took; `None` where it does not come to the end, or
    /// nothing moves.
    pub fn by(
        scene: &'a dyn Scene,
        problem: &Problem,
        method: &MethodChoice,
        step: Step,
        budget: RunBudget,
    ) -> Option<(Self, Delivered)> {
        let whole = problem.time.end;
        let every = interval(problem, scene).max(whole / FRAMES);
        let mut reference = CoarseReference::blank(scene, problem, (whole, every));
        let (status, made) = reference.keep(method, step, budget)?;
        (status == Status::Completed && reference.frames.motion.squares > 0.0).then_some((reference, made))
    }

    fn blank(scene: &'a dyn Scene, problem: &Problem, (span, every): (f64, f64)) -> Self {
        let (whole, solver) = (problem.time.end, problem.solver);
        CoarseReference {
            scene,
            span,
            whole,
            solver,
            every,
            frames: Frames::default(),
            motion: Vec::new(),
            spent: Cell::new(0.0),
        }
    }

    /// Makes the reference.
    fn keep(&mut self, method: &MethodChoice, step: Step, budget: RunBudget) -> Option<(Status, Delivered)> {
        let clock = Clock::default();
        let before = clock.seconds();
        let mut sampler = Sampler::keeping(self.scene, self.every);
        let (outcome, _) = self.drive(method, step, &mut sampler, (budget, u64::MAX))?;
        let made = Delivered::of(&outcome, 0.0, clock.seconds() - before);
        // The last state is a frame, wherever the run was stopped.
        self.span = outcome.t_end;
        self.frames = sampler.into_frames();
        self.add_up();
        Some((outcome.status, made))
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

    /// Makes a run; `None` where it fails, or needs more than it may.
    pub fn measure(&self, method: &MethodChoice, step: Step, budget: RunBudget) -> Option<Delivered> {
        let mut sampler = Sampler::comparing(self.scene, self.every, &self.frames, (0.0, Distance::default()));
        let clock = Clock::default();
        let before = clock.seconds();
        let half = self.frames.motion.frames / 2;
        let (outcome, halfway) = self.drive(method, step, &mut sampler, (budget, half))?;
        let seconds = clock.seconds() - before;
        let [error, _] = sampler.distance().over(self.frames.motion)?;
        let made = Delivered::of(&outcome, error * self.grown(error, halfway), seconds);
        (outcome.status == Status::Completed).then_some(made)
    }

    /// Makes a run until its end or that of its budget. Returns also the distance once `half` frames were compared.
    fn drive(
        &self,
        method: &MethodChoice,
        step: Step,
        sampler: &mut Sampler<'_>,
        (budget, half): (RunBudget, u64),
    ) -> Option<(Outcome, Distance)> {
        let frames_every = Some(self.every);
        let experiment =
            Experiment { frames_every, ..Experiment::new(self.scene, method, self.solver, step, self.span) };
        let (mut made, mut halfway) = (0, Distance::default());
        let run = experiment.run(Start::Initial, Some(sampler), &mut |event, distance| match event {
            Event::Boundary(run) => {
                let cost = |units: Units| units.cost(run.step as f64, work(run.counters));
                Flow::stop_if(budget.work.is_some_and(|(units, most)| cost(units) > most))
            }
            Event::Step(_) => {
                if halfway.frames == 0 && distance.frames >= half {
                    halfway = distance;
                }
                made += 1;
                Flow::stop_if(made >= budget.steps)
            }
            _ => Flow::Continue,
        });
        let outcome = run.ok()?;
        self.spent.set(self.spent.get() + outcome.steps as f64 * nominal_step(self.scene, method));
        Some((outcome, halfway))
    }

    /// [s] What runs have taken since this was asked last, nominally.
    pub fn spent(&self) -> f64 {
        self.spent.take()
    }

    /// [-] How many times the error will be at the end what it is where runs are cut, as it has grown since the middle.
    fn grown(&self, error: f64, halfway: Distance) -> f64 {
        let (half, all) = (halfway.frames as usize, self.motion.len());
        let moved = half.checked_sub(1).and_then(|last| self.motion.get(last)).copied().unwrap_or(0.0);
        if self.span >= self.whole || half >= all || moved <= 0.0 {
            return 1.0;
        }
        let then = (halfway.squares / moved).sqrt();
        let power = (error / then).ln() / (all as f64 / half as f64).ln();
        let power = if power.is_finite() { power.clamp(0.0, GROWTH) } else { 1.0 };
        (self.whole / self.span).powf(power)
    }

    fn add_up(&mut self) {
        let nodes = self.scene.reference().len();
        let state = self.scene.initial_state();
        let (mut start, mut rates) = (vec![[0.0; 3]; nodes], vec![[0.0; 3]; nodes]);
        self.scene.trace(state.as_ref(), &mut start, &mut rates);
        let mut sum = 0.0;
        for frame in self.frames.positions.chunks_exact(nodes.max(1)) {
            let square = |(a, b): (&[f64; 3], &[f64; 3])| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            sum += frame.iter().zip(&start).map(square).sum::<f64>();
            self.motion.push(sum);
        }
    }
}

impl Delivered {
    fn of(outcome: &Outcome, error: f64, seconds: f64) -> Self {
        Delivered {
            error,
            steps: outcome.steps as f64,
            work: work(outcome.counters),
            account_passes: outcome.account_passes as f64,
            newton_iterations: outcome.counters.newton_iterations as f64,
            seconds,
        }
    }
}

/// In the order of [`Delivered::work`].
fn work(c: Counters) -> [f64; 4] {
    let [passes, assemblies, factorizations, solves, _] = sample::work(c).map(|n| n as f64);
    [passes, assemblies, factorizations, solves]
}
