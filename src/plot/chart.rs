//! One chart as plain data, and its picture as SVG text.
//!
//! ```
//! use canopy_fem::plot::chart::{Axis, Chart, Line, Scale, svg};
//! let chart = Chart {
//!     title: "order of the schemes".into(),
//!     x: Axis { label: "step [s]".into(), scale: Scale::Log, ..Axis::default() },
//!     y: Axis { label: "error [m]".into(), scale: Scale::Log, ..Axis::default() },
//!     lines: vec![Line::new("newmark", vec![(1e-3, 1e-6), (1e-2, 1e-4)])],
//!     ..Chart::default()
//! };
//! assert!(svg(&chart)?.starts_with("<svg"));
//! # Ok::<(), canopy_fem::plot::PlotError>(())
//! ```

use super::PlotError;

/// A chart: two axes and lines on them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// above the picture; empty = none
    pub title: String,
    /// horizontal axis
    pub x: Axis,
    /// vertical axis
    pub y: Axis,
    /// drawn in this order, later ones on top
    pub lines: Vec<Line>,
    /// a unit is as long on one axis as on the other; for pictures of places
    pub equal_units: bool,
    /// of the picture, legend included
    pub size: Size,
}

/// Width and height of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// [px]
    pub width: u32,
    /// [px]
    pub height: u32,
}

/// An axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// with the unit in brackets: `time t [s]`
    pub label: String,
    /// linear or logarithmic
    pub scale: Scale,
    /// lower and upper end; lines are cut there. `None`: what the points need
    pub range: Option<(f64, f64)>,
}

/// How numbers lie on an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// equal steps are equally long
    #[default]
    Linear,
    /// equal factors are equally long; numbers that are not above 0 are left out
    Log,
}

/// A line, or marks, or both.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// its entry in the legend; empty = none
    pub label: String,
    /// a point that is not finite interrupts the line
    pub points: Vec<(f64, f64)>,
    /// how points are joined
    pub stroke: Stroke,
    /// what stands at each point
    pub marker: Marker,
    /// number in the palette. `None`: the next free one for a line with a label; a line without one goes with the line before it
    pub color: Option<usize>,
}

/// How points are joined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stroke {
    /// not at all: marks only
    None,
    /// hair lines, for bundles of many
    Thin,
    /// the usual line
    #[default]
    Normal,
    /// the usual line, dashed: references and bounds
    Dashed,
    /// the usual line around a pale area that it closes; the area is not cut at the axes, so it must lie within them
    Filled,
}

/// What stands at each point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Marker {
    /// nothing
    #[default]
    None,
    /// a small disc
    Dot,
    /// a ring: ends and special points
    Ring,
    /// a cross: failures
    Cross,
}

impl Default for Size {
    fn default() -> Self {
        Size { width: 900, height: 540 }
    }
}

impl Axis {
    /// A linear axis as wide as the points need.
    pub fn linear(label: impl Into<String>) -> Self {
        Axis { label: label.into(), ..Axis::default() }
    }

    /// A logarithmic axis as wide as the points need.
    pub fn log(label: impl Into<String>) -> Self {
        Axis { label: label.into(), scale: Scale::Log, range: None }
    }
}

impl Line {
    /// A usual line without marks.
    pub fn new(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Line { label: label.into(), points, ..Line::default() }
    }
}

/// The chart as an SVG picture. Lines of many points are thinned; no extreme is lost.
///
/// # Errors
/// Nothing to draw, or a range that is none.
pub fn svg(chart: &Chart) -> Result<String, PlotError> {
    svg_grid(std::slice::from_ref(chart), 1)
}

/// Several charts in one picture, filled row by row; the legend is that of the first one.
///
/// # Errors
/// Those of [`svg`].
pub fn svg_grid(charts: &[Chart], columns: usize) -> Result<String, PlotError> {
    super::draw::grid(charts, columns)
}
