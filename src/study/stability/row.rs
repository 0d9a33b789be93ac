//! What is known of a method in the end: a row of the table.

use super::measure::{Halt, MethodRuns};
use super::perturbation::Start;
use super::search::Bracket;
use super::{Kind, Prediction, Verdict};
use crate::case::schema::Method;
use crate::drive::Failure;
use crate::integrate::registry::MethodChoice;
use crate::study::row::label;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Relative difference that needs no explanation.
pub(super) const AGREES: f64 = 0.02;

/// Whether a method was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// it was
    Measured,
    /// runs beyond the predicted limit hold, too short for growth to be seen: it lies between `at_least` and `at_most`
    NotSettled,
    /// it does not go with the scene
    Refused,
    /// the budget was spent before
    OutOfBudget,
    /// the user stopped the study
    Interrupted,
}

/// One run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunRow {
    /// where it began
    pub start: Start,
    /// [s] its step
    pub step: f64,
    /// steps it was to make
    pub steps: u64,
    /// steps it made
    pub made: u64,
    /// [s] time of its last good state
    pub t_end: f64,
    /// [-] largest kinetic and elastic energy over all energy supplied so far
    pub peak: f64,
    /// [-] mean energy of motion over the last quarter of the run, over all energy supplied
    pub lively: f64,
    /// what came of it
    pub verdict: Verdict,
}

/// What the scene's own start gives, where small motion was measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AsGiven {
    /// [s] largest step that held; 0 if none did
    pub measured: Option<f64>,
    /// [s] least step above it that did not hold
    pub unstable: Option<f64>,
    /// whether the limit lies between them; else runs between them held that were too short for growth to be seen
    pub settled: bool,
}

/// A method, its predicted and its measured largest stable step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// name in a case, with the parameters that are not the default ones
    pub method: String,
    /// all parameters
    pub parameters: BTreeMap<String, f64>,
    /// whether it was measured
    pub status: Status,
    /// why it was not
    pub why: Option<String>,
    /// what theory says at t = 0
    pub prediction: Prediction,
    /// where the runs behind the next numbers began
    pub start: Start,
    /// [s] largest step that held; null if no failing step was found (`tried_up_to`) or none that holds
    pub measured: Option<f64>,
    /// [s] least step above it that did not hold
    pub unstable: Option<f64>,
    /// [s] longest step tried by a method that held at every step
    pub tried_up_to: Option<f64>,
    /// [s] where a limit is not settled, or the study ended before: largest step known to hold
    pub at_least: Option<f64>,
    /// [s] where a limit is not settled, or the study ended before: least step known to fail
    pub at_most: Option<f64>,
    /// what runs from the scene's own start gave, where `start` is small motion: the scene's own motion is linear, and
    /// steps near the limit are not
    pub as_given: Option<AsGiven>,
    /// [-] measured over predicted
    pub ratio: Option<f64>,
    /// whether they differ by more than 2 %, or may
    pub differs: bool,
    /// why they differ, or may
    pub explanation: Option<String>,
    /// the failure of a run at `unstable`
    pub failure: Option<Failure>,
    /// all runs, in the order they were made
    pub runs: Vec<RunRow>,
}

/// A whole study, as `stability.json` holds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stability {
    /// name of the case
    pub name: String,
    /// [s] end of the case
    pub end: f64,
    /// free degrees of freedom
    pub unknowns: u64,
    /// a row a method
    pub methods: Vec<Row>,
    /// the case as it was studied
    pub case: serde_json::Value,
    /// version of the program
    pub version: String,
}

impl Row {
    pub(super) fn new(method: &MethodChoice, prediction: Prediction) -> Self {
        let other = method.parameters().zip(method.info.parameters).filter(|((_, value), p)| p.default != *value);
        let parameters = other.map(|((name, value), _)| (name.to_owned(), value)).collect();
        Row {
            method: label(&Method { name: method.info.name.to_owned(), parameters }),
            parameters: method.parameters().map(|(name, value)| (name.to_owned(), value)).collect(),
            status: Status::Measured,
            why: None,
            prediction,
            start: Start::AsGiven,
            measured: None,
            unstable: None,
            tried_up_to: None,
            at_least: None,
            at_most: None,
            as_given: None,
            ratio: None,
            differs: false,
            explanation: None,
            failure: None,
            runs: Vec::new(),
        }
    }

    pub(super) fn made(&mut self, runs: &MethodRuns<'_>) {
        self.runs.extend(runs.trials.iter().map(|trial| trial.row));
    }

    pub(super) fn measured(&mut self, runs: &MethodRuns<'_>, bracket: Bracket) {
        let Bracket { stable, unstable } = bracket;
        self.unstable = unstable;
        match unstable {
            Some(_) => self.measured = Some(stable.unwrap_or(0.0)),
            None => self.tried_up_to = stable,
        }
        let predicted = self.prediction.step.filter(|step| *step > 0.0);
        self.ratio = predicted.zip(self.measured).map(|(predicted, measured)| measured / predicted);
        self.differs = match (runs.kind(), predicted) {
            (Kind::Near(_), Some(predicted)) => {
                let most = self.prediction.at_most.unwrap_or(predicted).max(predicted);
                let near = predicted * (1.0 - AGREES)..=most * (1.0 + AGREES);
                unstable.is_none() || !stable.is_some_and(|stable| near.contains(&stable))
            }
            // No limit, and none found.
            (Kind::Unlimited | Kind::Somewhere, _) => self.unstable.is_some(),
            (Kind::Near(_), None) => false,
        };
        if self.differs && stable.is_some_and(|longest| !runs.settles(longest)) {
            self.unsettled(Status::NotSettled, runs);
        }
        self.failure = unstable.filter(|_| self.differs || predicted.is_none()).and_then(|h| runs.failure(h));
    }

    /// Makes room for a measurement from small motion.
    pub(super) fn set_aside(&mut self) {
        let as_given = match self.status {
            Status::NotSettled => AsGiven { measured: self.at_least, unstable: self.at_most, settled: false },
            _ => AsGiven { measured: self.measured, unstable: self.unstable, settled: true },
        };
        self.clear(Status::Measured);
        self.as_given = Some(as_given);
        self.start = Start::SmallMotion;
    }

    /// No limit, but what runs know of it.
    fn unsettled(&mut self, status: Status, runs: &MethodRuns<'_>) {
        self.status = status;
        (self.measured, self.unstable, self.tried_up_to, self.ratio) = (None, None, None, None);
        [self.at_least, self.at_most] = runs.between();
    }

    /// A row without a measurement.
    fn clear(&mut self, status: Status) {
        self.status = status;
        (self.measured, self.unstable, self.tried_up_to, self.ratio) = (None, None, None, None);
        (self.at_least, self.at_most, self.differs, self.failure) = (None, None, false, None);
    }

    /// A measurement that was not finished: what the runs that were made of `runs` know.
    pub(super) fn halted(&mut self, halt: Halt, runs: Option<&MethodRuns<'_>>) {
        self.clear(match halt {
            Halt::OutOfBudget => Status::OutOfBudget,
            Halt::Interrupted => Status::Interrupted,
            Halt::Refused(_) => Status::Refused,
        });
        match (halt, runs) {
            (Halt::Refused(why), _) => self.why = Some(why),
            (_, Some(runs)) => [self.at_least, self.at_most] = runs.between(),
            (_, None) => {}
        }
    }
}
