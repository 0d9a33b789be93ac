//! Makes the runs of a study, or a share of them, and gathers the results of all of them.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::error::StudyError;
use super::models::{Model, problem_of};
use super::pareto::mark_front;
use super::plan::{Plan, Variant};
use super::prepared_case::{PreparedCase, choice};
use super::ranking::Ranking;
use super::reference::Reference;
use super::row::{Job, Row, RowStatus, RunResult, StepSetting, median};
use super::store::Store;
use crate::case::Case;
use crate::format_number::figures;

/// A share of the runs: number `part` of `of`, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// which one, from 1
    pub part: usize,
    /// how many there are
    pub of: usize,
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |word: &str| word.trim().parse::<usize>().ok();
        let parts = text.split_once('/').and_then(|(part, of)| Some((number(part)?, number(of)?)));
        match parts {
            Some((part, of)) if (1..=of).contains(&part) => Ok(Shard { part, of }),
            _ => Err("expected I/N with I from 1 to N, such as 3/8".to_owned()),
        }
    }
}

impl Shard {
    /// Whether run `number`, from 0, belongs to this share.
    pub(super) fn has(self, number: usize) -> bool {
        number % self.of == self.part - 1
    }
}

/// A study with what came of its runs so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// the plan
    pub plan: Plan,
    /// all runs, in the plan's order
    pub rows: Vec<Row>,
}

/// A variant of the case, ready to run.
pub(super) struct PreparedVariant {
    pub case: PreparedCase,
    pub reference: Reference,
    /// when its share of the budget is spent
    pub deadline: Option<Instant>,
}

/// How a run ended, if the user did not interrupt it.
pub(super) enum RunEnd {
    Done(Box<RunResult>),
    /// the budget was spent at this time [s] of the run, where it is saved
    OutOfTime(f64),
}

/// Makes runs.
pub struct Runner<'a> {
    /// what is to be done
    pub plan: &'a Plan,
    /// where it goes
    pub store: &'a Store,
    /// the share that is made; `None`: all
    pub shard: Option<Shard>,
    /// threads of the force passes
    pub threads: usize,
    /// when the budget is spent
    pub deadline: Option<Instant>,
    /// set when the user interrupts
    pub interrupt: &'a AtomicBool,
    /// called with every run before it is made: its number, the number of all, and what it is
    pub on_run: &'a dyn Fn(usize, usize, &str),
}

