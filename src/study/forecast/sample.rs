//! A few real steps of a method from a state on the way: what they cost, how far they go.

use super::timing::Clock;
use crate::drive::clock::{FixedSteps, Step};
use crate::drive::ledger::Ledger;
use crate::drive::watch::Watch;
use crate::drive::{RunError, Snapshot, Status};
use crate::integrate::Counters;
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::MethodChoice;
use crate::integrate::stepper::Stepper;
use crate::model::point::Point;
use crate::model::state::State;
use crate::scene::Scene;
use crate::study::experiment::{Event, Experiment, Flow, Start};

/// [-] A step this many times the one before is not yet the size the tolerance allows.
const GROWING: f64 = 1.4;
/// How many times its allowance a trial may take for steps that still grow.
pub(super) const PATIENCE: f64 = 3.0;
/// Steps that a trial makes even beyond its allowance, unless they are so dear that its patience ends.
const LEAST: u64 = 6;
/// Steps that are made one by one, however dear: their memory is touched for the first time.
pub(super) const COLD: u64 = 2;

/// What is tried.
#[derive(Clone, Copy, Debug)]
pub struct Attempted<'a> {
    /// the method
    pub method: &'a MethodChoice,
    /// how implicit steps are solved
    pub solver: SolverSpec,
    /// its steps
    pub step: Step,
    /// [s] end of the run it stands for
    pub end: f64,
    /// [s] interval of the frames, where adaptive steps of some schemes end
    pub frames_every: Option<f64>,
    /// [s] processor time it may take, from one state
    pub allowance: f64,
}

impl<'a> Attempted<'a> {
    /// Its run, every step made singly.
    pub(super) fn experiment(self, scene: &'a dyn Scene) -> Experiment<'a> {
        let Attempted { method, solver, step, end, frames_every, .. } = self;
        Experiment { frames_every, ..Experiment::new(scene, method, solver, step, end) }
    }
}

/// Counted work in the order of [`Sample::work`].
pub(super) fn work(c: Counters) -> [u64; 5] {
    [c.force_evaluations, c.tangent_assemblies, c.factorizations, c.linear_solves, c.newton_iterations]
}

/// What some steps cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// accepted steps
    pub steps: f64,
    /// [s] simulated time
    pub simulated: f64,
    /// [s] processor time
    pub seconds: f64,
    /// [-] force passes, tangents, factorisations, solves, Newton iterations
    pub work: [f64; 5],
}

impl Sample {
    /// [1/s] Steps a second simulated.
    pub fn pace(&self) -> f64 {
        self.steps / self.simulated
    }
}

