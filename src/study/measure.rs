//! One run of a study: made, compared with the reference, and kept whenever it is stopped.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::bench::{Bench, Try, TryError, choice};
use super::error::StudyError;
use super::frames::{Frames, Motion, Sampler};
use super::row::{Job, Measured, Pace, RowStatus};
use super::store::{Store, Unfinished};
use crate::drive::observer::{
    AcceptedStep, LedgerRow, ObserveError, Observer, Occasion, Point, Resumable, UpcomingStep, Wants,
};
use crate::drive::{Outcome, RunError, Status};
use crate::format_number::figures;
use crate::model::stop::Stop;
use crate::process::{Cost, Stopwatch};

/// An unfinished run is kept this often, so that a kill costs no more.
const KEPT_EVERY: Duration = Duration::from_secs(20);
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
        let stop = AtomicBool::new(false);
        let before = Cost { cpu: (spent > 0.0).then_some(spent), wall: Duration::from_secs_f64(spent) };
        let watch = Stopwatch::start(before);
        let mut attendant = Attendant {
            sampler: Sampler::comparing(scene, self.bench.every, self.reference, (from, so_far)),
            meter: self,
            job,
            stop: &stop,
            watch,
            countdown: 0,
            kept: Instant::now(),
            failed: None,
        };
        let what = Try {
            method: &method,
            step: job.pace.step(),
            solver: self.bench.problem.solver,
            interrupt: Stop::on(self.interrupt),
            from: earlier.map(|e| e.snapshot),
        };
        let run = self.bench.run(what, &mut [&mut attendant], &stop);
        let cost = watch.read();
        let distance = attendant.sampler.distance();
        if let Some(failed) = attendant.failed {
            return Err(failed);
        }
        let outcome = match run {
            Ok(outcome) => outcome,
            Err(TryError::Method(why)) => return Ok(refused(why.to_string())),
            Err(TryError::Run(RunError::Start(why))) => return Ok(refused(why.to_string())),
            Err(TryError::Run(why)) => return Err(StudyError::Usage(format!("{}: {why}", job.id))),
        };
        let interrupted = self.interrupt.load(Ordering::Relaxed);
        // A failure whose cause was not looked for to the end is not a row yet.
        if interrupted && (outcome.status == Status::Interrupted || outcome.failure.is_some()) {
            return Ok(Ended::Interrupted);
        }
        if outcome.status == Status::Interrupted {
            return Ok(Ended::OutOfTime(outcome.t_end));
        }
        let seconds = cost.cpu.unwrap_or(cost.wall.as_secs_f64());
        Ok(Ended::Done(measured(&outcome, distance.over(self.motion), seconds)))
    }
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

/// Compares frames, looks at the clock, and keeps the run when it is time or when it is stopped.
struct Attendant<'a> {
    sampler: Sampler<'a>,
    meter: &'a Meter<'a>,
    job: &'a Job,
    stop: &'a AtomicBool,
    watch: Stopwatch,
    /// steps until the clock is read next
    countdown: u32,
    kept: Instant,
    failed: Option<StudyError>,
}

impl Attendant<'_> {
    fn keep(&mut self, run: &Resumable<'_>) {
        let cost = self.watch.read();
        let spent = cost.cpu.unwrap_or(cost.wall.as_secs_f64());
        let unfinished = Unfinished { snapshot: run.snapshot(), distance: self.sampler.distance(), spent };
        if let Err(error) = self.meter.store.keep_unfinished(self.job, &unfinished) {
            self.failed = Some(error);
            self.stop.store(true, Ordering::Relaxed);
        }
        self.kept = Instant::now();
    }
}

impl Observer for Attendant<'_> {
    fn started(&mut self, at: &Point, ledger: LedgerRow) -> Result<(), ObserveError> {
        self.sampler.started(at, ledger)
    }

    fn resumable(&mut self, run: &Resumable<'_>) -> Result<(), ObserveError> {
        if run.occasion == Occasion::Interrupted {
            self.keep(run);
            return Ok(());
        }
        if self.meter.interrupt.load(Ordering::Relaxed) {
            // The driver looks at the flag before the next step.
            self.stop.store(true, Ordering::Relaxed);
        }
        if self.countdown > 0 {
            self.countdown -= 1;
            return Ok(());
        }
        let now = Instant::now();
        if self.meter.deadline.is_some_and(|deadline| now >= deadline) {
            self.stop.store(true, Ordering::Relaxed);
        } else if now.duration_since(self.kept) >= KEPT_EVERY {
            self.keep(run);
        }
        // Reading the clock costs as much as a step of a pendulum.
        self.countdown = if self.meter.bench.scene.n_dof() < 1000 { LOOK } else { 0 };
        Ok(())
    }

    fn wants(&self, step: UpcomingStep) -> Wants {
        self.sampler.wants(step)
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.sampler.accepted(step)
    }

    fn finished(&mut self, last: &Point) -> Result<(), ObserveError> {
        // A run that was stopped has kept its distance before; this frame is not one of it.
        self.sampler.finished(last)
    }
}
