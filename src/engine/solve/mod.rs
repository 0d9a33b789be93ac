//! Linear solvers behind one small trait, and Newton's iteration on top of them.

mod bsr;
mod cholesky;
mod conjugate;
mod cost_model;
mod eisenstat;
mod failure;
mod forcing;
mod linear;
mod lu;
mod mixed;
mod mixed_precision;
mod multigrid;
pub mod newton;
mod ordering;
mod partitioned_cg;
mod problem;
pub mod quasi_newton;
mod relaxed_ic0;
mod search;
mod sections;
mod vectors;

pub use cholesky::Cholesky;
pub use conjugate::ConjugateGradients;
pub use cost_model::AutoSolver;
pub use linear::{
    Accuracy, ExpectedUse, Inertia, LinearChoice, LinearError, LinearSolver, LinearStats, Prediction, REUSED_RELATIVE,
    SolverWork, reusing_solver_for, solver_for,
};
pub use lu::Lu;
pub use ordering::{Elimination, Permutation, fill_reducing};
