//! `solve --verify` and `solve --within`: what the numbers of a run are worth, and the step for an accuracy.

use super::progress::{Display, Progress};
use super::{CliError, SolveArgs};
use crate::analysis::warnings::limit_at_start;
use crate::case::Case;
use crate::drive::clock::Step;
use crate::format_number::{figures, with_error};
use crate::model::stop::Stop;
use crate::output::gauges::MeasuredQuantity;
use crate::output::largest::LargestValues;
use crate::output::summary::Summary;
use crate::simulation::Recorded;
use crate::study::StudyError;
use crate::study::beside::Numbers;
use crate::study::frames::Sampler;
use crate::study::prepared_case::PreparedCase;
use crate::study::verify::{Verifier, Within, compared_every};
use crate::study::worth::KnownError;
use std::fmt::Write;
use std::sync::atomic::AtomicBool;

/// A case whose numbers are to be known with their errors.
pub(super) struct Accounted {
    prepared: PreparedCase,
    /// [s] interval of the frames by which motions are compared
    frames: f64,
    /// [s]
    limit: f64,
    display: Display,
}

impl Accounted {
    pub(super) fn of(case: &Case, args: &SolveArgs) -> Result<Self, CliError> {
        let prepared = PreparedCase::of(case.problem().clone(), args.threads.get())?;
        let (scene, problem) = (&*prepared.scene, &prepared.problem);
        let named = LargestValues::new(scene, &problem.output, problem.time.end, None);
        let named = named.map_err(|why| StudyError::Usage(why.to_string()))?.quantities();
        let motion = named.iter().any(MeasuredQuantity::is_motion);
        let limit = limit_at_start(problem.run_spec().planned(scene, Stop::NEVER)).step;
        let display = if args.print.quiet { Display::Quiet } else { Display::Terminal };
        let frames = compared_every(&prepared, motion);
        Ok(Accounted { prepared, frames, limit, display })
    }

    /// The observer of the run that keeps its motion.
    pub(super) fn sampler(&self) -> Sampler<'_> {
        Sampler::keeping(&*self.prepared.scene, self.frames)
    }

    fn with<R>(
        &self,
        interrupt: &AtomicBool,
        what: impl FnOnce(&Verifier<'_>) -> Result<R, StudyError>,
    ) -> Result<R, CliError> {
        let line = Progress::new(1.0, self.display);
        let tell = |step: &str| line.say(&format!("beside it: {step}"));
        let Accounted { prepared, frames, limit, .. } = self;
        let verifier = Verifier { prepared, frames: *frames, limit: *limit, interrupt, tell: &tell };
        let made = what(&verifier);
        line.clear();
        Ok(made?)
    }

    /// Finds the step for an accuracy.
    pub(super) fn within(&self, args: &SolveArgs, interrupt: &AtomicBool) -> Result<Option<Within>, CliError> {
        let Some(accuracy) = &args.within else { return Ok(None) };
        self.with(interrupt, |verifier| verifier.within(accuracy)).map(Some)
    }

    /// Adds the errors to the summary of a run; `frames` are those of the run.
    pub(super) fn verify(
        &self,
        recorded: &mut Recorded,
        frames: Option<Sampler<'_>>,
        within: Option<&Within>,
        interrupt: &AtomicBool,
    ) -> Result<String, CliError> {
        let frames = frames.map(Sampler::into_frames);
        let (worths, how) = match within {
            Some(within) => {
                let spent = figures(within.seconds, 2);
                (within.worths.clone(), format!("{} in {spent} s", within.made.join(", ")))
            }
            None => {
                let Recorded { quantities, outcome, summary, spec, .. } = &*recorded;
                let own = Numbers { quantities, peaks: &summary.peaks, frames: frames.as_ref() };
                let mean = outcome.t_end / outcome.steps.max(1) as f64;
                let step = spec.step.fixed().unwrap_or(mean);
                let verified = self.with(interrupt, |verifier| verifier.verify(own, spec.step, step))?;
                let beside = if verified.beside.is_empty() { "none".to_owned() } else { verified.beside.join(", ") };
                (verified.worths, format!("beside {beside}"))
            }
        };
        worths.add_to(&mut recorded.summary);
        let kind = if recorded.spec.step.fixed().is_some() { "step" } else { "tolerance" };
        Ok(lines(&recorded.quantities, &recorded.summary, kind, &how))
    }
}

/// The step of a run as a change of the case.
pub(super) fn as_override(step: Step) -> Vec<(String, String)> {
    match step {
        Step::Fixed(h) => vec![("time.step".to_owned(), format!("{h:e}"))],
        Step::Adaptive(tolerance) => vec![
            ("time.tolerance.relative".to_owned(), format!("{:e}", tolerance.relative)),
            ("time.tolerance.absolute".to_owned(), format!("{:e}", tolerance.absolute)),
        ],
    }
}

/// What the report says of errors below the numbers themselves.
fn lines(quantities: &[MeasuredQuantity], summary: &Summary, kind: &str, how: &str) -> String {
    let mut text = String::new();
    let of = |quantity: &MeasuredQuantity| summary.quantities.get(&quantity.name);
    let asked = summary.case.pointer("/study/quantities").is_some();
    for quantity in quantities.iter().filter(|quantity| quantity.wanted) {
        let Some(report) = of(quantity) else { continue };
        match quantity.value {
            Some(value) if asked => {
                let value = with_error(value, report.error);
                let _ = writeln!(text, "  quantity        {} = {value} {}", quantity.name, quantity.unit);
            }
            None if quantity.is_motion() => {
                let error = report.error.map_or_else(
                    || "not known".to_owned(),
                    |error| format!("± {} % of the motion, by the {kind}s", figures(100.0 * error, 2)),
                );
                let _ = writeln!(text, "  motion          {error}");
            }
            _ => {}
        }
    }
    // Not wider than the column of all labels.
    let by = if kind == "step" { "± by the step" } else { "± by tolerance" };
    let _ = writeln!(text, "  {by:<16}{how}");
    let extrapolated: Vec<String> = quantities
        .iter()
        .filter_map(|quantity| Some((quantity, of(quantity)?.extrapolated?, of(quantity)?.error)))
        .map(|(quantity, value, error)| {
            let value = with_error(value, error);
            let value = value.split(" ±").next().unwrap_or_default().to_owned();
            format!("{} {value} {}", quantity.name, quantity.unit)
        })
        .collect();
    if !extrapolated.is_empty() {
        let _ = writeln!(text, "  extrapolated    {}", extrapolated.join(", "));
    }
    for (why, heading) in [(KnownError::Contradiction, "not settled"), (KnownError::Unknown, "not known")] {
        let names: Vec<&str> = quantities
            .iter()
            .filter(|quantity| of(quantity).is_some_and(|of| of.error.is_none() && of.error_by == why.words()))
            .map(|quantity| quantity.name.as_str())
            .collect();
        if !names.is_empty() {
            let _ = writeln!(text, "  {heading:<16}{}: {}", names.join(", "), why.words());
        }
    }
    text
}
