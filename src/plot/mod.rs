//! Pictures: charts from plain series of numbers, and displacement, phase and energy of finished runs.
//!
//! [`chart`] draws and knows nothing of runs; the rest reads result folders and makes curves of them.

pub mod chart;
mod draw;
mod error;
mod legend;
mod pen;
mod ruler;
mod trim;

pub use error::PlotError;
