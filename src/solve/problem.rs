//! What Newton's iteration asks of a problem.

use super::{Accuracy, Expected, Inertia, LinearError};

/// Sizes that residuals and increments are compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// [N] size of the forces that the residual balances
    pub residual: f64,
    /// [m] size of the unknown
    pub increment: f64,
    /// [m] what rounding alone leaves of an increment
    pub increment_floor: f64,
}

/// Which tangent a direction is taken from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curvature {
    /// dF/dz
    Exact,
    /// dF/dz without what makes it indefinite
    Convex,
}

/// F(z) = 0, its tangent and a solver for it.
pub trait NonlinearProblem {
    /// Writes the residual r = F(z) and, one by one, what rounding alone can leave of it.
    fn residual(&mut self, z: &[f64], r: &mut [f64], floor: &mut [f64]);

    /// Called after the residual at a first guess `z`: replaces a guess that went too far by a more cautious one and
    /// says so; `false` keeps it.
    fn retreat(&mut self, z: &mut [f64]) -> bool {
        let _ = z;
        false
    }

    /// Whether F is the gradient of a potential.
    fn conservative(&self) -> bool {
        false
    }

    /// Factorises the tangent dF/dz where the residual was last evaluated. An exact tangent of a conservative problem
    /// that is indefinite need not be factorised: no direction is taken from it.
    ///
    /// # Errors
    /// A tangent that is not finite or singular.
    fn linearise(&mut self, curvature: Curvature) -> Result<Inertia, LinearError>;

    /// Factorises a symmetric positive definite approximation of the tangent where the residual was last evaluated, to
    /// be used for many solves; `false` if there is none to be had. `expected` is what it will be used for
    /// ([`super::LinearSolver::anticipate`]).
    ///
    /// # Errors
    /// A tangent that is not finite.
    fn freeze(&mut self, expected: Expected) -> Result<bool, LinearError> {
        let _ = expected;
        Ok(false)
    }

    /// Whether the factor of the last [`NonlinearProblem::freeze`] would be of another kind, had this been expected.
    fn prefers_another(&self, expected: Expected) -> bool {
        let _ = expected;
        false
    }

    /// Iterations of conjugate gradients so far.
    fn cg_iterations(&self) -> u64 {
        0
    }

    /// From now on [`NonlinearProblem::solve`] is with the factor of the last [`NonlinearProblem::freeze`], of an
    /// earlier problem too.
    fn take_frozen(&mut self) {}

    /// Whether there is a matrix to be kept over many solves.
    fn keeps(&self) -> bool {
        false
    }

    /// What further solves may leave of their right-hand sides; solvers that are exact take no notice.
    fn ask(&mut self, accuracy: Accuracy) {
        let _ = accuracy;
    }

    /// [N] Force that would stop the motion within the step: what moves on its own needs no other.
    fn stopping_force(&mut self) -> f64 {
        0.0
    }

    /// [-] cost of a factorisation in iterations on a factor that is there, by counted operations.
    fn factor_cost(&self) -> f64 {
        0.0
    }

    /// Replaces b by (dF/dz)^-1 b.
    ///
    /// # Errors
    /// A solution that is not finite, or a tangent that only now shows not to be positive definite.
    fn solve(&mut self, b: &mut [f64]) -> Result<(), LinearError>;
}
