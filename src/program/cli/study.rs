//! What the studies that can be divided among machines, `tradeoff`, `sweep` and `require`, have in common on the
//! command line.

use super::case_args::{Changes, Print, asked_for, duration};
use super::{CliError, complain};
use crate::case::Case;
use crate::output::sanitize::file_stem;
use crate::study::store::{Store, StudyPlan};
use crate::study::{Shard, StudyError};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::ffi::OsString;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// The case of a study, and how its runs are divided and kept.
#[derive(Clone, Debug, clap::Args)]
pub struct StudyArgs {
    /// Case file (JSON; // comments and trailing commas are allowed); not needed where --out holds a plan
    #[arg(required_unless_present_any = ["shard", "merge"])]
    pub case: Option<PathBuf>,
    /// Time limit: 60s, 5min, 2h or none. Runs that are left out are marked; the same command makes them when it is
    /// given again [default: none; for tradeoff and require 2min, but none with --plan, --shard and for require
    /// --merge]
    #[arg(long, value_name = "TIME", value_parser = budget)]
    pub budget: Option<Budget>,
    /// Make the list of runs only, for `tradeoff` with the references
    #[arg(long, conflicts_with_all = ["shard", "merge", "json"])]
    pub plan: bool,
    /// Make one share of the planned runs, e.g. 3/8; shares are counted from 1
    #[arg(long, value_name = "I/N", conflicts_with_all = ["merge", "json"])]
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
    /// changes
    #[command(flatten)]
    pub changes: Changes,
    /// A number that is asked for, as study.quantities of the case has it: riser.tension.peak, tip.z@0.5, opening_load,
    /// motion …; may be given several times. A tradeoff study ranks its runs by the worst error of them
    #[arg(long, value_name = "NAME")]
    pub quantity: Vec<String>,
    /// Replace earlier results in the folder
    #[arg(long, conflicts_with_all = ["shard", "merge"])]
    pub force: bool,
    /// what is printed
    #[command(flatten)]
    pub print: Print,
}

/// A case, and its file as it was typed.
pub(super) type CaseFile<'a> = (&'a Path, Case);

/// [s] Time limit of a study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// so many seconds
    Seconds(f64),
    /// as long as it takes
    Unlimited,
}

fn budget(text: &str) -> Result<Budget, String> {
    match text.trim() {
        "none" => Ok(Budget::Unlimited),
        time => duration(time).map(Budget::Seconds).map_err(|expected| expected + ", or none"),
    }
}

impl Budget {
    /// When a study that began at `started` has to stop.
    pub(super) fn deadline(self, started: Instant) -> Option<Instant> {
        match self {
            Budget::Seconds(seconds) => Some(started + Duration::from_secs_f64(seconds.min(1e9))),
            Budget::Unlimited => None,
        }
    }
}

impl StudyArgs {
    /// The case, if one is given, and the folder of the study.
    pub(super) fn case_and_folder(&self) -> Result<(Option<CaseFile<'_>>, PathBuf), CliError> {
        let end = self.end.clone().map(|end| ("time.end".to_owned(), end));
        let quantities = asked_for(&self.quantity);
        let overrides: Vec<(String, String)> = self.changes.set.iter().cloned().chain(end).chain(quantities).collect();
        let read = |path| Ok::<_, CliError>((path, Case::from_file(path, &overrides)?));
        let case = self.case.as_deref().map(read).transpose()?;
        let out = match (&self.out, &case) {
            (Some(out), _) => out.clone(),
            (None, Some((_, case))) => PathBuf::from("out").join(file_stem(&case.problem().name)),
            (None, None) => {
                let why = "give the case, or the folder of its study with --out".to_owned();
                return Err(StudyError::Usage(why).into());
            }
        };
        if case.is_none() && !overrides.is_empty() {
            return Err(
                StudyError::Usage("--set, --end and --quantity change a case: give the case too".to_owned()).into()
            );
        }
        Ok((case, out))
    }

    /// Whether the command is a part of a study that was planned before.
    pub(super) fn follows_a_plan(&self) -> bool {
        self.shard.is_some() || self.merge.is_some()
    }