/// Why there is no sample.
#[derive(Debug, thiserror::Error)]
pub enum SampleError {
    /// The method cannot run here.
    #[error(transparent)]
    Run(#[from] RunError),
    /// Its own run from the start failed.
    #[error("fails at t = {time:.3e} s: {cause}")]
    Failed {
        /// [s] when
        time: f64,
        /// what happened
        cause: String,
    },
    /// It failed on its first steps from the state of another method.
    #[error("fails at t = {time:.3e} s, tried from t = {from:.3e} s: {cause}")]
    OnTheWay {
        /// [s] when
        time: f64,
        /// [s] where the trial began
        from: f64,
        /// what happened
        cause: String,
    },
    /// No step was made.
    #[error("no step could be made in the time of a trial")]
    Nothing,
}

/// Makes a few steps of a bound method from a state, without leaving anything.
///
/// # Errors
/// When they fail.
pub fn sample(
    scene: &dyn Scene,
    stepper: &mut Stepper<'_>,
    tried: Attempted<'_>,
    sampled: &Snapshot,
) -> Result<Sample, SampleError> {
    let snapshot = begin(scene, stepper, tried, sampled)?;
    let from = snapshot.t;
    let mut meter = Meter::new(tried);
    // Steps are made in blocks as a run with these frames makes them, once the first ones were made.
    let experiment = Experiment { single_steps: COLD, ..tried.experiment(scene) };
    let outcome = experiment.run_with(stepper, Start::Snapshot(Box::new(snapshot)), None, &mut |event, _| {
        match event {
            Event::Boundary(run) if meter.due || meter.over => {
                meter.due = false;
                meter.mark(run.step, run.at.state.t, run.counters);
            }
            Event::Step(step) => meter.stepped(step.h()),
            _ => {}
        }
        Flow::stop_if(meter.over)
    })?;
    meter.mark(outcome.steps, outcome.t_end, outcome.counters);
    let sample = meter.sample();
    match (outcome.failure, outcome.status) {
        (Some(failure), Status::Diverged | Status::NotConverged) => {
            Err(SampleError::OnTheWay { time: failure.time, from, cause: failure.cause })
        }
        _ => sample.ok_or(SampleError::Nothing),
    }
}

/// The state as a run of this method would have come to it, its account opened anew; for fixed steps at the nearest of
/// their times.
fn begin(
    scene: &dyn Scene,
    stepper: &mut Stepper<'_>,
    tried: Attempted<'_>,
    from: &Snapshot,
) -> Result<Snapshot, SampleError> {
    let (step, t) = match tried.step {
        Step::Adaptive(_) => (from.step, from.t),
        Step::Fixed(h) => {
            let clock = FixedSteps::new(h, tried.end);
            // The last step may be cut, and a few before it are to be made.
            let step = ((from.t / h).round() as u64).min(clock.count().saturating_sub(1 + LEAST));
            (step, if step == 0 { 0.0 } else { clock.tick(step).t })
        }
    };
    let mut at = Point { state: State { t, x: from.x.clone(), v: from.v.clone() }, forces: scene.new_forces() };
    scene.evaluate(at.state.as_ref(), &mut at.forces);
    stepper.start(&at).map_err(RunError::from)?;
    let (ledger, row) = Ledger::open(scene, &at);
    let watch = Watch::open(scene, tried.method.info, &row).account().silent();
    let State { x, v, .. } = at.state;
    let adaptive = from.adaptive.clone().filter(|_| tried.step.fixed().is_none());
    Ok(Snapshot { step, t, x, v, carried: stepper.save(), ledger, row, watch, adaptive, ..Snapshot::default() })
}

#[derive(Clone, Copy, Debug)]
struct Mark {
    step: u64,
    /// [s]
    t: f64,
    /// [s]
    cpu: f64,
    counters: Counters,
}

/// Reads the clock now and then and says when the trial is over.
struct Meter {
    clock: Clock,
    allowance: f64,
    adaptive: bool,
    /// [s] the step before
    before: f64,
    /// number of steps after which the clock is read next
    next: u64,
    made: u64,
    /// whether a mark is to be made
    due: bool,
    /// whether no more steps are to be made
    over: bool,
    marks: Vec<Mark>,
}

impl Meter {
    fn new(tried: Attempted<'_>) -> Self {
        let (clock, allowance, adaptive) = (Clock::default(), tried.allowance, tried.step.fixed().is_none());
        Meter { clock, allowance, adaptive, before: 0.0, next: 1, made: 0, due: true, over: false, marks: Vec::new() }
    }

    fn mark(&mut self, step: u64, t: f64, counters: Counters) {
        if self.marks.last().is_none_or(|last| step > last.step) {
            self.marks.push(Mark { step, t, cpu: self.clock.seconds(), counters });
        }
    }

    /// What the later steps cost: the first ones start from a state of another method, and adaptive steps have yet to
    /// find their size.
    fn sample(&self) -> Option<Sample> {
        let (first, last) = (self.marks.first()?, self.marks.last()?);
        let settled = (first.step + last.step) / 2;
        let from = self.marks.iter().rev().find(|mark| mark.step <= settled && mark.step < last.step)?;
        let (before, after) = (work(from.counters), work(last.counters));
        Some(Sample {
            steps: (last.step - from.step) as f64,
            simulated: last.t - from.t,
            seconds: last.cpu - from.cpu,
            work: std::array::from_fn(|i| after[i].saturating_sub(before[i]) as f64),
        })
    }

    /// After a step of h [s].
    fn stepped(&mut self, h: f64) {
        self.made += 1;
        let grows = self.adaptive && h > GROWING * self.before;
        self.before = h;
        // Reading the clock is as dear as a step of a pendulum: read it less and less often.
        if self.made >= self.next {
            self.due = true;
            self.next = self.made + 1 + self.made / 8;
            let spent = self.marks.first().map_or(0.0, |first| self.clock.seconds() - first.cpu);
            let over = spent > self.allowance && self.made >= LEAST && !grows;
            self.over |= over || spent > PATIENCE * self.allowance && self.made >= 2;
        }
    }
}
