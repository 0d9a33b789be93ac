//! `canopy-fem gradient`: exact derivatives of the quantities of a run with respect to numbers of its case.

use super::case_args::{CaseArgs, Print, Threads};
use super::interrupt::stop_on_interrupt;
use super::{CliError, CommandOutput, complain};
use crate::case::Case;
use crate::format_number::{counted, figures, first_few};
use crate::model::stop::Stop;
use crate::study::gradient::{
    Derivative, ElementDerivatives, GradientReport, GradientSpec, QuantityGradient, gradient,
};
use std::fmt::Write;

/// `gradient`.
#[derive(Clone, Debug, clap::Args)]
pub struct GradientArgs {
    /// the case
    #[command(flatten)]
    pub case: CaseArgs,
    /// A quantity, as study.quantities of the case has it: riser.tension.peak, tip.z@0.5, opening_load …; may be given
    /// several times [default: study.quantities, else the numbers that solve prints]
    #[arg(long, value_name = "NAME")]
    pub of: Vec<String>,
    /// A number of the case by its key, as in --set, or by the end of its key where no other ends so; or a key that
    /// holds numbers, for all of them; or what each spring or node has: each.stiffness, each.rest_length, each.mass,
    /// each.force, each.position, each.velocity. May be given several times
    #[arg(long, value_name = "KEY", required = true)]
    pub by: Vec<String>,
    /// Compare each derivative with that by differences of four whole runs
    #[arg(long)]
    pub verify: bool,
    /// Steps that are kept at once for derivatives by each spring or node; parts of a run that has more are made again
    /// [default: what 256 MiB hold, at least 20]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..))]
    pub states: Option<u64>,
    /// threads
    #[command(flatten)]
    pub threads: Threads,
    /// what is printed
    #[command(flatten)]
    pub print: Print,
}

pub(super) fn run(args: &GradientArgs) -> Result<CommandOutput, CliError> {
    let case = Case::from_file(&args.case.case, &args.case.with_quantities(&args.of))?;
    if !args.print.quiet {
        case.warnings().iter().for_each(|warning| complain(&format!("warning: {warning}")));
    }
    let interrupt = Stop::on(stop_on_interrupt());
    let threads = args.threads.get();
    let (by, states, verify) = (&args.by, args.states, args.verify);
    let found = gradient(&GradientSpec { case: &case, by, states, threads, verify, interrupt })?;
    let text = match (args.print.json, args.print.quiet) {
        (true, _) => serde_json::to_string_pretty(&found).map(|text| text + "\n").map_err(CliError::Json)?,
        (false, true) => String::new(),
        (false, false) => report(&found),
    };
    Ok(CommandOutput { text, code: 0 })
}

/// Significant figures of a derivative.
const FIGURES: usize = 8;

fn report(found: &GradientReport) -> String {
    let GradientReport { case, method, steps, again, run_factorizations, factorizations, quantities } = found;
    let mut text = format!("{case}: derivatives of a run of {} by {method}\n", counted(*steps, "step", "steps"));
    if *factorizations > 0 {
        let _ =
            writeln!(text, "  factorisations  {run_factorizations} by the run, {factorizations} by its derivatives");
    }
    if *again > 0 {
        let _ = writeln!(text, "  made again      {}, as not all are kept at once", counted(*again, "step", "steps"));
    }
    for quantity in quantities {
        text.push_str(&of_quantity(quantity));
    }
    if quantities.iter().any(|of| !of.each.is_empty()) {
        text.push_str("  note: --json has the derivative by each spring or node\n");
    }
    text
}

