//! Charts from plain series of numbers, and of finished runs: motion, energies, steps, gauges, differences of two runs.
//!
//! [`chart`] draws, without knowledge of runs; `results` reads a result folder; `view` makes charts of it.
//!
//! The charts do not come from a crate. Those of plotters draw points beyond an axis at its end, so that lines follow
//! the frame. They also label all ticks of small numbers "0.0", and draw the legend over the curves. A crate would only
//! draw lines and texts, which SVG has itself (`canvas`). Crates turn SVG into PNG and PDF (`convert`).

mod axis;
mod canvas;
pub mod chart;
mod columns;
pub mod convert;
mod curve;
pub(crate) mod decimate;
mod difference;
mod error;
pub mod layout;
mod legend;
mod margin_panel;
mod outline;
mod panel;
pub mod picture;
pub mod results;
mod series;
pub(crate) mod table;
mod trajectory;
pub mod view;

pub use error::PlotError;
