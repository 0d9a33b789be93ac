//! Errors of a run that could not start, or whose results could not be written.

use super::observer::ObserveError;
use crate::integrate::StepError;
use crate::model::abilities::Passage;

/// Why a run could not start, or its results could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The scheme cannot start.
    #[error(transparent)]
    Start(#[from] StepError),
    /// Results cannot be written.
    #[error(transparent)]
    Observe(#[from] ObserveError),
    /// A time or tolerance out of range.
    #[error("the {what} is {value}: {needed} is needed")]
    OutOfRange {
        /// e.g. "step [s]"
        what: &'static str,
        /// what was given
        value: f64,
        /// e.g. "a finite number above 0"
        needed: &'static str,
    },
    /// Parts that contact should keep apart touch before the first step.
    #[error("{} touch or cross at the start: contact keeps apart what begins apart, so place them apart", .0.pair)]
    Closed(Passage),
    /// A state does not fit the scene.
    #[error("the state has {found} degrees of freedom, the scene {needed}")]
    OtherState {
        /// degrees of freedom of the state
        found: usize,
        /// degrees of freedom of the scene
        needed: usize,
    },
    /// The snapshot is of another scene.
    #[error("the saved state has {found} degrees of freedom, the scene {needed}")]
    OtherScene {
        /// degrees of freedom of the snapshot
        found: usize,
        /// degrees of freedom of the scene
        needed: usize,
    },
    /// The snapshot is of a scene with other force terms.
    #[error("the saved forces are those of a scene with other loads, damping or supports")]
    OtherForces,
    /// The run does not pass through the snapshot.
    #[error(
        "the saved state is at t = {t} s after {step} steps, which a run of {steps} steps until t = {end} s does not reach"
    )]
    NotOnTheWay {
        /// [s] time of the snapshot
        t: f64,
        /// its steps
        step: u64,
        /// steps of the run
        steps: u64,
        /// [s] end of the run
        end: f64,
    },
}