impl Runner<'_> {
    /// Makes every run of the share that is not finished: for each variant all of them once, then again for the
    /// repeats. Returns why runs were left out, by identifier.
    ///
    /// # Errors
    /// An interrupt, another case than the plan's, or files that cannot be written.
    pub fn run(&self) -> Result<BTreeMap<String, String>, StudyError> {
        let mut left = BTreeMap::new();
        let variants = self.plan.variants.len();
        for number in 0..variants {
            // The rest of the budget is divided among the remaining variants.
            let now = Instant::now();
            let share = |deadline: Instant| now + deadline.saturating_duration_since(now) / (variants - number) as u32;
            self.run_variant(number, self.deadline.map(share), &mut left)?;
        }
        Ok(left)
    }

    fn run_variant(
        &self,
        variant: usize,
        deadline: Option<Instant>,
        left: &mut BTreeMap<String, String>,
    ) -> Result<(), StudyError> {
        let mut prepared: BTreeMap<Option<Model>, PreparedVariant> = BTreeMap::new();
        for pass in 0..self.plan.asked.repeat as usize {
            for (number, job) in self.plan.jobs.iter().enumerate().filter(|(_, job)| job.variant == variant) {
                if self.shard.is_some_and(|shard| !shard.has(number)) || left.contains_key(&job.id) {
                    continue;
                }
                let known = self.store.measured(job)?;
                let enough = |m: &RunResult| m.repeats.len() > pass || m.status != RowStatus::Completed;
                if known.as_ref().is_some_and(enough) {
                    continue;
                }
                if let Some(why) = self.too_long(deadline, job, known.as_ref())? {
                    left.insert(job.id.clone(), why);
                    continue;
                }
                let prepared = match prepared.entry(job.model) {
                    Entry::Occupied(known) => known.into_mut(),
                    Entry::Vacant(free) => free.insert(self.prepare(variant, job.model, deadline)?),
                };
                (self.on_run)(number + 1, self.plan.jobs.len(), &described(job, pass, self.plan));
                if self.interrupt.load(Ordering::Relaxed) {
                    return Err(StudyError::Interrupted);
                }
                match self.measure(prepared, job)? {
                    RunEnd::OutOfTime(t) => {
                        let why = format!("the budget was spent at t = {t:.3e} s of it; run the study again to go on");
                        left.insert(job.id.clone(), why);
                    }
                    RunEnd::Done(mut measured) => {
                        measured.repeats.splice(0..0, known.map(|known| known.repeats).unwrap_or_default());
                        self.store.keep_measured(job, &measured)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Builds the scene of a variant, as a model, and reads the reference.
    fn prepare(
        &self,
        number: usize,
        model: Option<Model>,
        deadline: Option<Instant>,
    ) -> Result<PreparedVariant, StudyError> {
        let folder = self.store.plan_path();
        let variant = self.plan.variants.get(number).ok_or_else(|| Store::<Plan>::no_plan(&folder))?;
        let case = self.plan.case()?.with(&variant.overrides)?;
        let prepared = PreparedCase::of(problem_of(&case, model)?, self.threads)?;
        if let Some(differences) = variant.fingerprint_of(model).differences(&prepared.fingerprint) {
            return Err(StudyError::OtherStudy { folder, difference: differences.to_string() });
        }
        Ok(PreparedVariant { case: prepared, reference: self.store.reference(number)?, deadline })
    }

    /// Why a run is not begun: its cost, predicted from earlier runs, exceeds the rest of the budget.
    fn too_long(
        &self,
        deadline: Option<Instant>,
        job: &Job,
        known: Option<&RunResult>,
    ) -> Result<Option<String>, StudyError> {
        let Some(deadline) = deadline else { return Ok(None) };
        let left = deadline.saturating_duration_since(Instant::now()).as_secs_f64();
        let predicted = match known.and_then(|m| median(&m.repeats)) {
            Some(seconds) => Some(seconds),
            None => self.predicted(job)?,
        };
        Ok(match predicted {
            _ if left == 0.0 => Some("the budget was spent before it; run the study again to go on".to_owned()),
            Some(seconds) if seconds > left => Some(format!(
                "it takes about {seconds:.2} s and {left:.2} s of the budget were left; run the study again to go on"
            )),
            _ => None,
        })
    }

    /// [s] Predicted from the finished run of the same method with the nearest step.
    fn predicted(&self, job: &Job) -> Result<Option<f64>, StudyError> {
        let order = f64::from(choice(&job.method)?.order());
        let mut nearest: Option<(f64, f64)> = None;
        let alike = |o: &&Job| (o.variant, o.model) == (job.variant, job.model) && o.method == job.method;
        for other in self.plan.jobs.iter().filter(alike) {
            let more = match (job.setting, other.setting) {
                (StepSetting::Step(h), StepSetting::Step(other)) => other / h,
                (StepSetting::Tolerance(t), StepSetting::Tolerance(other)) => (other / t).powf(1.0 / order),
                _ => continue,
            };
            let Some(found) = self.store.measured(other)?.filter(|m| m.status == RowStatus::Completed) else {
                continue;
            };
            let Some(seconds) = median(&found.repeats) else { continue };
            if nearest.is_none_or(|(least, _)| more.ln().abs() < least) {
                nearest = Some((more.ln().abs(), seconds * more));
            }
        }
        Ok(nearest.map(|(_, seconds)| seconds))
    }
}

impl Plan {
    /// The case of the study.
    ///
    /// # Errors
    /// Those of a case; only where the files it names have changed.
    pub fn case(&self) -> Result<Case, StudyError> {
        let base = Path::new(&self.case_file).parent().unwrap_or(Path::new("")).to_owned();
        Ok(Case::from_text(self.case.to_string(), &self.case_file, base, &[])?)
    }

    /// The variant of a run.
    pub fn variant_of(&self, job: &Job) -> Option<&Variant> {
        self.variants.get(job.variant)
    }
}

fn described(job: &Job, pass: usize, plan: &Plan) -> String {
    let what = match job.setting {
        StepSetting::Step(h) => format!("step {} s", figures(h, 5)),
        StepSetting::Tolerance(t) => format!("tolerance {t:e}"),
    };
    let stiff = plan.variant_of(job).map_or(1.0, |v| v.stiffness_factor);
    let stiff = if stiff == 1.0 { String::new() } else { format!(", {stiff} times as stiff") };
    let again = if pass == 0 { String::new() } else { format!(", repeat {}", pass + 1) };
    format!("{}, {what}{stiff}{again}", job.label())
}

/// What came of all runs so far; `left` says why some were left out.
///
/// # Errors
/// Files that cannot be read.
pub fn rows_of(plan: &Plan, store: &Store, left: &BTreeMap<String, String>) -> Result<Vec<Row>, StudyError> {
    let mut rows = Vec::with_capacity(plan.jobs.len());
    for job in &plan.jobs {
        let family = choice(&job.method)?.info.family;
        let not_run = || RunResult { note: left.get(&job.id).cloned().unwrap_or_default(), ..RunResult::default() };
        let measured = store.measured(job)?.unwrap_or_else(not_run);
        let cpu_seconds = median(&measured.repeats).filter(|_| measured.status != RowStatus::Refused);
        rows.push(Row { job: job.clone(), family, measured, cpu_seconds, pareto: false });
    }
    for number in 0..plan.variants.len() {
        mark_front(&mut rows, number, &Ranking::of(plan, number));
    }
    Ok(rows)
}
