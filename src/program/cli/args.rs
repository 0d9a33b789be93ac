//! The arguments of the command line.

use super::case_args::{CheckArgs, SolveArgs};
use super::export::ExportArgs;
use super::fit::FitArgs;
use super::gradient::GradientArgs;
use super::init::InitArgs;
use super::mesh::{MeshArgs, MeshCommand};
use super::methods::MethodsArgs;
use super::plot::PlotArgs;
use super::require::RequireArgs;
use super::stability::StabilityArgs;
use super::static_::StaticArgs;
use super::sweep::SweepArgs;
use super::tradeoff::TradeoffArgs;
use super::view::ViewArgs;
use clap::error::{ContextKind, ContextValue};
use clap::{Parser, Subcommand};
use clap_complete::Shell;
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
    /// Writes tradeoff.csv, .json, .svg and .html, and prints which method and step to use for which accuracy: of the
    /// motion of all nodes, and of the numbers that are read, by --quantity or those that `solve` prints. By
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
    /// quantity of a gauge the columns GAUGE.QUANTITY.peak, .peak_time [s], .last (the value at the end) and
    /// .is_steady (whether it changed by less than 1 % over the last tenth of the run), then quantities that are asked
    /// for, those of the landing where runs end on the ground (landing.time, .speed, .drift, .heading, .x and .y), and
    /// `note`. Runs that failed are rows without these values; `note` says why. A sweep that was stopped continues when
    /// the same command is given again.
    #[command(after_help = EXIT_STATUS)]
    Sweep(SweepArgs),
    /// Fit values of a case's keys to measured curves, with their errors
    ///
    /// Finds by least squares the values with which gauges of the run come nearest to tables of data, and how well the
    /// data determine them: standard errors, intervals of 95 %, correlations. Writes fit.json, .csv, .svg and .html,
    /// and fitted.json: the case with these values. A value that the data do not determine is told.
    #[command(after_help = EXIT_STATUS)]
    Fit(FitArgs),
    /// Find what a scene requires: what each part of the model does to the numbers of the report, and what it costs
    ///
    /// Runs the case with one change at a time: coarser and finer meshes and steps, the other model of the cloth, parts
    /// of the model left out. Then it combines those that stay within the accuracy, measures each combination, and
    /// writes the leanest as a case of its own, NAME-lean.json. Also writes require.csv, .json and .html. A row of
    /// require.csv is a run: `change`, `from`, `to`, `cpu_seconds` [s], each quantity and, as `error_` with its name,
    /// what it differs by from the full model, `saved` (share of the time), `within`, `status`, `note`. With --shard,
    /// the combinations are made by --merge.
    #[command(after_help = EXIT_STATUS)]
    Require(RequireArgs),
    /// Find exact derivatives of the numbers of a run with respect to numbers of its case
    ///
    /// One run gives the derivatives of all quantities by all keys: those of the discrete motion itself, found by the
    /// tangent-linear run. The most important key comes first: that of which 1 % more changes the quantity most. The
    /// command writes no files. Steps are fixed ones.
    #[command(after_help = EXIT_STATUS)]
    Gradient(GradientArgs),
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
    /// Make a page that shows a run in 3D, with its gauges; or two runs beside each other
    ///
    /// Writes view.html, replacing an earlier one, and prints its name. The page needs a browser and nothing else: it
    /// plays and turns the scene, colours it by tension, stress, pressure, strain or speed, as far as its frames hold
    /// them, switches groups, and shows gauges with a cursor. A run that goes on or was killed is shown as far as it
    /// went.
    #[command(after_help = super::view::EXAMPLES)]
    View(ViewArgs),
    /// Make an animation of a run for Blender, Omniverse and other programs of pictures
    ///
    /// Writes NAME.glb or NAME.usda, replacing an earlier one, and prints its name. Cloth is a mesh seen from both
    /// sides, edges that are no sides of triangles are lines, and times are those of the run. USD has +Z up and metres;
    /// glTF has +Y up, which programs turn back as they read it.
    #[command(after_help = super::export::EXAMPLES)]
    Export(ExportArgs),
    /// Make, convert or inspect a mesh
    Mesh(MeshArgs),
    /// List the methods with order and stability
    Methods(MethodsArgs),
    /// Print the JSON Schema of the case file
    Schema,
    /// Print the materials that cases can name, with their sources, as a case's own file of materials is written
    Materials,
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
            Command::Check(args) => args.print.json || args.expand,
            Command::Tradeoff(args) => args.study.print.json,
            Command::Sweep(args) => args.study.print.json,
            Command::Fit(args) => args.print.json,
            Command::Require(args) => args.study.print.json,
            Command::Gradient(args) => args.print.json,
            Command::Stability(args) => args.print.json,
            Command::Methods(args) => args.json,
            Command::Mesh(MeshArgs { command: MeshCommand::Inspect(args) }) => args.json,
            Command::Schema | Command::Materials | Command::Completions(_) => true,
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
    ("calibrate", "fit"),
    ("identify", "fit"),
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

/// `completions`.
#[derive(Clone, Debug, clap::Args)]
pub struct CompletionsArgs {
    /// Shell to complete commands for
    #[arg(value_enum)]
    pub shell: Shell,
}

/// `man`.
#[derive(Clone, Debug, clap::Args)]
pub struct ManArgs {
    /// Folder for the pages, made if it does not exist; pages of the same name are replaced
    pub dir: PathBuf,
}
