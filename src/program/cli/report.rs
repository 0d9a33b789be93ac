//! The report of `canopy-fem solve` on a finished run, and what it says of a failed one.

use super::progress::LONG_START;
use super::stages;
use super::terminal::coloured;
use crate::analysis::warnings::worth;
use crate::drive::event::{Fired, Landing};
use crate::drive::lost_payload::LostPayload;
use crate::drive::max_displacement::Displacement;
use crate::drive::{Failure, Outcome, Status};
use crate::format_number::{counted, figures, with_error};
use crate::mesh::with_groups;
use crate::model::gauge::ReportLine;
use crate::output::folder::{CHECKPOINT, frames_of};
use crate::output::gauges::Peak;
use crate::output::summary::Summary;
use crate::simulation::Recorded;
use anstyle::AnsiColor;
use std::fmt::Write;
use std::path::Path;

/// [-] Energy error below which a run is called good. Speeds go with the root of the kinetic energy, so none of them is
/// off by more than half a per cent of the largest by what the scheme did to the energy.
const GOOD: f64 = 0.01;
/// [-] Energy error from which a run is called wrong: speeds may be off by a twentieth, and where it is energy that the
/// scheme made, a part of the motion is not the scene's.
const WRONG: f64 = 0.1;

/// The report on the run of a case of this name, whose results are in `out`; `errors` are lines on the errors of its
/// numbers.
pub(super) fn report(name: &str, recorded: &Recorded, errors: &str, out: &Path) -> String {
    let Recorded { spec, outcome, summary, last_frame, .. } = recorded;
    let status = match outcome.status {
        Status::Completed => "completed",
        Status::Diverged => "diverged",
        Status::NotConverged => "not converged",
        Status::Interrupted => "interrupted",
    };
    let failed = outcome.failure.is_some();
    let t = figures(outcome.t_end, 12);
    let steps = counted(outcome.steps, "step", "steps");
    let mut text = format!("{name}: {status} at t = {t} s after {steps} of {}\n", spec.method.info.name);
    match summary.at_rest {
        Some(true) => text.push_str("  at rest         yes, so the run ended before its time\n"),
        Some(false) if !failed => text.push_str("  at rest         no\n"),
        _ => {}
    }
    if let Some(t) = summary.resumed_from {
        let _ = writeln!(text, "  resumed         from t = {} s", figures(t, 12));
    }
    if let Some(added) = &summary.mass_scaling {
        let _ = writeln!(text, "  mass scaling    {}", added.text());
    }
    describe_events(&mut text, outcome);
    if let Some(LostPayload { time, last }) = &summary.payload_lost {
        let t = figures(*time, 8);
        let _ = writeln!(text, "  payload         lost at t = {t} s: no canopy holds it after {last} has broken");
    }
    describe_cost(&mut text, outcome, summary);
    if !failed {
        let _ = writeln!(text, "  energy error    {}", energy_verdict(outcome));
    }
    // For adaptive steps, their average.
    let fixed = spec.step.fixed().map(|step| step.min(spec.end));
    let step = fixed.unwrap_or(outcome.t_end / outcome.steps.max(1) as f64);
    if let Some(tolerance) = spec.step.tolerance() {
        let _ = writeln!(
            text,
            "  adaptive        tolerance {:e} of the motion and {}; {step:.2e} s a step on average, {} dropped",
            tolerance.relative,
            figures(tolerance.absolute, 3),
            counted(outcome.rejected_steps, "attempt", "attempts")
        );
    }
    if failed {
        // After a divergence, error, displacement and share of the critical step have no meaning.
        if let Some(t) = *last_frame {
            let _ = writeln!(text, "  last frame      t = {} s", figures(t, 12));
        }
    } else {
        describe_motion(&mut text, recorded, step);
        text.push_str(errors);
    }
    let results = frames_of(out, name);
    let _ = writeln!(text, "  results         {}", results.display());
    if outcome.status == Status::Interrupted {
        let path = out.join(CHECKPOINT);
        let _ =
            writeln!(text, "  checkpoint      {}; the same command with --resume goes on from there", path.display());
    }
    text
}

/// Lines of a report on springs that break, before the others are only counted.
const BROKEN: usize = 8;

