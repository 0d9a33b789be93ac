//! The arguments of the command line.

use super::init::InitArgs;
use super::mesh::{MeshArgs, MeshCommand};
use super::methods::MethodsArgs;
use super::plot::PlotArgs;
use super::shell::{CompletionsArgs, ManArgs};
use super::stability::StabilityArgs;
use super::static_::StaticArgs;
use super::sweep::SweepArgs;
use super::tradeoff::TradeoffArgs;
use clap::error::{ContextKind, ContextValue};
use clap::{Parser, Subcommand};
use std::path::PathBuf;

/// Printed below the help of commands that can fail in more than one way.
const EXIT_STATUS: &str = "\
Exit status:
  0    done
  1    input, output or internal failure
  2    bad usage or bad case
  3    the integration diverged, an implicit step could not be solved, or there is no equilibrium
  130  interrupted; `solve` keeps a checkpoint";

/// Parachute canopies and cloth as mass-spring networks, integrated the way a finite-element code would.
#[derive(Debug, Parser)]
#[command(
    name = "canopy-fem",
    version = env!("CANOPY_FEM_VERSION"),
    about,
    arg_required_else_help = true,
    after_help = EXIT_STATUS
)]
pub struct Args {
    /// Log to standard error: phases and their times, solvers, events of the scene; -vv: every factorisation too
    #[arg(long, short, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
    /// the command
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Integrate a case and write ParaView frames, history, probes and a summary
    ///
    /// The report judges the energy error, the largest energy that the method itself lost or made over the largest that
    /// was exchanged: good below 1 % (no speed is then off by more than half a per cent of the largest by it), doubtful
    /// up to 10 %, wrong above. A good one does not prove a run accurate: `canopy-fem check` and `tradeoff` tell how
    /// long a step may be.
    #[command(after_help = EXIT_STATUS)]
    Solve(SolveArgs),
    /// Find the static equilibrium of a case, and the vibration modes about it
    ///
    /// Starts from the case's initial state, which may be far, at rest; needs no `time` section. Writes one frame,
    /// summary.json, gauges.csv and probes.csv, and with --modes also modes.csv and shapes in the folder `modes`.
    /// `"initial": {"from": "out/NAME"}` starts a run from it. Parts that no force keeps in place are named. Where
    /// there is no equilibrium the exit status is 3.
    #[command(after_help = EXIT_STATUS)]
    Static(StaticArgs),
    /// Check a case without solving it: faults, which method and step to take, what it costs, whether it is stable
    ///
    /// The predictions come from a few seconds of trial steps. The command writes no files. `canopy-fem tradeoff`
    /// measures what it predicts.
    #[command(after_help = EXIT_STATUS)]
    Check(CheckArgs),
    /// Measure what accuracy costs: run methods and steps against a reference whose own error is known
    ///
    /// Writes tradeoff.csv, .json, .svg and .html, and prints which method and step to use for which accuracy. By
    /// default, the steps of explicit methods are chosen around their critical step, and those of implicit methods
    /// around the periods of the scene. A study that was stopped continues when the same command is given again;
    /// finished runs are not repeated.
    #[command(after_help = EXIT_STATUS)]
    Tradeoff(TradeoffArgs),
    /// Run a case over values of its keys, and gather what its gauges measured
    ///
    /// Writes sweep.csv, .json, .svg and .html. A row of sweep.csv is a run: `run`, the keys that vary, `status`,
    /// `t_end` [s], `displacement_end` [m] (largest, at the end), `max_speed` [m/s], `max_strain`, `energy_error`,
    /// `cpu_seconds` [s], counted work, with mass scaling `added_mass` [kg] and `added_mass_share`, and for every
    /// quantity of a gauge the columns GAUGE.QUANTITY.peak, .peak_time [s], .last (the value at the end) and .steady
    /// (whether it changed by less than 1 % over the last tenth of the run), then `note`. Runs that failed are rows
    /// without these values; `note` says why. A sweep that was stopped continues when the same command is given again.
    #[command(after_help = EXIT_STATUS)]
    Sweep(SweepArgs),
    /// Measure the largest stable step of every method on this scene, and compare it with the predicted one
    ///
    /// Finds the limit by bisection with real runs. Writes stability.csv, .json, .html and .svg (the stability
    /// regions and the motions of the scene in them).
    #[command(after_help = EXIT_STATUS)]
    Stability(StabilityArgs),
    /// Plot motion, energies, steps and gauges of finished runs, several runs overlaid, or the difference of two
    ///
    /// Writes a picture for each kind, such as displacement.svg, replacing earlier ones, and prints their names.
    /// Displacements are measured from the position before the initial displacement; a pendulum shows its angle.
    /// Motion between two frames is the cubic with their positions and velocities. A curve that coincides with an
    /// earlier one is dashed.
    #[command(after_help = super::plot::EXAMPLES)]
    Plot(PlotArgs),
    /// Make, convert or inspect a mesh
    Mesh(MeshArgs),
    /// List the methods with order and stability
    Methods(MethodsArgs),
    /// Print the JSON Schema of the case file
    Schema,
    /// Write a commented example case
    ///
    /// The file names a JSON Schema for editors, which is written beside it as case.schema.json: they then complete
    /// keys and show what these mean.
    Init(InitArgs),
    /// Print a script for a shell that completes commands and options
    ///
    /// For bash: canopy-fem completions bash > ~/.local/share/bash-completion/completions/canopy-fem
    Completions(CompletionsArgs),
    /// Write a manual page for each command
    ///
    /// For a user: canopy-fem man ~/.local/share/man/man1
    Man(ManArgs),
}

