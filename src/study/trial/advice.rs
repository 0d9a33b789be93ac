//! Which method and which step to take for a wanted accuracy.

use super::estimate::{Estimate, two_digits};
use super::{Candidate, Row, safe_step};
use crate::integrate::registry::Family;

/// A method with its steps for an accuracy.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Choice {
    /// name in a case
    pub method: &'static str,
    /// [-] relative tolerance of adaptive steps
    pub tolerance: f64,
    /// [s] processor time of the run with these
    pub cpu_seconds: f64,
    /// [s] fixed step of about the same accuracy, two digits, stable; null for a method without stable step
    pub step: Option<f64>,
    /// the run with that step
    pub fixed: Option<Estimate>,
}

/// What to take.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Advice {
    /// [-] wanted accuracy, relative to the motion
    pub accuracy: f64,
    /// the cheapest
    pub best: Choice,
    /// the cheapest of the other family: implicit against explicit
    pub runner_up: Option<Choice>,
    /// [-] how many times the runner-up costs what the best does
    pub factor: Option<f64>,
}

impl Choice {
    /// [s] The cheaper of adaptive and fixed steps.
    pub fn least_seconds(&self) -> f64 {
        self.fixed.map_or(self.cpu_seconds, |fixed| fixed.cpu_seconds.min(self.cpu_seconds))
    }
}

/// [-] What a prediction is uncertain by at least: the case's own method need not be cheaper by that to be taken.
const NOISE: f64 = 0.1;

/// The cheapest method for an accuracy (or the case's `own`, if it is hardly dearer) and the cheapest of the other family; `fixed` predicts a run of a method with a step [s].
pub fn advise(
    accuracy: f64,
    own: &str,
    rows: &[Row],
    candidates: &[Candidate],
    mut fixed: impl FnMut(&str, f64) -> Option<Estimate>,
) -> Option<Advice> {
    let mut cheapest = |implicit: bool| {
        let family = rows.iter().filter(|row| (row.family == Family::Implicit) == implicit);
        let priced = family.filter_map(|row| Some((row, row.at_accuracy?)));
        let cost = |(row, estimate): &(&Row, Estimate)| {
            estimate.cpu_seconds * if row.method == own { 1.0 - NOISE } else { 1.0 }
        };
        let (row, estimate) = priced.min_by(|a, b| cost(a).total_cmp(&cost(b)))?;
        let limit = candidates.iter().find(|c| c.method.info.name == row.method).and_then(|c| c.limit);
        let step = match limit {
            Some(limit) if limit.step == 0.0 => None,
            Some(limit) if limit.step.is_finite() => Some(two_digits(estimate.mean_step).min(safe_step(limit))),
            _ => Some(two_digits(estimate.mean_step)),
        };
        let fixed = step.and_then(|step| fixed(row.method, step));
        let step = step.filter(|_| fixed.is_some());
        Some(Choice { method: row.method, tolerance: accuracy, cpu_seconds: estimate.cpu_seconds, step, fixed })
    };
    let (explicit, implicit) = (cheapest(false), cheapest(true));
    let (best, runner_up) = match (explicit, implicit) {
        (Some(a), Some(b)) if b.least_seconds() < a.least_seconds() => (b, Some(a)),
        (Some(a), b) => (a, b),
        (None, b) => (b?, None),
    };
    let factor = runner_up.as_ref().map(|other| other.least_seconds() / best.least_seconds());
    Some(Advice { accuracy, best, runner_up, factor })
}
