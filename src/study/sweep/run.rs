//! Makes the runs of a sweep, several at the same time, and gathers their results.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::plan::{SweepJob, SweepPlan};
use super::result::SweepResult;
use crate::case::Case;
use crate::drive::max_displacement::MaxDisplacement;
use crate::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, Point, Resumable, UpcomingStep, Wants};
use crate::drive::{Explain, RunError, Status};
use crate::error::StudyError;
use crate::experiment::{Experiment, Start};
use crate::keeper::{Course, Keeper};
use crate::measure::measured;
use crate::model::stop::Stop;
use crate::output::gauges::MeasuredQuantity;
use crate::output::largest::{LargestSoFar, LargestValues};
use crate::output::quantity::QuantityReports;
use crate::prepared_case::fingerprint_of;
use crate::process::{Cost, Stopwatch};
use crate::row::{RowStatus, RunResult};
use crate::runner::Shard;
use crate::simulation::{SetupError, build_scene};
use crate::store::{Store, Unfinished};

/// A run and what came of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SweepRow {
    /// the run
    #[serde(flatten)]
    pub job: SweepJob,
    /// what came of it
    #[serde(flatten)]
    pub result: SweepResult,
}

/// Makes runs.
pub struct SweepRunner<'a> {
    /// what is to be done
    pub plan: &'a SweepPlan,
    /// where it goes
    pub store: &'a Store<SweepPlan>,
    /// the share that is made; `None`: all
    pub shard: Option<Shard>,
    /// runs at the same time
    pub threads: usize,
    /// when the budget is spent
    pub deadline: Option<Instant>,
    /// set when the user interrupts
    pub interrupt: &'a AtomicBool,
    /// called with every run before it is made: its number, the number of all, and what it is
    pub on_run: &'a (dyn Fn(usize, usize, &str) + Sync),
}

/// How a run ended, if the user did not interrupt it.
enum RunEnd {
    Done(Box<SweepResult>),
    /// the budget was spent at this time [s] of the run, where it is saved
    OutOfTime(f64),
}

impl SweepRunner<'_> {
    /// Makes every run of the share that is not finished. Returns why runs were left out, by identifier.
    ///
    /// # Errors
    /// An interrupt, another case than the plan's, or files that cannot be read or written.
    pub fn run(&self) -> Result<BTreeMap<String, String>, StudyError> {
        let mut wanted = Vec::new();
        for job in self.plan.jobs.iter().filter(|job| self.shard.is_none_or(|shard| shard.has(job.run))) {
            if self.store.measured(job)?.is_none() {
                wanted.push(job);
            }
        }
        if wanted.is_empty() {
            return Ok(BTreeMap::new());
        }
        let base = self.plan.base()?;
        let (next, left, failed) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()), Mutex::new(None));
        let work = || {
            while let Some(job) = wanted.get(next.fetch_add(1, Ordering::Relaxed)) {
                match self.make(&base, job) {
                    Ok(None) => {}
                    Ok(Some(why)) => {
                        left.lock().unwrap_or_else(PoisonError::into_inner).insert(job.id.clone(), why);
                    }
                    Err(error) => {
                        // The others finish their runs and take no more.
                        next.store(wanted.len(), Ordering::Relaxed);
                        failed.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                    }
                }
            }
        };
        std::thread::scope(|scope| {
            (1..self.threads.min(wanted.len())).for_each(|_| {
                scope.spawn(work);
            });
            work();
        });
        match failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(error) => Err(error),
            None => Ok(left.into_inner().unwrap_or_else(PoisonError::into_inner)),
        }
    }

    /// Makes one run and stores its result; returns why it was left out.
    fn make(&self, base: &Case, job: &SweepJob) -> Result<Option<String>, StudyError> {
        if self.interrupt.load(Ordering::Relaxed) {
            return Err(StudyError::Interrupted);
        }
        if self.deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            return Ok(Some("the budget was spent before it; run the sweep again to go on".to_owned()));
        }
        (self.on_run)(job.run + 1, self.plan.jobs.len(), &job.described());
        match self.measure(base, job)? {
            RunEnd::OutOfTime(t) => {
                Ok(Some(format!("the budget was spent at t = {t:.3e} s of it; run the sweep again to go on")))
            }
            RunEnd::Done(result) => self.store.keep_measured(job, &*result).map(|()| None),
        }
    }

    /// Makes a run, from where an earlier process left it.
    fn measure(&self, base: &Case, job: &SweepJob) -> Result<RunEnd, StudyError> {
        let mut problem = base.with(&job.overrides())?.into_problem();
        if fingerprint_of(&problem)?.digest() != job.case_digest {
            let difference = format!("a file that its case names is not what it was, with {}", job.described());
            return Err(StudyError::OtherStudy { folder: self.store.plan_path(), difference });
        }
        let scene = match build_scene(problem.take_system(), 1) {
            Ok(scene) => scene,
            Err(why @ SetupError::Threads(_)) => return Err(why.into()),
            Err(why) => return Ok(refused(why.to_string())),
        };
        let experiment = Experiment {
            frames_every: problem.output.frames_every,
            explain: Explain::Failures,
            interrupt: Stop::on(self.interrupt),
            ..Experiment::new(&*scene, &problem.method, problem.solver, problem.time.step, problem.time.end)
        };
        let mut stepper = match experiment.stepper() {
            Ok(stepper) => stepper,
            Err(why) => return Ok(refused(why.to_string())),
        };
        let earlier: Option<Unfinished<LargestSoFar>> = self.store.unfinished(job);
        let spent = earlier.as_ref().map_or(0.0, |earlier| earlier.spent);
        let before = Cost { cpu: (spent > 0.0).then_some(spent), wall: Duration::from_secs_f64(spent) };
        let stop = AtomicBool::new(false);
        let so_far = earlier.as_ref().map(|earlier| &earlier.measured);
        let largest = LargestValues::new(&*scene, &problem.output, problem.time.end, so_far)
            .map_err(|why| StudyError::Usage(why.to_string()))?;
        let mut watcher = Watcher {
            runner: self,
            job,
            largest,
            keeper: Keeper::new(scene.n_dof(), self.interrupt, self.deadline),
            watch: Stopwatch::of_thread(before),
            stop: &stop,
        };
        let mut farthest = MaxDisplacement::new(&*scene);
        let start = earlier.map_or(Start::Initial, |earlier| Start::Snapshot(Box::new(earlier.snapshot)));
        let run = experiment.observed(&mut stepper, start, &mut [&mut watcher, &mut farthest], &stop);
        let Watcher { largest, keeper, watch, .. } = watcher;
        let seconds = watch.seconds();
        keeper.done()?;
        let outcome = match run {
            Ok(outcome) => outcome,
            Err(RunError::Start(why)) => return Ok(refused(why.to_string())),
            Err(why) => return Err(StudyError::Usage(format!("{}: {why}", job.id))),
        };
        // A failure whose cause was not searched to the end is not a result yet.
        if self.interrupt.load(Ordering::Relaxed) && outcome.status != Status::Completed {
            return Err(StudyError::Interrupted);
        }
        if outcome.status == Status::Interrupted {
            return Ok(RunEnd::OutOfTime(outcome.t_end));
        }
        let result = SweepResult::of(measured(&outcome, None, seconds), &largest, farthest.found.distance);
        let completed = result.status == RowStatus::Completed && !problem.output.quantities.is_empty();
        let asked: Vec<_> = largest.quantities().into_iter().filter(|quantity| completed && quantity.wanted).collect();
        let (quantities, mass_scaling) = (MeasuredQuantity::reports(&asked), scene.added_mass());
        Ok(RunEnd::Done(Box::new(SweepResult { quantities, mass_scaling, ..result })))
    }
}