impl Command {
    /// Whether its output is for programs, and printed byte for byte.
    pub(super) fn prints_data(&self) -> bool {
        match self {
            Command::Solve(args) => args.print.json,
            Command::Static(args) => args.print.json,
            Command::Check(args) => args.print.json,
            Command::Tradeoff(args) => args.study.print.json,
            Command::Sweep(args) => args.study.print.json,
            Command::Stability(args) => args.print.json,
            Command::Methods(args) => args.json,
            Command::Mesh(MeshArgs { command: MeshCommand::Inspect(args) }) => args.json,
            Command::Schema | Command::Completions(_) => true,
            _ => false,
        }
    }
}

/// Commands of other programs, and those of this one that do the same.
const OTHER_COMMANDS: &[(&str, &str)] = &[
    ("run", "solve"),
    ("simulate", "solve"),
    ("sim", "solve"),
    ("validate", "check"),
    ("verify", "check"),
    ("lint", "check"),
    ("statics", "static"),
    ("equilibrium", "static"),
    ("modes", "static"),
    ("compare", "tradeoff"),
    ("new", "init"),
    ("convert", "mesh"),
];

/// Options of other programs, and those of this one that do the same.
const OTHER_OPTIONS: &[(&str, &str)] = &[
    ("--dt", "--step"),
    ("--timestep", "--step"),
    ("--time-step", "--step"),
    ("--tol", "--tolerance"),
    ("--rtol", "--tolerance"),
    ("--t-end", "--end"),
    ("--tend", "--end"),
    ("--end-time", "--end"),
    ("--duration", "--end"),
    ("--output", "--out"),
    ("--outdir", "--out"),
    ("--output-dir", "--out"),
    ("-o", "--out"),
    ("--overwrite", "--force"),
    ("-f", "--force"),
    ("--jobs", "--threads"),
    ("-j", "--threads"),
    ("--integrator", "--method"),
    ("--scheme", "--method"),
    ("--param", "--set"),
];

/// The same error with what was probably meant, where that is a word of another program or a case without a command.
pub(super) fn with_advice(mut error: clap::Error) -> clap::Error {
    let text = |error: &clap::Error, kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.clone()),
        _ => None,
    };
    let like = |names: &[(&str, &str)], given: &str| {
        names.iter().find(|(other, _)| *other == given).map(|(_, name)| (*name).to_owned())
    };
    if let Some(given) = text(&error, ContextKind::InvalidSubcommand) {
        let lowered = given.to_lowercase();
        if let Some(name) = like(OTHER_COMMANDS, &lowered) {
            error.insert(ContextKind::SuggestedSubcommand, ContextValue::Strings(vec![name]));
        } else if lowered.ends_with(".json") {
            error.insert(ContextKind::SuggestedSubcommand, ContextValue::Strings(vec![format!("solve {given}")]));
        }
    } else if let Some(given) = text(&error, ContextKind::InvalidArg) {
        let name = given.split('=').next().unwrap_or_default();
        if let Some(name) = like(OTHER_OPTIONS, &name.to_lowercase().replace('_', "-")) {
            error.insert(ContextKind::SuggestedArg, ContextValue::String(name));
        }
    }
    error
}

/// Changes of a case, for every command that reads one.
#[derive(Clone, Debug, clap::Args)]
pub struct Changes {
    /// Replace any value of the case, e.g. time.step=1e-3 or system.network.springs.0.stiffness=500
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub set: Vec<(String, String)>,
}

/// Threads, for every command that evaluates forces.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct Threads {
    /// Threads for the force passes of scenes above 2,000 nodes; results are the same for every number
    #[arg(long = "threads", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub number: u16,
}

/// What a command prints.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct Print {
    /// No progress, no warnings, no report
    #[arg(long, short)]
    pub quiet: bool,
    /// Print the results as JSON in place of the report
    #[arg(long)]
    pub json: bool,
}

impl Threads {
    /// Their number.
    pub(super) fn get(self) -> usize {
        usize::from(self.number)
    }
}

