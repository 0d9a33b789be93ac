//! One run of a study: made, compared with the reference, and kept whenever it is stopped.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::bench::{Bench, choice};
use super::error::StudyError;
use super::experiment::{Event, Experiment, ExperimentError, Flow, Start};
use super::frames::{Frames, Motion, Sampler};
use super::row::{Job, Measured, Pace, RowStatus};
use super::store::{Store, Unfinished};
use crate::drive::observer::Occasion;
use crate::drive::{Outcome, RunError, Status};
use crate::format_number::figures;
use crate::model::stop::Stop;
use crate::process::{Cost, Stopwatch};

/// An unfinished run is saved this often, so that a kill costs no more.
const SAVED_EVERY: Duration = Duration::from_secs(20);
/// The clock is read once in so many steps, unless these take long.
const LOOK: u32 = 64;

/// What a run is measured with.
pub struct Meter<'a> {
    /// the variant
    pub bench: &'a Bench,
    /// frames of its reference
    pub reference: &'a Frames,
    /// how far they move
    pub motion: Motion,
    /// where results go
    pub store: &'a Store,
    /// set when the user interrupts
    pub interrupt: &'a AtomicBool,
    /// when the budget is spent
    pub deadline: Option<Instant>,
}

/// How a measurement ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ended {
    /// at its end
    Done(Measured),
    /// the budget was spent; where the run had come to is kept. [s] time it came to
    OutOfTime(f64),
    /// the user interrupted; where the run had come to is kept
    Interrupted,
}

impl Meter<'_> {
    /// Makes a run, taking up what an earlier process left of it, and compares it with the reference.
    ///
    /// # Errors
    /// When files of the study cannot be written.
    pub fn run(&self, job: &Job) -> Result<Ended, StudyError> {
        let method = choice(&job.method)?;
        if let Pace::Step(h) = job.pace
            && h > self.bench.end()
        {
            return Ok(refused(format!(
                "the step of {} s is longer than the run of {} s",
                figures(h, 4),
                self.bench.end()
            )));
        }
        let earlier = self.store.unfinished(job);
        let (from, spent) = earlier.as_ref().map_or((0.0, 0.0), |e| (e.snapshot.t, e.spent));
        let so_far = earlier.as_ref().map(|e| e.distance).unwrap_or_default();
        let scene = &*self.bench.scene;
        let before = Cost { cpu: (spent > 0.0).then_some(spent), wall: Duration::from_secs_f64(spent) };
        let watch = Stopwatch::start(before);
        let mut sampler = Sampler::comparing(scene, self.bench.every, self.reference, (from, so_far));
        let start = earlier.map_or(Start::Initial, |earlier| Start::Snapshot(Box::new(earlier.snapshot)));
        // The clock is read after so many steps: reading it takes as long as a step of a pendulum.
        let between = if scene.n_dof() < 1000 { LOOK } else { 0 };
        let (mut countdown, mut saved, mut failed) = (0, Instant::now(), None);
        let interrupt = Stop::on(self.interrupt);
        let experiment = Experiment { interrupt, single_steps: 0, ..self.bench.experiment(&method, job.pace.step()) };
        let run = experiment.run(start, Some(&mut sampler), &mut |event, distance| {
            let Event::Boundary(run) = event else { return Flow::Continue };
            let mut save = || {
                let unfinished = Unfinished { snapshot: run.snapshot(), distance, spent: seconds(watch.read()) };
                failed = self.store.keep_unfinished(job, &unfinished).err();
                Flow::stop_if(failed.is_some())
            };
            if run.occasion == Occasion::Interrupted {
                return save();
            }
            let interrupted = self.interrupt.load(Ordering::Relaxed);
            if countdown > 0 {
                countdown -= 1;
                return Flow::stop_if(interrupted);
            }
            countdown = between;
            let now = Instant::now();
            let over = self.deadline.is_some_and(|deadline| now >= deadline);
            if interrupted || over || now.duration_since(saved) < SAVED_EVERY {
                return Flow::stop_if(interrupted || over);
            }
            saved = now;
            save()
        });
        let cost = watch.read();
        let distance = sampler.distance();
        if let Some(failed) = failed {
            return Err(failed);
        }
        let outcome = match run {
            Ok(outcome) => outcome,
            Err(ExperimentError::Method(why)) => return Ok(refused(why.to_string())),
            Err(ExperimentError::Run(RunError::Start(why))) => return Ok(refused(why.to_string())),
            Err(ExperimentError::Run(why)) => return Err(StudyError::Usage(format!("{}: {why}", job.id))),
        };
        let interrupted = self.interrupt.load(Ordering::Relaxed);
        // A failure whose cause was not looked for to the end is not a row yet.
        if interrupted && (outcome.status == Status::Interrupted || outcome.failure.is_some()) {
            return Ok(Ended::Interrupted);
        }
        if outcome.status == Status::Interrupted {
            return Ok(Ended::OutOfTime(outcome.t_end));
        }
        Ok(Ended::Done(measured(&outcome, distance.over(self.motion), seconds(cost))))
    }
}

/// [s] Processor time, or that of the wall clock where the system does not say.
fn seconds(cost: Cost) -> f64 {
    cost.cpu.unwrap_or(cost.wall.as_secs_f64())
}

fn refused(note: String) -> Ended {
    Ended::Done(Measured { status: RowStatus::Refused, note, ..Measured::default() })
}

fn measured(outcome: &Outcome, errors: Option<[f64; 2]>, seconds: f64) -> Measured {
    let status = match outcome.status {
        Status::Completed => RowStatus::Completed,
        Status::Diverged => RowStatus::Diverged,
        Status::NotConverged => RowStatus::NotConverged,
        Status::Interrupted => RowStatus::NotRun,
    };
    let errors = errors.filter(|_| status == RowStatus::Completed);
    let note = match &outcome.failure {
        Some(failure) => format!("at t = {:.4e} s: {}; {}", failure.time, failure.cause, failure.advice),
        None => outcome.doubt.clone().or_else(|| outcome.energy_doubt()).unwrap_or_default(),
    };
    Measured {
        status,
        note,
        error: errors.map(|e| e[0]),
        error_max: errors.map(|e| e[1]),
        energy_error: Some(outcome.energy_error).filter(|e| e.is_finite()),
        repeats: vec![seconds],
        steps: outcome.steps,
        rejected_steps: outcome.rejected_steps,
        t_end: outcome.t_end,
        counters: outcome.counters,
    }
}
