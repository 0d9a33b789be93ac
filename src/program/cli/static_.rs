//! `canopy-fem static`: finds the equilibrium of a case and writes it.

use super::case_args::{Changes, Print, Threads};
use super::interrupt::stop_on_interrupt;
use super::progress::{Display, SearchLine};
use super::{CliError, CommandOutput, complain};
use crate::case::Case;
use crate::drive::Status;
use crate::format_number::{counted, figures};
use crate::output::at_rest::LargestValue;
use crate::output::csv::write_fault;
use crate::output::folder::{SUMMARY, frames_of};
use crate::output::sanitize::file_stem;
use crate::output::summary::EquilibriumReport;
use crate::simulation::{EarlierResults, RecordedStatic, StaticSettings, record_static_watched};
use crate::startup::StartupTimer;
use crate::statics::{Stability, Watcher};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// `static`.
#[derive(Clone, Debug, clap::Args)]
pub struct StaticArgs {
    /// Case file (JSON; // comments and trailing commas are allowed); its `time` section is not needed
    pub case: PathBuf,
    /// changes
    #[command(flatten)]
    pub changes: Changes,
    /// Time of loads, wind and supports [s]
    #[arg(long, value_name = "T", default_value_t = 0.0, value_parser = time)]
    pub at: f64,
    /// Apply weight, pressures, forces and displacements of supports in this many steps. By default they act at once,
    /// and in steps if that fails
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub load_steps: u32,
    /// Find the N lowest vibration modes about the equilibrium
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub modes: Option<u16>,
    /// Folder for the results [default: out/NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// threads
    #[command(flatten)]
    pub threads: Threads,
    /// Replace earlier results in the folder
    #[arg(long)]
    pub force: bool,
    /// what is printed
    #[command(flatten)]
    pub print: Print,
}

pub(super) fn time(text: &str) -> Result<f64, String> {
    let t = text.trim().parse().ok().filter(|t: &f64| *t >= 0.0 && t.is_finite());
    t.ok_or_else(|| "expected a time of at least 0, in seconds".to_owned())
}

pub(super) fn run(args: &StaticArgs) -> Result<CommandOutput, CliError> {
    let _account = StartupTimer::of_process();
    let case = Case::from_file_at_rest(&args.case, &args.changes.set)?;
    let warn = |text: &str| {
        if !args.print.quiet {
            complain(&format!("warning: {text}"));
        }
    };
    let name = &case.problem().name;
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(file_stem(name)));
    let settings = StaticSettings {
        out: &out,
        earlier: if args.force { EarlierResults::Replace } else { EarlierResults::Keep },
        threads: args.threads.get(),
        at: args.at,
        load_steps: args.load_steps,
        modes: args.modes.map_or(0, usize::from),
    };
    let stop = stop_on_interrupt();
    let line = SearchLine::new(if args.print.quiet { Display::Quiet } else { Display::Terminal });
    let found = record_static_watched(&case, settings, stop, Watcher(&|progress| line.show(progress)))?;
    drop(line);
    found.warnings.iter().for_each(|warning| warn(&warning.to_string()));
    found.equilibrium.findings.iter().for_each(|finding| warn(&finding.text));
    if let Some(error) = &found.without_modes {
        complain(&format!("error: {error}"));
    }
    if let Some(failure) = &found.summary.failure {
        complain(&format!(
            "error: no equilibrium was found\n  cause   {}\n  advice  {}\n",
            failure.cause, failure.advice
        ));
    }
    let text = match (args.print.json, args.print.quiet) {
        (true, _) => found.summary.to_json().map_err(|e| write_fault(&out.join(SUMMARY), e.into()))?,
        (false, true) => String::new(),
        (false, false) => report(name, &found, &out),
    };
    let code = match found.summary.status {
        Status::Interrupted => 130,
        Status::Completed if found.without_modes.is_none() => 0,
        _ => 3,
    };
    Ok(CommandOutput { text, code })
}

