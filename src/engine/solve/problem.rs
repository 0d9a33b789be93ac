//! The problem that Newton's iteration solves.

use super::{Accuracy, ExpectedUse, Inertia, LinearError};
use crate::assembly::MixedForm;
use crate::model::spring_state::{SheetState, SpringState};

/// Sizes that residuals and increments are compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// [N] size of the forces that the residual balances
    pub residual: f64,
    /// [m] size of the unknown
    pub increment: f64,
    /// [m] increment that rounding alone can leave
    pub increment_floor: f64,
}

/// Which tangent gives a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curvature {
    /// dF/dz
    Exact,
    /// dF/dz without the parts that make it indefinite
    Convex,
}

/// F(z) = 0, its tangent and a solver for it.
pub trait NonlinearProblem {
    /// Writes the residual r = F(z) [N] and the rounding error each entry may have; both `[n]`.
    fn residual(&mut self, z: &[f64], r: &mut [f64], floor: &mut [f64]);

    /// Called after the residual at a first guess `z` `[n]`. Replaces a guess that goes too far by a more cautious one
    /// and returns `true`; `false` keeps it.
    fn replace_far_guess(&mut self, z: &mut [f64]) -> bool {
        let _ = z;
        false
    }

    /// Shortens the displacement `dz` `[n]` from `z` `[n]` of nodes that would pass through others or touch them.
    /// Returns the share that is free for all of them; `None` where nothing may touch.
    fn keep_apart(&mut self, z: &[f64], dz: &mut [f64]) -> Option<f64> {
        let _ = (z, dz);
        None
    }

    /// Whether anything pressed on anything else at the last evaluated residual.
    fn presses(&self) -> bool {
        false
    }

    /// Whether F is the gradient of a potential.
    fn conservative(&self) -> bool {
        false
    }

    /// Lets matrices that are solved with once be left to conjugate gradients, where that is less counted work;
    /// `expected` has the iterations of reused ones. `None`: all are factorised.
    fn leave_to_gradients(&mut self, expected: Option<ExpectedUse>) {
        let _ = expected;
    }

    /// Factorises the tangent dF/dz at the last evaluated residual. An indefinite exact tangent of a conservative
    /// problem need not be factorised: it gives no direction.
    ///
    /// # Errors
    /// A tangent that is not finite or singular.
    fn linearise(&mut self, curvature: Curvature) -> Result<Inertia, LinearError>;

    /// Factorises a symmetric positive definite approximation of the tangent at the last evaluated residual, for many
    /// solves. Returns `false` if there is none. `expected` is its expected use
    /// ([`super::LinearSolver::set_expected_use`]).
    ///
    /// # Errors
    /// A tangent that is not finite.
    fn freeze(&mut self, expected: ExpectedUse) -> Result<bool, LinearError> {
        let _ = expected;
        Ok(false)
    }

    /// [-] Steps that are to come in the run, with this one; infinite if its end is not known.
    fn steps_left(&self) -> f64 {
        f64::INFINITY
    }

    /// Whether [`NonlinearProblem::freeze`] would have chosen another solver for this expected use.
    fn prefers_other_solver(&self, expected: ExpectedUse) -> bool {
        let _ = expected;
        false
    }

    /// Iterations of conjugate gradients since the start of the run.
    fn cg_iterations(&self) -> u64 {
        0
    }

    /// [-] Cost of one of them with the reused matrix ([`super::LinearSolver::cg_cost`]).
    fn cg_cost(&self) -> f64 {
        1.0
    }

    /// Whether the reused matrix is solved with multigrid ([`super::LinearSolver::with_multigrid`]).
    fn with_multigrid(&self) -> bool {
        false
    }

    /// Makes [`NonlinearProblem::solve`] use the factor of the last [`NonlinearProblem::freeze`], which may be from an
    /// earlier step.
    fn take_frozen(&mut self) {}

    /// Whether factors are reused over many solves.
    fn reuses_factors(&self) -> bool {
        false
    }

    /// Sets the accuracy of further solves; direct solvers ignore it.
    fn set_accuracy(&mut self, accuracy: Accuracy) {
        let _ = accuracy;
    }

    /// [N] Force that would stop the motion within the step: the scale of a scene that moves without forces.
    fn stopping_force(&mut self) -> f64 {
        0.0
    }

    /// [-] Cost of a factorisation in iterations on an existing factor, by counted operations.
    fn factor_cost(&self) -> f64 {
        0.0
    }

    /// Its springs and membranes, if their tensions and stresses can be unknowns of the iteration.
    fn mixed(&mut self) -> Option<&mut dyn MixedSprings> {
        None
    }

    /// Replaces b `[n]` by (dF/dz)^-1 b.
    ///
    /// # Errors
    /// A solution that is not finite, or a tangent that only now shows not to be positive definite.
    fn solve(&mut self, b: &mut [f64]) -> Result<(), LinearError>;
}

/// The springs and membranes of a problem whose tensions and stresses are unknowns of the mixed iteration; lists are
/// `[n_springs]` and `[n_sheets]`.
pub trait MixedSprings {
    /// Numbers of springs and of membrane triangles.
    fn counts(&self) -> [usize; 2];

    /// Writes both at the start of the step.
    fn measure_start(&mut self, springs: &mut [SpringState], sheets: &mut [SheetState]);

    /// Writes both at the last evaluated residual.
    fn measure(&mut self, springs: &mut [SpringState], sheets: &mut [SheetState]);

    /// Factorises the matrix at the last evaluated residual with these tensions, stiffnesses and stresses. The problem
    /// decides whether it is in its symmetric form.
    ///
    /// # Errors
    /// As [`NonlinearProblem::linearise`].
    fn linearise(&mut self, form: MixedForm<'_>) -> Result<Inertia, LinearError>;

    /// Degree of freedom of every unknown `[n]`, and the number of degrees of freedom.
    fn dofs(&self) -> (&[u32], usize);

    /// [-] Weight of the forces in the residual.
    fn weight(&self) -> f64;
}
