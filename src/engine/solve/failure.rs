//! Why Newton's iteration failed, with its numbers.

use super::LinearError;

/// Why Newton's iteration failed.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum NewtonFailure {
    /// The tolerance was not reached within the allowed iterations.
    #[error(
        "Newton's iteration did not converge in {iterations} iterations: residual {residual:.3e} N against a tolerance of {tolerance:.3e} N"
    )]
    MaxIterations {
        /// iterations made
        iterations: u32,
        /// [N] last residual
        residual: f64,
        /// [N] its tolerance
        tolerance: f64,
        /// unknown with the largest residual
        worst: usize,
    },
    /// The line search found no smaller residual along Newton's direction.
    #[error(
        "Newton's iteration {iterations} is stuck: no step along its direction lowers the residual {residual:.3e} N (tolerance {tolerance:.3e} N)"
    )]
    Stuck {
        /// iterations made
        iterations: u32,
        /// [N] last residual
        residual: f64,
        /// [N] its tolerance
        tolerance: f64,
        /// unknown with the largest residual
        worst: usize,
    },
    /// The residual at the start is not finite.
    #[error("the residual is not finite at the start of the step")]
    NotFinite {
        /// an unknown whose residual is not finite
        worst: usize,
    },
    /// Rounding of the residual is as large as the forces: no iteration improves on the first guess, or the final
    /// residual is far above all forces.
    #[error(
        "the forces of the stiffest springs have rounding errors of {rounding:.1e} N, and only {forces:.1e} N act on the scene: rounding hides the motion"
    )]
    Hidden {
        /// iterations made
        iterations: u32,
        /// [N] rounding of the residual
        rounding: f64,
        /// [N] largest of the sums of inertia, internal and external forces
        forces: f64,
        /// unknown with the largest residual
        worst: usize,
    },
    /// The tangent could not be factorised.
    #[error("iteration {iterations}: {error}")]
    Linear {
        /// iterations made
        iterations: u32,
        /// the reason
        error: LinearError,
        /// unknown with the largest residual
        worst: usize,
    },
}

impl NewtonFailure {
    /// Iterations made.
    pub fn iterations(&self) -> u32 {
        match self {
            NewtonFailure::MaxIterations { iterations, .. }
            | NewtonFailure::Stuck { iterations, .. }
            | NewtonFailure::Hidden { iterations, .. }
            | NewtonFailure::Linear { iterations, .. } => *iterations,
            NewtonFailure::NotFinite { .. } => 0,
        }
    }

    /// The unknown with the largest residual.
    pub fn worst(&self) -> usize {
        match self {
            NewtonFailure::MaxIterations { worst, .. }
            | NewtonFailure::Stuck { worst, .. }
            | NewtonFailure::Hidden { worst, .. }
            | NewtonFailure::NotFinite { worst }
            | NewtonFailure::Linear { worst, .. } => *worst,
        }
    }
}
