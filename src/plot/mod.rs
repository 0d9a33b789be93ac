//! Pictures: charts from plain series of numbers, and displacement, phase and energy of finished runs.
//!
//! [`chart`] draws and knows nothing of runs; [`results`] reads a result folder back; [`view`] makes charts of it.

mod axis;
mod canvas;
pub mod chart;
mod curve;
mod decimate;
mod energy;
mod error;
mod layout;
mod legend;
mod margin_panel;
pub mod results;
mod series;
mod table;
mod trajectory;
pub mod view;

pub use error::PlotError;
