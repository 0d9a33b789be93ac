//! Pictures: charts from plain series of numbers, and displacement, phase and energy of finished runs.
//!
//! [`chart`] draws and knows nothing of runs; `results` reads a result folder back; `view` makes charts of it.
//!
//! The charts are not those of a crate: plotters' own draw points beyond an axis on its end, so that lines follow the
//! frame, write "0.0" at every tick of small numbers, and lay the legend over the curves. What is left for a crate are
//! lines and words, which SVG has itself (`canvas`).

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
pub(crate) mod results;
mod series;
mod table;
mod trajectory;
pub(crate) mod view;

pub use error::PlotError;
