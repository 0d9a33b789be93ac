//! One run of a study: made, compared with the reference, and saved whenever it is stopped.

use std::sync::atomic::Ordering;
use std::time::Duration;

use super::error::StudyError;
use super::experiment::{Event, Experiment, ExperimentError, Start};
use super::frames::Sampler;
use super::keeper::{Course, Keeper};
use super::prepared_case::choice;
use super::row::{Job, RowStatus, RunResult, StepSetting};
use super::runner::{PreparedVariant, RunEnd, Runner};
use super::store::Unfinished;
use crate::drive::{Outcome, RunError, Status};
use crate::format_number::figures;
use crate::model::stop::Stop;
use crate::process::{Cost, Stopwatch};

impl Runner<'_> {
    /// Makes a run, from where an earlier process left it, and compares it with the reference.
    ///
    /// # Errors
    /// An interrupt, after which the run is saved, or files of the study that cannot be written.
    pub(super) fn measure(&self, variant: &PreparedVariant, job: &Job) -> Result<RunEnd, StudyError> {
        let PreparedVariant { case, reference, deadline } = variant;
        let method = choice(&job.method)?;
        if let StepSetting::Step(h) = job.setting
            && h > case.end()
        {
            let end = case.end();
            return Ok(refused(format!("the step of {} s is longer than the run of {end} s", figures(h, 4))));
        }
        let earlier: Option<Unfinished> = self.store.unfinished(job);
        let (from, spent) = earlier.as_ref().map_or((0.0, 0.0), |e| (e.snapshot.t, e.spent));
        let so_far = earlier.as_ref().map(|e| e.measured).unwrap_or_default();
        let before = Cost { cpu: (spent > 0.0).then_some(spent), wall: Duration::from_secs_f64(spent) };
        let watch = Stopwatch::start(before);
        let mut sampler = Sampler::comparing(&*case.scene, case.every, &reference.frames, from, so_far);
        let start = earlier.map_or(Start::Initial, |earlier| Start::Snapshot(Box::new(earlier.snapshot)));
        let mut keeper = Keeper::new(case.scene.n_dof(), self.interrupt, *deadline);
        let interrupt = Stop::on(self.interrupt);
        let experiment = Experiment { interrupt, single_steps: 0, ..case.experiment(&method, job.setting.step()) };
        let run = experiment.run(start, Some(&mut sampler), &mut |event, distance| {
            let Event::Boundary(run) = event else { return false };
            keeper.goes_on(run.occasion, || {
                let unfinished = Unfinished { snapshot: run.snapshot(), measured: distance, spent: watch.seconds() };
                self.store.keep_unfinished(job, &unfinished)
            }) == Course::Ends
        });
        let cost = watch.read();
        keeper.done()?;
        let outcome = match run {
            Ok(outcome) => outcome,
            Err(ExperimentError::Method(why)) => return Ok(refused(why.to_string())),
            Err(ExperimentError::Run(RunError::Start(why))) => return Ok(refused(why.to_string())),
            Err(ExperimentError::Run(why)) => return Err(StudyError::Usage(format!("{}: {why}", job.id))),
        };
        let interrupted = self.interrupt.load(Ordering::Relaxed);
        // A failure whose cause was not searched to the end is not a result yet.
        if interrupted && (outcome.status == Status::Interrupted || outcome.failure.is_some()) {
            return Err(StudyError::Interrupted);
        }
        if outcome.status == Status::Interrupted {
            return Ok(RunEnd::OutOfTime(outcome.t_end));
        }
        let errors = sampler.distance().over(reference.account.motion);
        Ok(RunEnd::Done(measured(&outcome, errors, cost.seconds())))
    }
}

fn refused(note: String) -> RunEnd {
    RunEnd::Done(RunResult { status: RowStatus::Refused, note, ..RunResult::default() })
}

/// What is kept of a run that was made.
pub(super) fn measured(outcome: &Outcome, errors: Option<[f64; 2]>, seconds: f64) -> RunResult {
    let status = match outcome.status {
        Status::Completed => RowStatus::Completed,
        Status::Diverged => RowStatus::Diverged,
        Status::NotConverged => RowStatus::NotConverged,
        Status::Interrupted => RowStatus::NotRun,
    };
    let errors = errors.filter(|_| status == RowStatus::Completed);
    let note = match &outcome.failure {
        Some(failure) => format!("at t = {} s: {}; {}", figures(failure.time, 5), failure.cause, failure.advice),
        None => outcome.doubt.clone().or_else(|| outcome.energy_doubt()).unwrap_or_default(),
    };
    RunResult {
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
