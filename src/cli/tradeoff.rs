//! `canopy-fem tradeoff`: what accuracy costs, on the user's own scene.

use super::args::{duration, key_value};
use super::interrupt::stop_on_interrupt;
use super::{CliError, CommandOutput, complain};
use crate::case::Case;
use crate::output::sanitize::file_stem;
use crate::study::difference::differences;
use crate::study::options::{StudyOptions, TypedOptions};
use crate::study::plan::{Plan, Planner};
use crate::study::prepared_case::fingerprint_of;
use crate::study::recommendations::Recommendations;
use crate::study::reference::ALLOWANCE;
use crate::study::report::{self, Rerun};
use crate::study::row::{Row, RowStatus};
use crate::study::store::Store;
use crate::study::{Runner, Shard, Study, StudyError, rows_of};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// [s] Default budget of a study on one machine.
const BUDGET: f64 = 120.0;
/// Share of a budget that the references may take, in nominal costs.
const FOR_REFERENCES: f64 = 0.5;

/// `tradeoff`.
#[derive(Clone, Debug, clap::Args)]
pub struct TradeoffArgs {
    /// Case file (JSON; // comments and trailing commas are allowed); not needed where --out holds a plan
    #[arg(required_unless_present_any = ["shard", "merge"])]
    pub case: Option<PathBuf>,
    /// what to try
    #[command(flatten)]
    pub options: TypedOptions,
    /// Time limit of the study: 60s, 5min, 2h or none. Runs that are left out are marked; the same command makes them
    /// when it is given again [default: 2min; none for --plan and --shard]
    #[arg(long, value_name = "TIME", value_parser = budget)]
    pub budget: Option<Budget>,
    /// Make the references and the list of runs only
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
    /// Replace any value of the case, e.g. system.network.springs.0.stiffness=500
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub set: Vec<(String, String)>,
    /// Threads for the force passes of scenes above 2,000 nodes; counted work and errors are the same for every number
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Replace an earlier study in the folder
    #[arg(long, conflicts_with_all = ["shard", "merge"])]
    pub force: bool,
    /// No progress, no warnings, no report
    #[arg(long, short)]
    pub quiet: bool,
}

/// [s] Time limit of a study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// so many seconds
    Seconds(f64),
    /// as long as it takes
    Unlimited,
}

pub(super) fn budget(text: &str) -> Result<Budget, String> {
    match text.trim() {
        "none" => Ok(Budget::Unlimited),
        time => duration(time).map(Budget::Seconds).map_err(|expected| expected + ", or none"),
    }
}

pub(super) fn run(args: &TradeoffArgs) -> Result<CommandOutput, CliError> {
    let overrides: Vec<(String, String)> =
        args.set.iter().cloned().chain(args.end.clone().map(|end| ("time.end".to_owned(), end))).collect();
    let case =
        args.case.as_deref().map(|path| Ok::<_, CliError>((path, Case::from_file(path, &overrides)?))).transpose()?;
    let out = match (&args.out, &case) {
        (Some(out), _) => out.clone(),
        (None, Some((_, case))) => PathBuf::from("out").join(file_stem(&case.problem().name)),
        (None, None) => {
            return Err(StudyError::Usage("give the case, or the folder of its study with --out".to_owned()).into());
        }
    };
    if case.is_none() && !overrides.is_empty() {
        return Err(StudyError::Usage("--set and --end change a case: give the case too".to_owned()).into());
    }
    let command = Command { args, out, store_stop: stop_on_interrupt(), started: Instant::now() };
    command.run(case)
}

struct Command<'a> {
    args: &'a TradeoffArgs,
    out: PathBuf,
    store_stop: std::sync::Arc<AtomicBool>,
    started: Instant,
}