    /// Refuses a case beside a plan that is followed.
    pub(super) fn may_plan(&self) -> Result<(), StudyError> {
        if self.follows_a_plan() {
            let why = "--shard and --merge follow the plan in --out: leave the case out";
            return Err(StudyError::Usage(why.to_owned()));
        }
        Ok(())
    }

    pub(super) fn warn(&self, case: &Case) {
        if !self.print.quiet {
            case.warnings().iter().for_each(|warning| complain(&format!("warning: {warning}")));
        }
    }

    /// Takes the results of shards that ran elsewhere; `false` if nothing is to be merged.
    pub(super) fn merge_into<P: StudyPlan>(&self, store: &Store<P>, plan: &P) -> Result<bool, StudyError> {
        for folder in self.merge.iter().flatten() {
            store.take_from(&Store::in_folder(folder), plan)?;
        }
        Ok(self.merge.is_some())
    }

    /// What a command that made a share of the runs prints.
    pub(super) fn shard_done(&self, Shard { part, of }: Shard, finished: usize, all: usize, out: &Path) -> String {
        let out = out.display();
        self.unless_quiet(format!(
            "shard {part}/{of} done; {finished} of {all} runs of the study are finished in {out}\n"
        ))
    }

    /// What the whole study prints: its report, or what it has written as `results`.
    pub(super) fn printed(&self, report: String, results: &Path) -> Result<String, StudyError> {
        printed(self.print, report, results)
    }

    pub(super) fn unless_quiet(&self, text: String) -> String {
        if self.print.quiet { String::new() } else { text }
    }
}

/// A report, or with `--json` the file with all results; nothing with `--quiet` alone.
pub(super) fn printed(print: Print, report: String, results: &Path) -> Result<String, StudyError> {
    match (print.json, print.quiet) {
        (true, _) => {
            std::fs::read_to_string(results).map_err(|source| StudyError::System { path: results.to_owned(), source })
        }
        (false, true) => Ok(String::new()),
        (false, false) => Ok(report),
    }
}

/// The plan of the folder, which must be the one asked for; or that one, in a folder without a plan.
pub(super) fn plan_of<P: StudyPlan>(
    store: &Store<P>,
    (out, files): (&Path, &[&str]),
    asked: Option<P>,
    difference: impl Fn(&P, &P) -> Option<String>,
) -> Result<P, StudyError> {
    match (store.plan()?, asked) {
        (Some(known), Some(asked)) => match difference(&known, &asked) {
            Some(difference) => Err(StudyError::OtherStudy { folder: out.to_owned(), difference }),
            None => Ok(known),
        },
        (Some(known), None) => Ok(known),
        (None, Some(asked)) => {
            nothing_lost(out, files)?;
            store.keep_plan(&asked)?;
            Ok(asked)
        }
        (None, None) => Err(Store::<P>::no_plan(out)),
    }
}

/// Runs at the same time: as asked for, else one a core.
pub(super) fn runs_at_once(threads: Option<u16>) -> usize {
    threads.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from)
}

/// Refuses to overwrite results whose plan is not there.
pub(super) fn nothing_lost(out: &Path, files: &[&str]) -> Result<(), StudyError> {
    match files.iter().find(|name| out.join(name).exists()) {
        Some(name) => Err(StudyError::OtherStudy {
            folder: out.to_owned(),
            difference: format!("{name} exists without the plan that it came from"),
        }),
        None => Ok(()),
    }
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

/// The arguments of the command, for the reports of studies. Not those of the process: with the Python module it is the
/// interpreter's.
static TYPED: OnceLock<Vec<OsString>> = OnceLock::new();

/// Keeps the arguments of the command.
pub(super) fn remember(arguments: &[OsString]) {
    TYPED.get_or_init(|| arguments.to_vec());
}

/// The arguments as typed; bytes that are not UTF-8 are replaced.
pub(super) fn typed() -> impl Iterator<Item = String> {
    TYPED.get().into_iter().flatten().map(|word| word.to_string_lossy().into_owned())
}
