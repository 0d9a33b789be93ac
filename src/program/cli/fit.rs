//! `canopy-fem fit`: values of a case's keys from measured curves.

use super::case_args::{Changes, Print};
use super::interrupt::stop_on_interrupt;
use super::study::{ProgressLine, printed, runs_at_once, typed};
use super::{CliError, CommandOutput, complain};
use crate::case::Case;
use crate::output::sanitize::file_stem;
use crate::study::StudyError;
use crate::study::fit::{self, DataSource, FitReport, FitSpec, Parameter, Range};
use crate::study::report::Rerun;
use std::path::PathBuf;

/// `fit`.
#[derive(Clone, Debug, clap::Args)]
pub struct FitArgs {
    /// Case file (JSON; // comments and trailing commas are allowed)
    pub case: PathBuf,
    /// Measured curve and the gauge it is held against: FILE:GAUGE.COLUMN, such as riser.csv:riser.tension. The file
    /// has time [s], value and perhaps the standard deviation of the value. FILE:GAUGE.COLUMN*FACTOR multiplies the
    /// values, for other units. May be given several times
    #[arg(long, value_name = "FILE:GAUGE.COLUMN", required = true)]
    pub data: Vec<String>,
    /// A key of the case that is fitted, with the range in which it is searched: KEY=A..B, or KEY=log:A..B for a value
    /// that may differ by factors. The key is a dotted path as in --set. May be given several times
    #[arg(long, value_name = "KEY=A..B", required = true)]
    pub vary: Vec<String>,
    /// Fit an offset too, which is added to the times of the data: A..B [s]
    #[arg(long, value_name = "A..B", allow_hyphen_values = true)]
    pub offset: Option<String>,
    /// Number of starts of the search: the first is the case itself, others are spread over the ranges
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub starts: u32,
    /// Seed of the other starts
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Folder for the results [default: out/NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// End of the simulated time [s]; runs end with the data
    #[arg(long, allow_negative_numbers = true)]
    pub end: Option<String>,
    /// Runs at the same time, each on one thread; results are the same for every number [default: number of cores]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// changes
    #[command(flatten)]
    pub changes: Changes,
    /// Replace an earlier fit in the folder
    #[arg(long)]
    pub force: bool,
    /// what is printed
    #[command(flatten)]
    pub print: Print,
}

pub(super) fn run(args: &FitArgs) -> Result<CommandOutput, CliError> {
    let end = args.end.clone().map(|end| ("time.end".to_owned(), end));
    let overrides: Vec<(String, String)> = args.changes.set.iter().cloned().chain(end).collect();
    let case = Case::from_file(&args.case, &overrides)?;
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(file_stem(&case.problem().name)));
    let data = args.data.iter().map(|text| DataSource::parse(text)).collect::<Result<_, _>>()?;
    let vary = Parameter::parse_all(&args.vary)?;
    let wrong = |text: &str, why: &str| StudyError::Usage(format!("--offset {text}: {why}"));
    let offset = args.offset.as_deref().map(|text| Range::parse(text).map_err(|why| wrong(text, why)));
    if args.force {
        fit::clear(&out)?;
    } else if let Some(found) = fit::FILES.iter().find(|file| out.join(file).exists()) {
        return Err(StudyError::HoldsStudy { folder: out, found }.into());
    }
    if !args.print.quiet {
        case.warnings().iter().for_each(|warning| complain(&format!("warning: {warning}")));
    }
    let line = ProgressLine::new(args.print.quiet);
    let spec = FitSpec {
        case: &case,
        data,
        vary,
        offset: offset.transpose()?,
        starts: args.starts,
        seed: args.seed,
        threads: runs_at_once(args.threads),
        interrupt: stop_on_interrupt(),
        on_run: &|made| line.tell(&format!("run {}", made + 1)),
    };
    let fit = spec.run()?;
    line.bar.finish_and_clear();
    let text = FitReport { case: &case, fit: &fit, how: &Rerun::here(typed()) }.write(&out)?;
    Ok(CommandOutput { text: printed(args.print, text, &out.join("fit.json"))?, code: 0 })
}