impl Command<'_> {
    fn run(&self, case: Option<(&Path, Case)>) -> Result<CommandOutput, CliError> {
        let store = Store::<Plan>::in_folder(&self.out);
        if self.args.force {
            store.clear()?;
            report::clear(&self.out)?;
        }
        let line = ProgressLine::new(self.args.quiet);
        let known = store.plan()?;
        let plan = match (known, case) {
            (Some(plan), Some((path, case))) => {
                self.same(&plan, path, &case)?;
                plan
            }
            (Some(plan), None) => plan,
            (None, Some((path, case))) if self.args.shard.is_none() && self.args.merge.is_none() => {
                self.nothing_lost()?;
                self.plan(path, &case, &store, &line)?
            }
            (None, _) => return Err(Store::<Plan>::no_plan(&self.out).into()),
        };
        if self.args.plan {
            return Ok(done(if self.args.quiet { String::new() } else { report::planned(&plan, &store)? }));
        }
        let mut left = BTreeMap::new();
        match &self.args.merge {
            Some(folders) => {
                for folder in folders {
                    store.take_from(&Store::in_folder(folder), &plan)?;
                }
            }
            None => left = self.make_runs(&plan, &store, &line)?,
        }
        line.bar.finish_and_clear();
        let rows = rows_of(&plan, &store, &left)?;
        if let Some(shard) = self.args.shard {
            return Ok(done(if self.args.quiet { String::new() } else { self.shard_done(shard, &rows) }));
        }
        let answers = Recommendations::of(&plan, &rows)?;
        let study = Study { plan, rows };
        let here = Rerun::here(typed());
        // To repeat a study one needs the command that planned it, not the one that merged its parts.
        let command = if study.plan.command.is_empty() { here.command } else { study.plan.command.clone() };
        let how = Rerun { command, ..here };
        let files = report::write(&self.out, &study, &answers, &how)?;
        let text = if self.args.quiet { String::new() } else { report::summary(&study, &answers, &files)? };
        Ok(done(text))
    }

    fn shard_done(&self, Shard { part, of }: Shard, rows: &[Row]) -> String {
        let finished = rows.iter().filter(|r| r.measured.status != RowStatus::NotRun).count();
        let (all, out) = (rows.len(), self.out.display());
        format!("shard {part}/{of} done; {finished} of {all} runs of the study are finished in {out}\n")
    }

    /// Refuses to overwrite results of a study without its plan.
    fn nothing_lost(&self) -> Result<(), StudyError> {
        let there = report::FILES.iter().find(|name| !self.args.force && self.out.join(name).exists());
        match there {
            Some(name) => Err(StudyError::OtherStudy {
                folder: self.out.clone(),
                difference: format!("{name} exists without the plan that it came from"),
            }),
            None => Ok(()),
        }
    }

    fn options(&self, case: &Case) -> Result<StudyOptions, StudyError> {
        StudyOptions::of(&self.args.options, case.file().study.as_ref())
    }

    /// [s] time limit of the study
    fn budget(&self, section: Option<f64>) -> Option<f64> {
        let shared = self.args.plan || self.args.shard.is_some();
        match self.args.budget {
            Some(Budget::Seconds(seconds)) => Some(seconds),
            Some(Budget::Unlimited) => None,
            None => section.or((!shared).then_some(BUDGET)),
        }
    }

    fn plan(&self, path: &Path, case: &Case, store: &Store, line: &ProgressLine) -> Result<Plan, CliError> {
        if !self.args.quiet {
            case.warnings().iter().for_each(|warning| complain(&format!("warning: {warning}")));
        }
        let options = self.options(case)?;
        let section = case.file().study.as_ref().and_then(|study| study.budget_seconds);
        let variants = options.stiffness_sweep.len().max(1) as f64;
        let allowance = self.budget(section).map_or(ALLOWANCE, |budget| FOR_REFERENCES * budget / variants);
        let planner = Planner {
            case,
            case_file: path,
            options,
            command: Rerun::here(typed()).command,
            threads: usize::from(self.args.threads),
            allowance,
            stop: &self.store_stop,
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
        let asks = self.args.shard.is_none() && self.args.merge.is_none();
        if asks && plan.asked != self.options(case)? {
            return Err(other("other methods, steps, tolerances, repeats or stiffnesses were asked for".to_owned()));
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
        let deadline = self.budget(section).map(|seconds| self.started + Duration::from_secs_f64(seconds.min(1e9)));
        let runner = Runner {
            plan,
            store,
            shard: self.args.shard,
            threads: usize::from(self.args.threads),
            deadline,
            interrupt: &self.store_stop,
            on_run: &|number, all, what| line.run(number, all, what),
        };
        runner.run()
    }
}

fn done(text: String) -> CommandOutput {
    CommandOutput { text, code: 0 }
}

/// The progress line on a terminal.
pub(super) struct ProgressLine {
    pub(super) bar: ProgressBar,
}

impl ProgressLine {
    pub(super) fn new(quiet: bool) -> Self {
        let hidden = quiet || !std::io::stderr().is_terminal();
        let target = if hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(10) };
        let bar = ProgressBar::with_draw_target(None, target);
        if let Ok(style) = ProgressStyle::with_template("{elapsed:>4} {wide_msg}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(500));
        ProgressLine { bar }
    }

    pub(super) fn tell(&self, what: &str) {
        self.bar.set_message(what.to_owned());
    }

    pub(super) fn run(&self, number: usize, all: usize, what: &str) {
        self.tell(&format!("run {number} of {all}: {what}"));
    }
}

/// The arguments as typed; bytes that are not UTF-8 are replaced.
pub(super) fn typed() -> impl Iterator<Item = String> {
    std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned())
}