/// The events that had to be found in the run, and those that were not met.
fn describe_events(text: &mut String, outcome: &Outcome) {
    let found = || outcome.fired.iter().filter(|fired| !fired.told && fired.landing.is_none());
    for Fired { t, name, what, place, velocity, .. } in found().take(BROKEN) {
        let [x, y, z] = *velocity;
        let (t, height, speed) = (figures(*t, 8), figures(place[2], 5), figures(x.hypot(y).hypot(z), 4));
        let _ = writeln!(
            text,
            "  event           t = {t} s: {name}, {what}, at z = {height} m and {speed} m/s over ground"
        );
    }
    let more = found().count().saturating_sub(BROKEN);
    if more > 0 {
        let _ = writeln!(text, "  events          {more} more, in the summary");
    }
    for (t, landing) in outcome.fired.iter().filter_map(|fired| Some((fired.t, fired.landing?))) {
        let Landing { speed, descent, drift, heading } = landing;
        let towards =
            heading.map_or_else(String::new, |heading| format!(" towards {} deg from north", figures(heading, 3)));
        let [t, speed, descent, drift] =
            [(t, 8), (speed, 4), (descent, 4), (drift, 5)].map(|(n, digits)| figures(n, digits));
        let _ = writeln!(
            text,
            "  landing         t = {t} s with {speed} m/s, {descent} m/s of it downward; drift {drift} m{towards}"
        );
    }
    if !outcome.unmet.is_empty() {
        let _ = writeln!(text, "  never fired     {}", outcome.unmet.join(", "));
    }
}

fn describe_cost(text: &mut String, outcome: &Outcome, summary: &Summary) {
    let cpu = summary.cpu_seconds.map_or_else(|| "unknown".to_owned(), |s| format!("{s:.2} s"));
    let _ = writeln!(text, "  cost            {cpu} CPU, {:.2} s wall", summary.wall_seconds);
    if summary.startup.wall_seconds > LONG_START {
        let _ = writeln!(text, "  start-up        {}", summary.startup.text());
    }
    let c = outcome.counters;
    let work = [
        (c.force_evaluations, "force pass", "force passes"),
        (c.factorizations, "factorisation", "factorisations"),
        (c.newton_iterations, "Newton iteration", "Newton iterations"),
        (c.cg_iterations, "iteration of conjugate gradients", "iterations of conjugate gradients"),
        (c.sweeps, "sweep", "sweeps"),
    ];
    let work = work.iter().filter(|(n, ..)| *n > 0).map(|(n, one, many)| counted(*n, one, many));
    let _ = writeln!(text, "  work            {}", work.collect::<Vec<_>>().join(", "));
}

/// Critical step, displacement and peaks of a run that did not fail; `step` [s] is that of the run.
fn describe_motion(text: &mut String, recorded: &Recorded, step: f64) {
    let Recorded { summary, limits, least, displacement, displaced, .. } = recorded;
    if summary.critical_step == Some(0.0) {
        let _ = writeln!(text, "  critical step   none: the method's energy grows at every step here");
    } else if let Some(critical) = summary.critical_step {
        let later = least
            .map_or_else(String::new, |least| format!(", about {:.2e} s at t = {} s", least.step, figures(least.t, 4)));
        let (known, used) = (worth(limits.taut), figures(100.0 * step / critical, 2));
        let at_start = match &limits.while_slack {
            Some(slack) => format!("with all springs taut, {} while {} are slack", slack.step(), slack.springs()),
            None => "at the start".to_owned(),
        };
        let _ = writeln!(text, "  critical step   {critical:.2e} s {at_start} ({known}; {used} % of it used){later}");
    }
    let Displacement { distance, .. } = displacement;
    let error = summary.quantities.get("displacement_end").and_then(|quantity| quantity.error);
    let distance = if error.is_some() { with_error(*distance, error) } else { format!("{distance:.6}") };
    let _ = writeln!(text, "  displacement    {distance} m at the end, the largest, of {displaced}");
    summary.peaks.iter().filter_map(peak).for_each(|line| text.push_str(&line));
    text.push_str(&stages::lines(&summary.stages));
}

