//! Linear solvers behind one small trait, and Newton's iteration on top of them.

mod blocks;
mod cholesky;
mod conjugate;
mod eisenstat;
mod failure;
mod forcing;
mod linear;
mod lu;
pub mod newton;
pub(crate) mod norms;
mod ordering;
mod pieces;
mod pivots;
mod problem;
pub mod quasi;
mod search;
mod single;
mod sparse;
mod strips;
mod weighed;

pub use cholesky::Cholesky;
pub use conjugate::ConjugateGradients;
pub use linear::{
    Accuracy, Expected, Inertia, KEPT_RELATIVE, LinearChoice, LinearError, LinearSolver, LinearStats, Prediction, Work,
    kept_solver_for, solver_for,
};
pub use lu::Lu;
pub use ordering::{Elimination, Permutation, fill_reducing};
pub use weighed::Weighed;
