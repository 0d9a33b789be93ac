//! What is known of one run of a study.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::compared_model::Model;
use super::ranking::QuantityResult;
use crate::case::schema::Method;
use crate::integrate::Counters;
use crate::integrate::registry::Family;

/// How a run goes through time, as a study writes it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StepSetting {
    /// [s] fixed steps of this size
    Step(f64),
    /// [-] adaptive steps within this share of the motion; the absolute tolerance is a hundredth of it, in metres
    Tolerance(f64),
}

/// One run of a study, before it is made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Job {
    /// name of its files; unique in the study
    pub id: String,
    /// number of the variant of the case, see [`super::plan::Variant`]
    pub variant: usize,
    /// its model, in a study that compares models
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<Model>,
    /// method and the parameters that were given
    pub method: Method,
    /// steps
    #[serde(flatten)]
    pub setting: StepSetting,
}

impl Job {
    /// Method and model in a word: `newmark`, `hht(alpha=-0.2)`, `newmark (net)`.
    pub fn label(&self) -> String {
        labelled(&self.method, self.model)
    }
}

/// How a run of a study ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RowStatus {
    /// reached the end
    Completed,
    /// left the physics
    Diverged,
    /// an implicit step could not be solved
    NotConverged,
    /// the method does not fit the scene
    Refused,
    /// not run, or not to its end: the budget was spent, or another shard has it
    #[default]
    NotRun,
}

impl RowStatus {
    /// The word in files.
    pub fn word(self) -> &'static str {
        match self {
            RowStatus::Completed => "completed",
            RowStatus::Diverged => "diverged",
            RowStatus::NotConverged => "not-converged",
            RowStatus::Refused => "refused",
            RowStatus::NotRun => "not-run",
        }
    }
}

/// What came of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunResult {
    /// how it ended
    pub status: RowStatus,
    /// why, and what to do, if not well
    pub note: String,
    /// [-] root mean square over frames and free nodes of the distance to the reference, over that of the reference's
    /// motion
    pub error: Option<f64>,
    /// [-] largest distance over the largest motion
    pub error_max: Option<f64>,
    /// quantities by name
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub quantities: BTreeMap<String, QuantityResult>,
    /// [-] largest numerical energy over the largest energy exchanged
    pub energy_error: Option<f64>,
    /// [s] processor time of every repeat
    pub repeats: Vec<f64>,
    /// accepted steps
    pub steps: u64,
    /// attempts of adaptive steps that were dropped
    pub rejected_steps: u64,
    /// [s] time it came to
    pub t_end: f64,
    /// counted work
    #[serde(flatten)]
    pub counters: Counters,
}

/// A run and what came of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// the run
    #[serde(flatten)]
    pub job: Job,
    /// what a step needs: `explicit`, `matrix-free` or `implicit`
    pub family: Family,
    /// what came of it
    #[serde(flatten)]
    pub measured: RunResult,
    /// [s] processor time, median of the repeats
    pub cpu_seconds: Option<f64>,
    /// whether no other run of its variant is both cheaper and more accurate, as [`super::ranking::Ranking`] has it
    pub pareto: bool,
}

impl Row {
    /// Method and model in a word, see [`Job::label`].
    pub fn label(&self) -> String {
        self.job.label()
    }
}

/// A method in a word, with its model if there is one.
pub(super) fn labelled(method: &Method, model: Option<Model>) -> String {
    let method = label(method);
    model.map_or(method.clone(), |model| format!("{method} ({})", model.words()))
}

/// A method in a word: `newmark`, `hht(alpha=-0.2)`.
pub fn label(method: &Method) -> String {
    if method.parameters.is_empty() {
        return method.name.clone();
    }
    let given = method.parameters.iter().map(|(name, value)| format!("{name}={value}"));
    format!("{}({})", method.name, given.collect::<Vec<_>>().join(","))
}

/// The middle of some numbers, the mean of the two middle ones for an even count; nothing for none.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let upper = *sorted.get(sorted.len() / 2)?;
    let lower = *sorted.get((sorted.len() - 1) / 2)?;
    Some(f64::midpoint(lower, upper))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[3.0]), Some(3.0));
        assert_eq!(median(&[9.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 9.0]), Some(3.0));
    }
}
