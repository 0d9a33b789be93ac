//! Real runs of a scene from its start, as far as is affordable, against a reference: what a step or a tolerance delivers.
//!
//! What local errors come to is only known once they have added up (a phase that runs ahead, a motion that damps them), so it is measured. How
//! far runs go is decided by nominal costs alone, and what they need is counted: the same case gives the same errors on every machine.

use std::sync::atomic::{AtomicBool, Ordering};

use super::Candidate;
use super::timing::Clock;
use crate::case::spec::Problem;
use crate::drive::clock::Step;
use crate::drive::observer::{LedgerRow, ObserveError, Observer, Point, StepView};
use crate::drive::{self, Outcome, RunSpec, Status};
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::MethodChoice;
use crate::integrate::stepper::Stepper;
use crate::scene::Scene;
use crate::study::bench::{interval, nominal_step, reference_tolerance};
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
/// [-] Part of the run below which nothing is told from it.
const FEW: f64 = 0.03;
/// Frames at least, where the run is cut.
const FRAMES: f64 = 10.0;
/// Fastest growth of an error with time that is carried on beyond what was seen.
const GROWTH: f64 = 1.5;

/// A reference and what is needed to compare with it.
pub struct Yardstick<'a> {
    /// what moves
    pub scene: &'a dyn Scene,
    /// [s] end of the runs that are compared
    pub span: f64,
    /// [s] end of the run they stand for
    pub whole: f64,
    solver: SolverSpec,
    every: f64,
    reference: Frames,
    /// [m^2] squares of the motion, added up to each frame
    motion: Vec<f64>,
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
    /// Newton iterations
    pub newton_iterations: f64,
    /// [s] processor time it took; decides nothing
    pub seconds: f64,
}

impl<'a> Yardstick<'a> {
    /// Makes the reference for an accuracy; `None` where it is not affordable far enough, or nothing moves.
    pub fn of(scene: &'a dyn Scene, problem: &Problem, candidates: &[Candidate], accuracy: f64) -> Option<Self> {
        let Candidate { method, limit } = candidates.iter().find(|c| c.method.info.name == METHOD)?;
        let whole = problem.time.end;
        let frames = interval(problem, scene);
        let limit = limit.map_or(f64::INFINITY, |limit| limit.step);
        let cost = nominal_step(scene, method);
        let needed = SLOWER * whole / frames.min(limit) * cost;
        let span = whole * (REFERENCE / needed).min(1.0);
        let every = if span < whole { frames.min(span / FRAMES) } else { frames };
        let relative = (FINER * accuracy).clamp(TOLERANCES[0], TOLERANCES[1]);
        let mut yardstick = Yardstick {
            scene,
            span,
            whole,
            solver: problem.solver,
            every,
            reference: Frames::default(),
            motion: Vec::new(),
        };
        let stop = AtomicBool::new(false);
        let most = (2.0 * REFERENCE / cost) as u64;
        let mut keeper = Attendant::new(Sampler::keeping(scene, every), most, u64::MAX, &stop);
        let step = Step::Adaptive(reference_tolerance(scene, relative));
        let outcome = yardstick.drive(method, step, &mut keeper, &stop)?;
        if !matches!(outcome.status, Status::Completed | Status::Interrupted) || outcome.t_end < FEW * whole {
            return None;
        }
        // The last state is a frame, wherever the run was stopped.
        yardstick.span = outcome.t_end;
        yardstick.reference = keeper.sampler.into_frames();
        yardstick.add_up();
        (yardstick.reference.motion.squares > 0.0).then_some(yardstick)
    }

    /// [-] Part of the run that is compared.
    pub fn seen(&self) -> f64 {
        (self.span / self.whole).min(1.0)
    }

    /// Frames that are compared.
    pub fn frames(&self) -> u64 {
        self.reference.motion.frames
    }

    /// [s] Period of what moves most.
    pub fn period(&self) -> f64 {
        self.reference.motion.period()
    }

    /// Makes a run in at most `most` steps; `None` where it fails, or needs more.
    pub fn measure(&self, method: &MethodChoice, step: Step, most: u64) -> Option<Delivered> {
        let stop = AtomicBool::new(false);
        let comparing = Sampler::comparing(self.scene, self.every, &self.reference, (0.0, Distance::default()));
        let mut attendant = Attendant::new(comparing, most, self.reference.motion.frames / 2, &stop);
        let clock = Clock::default();
        let before = clock.seconds();
        let Outcome { status, counters: c, steps, .. } = self.drive(method, step, &mut attendant, &stop)?;
        let seconds = clock.seconds() - before;
        let [error, _] = attendant.sampler.distance().over(self.reference.motion)?;
        let work = [c.force_evaluations, c.tangent_assemblies, c.factorizations, c.linear_solves].map(|n| n as f64);
        let grown = self.grown(error, attendant.halfway);
        let (steps, newton_iterations) = (steps as f64, c.newton_iterations as f64);
        let made = Delivered { error: error * grown, steps, work, newton_iterations, seconds };
        (status == Status::Completed).then_some(made)
    }

    fn drive(
        &self,
        method: &MethodChoice,
        step: Step,
        observer: &mut Attendant<'_>,
        stop: &AtomicBool,
    ) -> Option<Outcome> {
        let mut stepper = Stepper::bind(method.scheme(self.solver), self.scene.abilities()).ok()?;
        let spec = RunSpec {
            end: self.span,
            step,
            frames_every: Some(self.every),
            keep_going: false,
            explain_doubts: false,
            method,
        };
        drive::run(self.scene, &mut stepper, spec, &mut [observer], stop).ok()
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
        for frame in self.reference.positions.chunks_exact(nodes.max(1)) {
            let square = |(a, b): (&[f64; 3], &[f64; 3])| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            sum += frame.iter().zip(&start).map(square).sum::<f64>();
            self.motion.push(sum);
        }
    }
}

/// Visits the frames, notes the distance half-way, and ends a run that takes too many steps.
struct Attendant<'a> {
    sampler: Sampler<'a>,
    most: u64,
    /// frames after which half the way is made
    half: u64,
    halfway: Distance,
    made: u64,
    stop: &'a AtomicBool,
}

impl<'a> Attendant<'a> {
    fn new(sampler: Sampler<'a>, most: u64, half: u64, stop: &'a AtomicBool) -> Self {
        Attendant { sampler, most, half, halfway: Distance::default(), made: 0, stop }
    }
}

impl Observer for Attendant<'_> {
    fn started(&mut self, at: &Point, ledger: LedgerRow) -> Result<(), ObserveError> {
        self.sampler.started(at, ledger)
    }

    fn accepted(&mut self, step: StepView<'_>) -> Result<(), ObserveError> {
        self.sampler.accepted(step)?;
        let distance = self.sampler.distance();
        if self.halfway.frames == 0 && distance.frames >= self.half {
            self.halfway = distance;
        }
        self.made += 1;
        if self.made >= self.most {
            self.stop.store(true, Ordering::Relaxed);
        }
        Ok(())
    }

    fn finished(&mut self, last: &Point) -> Result<(), ObserveError> {
        self.sampler.finished(last)
    }
}
