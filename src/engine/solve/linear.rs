//! The interface of linear solvers, and which solver a matrix gets.

use super::cost_model::COSTS;
pub use super::cost_model::Prediction;
use super::{AutoSolver, Cholesky, ConjugateGradients, Lu};
use crate::assembly::Pattern;
use crate::interrupt::Interrupted;
use crate::model::workers::Workers;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use std::sync::Arc;

/// Linear solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename = "Linear"))]
#[serde(rename_all = "kebab-case")]
pub enum LinearChoice {
    /// Unless the strategy is `full`: Cholesky or conjugate gradients, whichever is less counted work, for matrices
    /// that are kept over many steps, and in scenes of 2,000 nodes and more for symmetric ones that are solved with
    /// once. Otherwise Cholesky for a symmetric tangent, and LU for any other.
    #[default]
    Auto,
    /// Sparse Cholesky. If the tangent is not symmetric, its symmetric part is used, and LU where that does not
    /// converge; the strategy must then not be `full`.
    Cholesky,
    /// Sparse LU.
    Lu,
    /// Conjugate gradients, preconditioned by an incomplete factorisation of which only the pivots are stored: little
    /// memory, for small steps and large meshes. Stiff nets of 2,000 nodes and more get multigrid. If the
    /// tangent is not symmetric, its symmetric part is used; the strategy must then not be `full`.
    Cg,
}

/// Name and sizes of a solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearStats {
    /// `cholesky`, `lu` or `cg`
    pub name: &'static str,
    /// stored entries of W
    pub matrix_nonzeros: usize,
    /// stored entries of the factor, if known
    pub factor_nonzeros: Option<usize>,
    /// multiplications and additions of a factorisation, if known
    pub factor_operations: Option<f64>,
    /// number of matrices that were not positive definite
    pub indefinite: u64,
    /// the comparison behind an automatic choice, if one was made
    pub prediction: Option<Prediction>,
}

impl LinearStats {
    /// [-] Cost of an assembly and a factorisation in Newton iterations on an existing factor, by counted operations.
    pub fn factor_cost(&self, unknowns: usize) -> f64 {
        COSTS.factor_cost(self, unknowns)
    }
}

/// Accuracy of a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// [-] largest relative residual
    pub relative: f64,
    /// [-] relative residual that is small enough for the iteration around the solve; reached if few iterations suffice
    pub enough: f64,
    /// whether the Euclidean norm of b - W x, in double precision, must be that small as well
    pub checked: bool,
}

impl Accuracy {
    /// The relative residual `relative` [-].
    pub fn to(relative: f64) -> Self {
        Accuracy { relative, enough: relative, checked: false }
    }

    /// The same, verified in double precision.
    pub fn checked(self) -> Self {
        Accuracy { checked: true, ..self }
    }

    /// Whether a factor in single precision, which leaves up to [`REUSED_RELATIVE`], is accurate enough.
    pub(super) fn allows_single(self) -> bool {
        self.relative >= REUSED_RELATIVE && !self.checked
    }

    /// The accuracy of a solve with a reused matrix.
    pub fn of_reused() -> Self {
        Accuracy::to(REUSED_RELATIVE)
    }
}

/// [-] Relative residual of a solve with a reused matrix. The Newton iteration with an old matrix converges no faster.
pub const REUSED_RELATIVE: f64 = 1e-3;

/// Expected use of a reused matrix.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ExpectedUse {
    /// [-] useful Newton iterations it will serve, over the square root of its cost in iterations
    pub reuse: f64,
    /// [-] iterations of conjugate gradients in an average solve, each counted as [`LinearSolver::cg_cost`]; 0 before
    /// any was seen
    pub cg_iterations: f64,
    /// whether the solves seen needed multigrid; conjugate gradients without it are then not tried
    pub multigrid: bool,
    /// [-] useful Newton iterations that are to come in the run; infinite if its end is not known
    pub left: f64,
}

impl Default for ExpectedUse {
    /// The expected use before any matrix was used.
    fn default() -> Self {
        ExpectedUse { reuse: 6.0, cg_iterations: 0.0, multigrid: false, left: f64::INFINITY }
    }
}