fn of_quantity(of: &QuantityGradient) -> String {
    let QuantityGradient { name, unit, value, peak_time, derivatives, each } = of;
    let value = value.map_or_else(|| "no value".to_owned(), |value| format!("{} {unit}", figures(value, FIGURES)));
    let when = peak_time.map_or_else(String::new, |t| format!(" at t = {} s", figures(t, 6)));
    let mut text = format!("\n{name} = {value}{when}\n");
    text.push_str(&of_elements(each, unit));
    if derivatives.is_empty() {
        return text;
    }
    let width = derivatives.iter().map(|of| of.by.chars().count()).max().unwrap_or(0);
    let relative = "1 % more changes it by";
    let _ = writeln!(text, "  {:width$}  {:>16}  {:>22}  {relative}", "by", "at", "derivative");
    for one in derivatives {
        text.push_str(&line(one, (unit, width)));
    }
    let note = |which: &dyn Fn(&Derivative) -> bool| {
        let keys: Vec<&str> = derivatives.iter().filter(|of| which(of)).map(|of| of.by.as_str()).collect();
        first_few(&keys)
    };
    for Derivative { by, sides, .. } in derivatives.iter().filter(|of| of.one_sided) {
        let which = sides.as_ref().map_or_else(
            || "the mean of both is given".to_owned(),
            |[below, above]| format!("{} below, {} above", figures(*below, 6), figures(*above, 6)),
        );
        let _ = writeln!(
            text,
            "  note: by {by}, {name} has another derivative on each side: {which}. A law switches there, or the largest of \
             several values changes places"
        );
    }
    let switching = note(&|of| of.switching > 0.0);
    if !switching.is_empty() {
        let most = derivatives.iter().map(|of| of.switching).fold(0.0, f64::max);
        let _ = writeln!(
            text,
            "  note: laws switch within the differences by {switching}, in up to {} % of the stages of steps, as where a \
             spring goes slack; the derivative is then nearly exact, and differences of whole runs are less so",
            figures(100.0 * most, 2)
        );
    }
    text
}

/// The derivatives by what each spring or node has: the largest of them, and what all do together.
fn of_elements(each: &[ElementDerivatives], unit: &str) -> String {
    let mut text = String::new();
    if each.is_empty() {
        return text;
    }
    let _ = writeln!(text, "  {:16}  {:>24}  {:22}  1 % more of all changes it by", "by", "largest derivative", "of");
    for ElementDerivatives { by, by_unit, largest, elasticity, .. } in each {
        let (value, place) = largest.as_ref().map_or_else(
            || ("-".to_owned(), "-"),
            |of| (format!("{} {}", figures(of.value, FIGURES), over(unit, by_unit)), of.place.as_str()),
        );
        let change = elasticity.map_or_else(|| "-".to_owned(), |of| format!("{} %", figures(of, 4)));
        let _ = writeln!(text, "  {by:16}  {value:>24}  {place:22}  {change}");
    }
    text
}

/// A unit over another one.
fn over(unit: &str, by: &str) -> String {
    match (unit, by) {
        (unit, "" | "-") => unit.to_owned(),
        (unit, by) if by.contains(['/', '*', ' ']) => format!("{unit}/({by})"),
        (unit, by) => format!("{unit}/{by}"),
    }
}

fn line(one: &Derivative, (unit, width): (&str, usize)) -> String {
    let Derivative { by, by_unit, at, value, elasticity, by_runs, .. } = one;
    let of_unit = over(unit, by_unit);
    let at = format!("{} {by_unit}", figures(*at, 6));
    let derivative = format!("{} {of_unit}", figures(*value, FIGURES));
    let change = elasticity.map_or_else(|| "-".to_owned(), |of| format!("{} %", figures(of, 4)));
    let mut text = format!("  {by:width$}  {:>16}  {derivative:>22}  {change}", at.trim_end());
    if let Some(by_runs) = by_runs {
        let size = value.abs().max(by_runs.abs());
        let differ = if size > 0.0 { (value - by_runs).abs() / size } else { 0.0 };
        let _ = write!(text, "  by whole runs {}, differs by {differ:.1e}", figures(*by_runs, FIGURES));
    }
    text + "\n"
}
