//! Global sparse assembly of W = cm M + cc C + ck K.
//!
//! The terms are run once with a [`Recorder`]. The emitted elements and their order determine the [`Pattern`] of W and
//! the slot of every entry of every block. A step then runs the same emission into [`Assembler::sink`], which adds
//! straight into the values of W.
//!
//! Unknowns are the free degrees of freedom. Fixed ones are eliminated: their entries go to a spare slot behind the
//! values. Of a symmetric W only the lower triangle is stored.

mod assembler;
#[cfg(feature = "matrices")]
mod export;
mod mean;
mod pattern;
mod record;
mod system;

pub use assembler::{Assembler, MatrixSink, Nodes};
#[cfg(feature = "matrices")]
pub use export::{ExportError, write_matrix_market};
pub use mean::MeanSystem;
pub use pattern::{Pattern, PatternError};
pub use record::{Emission, Recorder};
pub use system::{MixedForm, MixedSystem, SceneInterfaces, TangentSystem};
