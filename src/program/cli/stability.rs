//! `canopy-fem stability CASE`: predicted and measured largest stable step of every method.

use super::case_args::{Print, Threads, duration};
use super::study::printed;
use super::{CaseArgs, CliError, CommandOutput, complain};
use crate::case::Case;
use crate::integrate::registry::MethodChoice;
use crate::output::sanitize::file_stem;
use crate::scene::Scene;
use crate::simulation::build_scene;
use crate::study::options::method_list;
use crate::study::stability::{Folder, RunStart, Stability, StabilitySpec, Status, study, table};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::fmt::Write;
use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::Duration;

/// `stability`.
#[derive(Clone, Debug, clap::Args)]
pub struct StabilityArgs {
    /// the case
    #[command(flatten)]
    pub case: CaseArgs,
    /// Methods to study, as names or as in the case file, e.g. newmark,rk4,'{"hht": {"alpha": -0.2}}' [default: those
    /// of the study section, else all; the method of the case keeps its parameters]
    #[arg(long, value_name = "LIST", value_parser = methods)]
    pub methods: Option<MethodList>,
    /// Wall-clock time for the study, e.g. 60s, 5min, 1h; methods that are not finished by then are left out [default:
    /// no limit]
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub budget: Option<f64>,
    /// Folder for stability.csv, .json, .svg and .html [default: out/NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace an earlier study in the folder
    #[arg(long)]
    pub force: bool,
    /// threads
    #[command(flatten)]
    pub threads: Threads,
    /// what is printed
    #[command(flatten)]
    pub print: Print,
}

/// Methods as a JSON list, as a case has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MethodList(pub String);

fn methods(text: &str) -> Result<MethodList, String> {
    let list = method_list(text)?;
    serde_json::to_string(&list).map(MethodList).map_err(|e| e.to_string())
}

pub(super) fn run(args: &StabilityArgs) -> Result<CommandOutput, CliError> {
    let case = Case::from_file(&args.case.case, &overrides(args))?;
    let wanted = case.file().study.clone().unwrap_or_default();
    let (mut problem, _) = case.split();
    if !args.print.quiet {
        problem.warnings.iter().for_each(|w| complain(&format!("warning: {w}")));
    }
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(file_stem(&problem.name)));
    let folder = Folder::prepare(&out, args.force)?;
    let chosen = match wanted.methods {
        Some(list) => list.iter().map(|m| MethodChoice::new(&m.name, &m.parameters)).collect::<Result<Vec<_>, _>>(),
        None => Ok(problem.method.among_all().collect()),
    }?;
    let scene = build_scene(problem.take_system(), args.threads.get())?;
    let spec = StabilitySpec {
        scene: &*scene,
        methods: &chosen,
        solver: problem.solver,
        end: problem.time.end,
        budget: wanted.budget_seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok()),
    };
    let stop = super::interrupt::stop_on_interrupt();
    let bar = progress(chosen.len(), args.print.quiet);
    let mut begins = |beginning: RunStart<'_>| show(&bar, beginning);
    let rows = study(&spec, &mut begins, stop)?;
    bar.finish_and_clear();
    let code = if rows.iter().any(|row| row.status == Status::Interrupted) { 130 } else { 0 };
    let done = Stability {
        name: problem.name.clone(),
        end: problem.time.end,
        unknowns: unknowns(&*scene),
        methods: rows,
        case: problem.case_json,
        version: env!("CARGO_PKG_VERSION").to_owned(),
    };
    let written = folder.write(&*scene, &chosen, &done)?;
    let mut text = table(&done)?;
    for path in written {
        let _ = writeln!(text, "{}", path.display());
    }
    Ok(CommandOutput { text: printed(args.print, text, &out.join("stability.json"))?, code })
}

/// The flags of a study as values of the case's study section, so that they are checked as those are.
fn overrides(args: &StabilityArgs) -> Vec<(String, String)> {
    let mut all = args.case.overrides();
    // A method given by name has its default parameters.
    let named = args.case.method.as_ref().map(|method| match method.trim_start().starts_with(['{', '"']) {
        true => format!("[{method}]"),
        false => format!("[\"{method}\"]"),
    });
    let methods = args.methods.as_ref().map(|list| list.0.clone()).or(named);
    all.extend(methods.map(|list| ("study.methods".to_owned(), list)));
    all.extend(args.budget.iter().map(|seconds| ("study.budget_seconds".to_owned(), format!("{seconds:e}"))));
    all
}

fn unknowns(scene: &dyn Scene) -> u64 {
    scene.inverse_mass().iter().filter(|m| **m > 0.0).count() as u64
}

fn progress(methods: usize, quiet: bool) -> ProgressBar {
    let shown = !quiet && std::io::stderr().is_terminal();
    let target = if shown { ProgressDrawTarget::stderr_with_hz(10) } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(methods as u64), target);
    if let Ok(style) = ProgressStyle::with_template("{pos}/{len} [{bar:24}] {wide_msg}") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar
}

fn show(bar: &ProgressBar, RunStart { index, method, run, step, steps }: RunStart<'_>) {
    bar.set_position(index as u64);
    bar.set_message(format!("{method}  run {run}  h {step:.3e} s  {steps} steps"));
    bar.tick();
}
