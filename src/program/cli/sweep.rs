//! `canopy-fem sweep`: a case over values of its keys.

use super::interrupt::stop_on_interrupt;
use super::study::{CaseFile, ProgressLine, StudyArgs, nothing_lost, typed};
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
    /// or KEY=a,b,c (numbers, words or JSON). The key is a dotted path as in --set. Several --vary make a grid
    #[arg(long, value_name = "KEY=VALUES", required_unless_present_any = ["shard", "merge"],
          conflicts_with_all = ["shard", "merge"])]
    pub vary: Vec<String>,
    /// Column of sweep.csv to draw; may be given several times [default: the quantities that are asked for, else the
    /// first peaks of the gauges, else displacement and speed]
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
        let plan = self.plan(&store, asked)?;
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
        if self.args.study.follows_a_plan() {
            let why = "--shard and --merge follow the plan in --out: leave the case out";
            return Err(StudyError::Usage(why.to_owned()).into());
        }
        let vary = Vary::parse_all(&self.args.vary)?;
        self.args.study.warn(case);
        let command = Rerun::here(typed()).command;
        Ok(SweepPlanner { case, case_file: path, vary, command, stop: self.stop }.make()?)
    }

    /// The plan of the folder, which must be the one asked for; or that one, in a folder without a plan.
    fn plan(&self, store: &Store<SweepPlan>, asked: Option<SweepPlan>) -> Result<SweepPlan, CliError> {
        let other = |difference: String| StudyError::OtherStudy { folder: self.out.clone(), difference };
        match (store.plan()?, asked) {
            (Some(known), Some(asked)) => match known.difference(&asked) {
                Some(difference) => Err(other(difference).into()),
                None => Ok(known),
            },
            (Some(known), None) => Ok(known),
            (None, Some(asked)) => {
                nothing_lost(&self.out, &sweep::FILES)?;
                store.keep_plan(&asked)?;
                Ok(asked)
            }
            (None, None) => Err(Store::<SweepPlan>::no_plan(&self.out).into()),
        }
    }

    fn make_runs(
        &self,
        plan: &SweepPlan,
        store: &Store<SweepPlan>,
        line: &ProgressLine,
    ) -> Result<BTreeMap<String, String>, StudyError> {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        let runner = SweepRunner {
            plan,
            store,
            shard: self.args.study.shard,
            threads: self.args.threads.map_or_else(cores, usize::from),
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
