//! `canopy-fem solve`: runs a case and writes its results.

use super::interrupt::{flag, is_asked, stop_on_interrupt};
use super::progress::{Display, Progress};
use super::report::{already_done, describe, report};
use super::resume::finished_run;
use super::terminal::interject;
use super::view::PAGE;
use super::worth::{Accounted, as_override};
use super::{CliError, CommandOutput, SolveArgs, complain};
use crate::case::Case;
use crate::drive::Status;
use crate::drive::observer::Observer;
use crate::interrupt::heeding;
use crate::output::csv::write_fault;
use crate::output::folder::{ResultFolder, SUMMARY};
use crate::output::sanitize::file_stem;
use crate::output::summary::Summary;
use crate::plot::PlotError;
use crate::simulation::{EarlierResults, RecordSettings, RecordWatch, record_watched};
use crate::startup::{Phase, StartupTimer, timed};
use crate::study::export::AnimationFormat;
use crate::study::view::Recording;
use crate::warning::Warning;
use clap::ValueEnum;
use std::path::{Path, PathBuf};

pub(super) fn run(args: &SolveArgs) -> Result<CommandOutput, CliError> {
    let account = StartupTimer::of_process();
    let case = timed(Phase::Parse, || Case::from_file(&args.case.case, &args.case.with_quantities(&args.quantity)))?;
    let warned = |warning: &Warning| {
        if !args.print.quiet {
            interject(&format!("warning: {warning}"));
        }
    };
    let (problem, name) = (case.problem(), case.problem().name.clone());
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(file_stem(&name)));
    if let Some(summary) = args.resume.then(|| finished_run(&out, problem)).flatten() {
        problem.warnings.iter().for_each(warned);
        let view = view(args, &out)?;
        if !args.print.quiet {
            tell_outdated(&out, &name, args.view);
        }
        let text = printed(args, &summary, &out, || already_done(&summary, &name, &out) + &view)?;
        return Ok(CommandOutput { text, code: 0 });
    }
    let settings = RecordSettings {
        out: &out,
        earlier: match (args.resume, args.force) {
            (true, _) => EarlierResults::Resume,
            (false, true) => EarlierResults::Replace,
            (false, false) => EarlierResults::Keep,
        },
        threads: args.threads.get(),
        keep_going: args.keep_going,
        matrices: args.dump_matrices.as_deref(),
    };
    if settings.earlier == EarlierResults::Keep {
        ResultFolder::check(&out, &name)?;
    }
    let (accounted, within) = account.without(|| {
        let accounted = (args.verify || args.within.is_some()).then(|| Accounted::of(&case, args)).transpose()?;
        let within = accounted.as_ref().map(|accounted| accounted.within(args, stop_on_interrupt())).transpose()?;
        Ok::<_, CliError>((accounted, within.flatten()))
    })?;
    let case = match &within {
        Some(within) => case.with(&as_override(within.run.step))?,
        None => case,
    };
    let display = if args.print.quiet { Display::Quiet } else { Display::Terminal };
    let mut progress = Progress::new(case.problem().time.end, display);
    let begins = || {
        stop_on_interrupt();
    };
    let watch = RecordWatch { begins: &begins, warned: &warned };
    // A signal also ends an implicit step, which may be long.
    let mut sampler = accounted.as_ref().map(Accounted::sampler);
    let mut observers: Vec<&mut dyn Observer> = vec![&mut progress];
    observers.extend(sampler.as_mut().map(|sampler| sampler as &mut dyn Observer));
    let mut recorded = heeding(is_asked, || record_watched(case, settings, watch, &mut observers, flag()))?;
    let errors = match accounted.as_ref().filter(|_| recorded.outcome.status == Status::Completed) {
        Some(accounted) => {
            let errors = accounted.verify(&mut recorded, sampler, within.as_ref(), flag())?;
            recorded.summary.write(&out.join(SUMMARY))?;
            errors
        }
        None => String::new(),
    };
    let outcome = &recorded.outcome;
    if let Some(failure) = &outcome.failure {
        complain(&describe(&recorded.summary, failure));
    }
    if !args.print.quiet {
        tell_outdated(&out, &name, args.view);
    }
    let view = view(args, &out)?;
    let text = printed(args, &recorded.summary, &out, || report(&name, &recorded, &errors, &out) + &view)?;
    let code = match outcome.status {
        Status::Completed => 0,
        // The summary has its failure, with the cause as far as it is known.
        Status::Diverged | Status::NotConverged if is_asked() => 130,
        Status::Diverged | Status::NotConverged => 3,
        Status::Interrupted => 130,
    };
    Ok(CommandOutput { text, code })
}

/// Tells what was made of an earlier run of the same name, in this folder under its usual name.
fn tell_outdated(out: &Path, name: &str, viewed: bool) {
    let page = (!viewed).then(|| (out.join(PAGE), format!("canopy-fem view {}", out.display())));
    let animation = |format: &AnimationFormat| {
        let ending = format.ending();
        let path = out.join(format!("{}.{ending}", file_stem(name)));
        (path, format!("canopy-fem export {} --to {ending}", out.display()))
    };
    let all = page.into_iter().chain(AnimationFormat::value_variants().iter().map(animation));
    for (path, again) in all.filter(|(path, _)| path.is_file()) {
        complain(&format!("note: {} shows an earlier run; {again} makes it anew", path.display()));
    }
}

/// Writes the page of the run, if it is asked for; its line of the report. A run that ended before its first frame has
/// none, which is a warning.
fn view(args: &SolveArgs, out: &Path) -> Result<String, CliError> {
    if !args.view {
        return Ok(String::new());
    }
    match Recording::open(out) {
        Ok(recording) => {
            let page = super::view::write(&[recording], out, args.print.quiet)?;
            Ok(format!("  view            {}\n", page.display()))
        }
        Err(PlotError::NotThere(why)) => {
            complain(&format!("warning: --view: {why}"));
            Ok(String::new())
        }
        Err(error) => Err(error.into()),
    }
}

/// What goes to standard output: the summary as it is in the file, the report, or nothing.
fn printed(
    args: &SolveArgs,
    summary: &Summary,
    folder: &Path,
    report: impl FnOnce() -> String,
) -> Result<String, CliError> {
    match (args.print.json, args.print.quiet) {
        (true, _) => Ok(summary.to_json().map_err(|e| write_fault(&folder.join(SUMMARY), e.into()))?),
        (false, true) => Ok(String::new()),
        (false, false) => Ok(report()),
    }
}
