//! `canopy-fem tradeoff`: what accuracy costs, on the user's own scene.

use super::case_args::Threads;
use super::interrupt::stop_on_interrupt;
use super::study::{Budget, CaseFile, ProgressLine, StudyArgs, nothing_lost, typed};
use super::{CliError, CommandOutput, complain};
use crate::case::Case;
use crate::study::difference::differences;
use crate::study::options::{StudyOptions, TypedOptions};
use crate::study::plan::{Plan, Planner};
use crate::study::prepared_case::fingerprint_of;
use crate::study::recommendations::Recommendations;
use crate::study::reference::ALLOWANCE;
use crate::study::report::{self, Rerun};
use crate::study::row::RowStatus;
use crate::study::store::Store;
use crate::study::{Runner, Study, StudyError, rows_of};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// [s] Default budget of a study on one machine.
const BUDGET: f64 = 120.0;
/// Share of a budget that the references may take, in nominal costs.
const FOR_REFERENCES: f64 = 0.5;

/// `tradeoff`.
#[derive(Clone, Debug, clap::Args)]
pub struct TradeoffArgs {
    /// case, folder and shares
    #[command(flatten)]
    pub study: StudyArgs,
    /// what to try
    #[command(flatten)]
    pub options: TypedOptions,
    /// threads
    #[command(flatten)]
    pub threads: Threads,
}

pub(super) fn run(args: &TradeoffArgs) -> Result<CommandOutput, CliError> {
    let (case, out) = args.study.case_and_folder()?;
    let command = Command { args, out, stop: stop_on_interrupt(), started: Instant::now() };
    command.run(case)
}

struct Command<'a> {
    args: &'a TradeoffArgs,
    out: PathBuf,
    stop: &'static AtomicBool,
    started: Instant,
}

impl Command<'_> {
    fn run(&self, case: Option<CaseFile<'_>>) -> Result<CommandOutput, CliError> {
        let asked = &self.args.study;
        let store = Store::<Plan>::in_folder(&self.out);
        if asked.force {
            store.clear()?;
            report::clear(&self.out)?;
        }
        let line = ProgressLine::new(asked.print.quiet);
        let known = store.plan()?;
        let plan = match (known, case) {
            (Some(plan), Some((path, case))) => {
                self.same(&plan, path, &case)?;
                plan
            }
            (Some(plan), None) => plan,
            (None, Some((path, case))) if !asked.follows_a_plan() => {
                nothing_lost(&self.out, &report::FILES)?;
                self.plan(path, &case, &store, &line)?
            }
            (None, _) => return Err(Store::<Plan>::no_plan(&self.out).into()),
        };
        if asked.plan {
            return Ok(done(asked.unless_quiet(report::planned(&plan, &store)?)));
        }
        let merged = asked.merge_into(&store, &plan)?;
        let left = if merged { BTreeMap::new() } else { self.make_runs(&plan, &store, &line)? };
        line.bar.finish_and_clear();
        let rows = rows_of(&plan, &store, &left)?;
        if let Some(shard) = asked.shard {
            let finished = rows.iter().filter(|r| r.measured.status != RowStatus::NotRun).count();
            return Ok(done(asked.shard_done(shard, finished, rows.len(), &self.out)));
        }
        let answers = Recommendations::of(&plan, &rows)?;
        let study = Study { plan, rows };
        let here = Rerun::here(typed());
        // To repeat a study one needs the command that planned it, not the one that merged its parts.
        let command = if study.plan.command.is_empty() { here.command } else { study.plan.command.clone() };
        let how = Rerun { command, ..here };
        let files = report::write(&self.out, &study, &answers, &how)?;
        let text = report::summary(&study, &answers, &files)?;
        Ok(done(asked.printed(text, &self.out.join("tradeoff.json"))?))
    }

    fn options(&self, case: &Case) -> Result<StudyOptions, StudyError> {
        StudyOptions::of(&self.args.options, case.file().study.as_ref())
    }

    /// [s] time limit of the study
    fn budget(&self, section: Option<f64>) -> Budget {
        let shared = self.args.study.plan || self.args.study.shard.is_some();
        let default = section.or((!shared).then_some(BUDGET)).map_or(Budget::Unlimited, Budget::Seconds);
        self.args.study.budget.unwrap_or(default)
    }

    fn plan(&self, path: &Path, case: &Case, store: &Store, line: &ProgressLine) -> Result<Plan, CliError> {
        self.args.study.warn(case);
        if case.problem().time.to_ground && !self.args.study.print.quiet {
            complain(
                "note: these runs go on to time.end, since all of them are compared with the reference at the same \
                 times; their landing.* numbers are those at the ground",
            );
        }
        let options = self.options(case)?;
        let section = case.file().study.as_ref().and_then(|study| study.budget_seconds);
        let references = options.stiffness_sweep.len().max(options.models.len()).max(1) as f64;
        let allowance = match self.budget(section) {
            Budget::Seconds(budget) => FOR_REFERENCES * budget / references,
            Budget::Unlimited => ALLOWANCE,
        };
        let planner = Planner {
            case,
            case_file: path,
            options,
            command: Rerun::here(typed()).command,
            threads: self.args.threads.get(),
            allowance,
            stop: self.stop,
            tell: &|what| line.tell(what),
        };
        let plan = planner.make(|variant, reference| store.keep_reference(variant, reference))?;
        store.keep_plan(&plan)?;
        Ok(plan)
    }

    /// Refuses a folder with the study of another case or with other options.
    fn same(&self, plan: &Plan, path: &Path, case: &Case) -> Result<(), StudyError> {
        let other = |difference: String| StudyError::OtherStudy { folder: self.out.clone(), difference };
        if plan.case != case.problem().case_json {
            let keys = differences(&plan.case, &case.problem().case_json);
            return Err(other(format!("its case is not {} as given now: {keys}", path.display())));
        }
        // The files that the case names may have changed, although the case has not. One variant is enough: the others
        // differ in stiffness only.
        if let Some(variant) = plan.variants.first() {
            let now = fingerprint_of(case.with(&variant.overrides)?.problem())?;
            if let Some(differences) = variant.fingerprint.differences(&now) {
                return Err(other(differences.to_string()));
            }
        }
        // A shard or a merge follows the plan and its options.
        if !self.args.study.follows_a_plan() && plan.asked != self.options(case)? {
            return Err(other(
                "other methods, steps, tolerances, repeats, stiffnesses or models were asked for".to_owned(),
            ));
        }
        Ok(())
    }

    fn make_runs(
        &self,
        plan: &Plan,
        store: &Store,
        line: &ProgressLine,
    ) -> Result<BTreeMap<String, String>, StudyError> {
        let section = plan.case.pointer("/study/budget_seconds").and_then(serde_json::Value::as_f64);
        let runner = Runner {
            plan,
            store,
            shard: self.args.study.shard,
            threads: self.args.threads.get(),
            deadline: self.budget(section).deadline(self.started),
            interrupt: self.stop,
            on_run: &|number, all, what| line.run(number, all, what),
        };
        runner.run()
    }
}

fn done(text: String) -> CommandOutput {
    CommandOutput { text, code: 0 }
}
