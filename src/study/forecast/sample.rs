//! A few real steps of a method, their cost and the time they simulate. They begin at the start of a run or at a state
//! along it. Nothing is written.

use super::work::Work;
use crate::drive::clock::{FixedSteps, Step};
use crate::drive::ledger::Ledger;
use crate::drive::watch::Watch;
use crate::drive::{RunError, Snapshot, Status};
use crate::experiment::{Event, Experiment, Start};
use crate::integrate::Counters;
use crate::integrate::stepper::Stepper;
use crate::model::point::Point;
use crate::model::state::State;
use crate::process::Stopwatch;

/// [-] While a step is this many times the one before, adaptive steps have not reached their size yet.
const GROWING: f64 = 1.4;
/// A trial may take this multiple of its allowance while its steps still grow.
pub(super) const PATIENCE: f64 = 3.0;
/// Smallest number of steps of a trial, even beyond its allowance, up to [`PATIENCE`] times it.
const LEAST: u64 = 6;
/// Number of first steps that are always made one by one: they touch their memory for the first time.
pub(super) const COLD: u64 = 2;

/// What some steps cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// [-] accepted steps
    pub steps: f64,
    /// [s] simulated time
    pub simulated: f64,
    /// [s] processor time
    pub seconds: f64,
    /// [-] work
    pub work: Work,
}

impl Sample {
    /// [1/s] Steps a second simulated.
    pub fn pace(&self) -> f64 {
        self.steps / self.simulated
    }

    /// The same of one step.
    pub fn each(&self) -> Sample {
        self.times(1.0 / self.steps.max(1.0))
    }

    /// So many times as much.
    pub fn times(&self, times: f64) -> Sample {
        Sample {
            steps: self.steps * times,
            simulated: self.simulated * times,
            seconds: self.seconds * times,
            work: self.work.times(times),
        }
    }

    /// The difference to `earlier`, both being sums since the start.
    fn since(&self, earlier: &Sample) -> Sample {
        Sample {
            steps: self.steps - earlier.steps,
            simulated: self.simulated - earlier.simulated,
            seconds: self.seconds - earlier.seconds,
            work: Work::each(|kind| kind(&self.work) - kind(&earlier.work)),
        }
    }
}

/// The steps of a run from its start.
#[derive(Clone, Copy, Debug)]
pub struct StartSample {
    /// all of its steps
    pub sample: Sample,
    /// [1/s] steps a second simulated, in its first quarter to half by steps, and after that
    pub pace: [f64; 2],
}

/// Why there is no sample.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
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

/// A run from its start until it has taken `allowance` [s] of processor time.
///
/// # Errors
/// Where it fails before.
pub fn sample_start(
    run: Experiment<'_>,
    stepper: &mut Stepper<'_>,
    allowance: f64,
) -> Result<StartSample, SampleError> {
    let clock = Stopwatch::default();
    let start = clock.seconds();
    // Steps made and the time [s] then, at the last two powers of two.
    let (mut made, mut marks) = (0_u64, [(0_u64, 0.0); 2]);
    let run = Experiment { single_steps: 0, ..run };
    let outcome = run.run_with(stepper, Start::Initial, None, &mut |event, _| {
        let Event::Step(step) = event else { return false };
        made += 1;
        if made.is_power_of_two() {
            marks = [marks[1], (made, step.t)];
        }
        let look = made < 16 || made.is_multiple_of(16);
        look && clock.seconds() >= start + allowance
    })?;
    if let Some(failure) = outcome.failure {
        return Err(SampleError::Failed { time: failure.time, cause: failure.cause });
    }
    if outcome.steps == 0 {
        return Err(SampleError::Nothing);
    }
    let sample = Sample {
        steps: outcome.steps as f64,
        simulated: outcome.t_end,
        seconds: clock.seconds() - start,
        work: outcome.counters.into(),
    };
    let (steps, t) = (marks[0].0 as f64, marks[0].1);
    let pace = match steps > 0.0 {
        true => [steps / t, (sample.steps - steps) / (sample.simulated - t)],
        false => [sample.pace(); 2],
    };
    Ok(StartSample { sample, pace })
}

/// A few steps from a state on the way of another run, which take about `allowance` [s] of processor time.
///
/// # Errors
/// When they fail.
pub fn sample(
    run: Experiment<'_>,
    stepper: &mut Stepper<'_>,
    allowance: f64,
    at: &Snapshot,
) -> Result<Sample, SampleError> {
    let snapshot = begin(&run, stepper, at)?;
    let from = snapshot.t;
    let adaptive = run.step.fixed().is_none();
    let mut meter = Meter { clock: Stopwatch::default(), allowance, adaptive, due: true, ..Meter::default() };
    // Steps are made in blocks as a run with these frames makes them, once the first ones were made.
    let run = Experiment { single_steps: COLD, ..run };
    let outcome = run.run_with(stepper, Start::Snapshot(Box::new(snapshot)), None, &mut |event, _| {
        match event {
            Event::Boundary(run) if meter.due || meter.over => {
                meter.due = false;
                meter.mark(run.step, run.at.state.t, run.counters);
            }
            Event::Step(step) => meter.stepped(step.h()),
            _ => {}
        }
        meter.over
    })?;
    meter.mark(outcome.steps, outcome.t_end, outcome.counters);
    match (outcome.failure, outcome.status) {
        (Some(failure), Status::Diverged | Status::NotConverged) => {
            Err(SampleError::OnTheWay { time: failure.time, from, cause: failure.cause })
        }
        _ => meter.sample().ok_or(SampleError::Nothing),
    }
}

