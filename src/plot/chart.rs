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
pub use super::layout::svg_grid;

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
    /// words in the picture
    pub notes: Vec<Note>,
    /// marks that have no place on one of the axes, beside the picture
    pub margin_panel: Option<MarginPanel>,
}

/// Words at a place of a chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Note {
    /// where, in the units of the axes
    pub at: (f64, f64),
    /// the words
    pub text: String,
    /// on which side of the place they stand
    pub align: Align,
}

/// Where words stand from their place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Align {
    /// to its right, a little above
    #[default]
    Right,
    /// to its left, a little above
    Left,
    /// to its right, a little below
    RightBelow,
    /// centred above it
    Above,
}

/// A strip beside the picture for marks that have no place on one axis: runs without a result have a cost, but no
/// error. Marks that would cover each other are moved apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MarginPanel {
    /// where it stands
    pub side: PanelSide,
    /// what its marks have in common
    pub label: String,
    /// the marks
    pub marks: Vec<PanelMark>,
}

/// Where a strip stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PanelSide {
    /// to the right, along the vertical axis
    #[default]
    Right,
    /// above, along the horizontal axis
    Top,
}

/// A mark in a strip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanelMark {
    /// its place along the axis that it has; beyond the axis' ends it stands at the end. `None`: in a part of its own
    /// at the lower end
    pub at: Option<f64>,
    /// the mark
    pub marker: Marker,
    /// number in the palette
    pub color: usize,
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

/// A line, or marks, or both; one that has a label but neither stroke nor marks is a heading in the legend.
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
    /// number in the palette. `None`: the next free one for a line with a label; a line without one goes with the line
    /// before it
    pub color: Option<usize>,
}

/// How points are joined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stroke {
    /// not at all: marks only
    None,
    /// hair lines, for bundles of many
    Thin,
    /// a full line that is thinner than the usual one: fronts and guides
    Fine,
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
    /// an upright cross
    Plus,
    /// a short vertical line
    Tick,
    /// a short horizontal line
    Bar,
    /// filled
    Square,
    /// its outline
    OpenSquare,
    /// filled, pointing up
    Triangle,
    /// its outline
    OpenTriangle,
    /// filled, pointing down
    TriangleDown,
    /// its outline
    OpenTriangleDown,
    /// filled
    Diamond,
    /// its outline
    OpenDiamond,
    /// filled, with five points
    Star,
    /// its outline
    OpenStar,
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
