//! Why a measured limit is not the predicted one, from evidence. The sentences are those of the template.

use super::classify::STAYS;
use super::measure::{E_FOLDS, MethodRuns};
use super::{Kind, KnownBy, Row, Start};
use crate::StudyError;
use crate::analysis::critical::{CostLimits, CriticalStep};
use crate::analysis::spectrum::Spectrum;
use crate::integrate::registry::Family;
use crate::scene::place_of;
use crate::template::render;
use minijinja::{Value, context};

/// Relative change of a critical step that explains something.
const CLEAR: f64 = 0.015;
/// Estimates are this good where damping couples motions.
const ESTIMATE: f64 = 0.1;
/// [-] a swing of the energy that explains something
const SWINGS: f64 = 3.0;
/// A critical step this much above the failing one still explains it.
const ENOUGH: f64 = 0.05;

pub(super) fn explain(row: &mut Row, runs: &MethodRuns<'_>) -> Result<(), StudyError> {
    if row.differs {
        let reason = match runs.kind {
            Kind::Near(predicted) => match row.measured {
                Some(measured) if measured < predicted => too_early(row, runs, measured),
                _ => too_late(row, runs, runs.longest().unwrap_or(predicted)),
            },
            Kind::Somewhere if row.prediction.step == Some(0.0) => slow_from_zero(row, runs),
            Kind::Somewhere => {
                let later = along(runs, row.measured.unwrap_or(0.0), 0).filter(|later| later.critical.step.is_finite());
                context! { why => "not-at-the-start", later => later.map(|later| later.shown(runs)) }
            }
            Kind::Unlimited => {
                let failed = row.runs.iter().find(|run| Some(run.step) == row.unstable);
                let (filtered, fails) = (runs.method.info.family == Family::MatrixFree, row.unstable.unwrap_or(0.0));
                context! { why => "unlimited", filtered, fails, verdict => failed.map(|run| run.verdict) }
            }
        };
        // The words of `solve`; of a motion of some 1e-8 of the scene's size they are about nothing.
        let cause = row.failure.as_ref().filter(|_| row.start == Start::AsGiven).map(|failure| &failure.cause);
        let start = State { t: 0.0, critical: runs.critical }.shown(runs);
        let text = include_str!("../templates/explain.txt");
        let text = render("explain.txt", text, &context! { cause, start, ..reason })?;
        row.explanation = Some(text.trim().to_owned());
    }
    Ok(())
}

/// Runs fail below the predicted step.
fn too_early(row: &Row, runs: &MethodRuns<'_>, measured: f64) -> Value {
    let failed = row.runs.iter().find(|run| Some(run.step) == row.unstable);
    let fails = row.unstable.unwrap_or(measured);
    let (peak, t_end) = failed.map_or((0.0, 0.0), |run| (run.peak, run.t_end));
    let below = (1.0 - CLEAR) * row.prediction.step.unwrap_or(0.0);
    let later = along(runs, measured, 0).filter(|later| later.critical.step < below);
    let enough = later.is_some_and(|later| later.critical.step < (1.0 + ENOUGH) * fails);
    let swings = runs.stays > STAYS[0] && peak > SWINGS && !enough;
    let scene = runs.spec.scene;
    let several = scene.inverse_mass().iter().filter(|m| **m > 0.0).count() > 1;
    let near = row.prediction.known_by == KnownBy::Estimate && row.ratio.unwrap_or(0.0) > 1.0 - ESTIMATE;
    let coupled = several && scene.velocity_dependent() && near;
    let later = later.map(|later| later.shown(runs));
    context! { why => "too-early", measured, fails, peak, t_end, swings, coupled, later }
}

/// Runs hold above the predicted step.
fn too_late(row: &Row, runs: &MethodRuns<'_>, longest: f64) -> Value {
    let step = (longest * row.prediction.step.unwrap_or(longest)).sqrt();
    let (middle, held) = (growth(runs, step), growth(runs, longest));
    let above = (1.0 + CLEAR) * row.prediction.step.unwrap_or(f64::INFINITY);
    if !runs.settles(longest) {
        return context! { why => "not-settled", e_folds => E_FOLDS, middle, held };
    }
    if runs.folds(step) <= 0.0 {
        return context! { why => "too-small", middle };
    }
    match along(runs, longest, 1).filter(|later| later.critical.step > above) {
        Some(later) => context! { why => "softens", held, later => later.shown(runs) },
        None => context! { why => "bounded", held },
    }
}

/// A method that grows at every step, measured over a number of steps.
fn slow_from_zero(row: &Row, runs: &MethodRuns<'_>) -> Value {
    let held = row.measured.filter(|h| *h > 0.0).map(|h| growth(runs, h));
    let fails = row.unstable.map(|h| growth(runs, h));
    let unlike = row.measured.is_some_and(|h| runs.folds(h) >= E_FOLDS);
    context! { why => "slow-from-zero", held, fails, unlike }
}

/// How the motion that sets the prediction grows in a run at step `h` [s].
fn growth(runs: &MethodRuns<'_>, h: f64) -> Value {
    let growth = runs.e_folds(h).map(f64::exp_m1);
    context! { step => h, growth, folds => runs.folds(h), steps => runs.steps(h) }
}

/// A state of a run, and its critical step.
#[derive(Clone, Copy)]
struct State {
    /// [s]
    t: f64,
    critical: CriticalStep,
}

/// The critical step where the run at step `h` [s] was stiffest (0) or softest (1).
fn along(runs: &MethodRuns<'_>, h: f64, which: usize) -> Option<State> {
    let state = runs.trial(h)?.extremes.get(which)?;
    let effort = CostLimits { stop: runs.stop(), ..CostLimits::START };
    let critical = Spectrum::with(runs.spec.scene, state.as_ref(), effort).critical_step(runs.method);
    Some(State { t: state.t, critical })
}

impl State {
    /// For the template.
    fn shown(self, runs: &MethodRuns<'_>) -> Value {
        let CriticalStep { step, rates: is, dof, .. } = self.critical;
        // A scene stiffens where its frequency rises, and only there.
        let was = runs.critical.rates;
        let change = if is.frequency > (1.0 + CLEAR) * was.frequency {
            "the scene stiffens"
        } else if is.damping > (1.0 + CLEAR) * was.damping {
            "damping rises"
        } else if is.damping < (1.0 - CLEAR) * was.damping {
            "damping falls"
        } else {
            "another motion sets the limit"
        };
        let place = place_of(runs.spec.scene, dof);
        context! { t => self.t, step, change, place, frequency => is.frequency, damping => is.damping }
    }
}
