//! Why a measured limit is not the predicted one, from evidence.

use super::classify::STAYS;
use super::measure::{E_FOLDS, MethodRuns};
use super::{Kind, KnownBy, Row, Start, Verdict};
use crate::analysis::critical::{CostLimits, CriticalStep};
use crate::analysis::spectrum::Spectrum;
use crate::format_number::figures;
use crate::integrate::registry::Family;
use crate::model::state::State;
use crate::scene::place_of;

/// Relative change of a critical step that explains something.
const CLEAR: f64 = 0.015;
/// Estimates are this good where damping couples motions.
const ESTIMATE: f64 = 0.1;
/// [-] a swing of the energy that explains something
const SWINGS: f64 = 3.0;
/// A critical step this much above the failing one still explains it.
const ENOUGH: f64 = 0.05;

pub(super) fn explain(row: &mut Row, runs: &MethodRuns<'_>) {
    if row.differs {
        row.explanation = Some(match runs.kind {
            Kind::Near(predicted) => limited(row, runs, predicted),
            Kind::Somewhere if row.prediction.step == Some(0.0) => slow_from_zero(row, runs),
            Kind::Somewhere => not_at_the_start(row, runs),
            Kind::Unlimited => unlimited(row, runs),
        });
    }
}

fn limited(row: &Row, runs: &MethodRuns<'_>, predicted: f64) -> String {
    match row.measured {
        Some(measured) if measured < predicted => too_early(row, runs, measured),
        _ => too_late(row, runs, runs.longest().unwrap_or(predicted)),
    }
}

/// Runs fail below the predicted step.
fn too_early(row: &Row, runs: &MethodRuns<'_>, measured: f64) -> String {
    let failed = row.runs.iter().find(|run| Some(run.step) == row.unstable);
    let fails = row.unstable.unwrap_or(measured);
    let peak = failed.map_or(0.0, |run| run.peak);
    let swings = (runs.stays > STAYS[0] && peak > SWINGS).then(|| {
        format!(
            "near its limit the method swings the energy of a stable motion many times (to {} times what was supplied in the run at {} s), \
             beyond where this scene's forces are linear",
            figures(peak, 3),
            figures(fails, 4),
        )
    });
    if let Some((t, later)) = along(runs, measured, 0).filter(|(_, later)| below(*later, row)) {
        let stiffens = format!(
            "{}: {}, in the run at {} s, {} (set around {}, w = {} rad/s, damping rate {} 1/s; at the start {} rad/s, {} 1/s)",
            what_changed(runs.critical, later),
            when(t),
            figures(measured, 4),
            fallen(later.step),
            place_of(runs.spec.scene, later.dof),
            figures(later.rates.frequency, 4),
            figures(later.rates.damping, 4),
            figures(runs.critical.rates.frequency, 4),
            figures(runs.critical.rates.damping, 4),
        );
        let enough = later.step < (1.0 + ENOUGH) * fails;
        return swings.filter(|_| !enough).map_or(stiffens.clone(), |swings| format!("{stiffens}; and {swings}"));
    }
    if let Some(swings) = swings {
        return swings;
    }
    if coupled(runs) && row.prediction.known_by == KnownBy::Estimate && row.ratio.unwrap_or(0.0) > 1.0 - ESTIMATE {
        return "the prediction is an estimate from the motions found, damping may couple them, and no stiffer state was seen in the run \
                that held"
            .to_owned();
    }
    format!(
        "no state in the run at {} s has a critical step below the predicted one: forces are not linear over a step there (runs fail at \
         t = {} s){}",
        figures(measured, 4),
        figures(failed.map_or(0.0, |run| run.t_end), 4),
        because(row),
    )
}

/// Runs hold above the predicted step.
fn too_late(row: &Row, runs: &MethodRuns<'_>, held: f64) -> String {
    let middle = (held * row.prediction.step.unwrap_or(held)).sqrt();
    if !runs.settles(held) {
        return format!(
            "not settled: beyond the predicted limit no run that held was long enough for the {E_FOLDS} e-folds of growth that are sure to be \
             seen: {}; {}",
            growth(runs, middle),
            growth(runs, held)
        );
    }
    if runs.folds(middle) <= 0.0 {
        return format!(
            "the prediction is an estimate, and too small: a step of {} s does not grow where forces are linear either",
            figures(middle, 4)
        );
    }
    if let Some((t, later)) = along(runs, held, 1).filter(|(_, later)| above(*later, row)) {
        return format!("the scene softens: {}, in the run at {} s, {}", when(t), figures(held, 4), risen(later.step));
    }
    format!(
        "the motion that sets the prediction (around {}) did not grow without bound, though where forces are linear it grows enough to be \
         seen ({}): it is not reached, or forces that are not linear hold it",
        place_of(runs.spec.scene, runs.critical.dof),
        growth(runs, held)
    )
}

