//! Why a run has no derivative.

use crate::assembly::PatternError;
use crate::solve::LinearError;

/// Why a run has no derivative.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum SensitivityError {
    /// The method has no derivative.
    #[error("the derivative of a step by {method} is not known; methods that have one: {known}")]
    Method {
        /// the method
        method: &'static str,
        /// those that have one
        known: String,
    },
    /// Parts of the scene may touch.
    #[error("contact has no derivative: leave out the contacts, or take differences of whole runs by a sweep")]
    Contact,
    /// With another value of the parameter the scene is another one.
    #[error("{parameter} changes {what}, which has no derivative")]
    OtherScene {
        /// the parameter
        parameter: String,
        /// what is different
        what: &'static str,
    },
    /// A scheme of a program's own does not tell all that its derivative needs.
    #[error(
        "the scheme does not tell the accelerations of stage {number}, which is implicit (Integrator::stage_acceleration)"
    )]
    Stage {
        /// stage, counted from 0
        number: usize,
    },
    /// The matrix of a step cannot be set up.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// The derivative of a step cannot be solved for.
    #[error("the derivative of the step to t = {t} s cannot be solved for: {source}")]
    Linear {
        /// [s]
        t: f64,
        /// why
        source: LinearError,
    },
    /// A derivative is not finite.
    #[error("the derivative with respect to {parameter} is not finite at t = {t} s")]
    NotFinite {
        /// the parameter
        parameter: String,
        /// [s]
        t: f64,
    },
}