/// A case with changes to it.
#[derive(Clone, Debug, clap::Args)]
pub struct CaseArgs {
    /// Case file (JSON; // comments and trailing commas are allowed)
    pub case: PathBuf,
    /// Method, with its default parameters, or as in the case file: '{"hht": {"alpha": -0.2}}'
    #[arg(long)]
    pub method: Option<String>,
    /// Fixed step [s]; replaces time.tolerance
    #[arg(long, allow_negative_numbers = true)]
    pub step: Option<String>,
    /// Relative tolerance of adaptive steps, with a hundredth of it [m] as the absolute one; replaces time.step
    #[arg(long, allow_negative_numbers = true, conflicts_with = "step")]
    pub tolerance: Option<String>,
    /// End of the simulated time [s]
    #[arg(long, allow_negative_numbers = true)]
    pub end: Option<String>,
    /// changes
    #[command(flatten)]
    pub changes: Changes,
}

/// `check`.
#[derive(Clone, Debug, clap::Args)]
pub struct CheckArgs {
    /// the case
    #[command(flatten)]
    pub case: CaseArgs,
    /// Recommend a method and a step for this accuracy, relative to the motion, in (0, 1) [default: the case's relative
    /// tolerance, else 1e-3]
    #[arg(long, value_name = "A", value_parser = accuracy, allow_hyphen_values = true)]
    pub accuracy: Option<f64>,
    /// Print the model, its cost, and what is predicted of every method, too
    #[arg(long, short, conflicts_with = "json")]
    pub all: bool,
    /// threads
    #[command(flatten)]
    pub threads: Threads,
    /// what is printed
    #[command(flatten)]
    pub print: Print,
}

/// `solve`.
#[derive(Clone, Debug, clap::Args)]
pub struct SolveArgs {
    /// the case
    #[command(flatten)]
    pub case: CaseArgs,
    /// Folder for the results [default: out/NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// threads
    #[command(flatten)]
    pub threads: Threads,
    /// Replace earlier results in the folder
    #[arg(long)]
    pub force: bool,
    /// Continue from the checkpoint in the folder. A run writes one when it is interrupted, and as often as
    /// output.checkpoint of the case says. With fixed steps, --end may be later than before
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
    /// Continue after a divergence until a value is not finite
    #[arg(long)]
    pub keep_going: bool,
    /// Write M, C and K at t = 0 as MatrixMarket files into DIR before solving
    #[arg(long, value_name = "DIR")]
    pub dump_matrices: Option<PathBuf>,
    /// what is printed
    #[command(flatten)]
    pub print: Print,
}

impl CaseArgs {
    /// All replacements in the order they apply: `--set` first, then the flags with a name of their own.
    pub fn overrides(&self) -> Vec<(String, String)> {
        let steps = [
            self.step.clone().map(|step| [("time.tolerance", "null".to_owned()), ("time.step", step)]),
            self.tolerance.as_deref().map(|t| [("time.step", "null".to_owned()), ("time.tolerance", both(t))]),
        ];
        let flags = [("time.method", &self.method), ("time.end", &self.end)];
        let flags = flags.into_iter().filter_map(|(key, value)| Some((key, value.clone()?)));
        let named = flags.chain(steps.into_iter().flatten().flatten()).map(|(key, value)| (key.to_owned(), value));
        self.changes.set.iter().cloned().chain(named).collect()
    }
}

/// Both tolerances from the relative one; a value that is not a number is left to the check of the case.
fn both(relative: &str) -> String {
    match relative.trim().parse::<f64>() {
        // A number such as `.001` is no JSON.
        Ok(number) if number.is_finite() => {
            format!("{{\"relative\": {number:e}, \"absolute\": {:e}}}", number / 100.0)
        }
        _ => format!("{{\"relative\": {}}}", serde_json::Value::String(relative.to_owned())),
    }
}

fn accuracy(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number > 0.0 && number < 1.0 => Ok(number),
        Ok(number) => Err(format!("{number} is not above 0 and below 1")),
        Err(_) => Err("expected a number above 0 and below 1, e.g. 1e-3".to_owned()),
    }
}

pub(super) fn key_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.is_empty() => Ok((key.to_owned(), value.to_owned())),
        _ => Err("expected KEY=VALUE, e.g. time.step=1e-3".to_owned()),
    }
}

/// [s] A time with its unit; without one, seconds.
pub(super) fn duration(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let units = [("min", 60.0), ("ms", 1e-3), ("s", 1.0), ("m", 60.0), ("h", 3600.0)];
    let (number, unit) =
        units.iter().find_map(|(unit, size)| Some((text.strip_suffix(unit)?, *size))).unwrap_or((text, 1.0));
    let seconds = number.trim().parse().ok().map(|number: f64| number * unit).filter(|s| *s > 0.0 && s.is_finite());
    seconds.ok_or_else(|| "expected a time above 0 such as 60s, 5min or 2h".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_as_typed() {
        let times = [("60s", 60.0), ("1.5", 1.5), ("5min", 300.0), ("5m", 300.0), ("2 h", 7200.0), ("100ms", 0.1)];
        for (text, seconds) in times {
            assert_eq!(duration(text), Ok(seconds), "{text}");
        }
        for text in ["", "0s", "-1s", "soon", "inf", "nan", "1day", "none"] {
            assert!(duration(text).is_err(), "{text}");
        }
    }
}
