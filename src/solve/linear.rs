//! What Newton needs of a linear solver, and which one a matrix gets.

use super::cost_model::COSTS;
pub use super::cost_model::Prediction;
use super::{AutoSolver, Cholesky, ConjugateGradients, Lu};
use crate::assembly::Pattern;
use crate::model::workers::Workers;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use std::sync::Arc;

/// Which solver to use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LinearChoice {
    /// Cholesky for a symmetric W, LU else.
    #[default]
    Auto,
    /// Cholesky; refused for a non-symmetric W.
    Cholesky,
    /// LU, of a symmetric W too.
    Lu,
    /// Conjugate gradients; refused for a non-symmetric W.
    Cg,
}

/// What a solver is and what it holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearStats {
    /// `cholesky`, `lu` or `cg`
    pub name: &'static str,
    /// entries stored of W
    pub matrix_nonzeros: usize,
    /// entries stored of the factor, where the library tells
    pub factor_nonzeros: Option<usize>,
    /// floating point operations of one factorisation, where the library tells the factor's shape
    pub factor_operations: Option<f64>,
    /// matrices that were found not to be positive definite
    pub indefinite: u64,
    /// what the choice was made from, where there was one
    pub prediction: Option<Prediction>,
}

impl LinearStats {
    /// [-] Cost of an assembly and a factorisation in Newton iterations on an existing factor, by counted operations.
    pub fn factor_cost(&self, unknowns: usize) -> f64 {
        COSTS.factor_cost(self, unknowns)
    }
}

/// What a solve may leave of its right-hand side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// [-] share that it may leave
    pub relative: f64,
    /// [-] share below which nothing is gained; as long as iterations are few it is worth going on to it
    pub enough: f64,
    /// whether the residual b - W x is computed in double precision, and its Euclidean norm must be that small as well
    pub checked: bool,
}

impl Accuracy {
    /// No less and no more than this [-].
    pub fn to(relative: f64) -> Self {
        Accuracy { relative, enough: relative, checked: false }
    }

    /// The same, shown in double precision.
    pub fn checked(self) -> Self {
        Accuracy { checked: true, ..self }
    }

    /// Whether a factor in single precision that leaves [`REUSED_RELATIVE`] serves.
    pub(super) fn allows_single(self) -> bool {
        self.relative >= REUSED_RELATIVE && !self.checked
    }

    /// That of a solve with a kept matrix.
    pub fn of_reused() -> Self {
        Accuracy::to(REUSED_RELATIVE)
    }
}

/// [-] Share of its right-hand side that a solve with a kept matrix may leave: what the iteration around it makes of
/// the old matrix is not better.
pub const REUSED_RELATIVE: f64 = 1e-3;

/// What is expected of a matrix that is kept.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Expected {
    /// [-] useful iterations that it will serve, over the root of what it costs in iterations
    pub reuse: f64,
    /// [-] iterations of conjugate gradients in an average solve; 0 as long as none was seen
    pub cg_iterations: f64,
}

impl Default for Expected {
    /// Before any matrix was seen.
    fn default() -> Self {
        Expected { reuse: 6.0, cg_iterations: 0.0 }
    }
}

/// Why a linear system cannot be solved.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
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
        /// an unknown without pivot, if the factorisation tells
        unknown: Option<usize>,
    },
    /// Cholesky was asked for a non-symmetric matrix.
    #[error(
        "this scene's tangent is not symmetric (air, follower pressure or axial dashpots), so \"cholesky\" cannot solve \
         with the exact one; use \"linear\": \"auto\", which keeps a symmetric part where that serves"
    )]
    NotSymmetric,
    /// Conjugate gradients or Cholesky were asked for where there are no blocks of nodes.
    #[error(
        "\"cholesky\" and \"cg\" work on the symmetric blocks of a network's nodes, and this system has none; use \"linear\": \"auto\""
    )]
    NotByNodes,
    /// Conjugate gradients were asked for true Newton iterations with a non-symmetric matrix.
    #[error(
        "this scene's tangent is not symmetric (air, follower pressure or axial dashpots), so \"cg\" can only solve with its symmetric part, \
         which the strategy \"full\" does not use; use \"strategy\": \"auto\", or \"linear\": \"lu\""
    )]
    FullNotSymmetric,
    /// LU was asked for together with a factor that is kept.
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
    /// Conjugate gradients did not come to the residual they were asked for.
    #[error(
        "conjugate gradients left {residual:.1e} of the right-hand side after {iterations} iterations, and {asked:.1e} was asked for: \
         the step is long for so stiff a scene, or its stiffnesses are too far apart for single precision; use \"linear\": \"cholesky\" or \"auto\", or a smaller step"
    )]
    Stalled {
        /// iterations made
        iterations: u32,
        /// [-] residual over that at the start
        residual: f64,
        /// [-] what it had to reach
        asked: f64,
    },
    /// The analysis ran out of memory or index range.
    #[error("the symbolic analysis of a matrix with {unknowns} unknowns failed: {reason}")]
    Analysis {
        /// size
        unknowns: usize,
        /// what the library said
        reason: String,
    },
}

