//! `canopy-fem sweep`: a case over values of its keys.

use super::args::key_value;
use super::interrupt::stop_on_interrupt;
use super::tradeoff::{Budget, ProgressLine, budget, typed};
use super::{CliError, CommandOutput, complain};
use crate::case::Case;
use crate::output::sanitize::file_stem;
use crate::study::report::Rerun;
use crate::study::row::RowStatus;
use crate::study::store::Store;
use crate::study::sweep::{self, SweepPlan, SweepPlanner, SweepReport, SweepRow, SweepRunner, Vary, rows_of};
use crate::study::{Shard, StudyError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// `sweep`.
#[derive(Clone, Debug, clap::Args)]
pub struct SweepArgs {
    /// Case file (JSON; // comments and trailing commas are allowed); not needed where --out holds a plan
    #[arg(required_unless_present_any = ["shard", "merge"])]
    pub case: Option<PathBuf>,
    /// Values of a key of the case: KEY=A..B:N (N numbers with equal differences), KEY=log:A..B:N (with equal ratios)
    /// or KEY=a,b,c (numbers, words or JSON). The key is a dotted path as in --set. Several --vary make a grid
    #[arg(long, value_name = "KEY=VALUES", required_unless_present_any = ["shard", "merge"],
          conflicts_with_all = ["shard", "merge"])]
    pub vary: Vec<String>,
    /// Column of sweep.csv to draw; may be given several times [default: the first peaks of the gauges, else
    /// displacement and speed]
    #[arg(long, value_name = "COLUMN")]
    pub plot: Vec<String>,
    /// Time limit of the sweep: 60s, 5min, 2h or none. Runs that are left out are marked; the same command makes them
    /// when it is given again [default: none]
    #[arg(long, value_name = "TIME", value_parser = budget)]
    pub budget: Option<Budget>,
    /// Check the case of every run and make the list of runs only
    #[arg(long, conflicts_with_all = ["shard", "merge"])]
    pub plan: bool,
    /// Make one share of the planned runs, e.g. 3/8; shares are counted from 1
    #[arg(long, value_name = "I/N", conflicts_with = "merge")]
    pub shard: Option<Shard>,
    /// Merge the results of the shards in --out, and in these folders if shards ran elsewhere
    #[arg(long, value_name = "DIR", num_args = 0..)]
    pub merge: Option<Vec<PathBuf>>,
    /// Folder for the results [default: out/NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// End of the simulated time [s]
    #[arg(long, allow_negative_numbers = true)]
    pub end: Option<String>,
    /// Replace any value of the case, e.g. time.step=1e-3
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub set: Vec<(String, String)>,
    /// Runs at the same time, each on one thread; results are the same for every number [default: number of cores]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Replace an earlier sweep in the folder
    #[arg(long, conflicts_with_all = ["shard", "merge"])]
    pub force: bool,
    /// No progress, no warnings, no report
    #[arg(long, short)]
    pub quiet: bool,
}

pub(super) fn run(args: &SweepArgs) -> Result<CommandOutput, CliError> {
    let overrides: Vec<(String, String)> =
        args.set.iter().cloned().chain(args.end.clone().map(|end| ("time.end".to_owned(), end))).collect();
    let case =
        args.case.as_deref().map(|path| Ok::<_, CliError>((path, Case::from_file(path, &overrides)?))).transpose()?;
    let out = match (&args.out, &case) {
        (Some(out), _) => out.clone(),
        (None, Some((_, case))) => PathBuf::from("out").join(file_stem(&case.problem().name)),
        (None, None) => {
            return Err(StudyError::Usage("give the case, or the folder of its sweep with --out".to_owned()).into());
        }
    };
    if case.is_none() && !overrides.is_empty() {
        return Err(StudyError::Usage("--set and --end change a case: give the case too".to_owned()).into());
    }
    Command { args, out, stop: stop_on_interrupt(), started: Instant::now() }.run(case)
}

struct Command<'a> {
    args: &'a SweepArgs,
    out: PathBuf,
    stop: Arc<AtomicBool>,
    started: Instant,
}

impl Command<'_> {
    fn run(&self, case: Option<(&Path, Case)>) -> Result<CommandOutput, CliError> {
        let args = self.args;
        let store = Store::<SweepPlan>::in_folder(&self.out);
        let asked = case.map(|(path, case)| self.asked(path, &case)).transpose()?;
        if args.force {
            store.clear()?;
            sweep::clear(&self.out)?;
        }
        let line = ProgressLine::new(args.quiet);
        let plan = self.plan(&store, asked)?;
        if args.plan {
            return done(if args.quiet { String::new() } else { sweep::planned(&plan, &store)? });
        }
        let mut left = BTreeMap::new();
        match &args.merge {
            Some(folders) => {
                for folder in folders {
                    store.take_from(&Store::in_folder(folder), &plan)?;
                }
            }
            None => left = self.make_runs(&plan, &store, &line)?,
        }
        line.bar.finish_and_clear();
        let rows = rows_of(&plan, &store, &left)?;
        if let Some(shard) = args.shard {
            return done(if args.quiet { String::new() } else { self.shard_done(shard, &rows) });
        }
        let here = Rerun::here(typed());
        // To repeat a sweep one needs the command that planned it, not the one that merged its parts.
        let how = Rerun { command: plan.command.clone(), ..here };
        let text = SweepReport { plan: &plan, rows: &rows, plot: &args.plot, how: &how }.write(&self.out)?;
        done(if args.quiet { String::new() } else { text })
    }

    /// The plan that the arguments ask for; a shard or a merge follows that of the folder.
    fn asked(&self, path: &Path, case: &Case) -> Result<SweepPlan, CliError> {
        let args = self.args;
        if args.shard.is_some() || args.merge.is_some() {
            let why = "--shard and --merge follow the plan in --out: leave the case out";
            return Err(StudyError::Usage(why.to_owned()).into());
        }
        let vary = Vary::parse_all(&args.vary)?;
        if !args.quiet {
            case.warnings().iter().for_each(|warning| complain(&format!("warning: {warning}")));
        }
        let command = Rerun::here(typed()).command;
        Ok(SweepPlanner { case, case_file: path, vary, command, stop: &self.stop }.make()?)
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
                if let Some(name) = sweep::FILES.iter().find(|name| self.out.join(name).exists()) {
                    return Err(other(format!("{name} exists without the plan that it came from")).into());
                }
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
        let deadline = match self.args.budget {
            Some(Budget::Seconds(seconds)) => Some(self.started + Duration::from_secs_f64(seconds.min(1e9))),
            Some(Budget::Unlimited) | None => None,
        };
        let runner = SweepRunner {
            plan,
            store,
            shard: self.args.shard,
            threads: self.args.threads.map_or_else(cores, usize::from),
            deadline,
            interrupt: &self.stop,
            on_run: &|number, all, what| line.run(number, all, what),
        };
        runner.run()
    }

    fn shard_done(&self, Shard { part, of }: Shard, rows: &[SweepRow]) -> String {
        let finished = rows.iter().filter(|row| row.result.status != RowStatus::NotRun).count();
        let (all, out) = (rows.len(), self.out.display());
        format!("shard {part}/{of} done; {finished} of {all} runs of the sweep are finished in {out}\n")
    }
}

fn done(text: String) -> Result<CommandOutput, CliError> {
    Ok(CommandOutput { text, code: 0 })
}
