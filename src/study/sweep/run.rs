//! Makes the runs of a sweep, several at the same time, and gathers their results.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::plan::{SweepJob, SweepPlan};
use super::result::SweepResult;
use crate::case::Case;
use crate::error::StudyError;
use crate::output::gauges::MeasuredQuantity;
use crate::prepared_case::fingerprint_of;
use crate::row::{RowStatus, RunResult};
use crate::runner::Shard;
use crate::saved_run::{Measured, SavedEnd, SavedRun, each};
use crate::store::Store;

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
        let (base, left) = (self.plan.base()?, Mutex::new(BTreeMap::new()));
        each(&wanted, self.threads, |job| {
            if let Some(why) = self.make(&base, job)? {
                left.lock().unwrap_or_else(PoisonError::into_inner).insert(job.id.clone(), why);
            }
            Ok(())
        })?;
        Ok(left.into_inner().unwrap_or_else(PoisonError::into_inner))
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
        let problem = base.with(&job.overrides())?.into_problem();
        if fingerprint_of(&problem)?.digest() != job.case_digest {
            let difference = format!("a file that its case names is not what it was, with {}", job.described());
            return Err(StudyError::OtherStudy { folder: self.store.plan_path(), difference });
        }
        let &SweepRunner { store, deadline, interrupt, .. } = self;
        let asked = !problem.output.quantities.is_empty();
        let result = match (SavedRun { store, job, deadline, interrupt }).make(problem)? {
            SavedEnd::OutOfTime(t) => {
                let why = format!("the budget was spent at t = {t:.3e} s of it; run the sweep again to go on");
                return Ok(Some(why));
            }
            SavedEnd::Refused(note) => SweepResult { status: RowStatus::Refused, note, ..SweepResult::default() },
            SavedEnd::Done(measured) => SweepResult::of(*measured, asked),
        };
        self.store.keep_measured(job, &result).map(|()| None)
    }
}

impl SweepResult {
    /// Values are those of runs that reached their end: the others have only their cost. `asked` says whether
    /// quantities are asked for.
    fn of(measured: Measured, asked: bool) -> Self {
        let Measured { run, max_speed, max_strain, displacement_end, peaks, quantities, mass_scaling, .. } = measured;
        let RunResult { status, note, energy_error, repeats, steps, rejected_steps, t_end, counters, .. } = run;
        let completed = status == RowStatus::Completed;
        let shown: Vec<_> = quantities.into_iter().filter(|one| completed && asked && one.wanted).collect();
        let value = |x: f64| Some(x).filter(|x| completed && x.is_finite());
        SweepResult {
            status,
            note,
            displacement_end: value(displacement_end),
            max_speed: value(max_speed),
            max_strain: value(max_strain),
            energy_error: energy_error.filter(|_| completed),
            cpu_seconds: repeats.first().copied(),
            steps,
            rejected_steps,
            t_end,
            counters,
            peaks: if completed { peaks } else { Vec::new() },
            quantities: MeasuredQuantity::reports(&shown),
            mass_scaling,
        }
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