impl SweepResult {
    /// Values are those of runs that reached their end: the others have only their cost.
    fn of(run: RunResult, largest: &LargestValues<'_>, farthest: f64) -> Self {
        let RunResult { status, note, energy_error, repeats, steps, rejected_steps, t_end, counters, .. } = run;
        let completed = status == RowStatus::Completed;
        let so_far = largest.so_far();
        let value = |x: f64| Some(x).filter(|x| completed && x.is_finite());
        SweepResult {
            status,
            note,
            displacement_end: value(farthest),
            max_speed: value(so_far.speed),
            max_strain: value(so_far.strain),
            energy_error: energy_error.filter(|_| completed),
            cpu_seconds: repeats.first().copied(),
            steps,
            rejected_steps,
            t_end,
            counters,
            peaks: if completed { largest.peaks() } else { Vec::new() },
            quantities: QuantityReports::new(),
            mass_scaling: None,
        }
    }
}

fn refused(note: String) -> RunEnd {
    RunEnd::Done(Box::new(SweepResult { status: RowStatus::Refused, note, ..SweepResult::default() }))
}

/// The observer of a run: measures, and saves the run where it may stop.
struct Watcher<'a, 's> {
    runner: &'a SweepRunner<'a>,
    job: &'a SweepJob,
    largest: LargestValues<'s>,
    keeper: Keeper<'a>,
    watch: Stopwatch,
    stop: &'a AtomicBool,
}

impl Observer for Watcher<'_, '_> {
    fn started(&mut self, at: &Point, ledger: Energies) -> Result<(), ObserveError> {
        self.largest.started(at, ledger)
    }

    fn resumed(&mut self, at: &Point, ledger: Energies) -> Result<(), ObserveError> {
        self.largest.resumed(at, ledger)
    }

    fn resumable(&mut self, run: &Resumable<'_>) -> Result<(), ObserveError> {
        let Self { runner, job, largest, watch, .. } = self;
        let course = self.keeper.goes_on(run.occasion, || {
            let unfinished =
                Unfinished { snapshot: run.snapshot(), measured: largest.so_far(), spent: watch.seconds() };
            runner.store.keep_unfinished(job, &unfinished)
        });
        if course == Course::Ends {
            self.stop.store(true, Ordering::Relaxed);
        }
        Ok(())
    }

    fn wants(&self, step: UpcomingStep) -> Wants {
        self.largest.wants(step)
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        // A case without frames has no other place where it is seen.
        if self.runner.interrupt.load(Ordering::Relaxed) {
            self.stop.store(true, Ordering::Relaxed);
        }
        self.largest.accepted(step)
    }

    fn failed(&mut self) -> Result<(), ObserveError> {
        self.largest.failed()
    }

    fn finished(&mut self, last: &Point) -> Result<(), ObserveError> {
        self.largest.finished(last)
    }
}

/// What came of all runs so far; `left` says why some were left out.
///
/// # Errors
/// Files that cannot be read.
pub fn rows_of(
    plan: &SweepPlan,
    store: &Store<SweepPlan>,
    left: &BTreeMap<String, String>,
) -> Result<Vec<SweepRow>, StudyError> {
    let row = |job: &SweepJob| {
        let not_run = || SweepResult { note: left.get(&job.id).cloned().unwrap_or_default(), ..SweepResult::default() };
        Ok(SweepRow { job: job.clone(), result: store.measured(job)?.unwrap_or_else(not_run) })
    };
    plan.jobs.iter().map(row).collect()
}