/// Largest values with their places, sum of the reactions, and springs without tension.
fn describe_largest(text: &mut String, found: &EquilibriumReport) {
    for LargestValue { quantity, value, unit, part, number, groups, place } in &found.largest {
        let value = match quantity.as_str() {
            "displacement" => format!("{} m from the start, the largest, of", figures(*value, 4)),
            "safety_factor" if *value < 1.0 => format!("{}, it would break: the smallest, of", figures(*value, 4)),
            "safety_factor" => format!("{}, the smallest, of", figures(*value, 4)),
            _ => format!("{} {unit}, the largest, of", figures(*value, 5)),
        };
        let groups = if groups.is_empty() { String::new() } else { format!(" ({})", groups.join(", ")) };
        let [x, y, z] = place.map(|x| figures(x, 4));
        let quantity = quantity.replace('_', " ");
        let _ = writeln!(text, "  {quantity:<15} {value} {part} {number}{groups} at ({x}, {y}, {z}) m");
    }
    if found.largest.iter().any(|value| value.quantity == "reaction") {
        let [x, y, z] = found.reaction_sum.map(|x| figures(x, 5));
        let _ = writeln!(text, "  reactions       ({x}, {y}, {z}) N in all");
    }
    if found.slack_springs > 0 {
        let _ = writeln!(text, "  slack           {}", counted(found.slack_springs as u64, "spring", "springs"));
    }
}

fn report(name: &str, found: &RecordedStatic, out: &Path) -> String {
    let (equilibrium, summary) = (&found.equilibrium, &found.summary);
    let state = match summary.status {
        Status::Completed => "in equilibrium",
        Status::Interrupted => "interrupted",
        _ => "not in equilibrium",
    };
    let c = summary.counters;
    let iterations = counted(c.newton_iterations, "Newton iteration", "Newton iterations");
    let mut text = format!("{name}: {state} at t = {} s after {iterations}\n", figures(summary.t_end, 12));
    let work = [
        counted(c.force_evaluations, "force pass", "force passes"),
        counted(c.factorizations, "factorisation", "factorisations"),
        counted(u64::from(equilibrium.load_steps), "load step", "load steps"),
    ];
    let residual = equilibrium.residual;
    let idle = summary.equilibrium.iter().flat_map(|report| &report.idle_loads);
    idle.for_each(|load| _ = writeln!(text, "  not acting      {load}"));
    let _ = writeln!(text, "  work            {}", work.join(", "));
    let _ = writeln!(text, "  residual        {:.1e} N of {} N", residual.force, figures(residual.scale, 4));
    if let Some(energy) = summary.equilibrium.as_ref().and_then(|report| report.potential_energy) {
        let _ = writeln!(text, "  potential       {} J, elastic and of weight", figures(energy, 6));
    }
    let stability = match equilibrium.stability {
        Some(Stability::Stable) => "stable",
        Some(Stability::Neutral) => "neutral: some motion meets no resistance",
        Some(Stability::Unstable) => "unstable: a small disturbance grows",
        None => "not judged",
    };
    let _ = writeln!(text, "  stability       {stability}");
    if let Some(found) = &summary.equilibrium {
        describe_largest(&mut text, found);
    }
    for peak in &summary.peaks {
        let _ = writeln!(text, "  {:<15} {} = {} {}", peak.name, peak.quantity, figures(peak.last, 6), peak.unit);
    }
    if !found.modes.modes.is_empty() {
        let shown: Vec<String> = found.modes.modes.iter().take(6).map(|mode| figures(mode.frequency(), 4)).collect();
        let more = if found.modes.modes.len() > shown.len() { ", … (modes.csv)" } else { "" };
        let _ = writeln!(text, "  modes           {}{more} Hz", shown.join(", "));
        if !found.modes.symmetric {
            text += "                  of the symmetric part of the tangent, which is not symmetric here\n";
        }
        let growing = found.modes.growing.iter().take(3).map(|motion| {
            let [rate, frequency] = [motion.rate, motion.frequency].map(|number| figures(number, 4));
            format!("{rate} 1/s at {frequency} Hz")
        });
        let growing: Vec<String> = growing.collect();
        match (&growing[..], found.modes.symmetric) {
            ([], true) => {}
            ([], false) => text += "  growing         no motion that these modes make together\n",
            _ => {
                let more = if found.modes.growing.len() > growing.len() { ", … (summary.json)" } else { "" };
                let _ = writeln!(text, "  growing         {}{more}", growing.join(", "));
            }
        }
    }
    let _ = writeln!(text, "  results         {}", frames_of(out, name).display());
    text
}
