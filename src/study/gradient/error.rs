//! Why there are no derivatives.

use crate::case::CaseError;
use crate::drive::RunError;
use crate::integrate::stepper::Unfit;
use crate::output::gauges::derivatives::NoDerivative;
use crate::sensitivity::SensitivityError;
use crate::simulation::SetupError;

/// Why there are no derivatives.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GradientError {
    /// A key that is no parameter.
    #[error("--by {key}: {why}")]
    Key {
        /// as it was given
        key: String,
        /// why
        why: String,
    },
    /// The case with a value beside that of a key is bad.
    #[error("--by {key}: its derivative needs the case with {key}={value:e} too, which is refused:\n{source}")]
    Beside {
        /// the key
        key: String,
        /// the value
        value: f64,
        /// why
        source: CaseError,
    },
    /// A case that is bad.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// A scene that cannot be built.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The method does not fit the scene.
    #[error(transparent)]
    Method(#[from] Unfit),
    /// The run cannot start.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A quantity without derivative.
    #[error(transparent)]
    Quantity(#[from] NoDerivative),
    /// The scene, a parameter or the method has no derivative.
    #[error(transparent)]
    Sensitivity(#[from] SensitivityError),
    /// A part of the run has no derivative.
    #[error("{what}; such a run has no derivative yet: {advice}")]
    Without {
        /// what it has
        what: String,
        /// what can be done
        advice: &'static str,
    },
    /// The run fails.
    #[error("the run fails after t = {t} s: {why}")]
    Failed {
        /// [s] last good time
        t: f64,
        /// why
        why: String,
    },
    /// Ctrl-C.
    #[error("interrupted")]
    Interrupted,
}

impl GradientError {
    /// 1 for the system, 2 for what a person can set right, 3 for a run that fails, 130 for an interrupt.
    pub fn exit_status(&self) -> u8 {
        match self {
            GradientError::Case(error) | GradientError::Beside { source: error, .. } => error.exit_status(),
            GradientError::Setup(SetupError::Threads(_)) => 1,
            GradientError::Failed { .. } => 3,
            GradientError::Interrupted => 130,
            _ => 2,
        }
    }
}
