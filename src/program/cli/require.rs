//! `canopy-fem require`: what each part of a model does to the quantities of interest, and what it costs.

use super::interrupt::stop_on_interrupt;
use super::study::{Budget, CaseFile, ProgressLine, StudyArgs, plan_of, runs_at_once, typed};
use super::{CliError, CommandOutput};
use crate::case::Case;
use crate::study::StudyError;
use crate::study::accuracy::Accuracy;
use crate::study::report::Rerun;
use crate::study::require::{
    self, Combiner, Lean, RequirePlan, RequirePlanner, RequireReport, RequireRow, RequireRunner, rows_of,
};
use crate::study::row::RowStatus;
use crate::study::store::Store;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Default accuracy.
const WITHIN: &str = "1%";
/// [s] Default budget of a study on one machine.
const BUDGET: f64 = 120.0;

/// `require`.
#[derive(Clone, Debug, clap::Args)]
pub struct RequireArgs {
    /// case, folder and shares
    #[command(flatten)]
    pub study: StudyArgs,
    /// Accuracy against the full model that the leanest case keeps: 1%, 5e-3, or with a unit, 20N [default: that of the
    /// plan, else 1%]
    #[arg(long, value_name = "ACCURACY")]
    pub within: Option<String>,
    /// Runs at the same time, each on one thread; results are the same for every number [default: number of cores]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

pub(super) fn run(args: &RequireArgs) -> Result<CommandOutput, CliError> {
    let (case, out) = args.study.case_and_folder()?;
    Command { args, out, stop: stop_on_interrupt(), started: Instant::now() }.run(case)
}

struct Command<'a> {
    args: &'a RequireArgs,
    out: PathBuf,
    stop: &'static AtomicBool,
    started: Instant,
}

impl Command<'_> {
    fn run(&self, case: Option<CaseFile<'_>>) -> Result<CommandOutput, CliError> {
        let args = &self.args.study;
        let asked = case.map(|(path, case)| self.asked(path, &case)).transpose()?;
        let store = Store::<RequirePlan>::in_folder(&self.out);
        if args.force {
            store.clear()?;
            require::clear(&self.out)?;
        }
        // The accuracy decides nothing about the runs.
        let within = asked.as_ref().map(|plan| plan.within.clone());
        let plan = plan_of(&store, (&self.out, &require::FILES), asked, RequirePlan::difference)?;
        let plan = RequirePlan { within: within.unwrap_or_else(|| plan.within.clone()), ..plan };
        let accuracy = accuracy(self.args.within.as_deref().unwrap_or(&plan.within))?;
        if args.plan {
            return done(args.unless_quiet(require::planned(&plan, &store)?));
        }
        args.merge_into(&store, &plan)?;
        let base = plan.base()?;
        let line = ProgressLine::new(args.print.quiet);
        let (rows, lean) = self.make_runs(&plan, &store, &base, &accuracy, &line)?;
        line.bar.finish_and_clear();
        if let Some(shard) = args.shard {
            let finished = rows.iter().filter(|row| row.result.status != RowStatus::NotRun).count();
            return done(args.shard_done(shard, finished, rows.len(), &self.out));
        }
        // To repeat a study one needs the command that planned it, not the one that merged its parts.
        let how = Rerun { command: plan.command.clone(), ..Rerun::here(typed()) };
        let (plan, base, rows, lean) = (&plan, &base, &rows, lean.as_ref());
        let text = RequireReport { plan, base, rows, lean, accuracy: &accuracy, how: &how }.write(&self.out)?;
        done(args.printed(text, &self.out.join("require.json"))?)
    }

    /// The plan that the arguments ask for; a shard or a merge follows that of the folder.
    fn asked(&self, path: &Path, case: &Case) -> Result<RequirePlan, CliError> {
        self.args.study.may_plan()?;
        self.args.study.warn(case);
        let within = self.args.within.clone().unwrap_or_else(|| WITHIN.to_owned());
        accuracy(&within)?;
        let command = Rerun::here(typed()).command;
        Ok(RequirePlanner { case, case_file: path, within, command, stop: self.stop }.make()?)
    }

    /// The planned runs and, unless this is a share of them, the combinations. Finer runs come last: a spent budget
    /// leaves them out first.
    fn make_runs(
        &self,
        plan: &RequirePlan,
        store: &Store<RequirePlan>,
        base: &Case,
        accuracy: &Accuracy,
        line: &ProgressLine,
    ) -> Result<(Vec<RequireRow>, Option<Lean>), StudyError> {
        let StudyArgs { shard, merge, budget, .. } = &self.args.study;
        let alone = shard.is_none() && merge.is_none();
        let budget = budget.unwrap_or(if alone { Budget::Seconds(BUDGET) } else { Budget::Unlimited });
        let runner = RequireRunner {
            plan,
            store,
            shard: *shard,
            threads: runs_at_once(self.args.threads),
            deadline: budget.deadline(self.started),
            interrupt: self.stop,
            on_run: &|number, all, what| line.run(number, all, what),
        };
        let merged = merge.is_some();
        let mut left = if merged { Default::default() } else { runner.run(base, false)? };
        let rows = rows_of(plan, store, &left)?;
        let lean = match shard {
            None => Combiner { runner: &runner, base, rows: &rows, accuracy }.lean(&self.out)?,
            Some(_) => None,
        };
        if !merged {
            left.extend(runner.run(base, true)?);
        }
        Ok((rows_of(plan, store, &left)?, lean))
    }
}

fn accuracy(text: &str) -> Result<Accuracy, StudyError> {
    text.parse().map_err(|why: String| StudyError::Usage(format!("--within {text}: {why}")))
}

fn done(text: String) -> Result<CommandOutput, CliError> {
    Ok(CommandOutput { text, code: 0 })
}
