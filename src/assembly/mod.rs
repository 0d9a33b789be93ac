//! Global sparse assembly of W = cm M + cc C + ck K.
//!
//! The terms are run once with a [`record::Recorder`]: which elements they emit, in which order, is all that is needed
//! to find the [`pattern::Pattern`] of W and the slot of every entry of every block. From then on a step runs the same
//! emission into a [`Assembler::sink`], which adds straight into the values of W.
//!
//! Unknowns are the free degrees of freedom; fixed ones are eliminated: their entries go to one spare slot behind the
//! values. A symmetric W keeps its lower triangle only.

mod assembler;
mod export;
mod pattern;
mod record;
mod system;

pub use assembler::{Assembler, MatrixSink, Nodes};
pub use export::{ExportError, write_matrix_market};
pub use pattern::{Pattern, PatternError};
pub use record::{Emission, Recorder};
pub use system::{Abilities, TangentSystem};
