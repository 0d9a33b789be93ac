//! Makes the runs of the study, several at the same time, and gathers their results.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::change::changed;
use super::compare::Number;
use super::plan::{RequireJob, RequirePlan};
use crate::case::{Case, Problem};
use crate::error::StudyError;
use crate::integrate::Counters;
use crate::output::gauges::names::without_rule;
use crate::planned_runs::PlannedRuns;
use crate::row::{RowStatus, RunResult};
use crate::saved_run::{Measured, SavedEnd};
use crate::store::Store;

/// What came of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RequireResult {
    /// how it ended
    pub status: RowStatus,
    /// why, and what to do, if not well
    pub note: String,
    /// [s] processor time, for information
    pub cpu_seconds: Option<f64>,
    /// [s] counted work at nominal costs, the same on every machine: what decides
    #[serde(default)]
    pub work: Option<f64>,
    /// accepted steps
    pub steps: u64,
    /// attempts of adaptive steps that were dropped
    pub rejected_steps: u64,
    /// [s] time it came to
    pub t_end: f64,
    /// counted work
    #[serde(flatten)]
    pub counters: Counters,
    /// the quantities that have a value, where it reached its end
    pub numbers: Vec<Number>,
}

/// A run and what came of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RequireRow {
    /// the run
    #[serde(flatten)]
    pub job: RequireJob,
    /// what came of it
    #[serde(flatten)]
    pub result: RequireResult,
}

/// Makes the runs of a study of requirements.
pub type RequireRunner<'a> = PlannedRuns<'a, RequirePlan>;

impl RequireRunner<'_> {
    /// Makes the planned runs that are not finished: those of the full model and of simpler ones, or the finer ones.
    /// Returns why runs were left out, by identifier.
    ///
    /// # Errors
    /// An interrupt, another case than the plan's, or files that cannot be read or written.
    pub fn run(&self, base: &Case, finer: bool) -> Result<BTreeMap<String, String>, StudyError> {
        let wanted: Vec<&RequireJob> = self.share().filter(|job| job.finer() == finer).collect();
        self.each(&wanted, |job| self.make_if_new(job, || Ok(changed(base, &job.variants)?.into_problem())))
    }

    /// Makes one run with this data, unless it is finished, and stores its result; returns why it was left out.
    fn make_if_new(
        &self,
        job: &RequireJob,
        problem: impl FnOnce() -> Result<Problem, StudyError>,
    ) -> Result<Option<String>, StudyError> {
        if self.store.measured(job)?.is_some() {
            return Ok(None);
        }
        let refused = |note: String| RequireResult { status: RowStatus::Refused, note, ..RequireResult::default() };
        let case = || match &job.refused {
            Some(why) => Ok(Err(refused(why.clone()))),
            None => problem().map(Ok),
        };
        self.make(job, case, |end| match end {
            Ok(SavedEnd::Done(measured)) => Ok(Ok(RequireResult::of(*measured))),
            Ok(SavedEnd::Refused(why)) => Ok(Ok(refused(why))),
            Ok(SavedEnd::OutOfTime(t)) => Ok(Err(t)),
            // A part that is left out may be the one that a quantity is of.
            Err(StudyError::Usage(why)) if !job.variants.is_empty() => Ok(Ok(refused(why))),
            Err(error) => Err(error),
        })
    }

    /// A run and what came of it, made if it is not finished.
    ///
    /// # Errors
    /// As [`RequireRunner::run`].
    pub(super) fn row(&self, base: &Case, job: RequireJob) -> Result<RequireRow, StudyError> {
        let left = self.make_if_new(&job, || Ok(changed(base, &job.variants)?.into_problem()))?;
        row_of(self.store, job, left)
    }

    /// The same with the data of the run, whose case is not one of the plan.
    ///
    /// # Errors
    /// As [`RequireRunner::run`].
    pub(super) fn row_as(&self, job: RequireJob, problem: Problem) -> Result<RequireRow, StudyError> {
        let left = self.make_if_new(&job, || Ok(problem))?;
        row_of(self.store, job, left)
    }
}

impl RequireResult {
    fn of(measured: Measured) -> Self {
        let Measured { run, quantities, work, .. } = measured;
        let RunResult { status, note, repeats, steps, rejected_steps, t_end, counters, .. } = run;
        let wanted = quantities.into_iter().filter(|quantity| quantity.wanted && status == RowStatus::Completed);
        RequireResult {
            status,
            note,
            cpu_seconds: repeats.first().copied(),
            work: Some(work),
            steps,
            rejected_steps,
            t_end,
            counters,
            numbers: wanted.map(Number::from).filter(|number| number.value.is_some()).collect(),
        }
    }

    /// Whether it reached its end.
    pub fn completed(&self) -> bool {
        self.status == RowStatus::Completed
    }

    /// A quantity. Lines without a gauge are named after the number of their rule, which may be another one here.
    pub fn number(&self, name: &str) -> Option<&Number> {
        let exact = self.numbers.iter().find(|number| number.name == name);
        exact.or_else(|| {
            let mut alike = self.numbers.iter().filter(|number| without_rule(&number.name) == without_rule(name));
            alike.next().filter(|_| alike.next().is_none() && without_rule(name) != name)
        })
    }
}

fn row_of(store: &Store<RequirePlan>, job: RequireJob, left: Option<String>) -> Result<RequireRow, StudyError> {
    let not_run = || RequireResult { note: left.unwrap_or_default(), ..RequireResult::default() };
    Ok(RequireRow { result: store.measured(&job)?.unwrap_or_else(not_run), job })
}

/// What came of all planned runs so far; `left` says why some were left out.
///
/// # Errors
/// Files that cannot be read.
pub fn rows_of(
    plan: &RequirePlan,
    store: &Store<RequirePlan>,
    left: &BTreeMap<String, String>,
) -> Result<Vec<RequireRow>, StudyError> {
    plan.jobs.iter().map(|job| row_of(store, job.clone(), left.get(&job.id).cloned())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_found_under_another_number_of_their_rule() {
        let number = |name: &str| Number { name: name.to_owned(), ..Number::default() };
        let with = |names: &[&str]| RequireResult {
            numbers: names.iter().map(|name| number(name)).collect(),
            ..RequireResult::default()
        };
        let found = |names: &[&str], name: &str| with(names).number(name).map(|number| number.name.clone());
        let [old, new, other] = ["springs[5] lines.peak", "springs[4] lines.peak", "springs[2] lines.peak"];
        assert_eq!(found(&[new, "riser.peak"], old).as_deref(), Some(new));
        assert_eq!(found(&[new, old], old).as_deref(), Some(old));
        assert_eq!(found(&[new, other], old), None, "one of two is not known");
        assert_eq!(found(&["lines.peak"], "riser.peak"), None);
    }
}