/// The state `steps` fixed steps after one on the way of another run.
///
/// # Errors
/// When they fail.
pub fn settled(
    run: Experiment<'_>,
    stepper: &mut Stepper<'_>,
    steps: u64,
    at: &Snapshot,
) -> Result<(Snapshot, Sample), SampleError> {
    let snapshot = begin(&run, stepper, at)?;
    let (from, clock, mut made, mut found) = (snapshot.t, Stopwatch::default(), 0, None);
    let before = clock.seconds();
    let outcome = run.run_with(stepper, Start::Snapshot(Box::new(snapshot)), None, &mut |event, _| {
        match event {
            Event::Boundary(run) if made == steps => found = Some(run.snapshot()),
            Event::Step(_) => made += 1,
            _ => {}
        }
        made >= steps && found.is_some()
    })?;
    if let Some(failure) = outcome.failure {
        return Err(SampleError::OnTheWay { time: failure.time, from, cause: failure.cause });
    }
    let work = outcome.counters.into();
    let sample = Sample { steps: made as f64, simulated: 0.0, seconds: clock.seconds() - before, work };
    found.map(|found| (found, sample)).ok_or(SampleError::Nothing)
}

/// `counted` fixed steps from a state on the way of another run, after `settle` steps that are not counted: what is
/// made is the same on every machine.
///
/// # Errors
/// When they fail.
pub fn sample_steps(
    run: Experiment<'_>,
    stepper: &mut Stepper<'_>,
    settle: u64,
    counted: u64,
    at: &Snapshot,
) -> Result<Sample, SampleError> {
    let snapshot = begin(&run, stepper, at)?;
    let from = snapshot.t;
    let mut meter = Meter { clock: Stopwatch::default(), ..Meter::default() };
    let outcome = run.run_with(stepper, Start::Snapshot(Box::new(snapshot)), None, &mut |event, _| {
        match event {
            Event::Boundary(run) if meter.made == settle => meter.mark(run.step, run.at.state.t, run.counters),
            Event::Step(_) => meter.made += 1,
            _ => {}
        }
        meter.made >= settle + counted
    })?;
    if let Some(failure) = outcome.failure {
        return Err(SampleError::OnTheWay { time: failure.time, from, cause: failure.cause });
    }
    meter.mark(outcome.steps, outcome.t_end, outcome.counters);
    match meter.marks[..] {
        [first, last] => Ok(last.since(&first)),
        _ => Err(SampleError::Nothing),
    }
}

/// A snapshot of this method at the state of `from`, with a new energy account; with fixed steps, at the nearest
/// multiple of the step.
fn begin(run: &Experiment<'_>, stepper: &mut Stepper<'_>, from: &Snapshot) -> Result<Snapshot, SampleError> {
    let (step, t) = match run.step {
        Step::Adaptive(_) => (from.step, from.t),
        Step::Fixed(h) => {
            let clock = FixedSteps::new(h, run.end);
            // The last step may be cut, and a few before it are to be made.
            let step = ((from.t / h).round() as u64).min(clock.count().saturating_sub(1 + LEAST));
            (step, if step == 0 { 0.0 } else { clock.tick(step).t })
        }
    };
    let scene = run.scene;
    let mut at = Point { state: State { t, x: from.x.clone(), v: from.v.clone() }, forces: scene.new_forces() };
    scene.evaluate(at.state.as_ref(), &mut at.forces);
    stepper.start(&at).map_err(RunError::from)?;
    let ledger = Ledger::open(scene, &at);
    let row = ledger.first();
    let watch = Watch::open(scene, run.method.info, &row).account().without_warning();
    let State { x, v, .. } = at.state;
    let adaptive = from.adaptive.clone().filter(|_| run.step.fixed().is_none());
    Ok(Snapshot { step, t, x, v, carried: stepper.save(), ledger, row, watch, adaptive, ..Snapshot::default() })
}

/// Reads the clock after some of the steps and decides when the trial ends.
#[derive(Default)]
struct Meter {
    clock: Stopwatch,
    /// [s]
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
    /// sums since the start of the run
    marks: Vec<Sample>,
}

impl Meter {
    fn mark(&mut self, step: u64, t: f64, counters: Counters) {
        let steps = step as f64;
        if self.marks.last().is_none_or(|last| steps > last.steps) {
            self.marks.push(Sample { steps, simulated: t, seconds: self.clock.seconds(), work: counters.into() });
        }
    }

    /// The later half of the steps: the first ones start from a state of another method, and adaptive steps have not
    /// reached their size yet.
    fn sample(&self) -> Option<Sample> {
        let (first, last) = (self.marks.first()?, self.marks.last()?);
        let settled = (first.steps + last.steps) / 2.0;
        let from = self.marks.iter().rev().find(|mark| mark.steps <= settled && mark.steps < last.steps)?;
        Some(last.since(from))
    }

    /// After a step of `h` [s].
    fn stepped(&mut self, h: f64) {
        self.made += 1;
        let grows = self.adaptive && h > GROWING * self.before;
        self.before = h;
        // Reading the clock costs as much as a step of a pendulum: it is read less and less often.
        if self.made >= self.next {
            self.due = true;
            self.next = self.made + 1 + self.made / 8;
            let spent = self.marks.first().map_or(0.0, |first| self.clock.seconds() - first.seconds);
            let over = spent > self.allowance && self.made >= LEAST && !grows;
            self.over |= over || spent > PATIENCE * self.allowance && self.made >= 2;
        }
    }
}
