//! The result for one method, a row of the table: what theory predicts, and what runs measured.

use super::measure::{MethodRuns, StopReason};
use super::perturbation::Start;
use super::search::Bracket;
use super::{Kind, Verdict};
use crate::analysis::critical::{Confidence, CriticalStep, has_limit, outside_filter};
use crate::case::schema::Method;
use crate::drive::Failure;
use crate::integrate::registry::MethodChoice;
use crate::row::label;
use crate::scene::{Scene, fastest_spring};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// [-] Relative difference that needs no explanation.
pub(super) const AGREES: f64 = 0.02;

/// The predicted largest stable step at t = 0.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Prediction {
    /// [s] predicted largest stable step; null where there is none or it is not known
    pub step: Option<f64>,
    /// what it is worth
    pub known_by: KnownBy,
    /// [s] steps above are proved to be unstable; null where nothing is proved
    pub at_most: Option<f64>,
    /// node that moves most in the motion that sets it
    pub node: Option<u32>,
    /// fastest spring at that node
    pub spring: Option<u32>,
    /// [rad/s] frequency of that motion
    pub frequency: Option<f64>,
    /// [1/s] damping rate of that motion
    pub damping: Option<f64>,
}

/// How a prediction is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum KnownBy {
    /// proved not to lie above the limit
    Certified,
    /// found by iteration on the linearised step
    Estimate,
    /// the method has no limit on linear scenes, or the scene sets none at t = 0
    Unlimited,
    /// not known: forces outside Kang's filter
    #[default]
    Unknown,
}

impl Prediction {
    pub(super) fn of(scene: &dyn Scene, method: &MethodChoice, critical: CriticalStep) -> Self {
        if outside_filter(method, scene) {
            return Prediction::default();
        }
        if !has_limit(method) || critical.step.is_infinite() {
            return Prediction { known_by: KnownBy::Unlimited, ..Prediction::default() };
        }
        let (known_by, at_most) = match critical.confidence {
            Confidence::Certified { at_most } => (KnownBy::Certified, Some(at_most).filter(|s| s.is_finite())),
            Confidence::Estimate | Confidence::NoLimit => (KnownBy::Estimate, None),
        };
        Prediction {
            step: Some(critical.step),
            known_by,
            at_most,
            node: Some(scene.name_of(critical.dof).0),
            spring: fastest_spring(scene, critical.dof),
            frequency: Some(critical.rates.frequency),
            damping: Some(critical.rates.damping),
        }
    }
}

/// Whether a method was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// it was
    #[default]
    Measured,
    /// runs beyond the predicted limit hold, too short for growth to be seen: it lies between `at_least` and `at_most`
    NotSettled,
    /// the method cannot run this scene
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
    /// [-] steps it was to make
    pub steps: u64,
    /// [-] steps it made
    pub made: u64,
    /// [s] time of its last good state
    pub t_end: f64,
    /// [-] largest kinetic and elastic energy over all energy supplied so far
    pub peak: f64,
    /// [-] mean energy of motion over the last quarter of the run, over all energy supplied
    pub lively: f64,
    /// how it ended
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
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
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
    /// [-] free degrees of freedom
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
            prediction,
            ..Row::default()
        }
    }

    /// Takes the bracket that a search with these runs found.
    pub(super) fn measured(&mut self, runs: &MethodRuns<'_>, Bracket { stable, unstable }: Bracket) {
        self.unstable = unstable;
        match unstable {
            Some(_) => self.measured = Some(stable.unwrap_or(0.0)),
            None => self.tried_up_to = stable,
        }
        let predicted = self.prediction.step.filter(|step| *step > 0.0);
        self.ratio = predicted.zip(self.measured).map(|(predicted, measured)| measured / predicted);
        self.differs = match (runs.kind, predicted) {
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
            let differs = self.differs;
            self.clear(Status::NotSettled);
            self.differs = differs;
            [self.at_least, self.at_most] = runs.between();
        }
        self.failure = unstable.filter(|_| self.differs || predicted.is_none()).and_then(|h| runs.failure(h));
    }

    /// Moves the result from the scene's own start to `as_given`, before small motion is measured.
    pub(super) fn set_aside(&mut self) {
        let as_given = match self.status {
            Status::NotSettled => AsGiven { measured: self.at_least, unstable: self.at_most, settled: false },
            _ => AsGiven { measured: self.measured, unstable: self.unstable, settled: true },
        };
        self.clear(Status::Measured);
        self.as_given = Some(as_given);
        self.start = Start::SmallMotion;
    }

    fn clear(&mut self, status: Status) {
        self.status = status;
        (self.measured, self.unstable, self.tried_up_to, self.ratio) = (None, None, None, None);
        (self.at_least, self.at_most, self.differs, self.failure) = (None, None, false, None);
    }

    /// A measurement that was not finished: keeps the bounds that the runs made so far give.
    pub(super) fn halted(&mut self, halt: StopReason, runs: Option<&MethodRuns<'_>>) {
        self.clear(match halt {
            StopReason::OutOfBudget => Status::OutOfBudget,
            StopReason::Interrupted => Status::Interrupted,
            StopReason::Refused(_) => Status::Refused,
        });
        match (halt, runs) {
            (StopReason::Refused(why), _) => self.why = Some(why),
            (_, Some(runs)) => [self.at_least, self.at_most] = runs.between(),
            (_, None) => {}
        }
    }
}
