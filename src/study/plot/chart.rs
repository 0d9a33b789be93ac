//! One chart as plain data, and its picture as SVG text.
//!
//! ```
//! use canopy_fem_study::plot::chart::{Axis, Chart, Line, Scale};
//! use canopy_fem_study::plot::layout::svg;
//! let chart = Chart {
//!     title: "order of the schemes".into(),
//!     x: Axis { label: "step [s]".into(), scale: Scale::Log, ..Axis::default() },
//!     y: Axis { label: "error [m]".into(), scale: Scale::Log, ..Axis::default() },
//!     lines: vec![Line::new("newmark", vec![(1e-3, 1e-6), (1e-2, 1e-4)])],
//!     ..Chart::default()
//! };
//! assert!(svg(&chart)?.starts_with("<svg"));
//! # Ok::<(), canopy_fem_study::plot::PlotError>(())
//! ```

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
    /// whether a unit has the same length on both axes, for plots of positions
    pub equal_units: bool,
    /// size of the picture, legend included
    pub size: Size,
    /// texts in the picture
    pub notes: Vec<Note>,
    /// panel beside the picture for marks without a value on one of the axes
    pub margin_panel: Option<MarginPanel>,
}

/// A text in a chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Note {
    /// its point, in the units of the axes
    pub at: (f64, f64),
    /// the text
    pub text: String,
    /// position of the text relative to the point
    pub align: Align,
}

/// Position of a text relative to its point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Align {
    /// to its right, a little above
    #[default]
    Right,
    /// to its left, a little above
    Left,
    /// to its right, a little below
    RightBelow,
    /// to its left, a little below
    LeftBelow,
    /// centred above it
    Above,
}

/// A panel beside the picture for marks without a value on one axis: runs without a result have a cost, but no error.
/// Marks that would cover each other are moved apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MarginPanel {
    /// its side
    pub side: PanelSide,
    /// label of all its marks
    pub label: String,
    /// the marks
    pub marks: Vec<PanelMark>,
}

/// The side of a margin panel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PanelSide {
    /// to the right, along the vertical axis
    #[default]
    Right,
    /// above, along the horizontal axis
    Top,
}

/// A mark in a margin panel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PanelMark {
    /// its value along the axis of the panel; beyond the ends of the axis it is drawn at the end. `None`: drawn in a
    /// separate part at the lower end
    pub at: Option<f64>,
    /// the mark
    pub marker: Marker,
    /// number in the palette
    pub color: usize,
    /// for pages: as [`Line::series`]
    pub series: String,
    /// for pages: as an entry of [`Line::runs`]
    pub run: String,
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
    /// lower and upper end, at which lines are cut. `None`: fitted to the points
    pub range: Option<(f64, f64)>,
}

/// The scale of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// equal differences have equal lengths
    #[default]
    Linear,
    /// equal factors have equal lengths; numbers that are not above 0 are left out
    Log,
}

/// A line, or marks, or both; one that has a label but neither stroke nor marks is a heading in the legend.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// label in the legend; empty = none
    pub label: String,
    /// a point that is not finite interrupts the line
    pub points: Vec<(f64, f64)>,
    /// how points are joined
    pub stroke: Stroke,
    /// derivatives of the piece from each point to the next, at its start and at its end, by a parameter that goes from
    /// 0 to 1: the piece is the cubic with these ends. It is straight where a derivative is not finite or not given
    pub tangents: Vec<[(f64, f64); 2]>,
    /// the mark at each point
    pub marker: Marker,
    /// number of marks, spread over the points; 0 = one at each point
    pub marks: usize,
    /// number in the palette. `None`: the next free one for a line with a label; a line without a label has the colour
    /// of the line before it
    pub color: Option<usize>,
    /// for pages: what is hidden and shown together; empty = always shown
    pub series: String,
    /// for pages: the run of each point, for what its mark tells; empty = marks tell nothing
    pub runs: Vec<String>,
}

/// How points are joined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stroke {
    /// no line: marks only
    None,
    /// hair lines, for many lines together
    Thin,
    /// a solid line, thinner than usual: for fronts and guides
    Fine,
    /// the usual line; dashed where it would hide an earlier one that it coincides with
    #[default]
    Normal,
    /// the usual line, dashed: references and bounds
    Dashed,
    /// the usual line around a pale area; the area is not cut at the axes, so it must be within them
    Filled,
}

/// The mark at each point.
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