/// Work of a solver since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// factorisations
    pub factorizations: u64,
    /// iterations of conjugate gradients
    pub iterations: u64,
}

/// What a factorisation tells of W.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inertia {
    /// W is positive definite
    Definite,
    /// W has eigenvalues that are not positive
    Indefinite,
    /// the factorisation does not tell
    Unknown,
}

/// Factorises W on a fixed pattern and solves with it. The analysis is done at construction, once.
pub trait LinearSolver: Send {
    /// Factorises the values of W (in the order of the pattern).
    ///
    /// # Errors
    /// Values that are not finite, or a singular W.
    fn factor(&mut self, values: &[f64]) -> Result<Inertia, LinearError>;

    /// The same, but an indefinite W is only told, not factorised: for those who want a descent direction or none.
    ///
    /// # Errors
    /// As [`LinearSolver::factor`].
    fn factor_definite(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        self.factor(values)
    }

    /// The same for a W that is kept for many solves, each of which may leave [`REUSED_RELATIVE`] of its right-hand
    /// side.
    ///
    /// # Errors
    /// As [`LinearSolver::factor`].
    fn prepare(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        self.factor_definite(values)
    }

    /// Decides how it would serve such a W, which [`LinearSolver::stats`] tells then, and factorises nothing:
    /// [`Inertia::Unknown`], or that it is indefinite.
    ///
    /// # Errors
    /// As [`LinearSolver::factor`].
    fn choose(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        let _ = values;
        Ok(Inertia::Unknown)
    }

    /// Replaces the right-hand side `b` by W^-1 b; `values` are those of the last `factor`. An error of conjugate
    /// gradients leaves `b`.
    ///
    /// # Errors
    /// A solution that is not finite, or wrong beyond repair: W is singular to working precision. Conjugate gradients:
    /// W is indefinite, or too badly conditioned.
    fn solve(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), LinearError>;

    /// What further solves may leave; direct solvers leave what rounding does.
    fn ask(&mut self, accuracy: Accuracy) {
        let _ = accuracy;
    }

    /// What the next matrix that is kept will probably be used for.
    fn anticipate(&mut self, expected: Expected) {
        let _ = expected;
    }

    /// Whether it would serve the last matrix otherwise, had it expected this.
    fn prefers_another(&self, expected: Expected) -> bool {
        let _ = expected;
        false
    }

    /// What it has done so far.
    fn work(&self) -> Work;

    /// What the solver is and holds.
    fn stats(&self) -> LinearStats;
}

/// The solver for a pattern, which may use these threads.
///
/// # Errors
/// When the choice does not fit the pattern or the analysis fails.
pub fn solver_for(
    pattern: Arc<Pattern>,
    choice: LinearChoice,
    workers: &Workers,
) -> Result<Box<dyn LinearSolver>, LinearError> {
    match (choice, pattern.symmetric) {
        (LinearChoice::Cholesky, false) => Err(LinearError::NotSymmetric),
        (LinearChoice::Cg, _) => Ok(Box::new(ConjugateGradients::new(pattern, workers)?)),
        (LinearChoice::Auto | LinearChoice::Cholesky, true) => Ok(Box::new(Cholesky::new(pattern)?)),
        (LinearChoice::Auto | LinearChoice::Lu, _) => Ok(Box::new(Lu::new(pattern)?)),
    }
}

/// The solver for a symmetric W that is kept over many solves.
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

/// The pattern without values.
pub(super) fn symbolic_matrix(pattern: &Pattern) -> SymbolicSparseColMatRef<'_, u32> {
    SymbolicSparseColMatRef::new_checked(pattern.n(), pattern.n(), &pattern.col_ptr, None, &pattern.row_idx)
}

/// The pattern with a value for each of its entries.
pub(super) fn matrix<'a>(pattern: &'a Pattern, values: &'a [f64]) -> SparseColMatRef<'a, u32, f64> {
    SparseColMatRef::new(symbolic_matrix(pattern), values)
}
