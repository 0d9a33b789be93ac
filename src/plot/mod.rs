//! Pictures: charts from plain series of numbers, and displacement, phase and energy of finished runs.
//!
//! [`chart`] draws and knows nothing of runs; [`results`] reads a result folder back; [`view`] makes charts of it.

pub mod chart;
mod curve;
mod draw;
mod energy;
mod error;
mod first_frame;
mod label;
mod legend;
mod motion;
mod pen;
pub mod results;
mod ruler;
mod select;
mod strip;
mod table;
mod trim;
pub mod view;

pub use error::PlotError;
