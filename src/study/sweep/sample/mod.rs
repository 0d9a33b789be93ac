//! Samples of distributions in place of a grid of values: what is drawn, and what the runs say.
//!
//! ```text
//! --vary --input, law--> distributions --design, sobol--> rows --run--> columns --estimate, indices--> scatter
//! ```
//! Rows are planned before any of them runs, so shares of them run anywhere. [`scatter`] is all that is said of them,
//! and [`beside`] sets the errors by step and mesh against it.

pub mod beside;
pub mod design;
pub mod ellipse;
pub mod estimate;
pub(super) mod figure;
pub mod indices;
pub mod input;
pub mod law;
mod normal;
pub mod rule;
pub mod scatter;
mod sobol;

pub(crate) use design::hypercube;
pub use design::{Sampled, Sampling};
pub use input::{Input, is_drawn};
pub(crate) use normal::student_quantile;
pub use rule::Rule;