/// Why a linear system cannot be solved.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum LinearError {
    /// An entry of W is not a finite number.
    #[error("the tangent matrix holds a value that is not finite in the column of unknown {unknown}")]
    NotFinite {
        /// the column
        unknown: usize,
    },
    /// W has no inverse.
    #[error("the tangent matrix is singular{}", unknown.map(|u| format!(" at unknown {u}")).unwrap_or_default())]
    Singular {
        /// an unknown without pivot, if the factorisation says which
        unknown: Option<usize>,
    },
    /// Cholesky was chosen for a non-symmetric matrix.
    #[error(
        "this scene's tangent is not symmetric (air, follower pressure or axial dashpots), so \"cholesky\" cannot solve \
         with the exact one; use \"linear\": \"auto\", which keeps a symmetric part where that serves"
    )]
    NotSymmetric,
    /// Conjugate gradients or Cholesky were chosen for a system without node blocks.
    #[error(
        "\"cholesky\" and \"cg\" work on the symmetric blocks of a network's nodes, and this system has none; use \"linear\": \"auto\""
    )]
    NotByNodes,
    /// Conjugate gradients were chosen with strategy `full` for a non-symmetric matrix.
    #[error(
        "this scene's tangent is not symmetric (air, follower pressure or axial dashpots), so \"cg\" can only solve with its symmetric part, \
         which the strategy \"full\" does not use; use \"strategy\": \"auto\", or \"linear\": \"lu\""
    )]
    FullNotSymmetric,
    /// LU was chosen with a strategy that reuses a factor.
    #[error(
        "\"lu\" factorises the exact tangent in every iteration, and the strategies \"modified\" and \"quasi\" keep a symmetric one; use \
         \"linear\": \"auto\", or \"strategy\": \"full\" or \"auto\""
    )]
    NotKept,
    /// Conjugate gradients met a direction p with p . W p <= 0.
    #[error("the tangent matrix is not positive definite: conjugate gradients found it in iteration {iterations}")]
    Indefinite {
        /// iterations made
        iterations: u32,
    },
    /// Conjugate gradients did not reach the requested residual.
    #[error(
        "conjugate gradients left {residual:.1e} of the right-hand side after {iterations} iterations, but {asked:.1e} was required: \
         the step is long for so stiff a scene, or its stiffnesses are too far apart for single precision; use \"linear\": \"cholesky\" or \"auto\", or a smaller step"
    )]
    Stalled {
        /// iterations made
        iterations: u32,
        /// [-] residual over that at the start
        residual: f64,
        /// [-] requested relative residual
        asked: f64,
    },
    /// The work was asked to stop.
    #[error("the solution is not finished: {0}")]
    Interrupted(#[from] Interrupted),
    /// The analysis ran out of memory or index range.
    #[error("the symbolic analysis of a matrix with {unknowns} unknowns failed: {reason}")]
    Analysis {
        /// size
        unknowns: usize,
        /// reason given by the library
        reason: String,
    },
}

/// Work of a solver since its construction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SolverWork {
    /// factorisations
    pub factorizations: u64,
    /// those of them by LU
    pub lu_factorizations: u64,
    /// iterations of conjugate gradients
    pub iterations: u64,
}

/// The definiteness of W, as far as a factorisation shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inertia {
    /// W is positive definite
    Definite,
    /// W has eigenvalues that are not positive
    Indefinite,
    /// unknown after this factorisation
    Unknown,
}

/// Factorises W on a fixed pattern and solves with it. The symbolic analysis is done once, at construction.
pub trait LinearSolver: Send {
    /// Factorises W; `values` [nonzeros] in the order of the pattern.
    ///
    /// # Errors
    /// Values that are not finite, or a singular W.
    fn factor(&mut self, values: &[f64]) -> Result<Inertia, LinearError>;

    /// The same, but an indefinite W is reported and not factorised: for callers that need a descent direction.
    ///
    /// # Errors
    /// As [`LinearSolver::factor`].
    fn factor_definite(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        self.factor(values)
    }

    /// As [`LinearSolver::factor_definite`], for one solve. W may be left to conjugate gradients if that is less
    /// counted work; `expected` has the iterations that reused matrices take. An indefinite W may then show only in the
    /// solve. If W is known to be `definite`, such a finding is rounding, and W is factorised.
    ///
    /// # Errors
    /// As [`LinearSolver::factor`].
    fn factor_once(&mut self, values: &[f64], definite: bool, expected: ExpectedUse) -> Result<Inertia, LinearError> {
        let _ = (definite, expected);
        self.factor_definite(values)
    }

    /// As [`LinearSolver::factor_definite`], for a W that is reused over many solves, each with relative residual
    /// [`REUSED_RELATIVE`].
    ///
    /// # Errors
    /// As [`LinearSolver::factor`].
    fn prepare(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        self.factor_definite(values)
    }

    /// Chooses how to solve with such a W without factorising it; [`LinearSolver::stats`] then has the choice. Returns
    /// [`Inertia::Unknown`], or [`Inertia::Indefinite`] if W is.
    ///
    /// # Errors
    /// As [`LinearSolver::factor`].
    fn choose(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        let _ = values;
        Ok(Inertia::Unknown)
    }

