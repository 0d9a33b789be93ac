//! Makes the runs of a sweep, several at the same time, and gathers their results.

use std::cell::Cell;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::plan::{SweepJob, SweepPlan};
use super::result::SweepResult;
use super::sample::Sampled;
use super::sample::scatter::until;
use crate::error::StudyError;
use crate::output::gauges::MeasuredQuantity;
use crate::planned_runs::PlannedRuns;
use crate::row::{RowStatus, RunResult};
use crate::saved_run::{Measured, SavedEnd};
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

/// Makes the runs of a sweep.
pub type SweepRunner<'a> = PlannedRuns<'a, SweepPlan>;

impl SweepRunner<'_> {
    /// Makes every run of the share that is not finished. A rule that ends a sample is looked at after every batch of
    /// rows, unless this is a share: shares do not know of each other's results. Returns why runs were left out, by
    /// identifier.
    ///
    /// # Errors
    /// An interrupt, another case than the plan's, or files that cannot be read or written.
    pub fn run(&self) -> Result<BTreeMap<String, String>, StudyError> {
        match &self.plan.sampled {
            Some(sampled) if sampled.until.is_some() && self.shard.is_none() => self.in_batches(sampled),
            _ => self.jobs(self.share()),
        }
    }

    fn in_batches(&self, sampled: &Sampled) -> Result<BTreeMap<String, String>, StudyError> {
        let (rows, beside) = self.plan.jobs.split_at(self.plan.rows());
        let mut made: Vec<SweepRow> = Vec::new();
        for end in sampled.batches() {
            let batch = rows.get(made.len()..end).unwrap_or_default();
            let left = self.jobs(batch.iter())?;
            if !left.is_empty() {
                return Ok(left);
            }
            for job in batch {
                made.push(row_of(self.store, job, &left)?);
            }
            if until(sampled, &made)?.is_some_and(|until| until.met) {
                break;
            }
        }
        self.jobs(beside.iter())
    }

    fn jobs<'j>(&self, jobs: impl Iterator<Item = &'j SweepJob>) -> Result<BTreeMap<String, String>, StudyError> {
        let mut wanted = Vec::new();
        for job in jobs {
            if self.store.measured(job)?.is_none() {
                wanted.push(job);
            }
        }
        if wanted.is_empty() {
            return Ok(BTreeMap::new());
        }
        let base = self.plan.base()?;
        self.each(&wanted, |job| {
            let asked = Cell::new(false);
            let problem = || {
                let problem = base.with(&job.overrides())?.into_problem();
                asked.set(!problem.output.quantities.is_empty());
                Ok(Ok(problem))
            };
            self.make(job, problem, |end| SweepResult::of_end(end?, asked.get()))
        })
    }
}

impl SweepResult {
    /// The result of a run, or the time [s] of it at which the budget was spent.
    fn of_end(end: SavedEnd, asked: bool) -> Result<Result<Self, f64>, StudyError> {
        Ok(match end {
            SavedEnd::OutOfTime(t) => Err(t),
            SavedEnd::Refused(note) => Ok(SweepResult { status: RowStatus::Refused, note, ..SweepResult::default() }),
            SavedEnd::Done(measured) => Ok(SweepResult::of(*measured, asked)),
        })
    }

    /// Values are those of runs that reached their end: the others have only their cost. `asked` says whether
    /// quantities are asked for.
    fn of(measured: Measured, asked: bool) -> Self {
        let Measured { run, max_speed, max_strain, displacement_end, peaks, quantities, mass_scaling, .. } = measured;
        let RunResult { status, note, energy_error, repeats, steps, rejected_steps, t_end, counters, .. } = run;
        let completed = status == RowStatus::Completed;
        let shows = |one: &MeasuredQuantity| completed && (asked && one.wanted || one.is_of_landing());
        let shown: Vec<_> = quantities.into_iter().filter(shows).collect();
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
    plan.jobs.iter().map(|job| row_of(store, job, left)).collect()
}

fn row_of(store: &Store<SweepPlan>, job: &SweepJob, left: &BTreeMap<String, String>) -> Result<SweepRow, StudyError> {
    let not_run = || SweepResult { note: left.get(&job.id).cloned().unwrap_or_default(), ..SweepResult::default() };
    Ok(SweepRow { job: job.clone(), result: store.measured(job)?.unwrap_or_else(not_run) })
}
