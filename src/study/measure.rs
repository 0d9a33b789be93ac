//! One run of a study: made, compared with the reference, and saved whenever it is stopped.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::error::StudyError;
use super::experiment::{Experiment, Start};
use super::frames::Sampler;
use super::keeper::{Course, Keeper};
use super::prepared_case::choice;
use super::ranking::{QuantityResult, ReferenceQuantity};
use super::row::{Job, RowStatus, RunResult, StepSetting};
use super::runner::{PreparedVariant, RunEnd, Runner};
use super::store::{ComparedSoFar, Unfinished};
use crate::drive::event::Fired;
use crate::drive::observer::{
    AcceptedStep, Energies, ObserveError, Observer, Point, Resumable, States, UpcomingStep, Wants,
};
use crate::drive::{Outcome, RunError, Status};
use crate::format_number::figures;
use crate::model::stop::Stop;
use crate::output::gauges::MeasuredQuantity;
use crate::output::largest::{LargestSoFar, LargestValues};
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
        let so_far = earlier.as_ref().map(|e| e.measured.clone()).unwrap_or_default();
        let before = Cost { cpu: (spent > 0.0).then_some(spent), wall: Duration::from_secs_f64(spent) };
        let stop = AtomicBool::new(false);
        let mut watcher = Watcher {
            runner: self,
            job,
            sampler: Sampler::comparing(&*case.scene, case.every, &reference.frames, from, so_far.distance),
            quantities: quantities(variant, so_far.quantities.as_ref())?,
            keeper: Keeper::new(case.scene.n_dof(), self.interrupt, *deadline),
            watch: Stopwatch::start(before),
            stop: &stop,
        };
        let start = earlier.map_or(Start::Initial, |earlier| Start::Snapshot(Box::new(earlier.snapshot)));
        let experiment =
            Experiment { interrupt: Stop::on(self.interrupt), ..case.experiment(&method, job.setting.step()) };
        let mut stepper = match experiment.stepper() {
            Ok(stepper) => stepper,
            Err(why) => return Ok(refused(why.to_string())),
        };
        let run = experiment.observed(&mut stepper, start, &mut [&mut watcher], &stop);
        let Watcher { sampler, quantities, keeper, watch, .. } = watcher;
        let cost = watch.read();
        keeper.done()?;
        let outcome = match run {
            Ok(outcome) => outcome,
            Err(RunError::Start(why)) => return Ok(refused(why.to_string())),
            Err(why) => return Err(StudyError::Usage(format!("{}: {why}", job.id))),
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
        let mut result = measured(&outcome, errors, cost.seconds());
        if let Some(values) = quantities.filter(|_| result.status == RowStatus::Completed) {
            result.quantities = compared(&reference.account.quantities, &values.quantities());
        }
        Ok(RunEnd::Done(Box::new(result)))
    }
}

/// The observer of the quantities that the reference knows, if there are any.
fn quantities<'a>(
    variant: &'a PreparedVariant,
    so_far: Option<&LargestSoFar>,
) -> Result<Option<LargestValues<'a>>, StudyError> {
    let PreparedVariant { case, reference, .. } = variant;
    let wanted = !reference.account.quantities.is_empty();
    let made = wanted.then(|| LargestValues::of_quantities(&*case.scene, &case.problem.output, case.end(), so_far));
    made.transpose().map_err(|why| StudyError::Usage(why.to_string()))
}

/// The quantities of a run beside those of the reference.
fn compared(known: &[ReferenceQuantity], values: &[MeasuredQuantity]) -> BTreeMap<String, QuantityResult> {
    let of = |known: &ReferenceQuantity| {
        let value = values.iter().find(|quantity| quantity.name == known.name).and_then(|quantity| quantity.value);
        (known.name.clone(), QuantityResult { value, error: value.and_then(|value| known.error_of(value)) })
    };
    known.iter().map(of).collect()
}

/// The observer of a run: compares its frames, measures its quantities, and saves it where it may stop.
struct Watcher<'a, 's> {
    runner: &'a Runner<'a>,
    job: &'a Job,
    sampler: Sampler<'s>,
    quantities: Option<LargestValues<'s>>,
    keeper: Keeper<'a>,
    watch: Stopwatch,
    stop: &'a AtomicBool,
}

impl Observer for Watcher<'_, '_> {
    fn started(&mut self, at: &Point, ledger: Energies) -> Result<(), ObserveError> {
        self.quantities.as_mut().map_or(Ok(()), |values| values.started(at, ledger))
    }

    fn resumed(&mut self, at: &Point, ledger: Energies) -> Result<(), ObserveError> {
        self.quantities.as_mut().map_or(Ok(()), |values| values.resumed(at, ledger))
    }

    fn resumable(&mut self, run: &Resumable<'_>) -> Result<(), ObserveError> {
        let Self { runner, job, sampler, quantities, watch, .. } = self;
        let course = self.keeper.goes_on(run.occasion, || {
            let quantities = quantities.as_ref().map(LargestValues::so_far);
            let measured = ComparedSoFar { distance: sampler.distance(), quantities };
            runner
                .store
                .keep_unfinished(job, &Unfinished { snapshot: run.snapshot(), measured, spent: watch.seconds() })
        });
        if course == Course::Ends {
            self.stop.store(true, Ordering::Relaxed);
        }
        Ok(())
    }

    fn wants(&self, step: UpcomingStep) -> Wants {
        let frames = self.sampler.wants(step);
        let states = self.quantities.as_ref().map_or(States::None, |values| values.wants(step).states);
        Wants { states: frames.states.max(states), ..frames }
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.sampler.accepted(step)?;
        self.quantities.as_mut().map_or(Ok(()), |values| values.accepted(step))
    }

    fn event(&mut self, event: &Fired) -> Result<(), ObserveError> {
        self.quantities.as_mut().map_or(Ok(()), |values| values.event(event))
    }

    fn failed(&mut self) -> Result<(), ObserveError> {
        self.quantities.as_mut().map_or(Ok(()), LargestValues::failed)
    }

    fn finished(&mut self, last: &Point) -> Result<(), ObserveError> {
        self.sampler.finished(last)?;
        self.quantities.as_mut().map_or(Ok(()), |values| values.finished(last))
    }
}

fn refused(note: String) -> RunEnd {
    RunEnd::Done(Box::new(RunResult { status: RowStatus::Refused, note, ..RunResult::default() }))
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
        quantities: BTreeMap::new(),
        energy_error: Some(outcome.energy_error).filter(|e| e.is_finite()),
        repeats: vec![seconds],
        steps: outcome.steps,
        rejected_steps: outcome.rejected_steps,
        t_end: outcome.t_end,
        counters: outcome.counters,
    }
}