    /// Replaces `b` `[n]` by W^-1 b; `values` are those of the last factorisation. An error of conjugate gradients
    /// leaves `b` unchanged, unless it is a solution that is not finite.
    ///
    /// # Errors
    /// A solution that is not finite, or wrong beyond repair: W is singular to working precision. Conjugate gradients:
    /// W is indefinite, or too badly conditioned.
    fn solve(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), LinearError>;

    /// Replaces `b` `[n]` by W^-T b: the same as W^-1 b for solvers of symmetric matrices.
    ///
    /// # Errors
    /// As [`LinearSolver::solve`].
    fn solve_transposed(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), LinearError> {
        self.solve(values, b)
    }

    /// Sets the accuracy of further solves; direct solvers ignore it.
    fn set_accuracy(&mut self, accuracy: Accuracy) {
        let _ = accuracy;
    }

    /// Sets the expected use of the next reused matrix.
    fn set_expected_use(&mut self, expected: ExpectedUse) {
        let _ = expected;
    }

    /// Whether another solver would have been chosen for the last matrix with this expected use.
    fn prefers_other_solver(&self, expected: ExpectedUse) -> bool {
        let _ = expected;
        false
    }

    /// [-] Cost of an iteration of conjugate gradients with the last matrix over one without multigrid.
    fn cg_cost(&self) -> f64 {
        1.0
    }

    /// Whether the last matrix is solved by conjugate gradients with multigrid.
    fn with_multigrid(&self) -> bool {
        false
    }

    /// Work since construction.
    fn work(&self) -> SolverWork;

    /// Name and sizes.
    fn stats(&self) -> LinearStats;
}

/// The solver for a pattern; it may use the threads of `workers`.
///
/// # Errors
/// When the choice does not fit the pattern or the analysis fails.
pub fn solver_for(
    pattern: Arc<Pattern>,
    choice: LinearChoice,
    workers: &Workers,
) -> Result<Box<dyn LinearSolver>, LinearError> {
    let (columns, symmetric) = (pattern.n(), pattern.symmetric);
    log::debug!("matrix of {columns} columns, symmetric: {symmetric}; linear solver asked for: {choice:?}");
    match (choice, pattern.symmetric) {
        (LinearChoice::Cholesky, false) => Err(LinearError::NotSymmetric),
        (LinearChoice::Cg, _) => Ok(Box::new(ConjugateGradients::new(pattern, workers)?)),
        (LinearChoice::Auto | LinearChoice::Cholesky, true) => Ok(Box::new(Cholesky::new(pattern, workers)?)),
        (LinearChoice::Auto | LinearChoice::Lu, _) => Ok(Box::new(Lu::new(pattern)?)),
    }
}

/// The solver for a symmetric W that is reused over many solves.
///
/// # Errors
/// As [`solver_for`].
pub fn reusing_solver_for(
    pattern: Arc<Pattern>,
    choice: LinearChoice,
    workers: &Workers,
) -> Result<Box<dyn LinearSolver>, LinearError> {
    match choice {
        LinearChoice::Auto if pattern.symmetric => Ok(Box::new(AutoSolver::new(pattern, workers)?)),
        _ => solver_for(pattern, choice, workers),
    }
}

pub(super) fn check_finite(pattern: &Pattern, values: &[f64], workers: &Workers) -> Result<(), LinearError> {
    if workers.all_finite(values) {
        return Ok(());
    }
    let slot = values.iter().position(|v| !v.is_finite()).unwrap_or(0) as u32;
    Err(LinearError::NotFinite { unknown: pattern.col_ptr.partition_point(|&p| p <= slot).saturating_sub(1) })
}

pub(super) fn check_solution(x: &[f64], workers: &Workers) -> Result<(), LinearError> {
    if workers.all_finite(x) {
        return Ok(());
    }
    match x.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        unknown => Err(LinearError::Singular { unknown }),
    }
}

/// The pattern as faer's factorisations read it.
pub(super) fn symbolic_matrix(pattern: &Pattern) -> SymbolicSparseColMatRef<'_, u32> {
    SymbolicSparseColMatRef::new_checked(pattern.n(), pattern.n(), &pattern.col_ptr, None, &pattern.row_idx)
}

/// The same with `values` [nonzeros].
pub(super) fn matrix<'a>(pattern: &'a Pattern, values: &'a [f64]) -> SparseColMatRef<'a, u32, f64> {
    SparseColMatRef::new(symbolic_matrix(pattern), values)
}
