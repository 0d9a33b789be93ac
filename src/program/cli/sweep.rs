//! `canopy-fem sweep`: a case over values of its keys.

use super::interrupt::stop_on_interrupt;
use super::sample::SampleArgs;
use super::study::{CaseFile, ProgressLine, StudyArgs, plan_of, runs_at_once, typed};
use super::{CliError, CommandOutput};
use crate::case::Case;
use crate::study::StudyError;
use crate::study::report::Rerun;
use crate::study::row::RowStatus;
use crate::study::store::Store;
use crate::study::sweep::{self, SweepPlan, SweepPlanner, SweepReport, SweepRunner, Vary, rows_of};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// `sweep`.
#[derive(Clone, Debug, clap::Args)]
pub struct SweepArgs {
    /// case, folder and shares
    #[command(flatten)]
    pub study: StudyArgs,
    /// Values of a key of the case: KEY=A..B:N (N numbers with equal differences), KEY=log:A..B:N (with equal ratios)
    /// or KEY=a,b,c (numbers, words or JSON). The key is a dotted path as in --set. Several --vary make a grid.
    /// With --samples a distribution: KEY=normal:MEAN±SD (+- and SD% too; ,A..B cuts off), KEY=lognormal:MEAN±SD,
    /// KEY=uniform:A..B, KEY=table:FILE.csv (columns value and cumulative, or value and weight), or rows:FILE.csv,
    /// whose rows are drawn as a whole: its columns are keys, and perhaps weight
    #[arg(long, value_name = "KEY=VALUES", required_unless_present_any = ["shard", "merge"],
          conflicts_with_all = ["shard", "merge"])]
    pub vary: Vec<String>,
    /// distributions
    #[command(flatten)]
    pub sample: SampleArgs,
    /// Column of sweep.csv to draw; may be given several times [default: the quantities that are asked for, else the
    /// first peaks of the gauges with speed and drift of a landing, else displacement and speed]
    #[arg(long, value_name = "COLUMN")]
    pub plot: Vec<String>,
    /// Runs at the same time, each on one thread; results are the same for every number [default: number of cores]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

pub(super) fn run(args: &SweepArgs) -> Result<CommandOutput, CliError> {
    let (case, out) = args.study.case_and_folder()?;
    Command { args, out, stop: stop_on_interrupt(), started: Instant::now() }.run(case)
}

struct Command<'a> {
    args: &'a SweepArgs,
    out: PathBuf,
    stop: &'static AtomicBool,
    started: Instant,
}

impl Command<'_> {
    fn run(&self, case: Option<CaseFile<'_>>) -> Result<CommandOutput, CliError> {
        let args = &self.args.study;
        let store = Store::<SweepPlan>::in_folder(&self.out);
        let asked = case.map(|(path, case)| self.asked(path, &case)).transpose()?;
        if args.force {
            store.clear()?;
            sweep::clear(&self.out)?;
        }
        let line = ProgressLine::new(args.print.quiet);
        let plan = plan_of(&store, (&self.out, &sweep::FILES), asked, SweepPlan::difference)?;
        if args.plan {
            return done(args.unless_quiet(sweep::planned(&plan, &store)?));
        }
        let merged = args.merge_into(&store, &plan)?;
        let left = if merged { BTreeMap::new() } else { self.make_runs(&plan, &store, &line)? };
        line.bar.finish_and_clear();
        let rows = rows_of(&plan, &store, &left)?;
        if let Some(shard) = args.shard {
            let finished = rows.iter().filter(|row| row.result.status != RowStatus::NotRun).count();
            return done(args.shard_done(shard, finished, rows.len(), &self.out));
        }
        let here = Rerun::here(typed());
        // To repeat a sweep one needs the command that planned it, not the one that merged its parts.
        let how = Rerun { command: plan.command.clone(), ..here };
        let text = SweepReport { plan: &plan, rows: &rows, plot: &self.args.plot, how: &how }.write(&self.out)?;
        done(args.printed(text, &self.out.join("sweep.json"))?)
    }

    /// The plan that the arguments ask for; a shard or a merge follows that of the folder.
    fn asked(&self, path: &Path, case: &Case) -> Result<SweepPlan, CliError> {
        self.args.study.may_plan()?;
        let sampled = self.args.sample.sampled(&self.args.vary)?;
        let vary = if sampled.is_some() { Vec::new() } else { Vary::parse_all(&self.args.vary)? };
        self.args.study.warn(case);
        let command = Rerun::here(typed()).command;
        let errors = !self.args.sample.no_errors;
        Ok(SweepPlanner { case, case_file: path, vary, sampled, errors, command, stop: self.stop }.make()?)
    }

    fn make_runs(
        &self,
        plan: &SweepPlan,
        store: &Store<SweepPlan>,
        line: &ProgressLine,
    ) -> Result<BTreeMap<String, String>, StudyError> {
        let runner = SweepRunner {
            plan,
            store,
            shard: self.args.study.shard,
            threads: runs_at_once(self.args.threads),
            deadline: self.args.study.budget.and_then(|budget| budget.deadline(self.started)),
            interrupt: self.stop,
            on_run: &|number, all, what| line.run(number, all, what),
        };
        runner.run()
    }
}

fn done(text: String) -> Result<CommandOutput, CliError> {
    Ok(CommandOutput { text, code: 0 })
}