/// A method that grows at every step, measured over a number of steps.
fn slow_from_zero(row: &Row, runs: &MethodRuns<'_>) -> String {
    let w = figures(runs.critical.rates.frequency, 4);
    let place = place_of(runs.spec.scene, runs.critical.dof);
    let held = row.measured.filter(|h| *h > 0.0).map(|h| growth(runs, h)).unwrap_or_default();
    let fails = row.unstable.map(|h| format!("; {}", growth(runs, h))).unwrap_or_default();
    let seen = row.measured.filter(|h| runs.folds(*h) >= E_FOLDS);
    let unlike =
        seen.map_or("", |_| "; the run that held would show it if forces were linear, so those that are not hold it");
    format!(
        "nothing damps the oscillation of {w} rad/s around {place}, so the method grows at every step and shows it when a run has \
         steps enough: {held}{fails}{unlike}"
    )
}

/// A scene that sets no limit at the start.
fn not_at_the_start(row: &Row, runs: &MethodRuns<'_>) -> String {
    match along(runs, row.measured.unwrap_or(0.0), 0).filter(|(_, later)| later.step.is_finite()) {
        Some((t, later)) => format!(
            "nothing sets a limit at the start, but {}: {} {} (set around {})",
            what_changed(runs.critical, later),
            when(t),
            limit(later.step),
            place_of(runs.spec.scene, later.dof)
        ),
        None => format!("nothing sets a limit at the start{}", because(row)),
    }
}

/// A method without limit on linear scenes.
fn unlimited(row: &Row, runs: &MethodRuns<'_>) -> String {
    let what = match row.runs.iter().find(|run| Some(run.step) == row.unstable).map(|run| run.verdict) {
        Some(Verdict::NotConverged) => "Newton's iteration does not converge",
        Some(Verdict::Grows) => "small motion grows",
        Some(Verdict::MotionStays) => "a motion goes on and on that dies out in shorter steps",
        Some(Verdict::NotFinite | Verdict::BlownUp) => "the motion blows up",
        _ => "the scheme makes energy that stays",
    };
    let why = match runs.method.info.family {
        Family::MatrixFree => "what acts outside the filter is explicit, and the filter is no exact solution",
        _ => "that every step is stable holds on linear scenes only",
    };
    format!("{why}: at {} s {what}{}", figures(row.unstable.unwrap_or(0.0), 4), because(row))
}

/// Whether there is more than one motion, and damping.
fn coupled(runs: &MethodRuns<'_>) -> bool {
    let free = runs.spec.scene.inverse_mass().iter().filter(|m| **m > 0.0).count();
    free > 1 && runs.spec.scene.velocity_dependent()
}

/// "at 0.1 s it grows by 2 % a step, 7.9 e-folds in 400 steps"
fn growth(runs: &MethodRuns<'_>, h: f64) -> String {
    let Some(rate) = runs.e_folds(h) else { return format!("at {} s no step can be made", figures(h, 4)) };
    format!(
        "at {} s it grows by {} % a step, {} e-folds in {} steps",
        figures(h, 4),
        figures(100.0 * rate.exp_m1(), 3),
        figures(runs.folds(h), 3),
        runs.steps(h)
    )
}

/// The words of `solve`; of a motion of some 1e-8 of the scene's size they are about nothing.
fn because(row: &Row) -> String {
    row.failure
        .as_ref()
        .filter(|_| row.start == Start::AsGiven)
        .map(|failure| format!("; {}", failure.cause))
        .unwrap_or_default()
}

/// The critical step where the run at step `h` [s] was stiffest (0) or softest (1).
fn along(runs: &MethodRuns<'_>, h: f64, which: usize) -> Option<(f64, CriticalStep)> {
    let state: &State = runs.trial(h)?.extremes.get(which)?;
    let effort = CostLimits { stop: runs.stop(), ..CostLimits::START };
    let critical = Spectrum::with(runs.spec.scene, state.as_ref(), effort).critical_step(runs.method);
    Some((state.t, critical))
}

/// What makes a critical step fall: a scene stiffens where its frequency rises, and only there.
fn what_changed(start: CriticalStep, later: CriticalStep) -> &'static str {
    let (was, is) = (start.rates, later.rates);
    if is.frequency > (1.0 + CLEAR) * was.frequency {
        "the scene stiffens"
    } else if is.damping > (1.0 + CLEAR) * was.damping {
        "damping rises"
    } else if is.damping < (1.0 - CLEAR) * was.damping {
        "damping falls"
    } else {
        "another motion sets the limit"
    }
}

/// A run starts a little beside the scene's own start, which is where a slack spring may be taut and a taut one slack.
fn when(t: f64) -> String {
    if t == 0.0 { "right at the start, a little displaced".to_owned() } else { format!("at t = {} s", figures(t, 4)) }
}

fn fallen(step: f64) -> String {
    if step > 0.0 { format!("the critical step has fallen to {} s", figures(step, 4)) } else { limit(step) }
}

fn risen(step: f64) -> String {
    if step.is_finite() { format!("the critical step has risen to {} s", figures(step, 4)) } else { limit(step) }
}

fn limit(step: f64) -> String {
    if step == 0.0 {
        "no step is stable".to_owned()
    } else if step.is_finite() {
        format!("the critical step is {} s", figures(step, 4))
    } else {
        "nothing limits the step any more".to_owned()
    }
}

fn below(later: CriticalStep, row: &Row) -> bool {
    later.step < (1.0 - CLEAR) * row.prediction.step.unwrap_or(0.0)
}

fn above(later: CriticalStep, row: &Row) -> bool {
    later.step > (1.0 + CLEAR) * row.prediction.step.unwrap_or(f64::INFINITY)
}