/// What the energy error says of a run. Whether energy was lost or made is told by the account at the end, so it is
/// "lost or made" where the two had cancelled by then.
fn energy_verdict(outcome: &Outcome) -> String {
    let error = outcome.energy_error;
    let at_end = outcome.ledger.numerical;
    let did = match (outcome.energy_made > GOOD, at_end > 0.0) {
        (true, _) => "the scheme made energy of its own",
        (false, true) => "the scheme took energy from the motion",
        (false, false) => "energy comes and goes with the steps",
    };
    let (word, colour, why) = match error {
        good if good < GOOD => ("good", AnsiColor::Green, "below 1 %".to_owned()),
        fair if fair < WRONG => ("doubtful", AnsiColor::Yellow, format!("above 1 %: {did}; take shorter steps")),
        _ => ("wrong", AnsiColor::Red, format!("above 10 %: {did}; take much shorter steps, or another method")),
    };
    format!("{error:.2e} of the energy that was exchanged: {} ({why})", coloured(word, colour))
}

/// A line of the report for a value that a reader looks for first: opening load, speed of descent, largest loads.
/// The drag of a canopy that starts full is no opening load.
fn peak(one: &Peak) -> Option<String> {
    let Peak { t, steady, strength, safety_factor, line, .. } = one;
    let (name, unit) = (one.shown(), if one.unit == "-" { "" } else { &format!(" {}", one.unit) });
    let drag = if *t > 0.0 { "opening load" } else { "largest drag" };
    let [value, last] = [with_error(one.value, one.error), with_error(one.last, one.last_error)];
    let t = figures(*t, 4);
    let line = match ((*line)?, strength, safety_factor) {
        (ReportLine::Drag, ..) => format!("  {drag}    {value}{unit} at t = {t} s ({name}, drag)"),
        (ReportLine::Descent, ..) => {
            let steady = if *steady { "steady" } else { "at the end, still changing" };
            format!("  speed           {last}{unit} {steady} ({name}, against the air)")
        }
        (ReportLine::Ratio { symbol, of }, ..) => format!("  {symbol:<16}{last}{of} at the end ({name})"),
        (ReportLine::Peak(_), Some(strength), Some(factor)) => format!(
            "  {:<16}{value}{unit} at t = {t} s ({name}), strength {}{unit}: safety factor {}{}",
            if one.unit == "N" { "line load" } else { "cloth stress" },
            figures(*strength, 4),
            figures(*factor, 3),
            if *factor < 1.0 - 1e-6 { ", it would break" } else { "" }
        ),
        // Springs with a strength that carry nothing.
        (ReportLine::Peak(_), Some(_), None) => return None,
        (ReportLine::Peak(what), ..) => format!("  peak            {value}{unit} at t = {t} s ({name}, {what})"),
        (ReportLine::Told(what), ..) => {
            let at_end = if last == value { String::new() } else { format!(", {last}{unit} at the end") };
            format!("  peak            {value}{unit} at t = {t} s{at_end} ({name}, {what})")
        }
    };
    Some(line + "\n")
}

pub(super) fn already_done(summary: &Summary, name: &str, out: &Path) -> String {
    let t = figures(summary.t_end, 12);
    format!("{name}: already completed at t = {t} s, in {}; nothing is left to resume\n", out.display())
}

/// What went wrong, for standard error.
pub(super) fn describe(summary: &Summary, failure: &Failure) -> String {
    let status = summary.status;
    let what = if status == Status::NotConverged { "could not be solved" } else { "diverged" };
    let mut text = format!("error: step {} ending at t = {:.6e} s {what}\n", failure.step, failure.time);
    let groups = |what: &str| summary.failure_groups.get(what).map_or(&[][..], |names| names);
    let named = |what: &str, number: Option<u32>| number.map(|n| with_groups(what, n, groups(what)));
    let term = failure.term.as_ref().map(|t| format!("most force from {t}"));
    let elements = [named("node", failure.node), named("spring", failure.spring), named("triangle", failure.triangle)];
    let pair = failure.pair.as_ref().map(|pair| format!("pressed most between {pair}"));
    let place: Vec<String> = elements.into_iter().chain([term, pair]).flatten().collect();
    if !place.is_empty() {
        let _ = writeln!(text, "  where   {}", place.join(", "));
    }
    if let Some(grew) = &failure.grew {
        let _ = writeln!(text, "  grew    {grew}, most of all energies in this step");
    }
    let _ = writeln!(text, "  cause   {}", failure.cause);
    let _ = writeln!(text, "  advice  {}", failure.advice);
    text
}
