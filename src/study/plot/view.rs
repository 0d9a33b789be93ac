//! The selected part of finished runs, and its charts.

use super::chart::{Chart, Scale, Size, svg_grid};
use super::curve::Plane;
use super::panel::{Panel, PanelChart};
use super::results::Run;
use super::{PlotError, columns, trajectory};

/// Size of a chart if there are several [px].
const PANEL: Size = Size { width: 640, height: 360 };

/// The kind of a chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Kind {
    /// displacement, or a pendulum's angle, over time
    Displacement,
    /// velocity over displacement, or a pendulum's angular velocity over its angle
    Phase,
    /// the energy account over time: one chart for one run, one per entry for several
    Energy,
    /// each entry of the energy account in a chart of its own
    Ledger,
    /// step size, Newton iterations, largest speed and largest strain over time
    Steps,
    /// what gauges measured: one chart per quantity
    Gauges,
    /// gauges of tension, and the largest tension of all springs in the frames
    Tension,
    /// gauges of reactions, and the sum and the largest of all supports in the frames
    Reaction,
}

/// A direction in space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Direction {
    /// along x
    X,
    /// along y
    Y,
    /// along z
    Z,
}

/// Finished runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Results {
    /// the runs to draw
    pub runs: Vec<Run>,
    /// the run to subtract from each
    pub base: Option<Run>,
}

/// A picture of some charts.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// SVG text
    pub svg: String,
    /// what it does not show
    pub remarks: Vec<String>,
}

/// The selected part of the results.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// direction of motion; `None`: an angle for pendulums, else where the motion is largest
    pub axis: Option<Direction>,
    /// probes by name; empty = all
    pub probes: Vec<String>,
    /// nodes; empty = all probed nodes
    pub nodes: Vec<u32>,
    /// gauges by name; empty = all
    pub gauges: Vec<String>,
    /// scales of the horizontal and of the vertical axis
    pub scales: [Scale; 2],
    /// [s] first time to show
    pub from: Option<f64>,
    /// [s] last time to show
    pub to: Option<f64>,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Kind; 8] = [
        Kind::Displacement,
        Kind::Phase,
        Kind::Energy,
        Kind::Ledger,
        Kind::Steps,
        Kind::Gauges,
        Kind::Tension,
        Kind::Reaction,
    ];

    /// The stem of its file.
    pub fn stem(self) -> &'static str {
        match self {
            Kind::Displacement => "displacement",
            Kind::Phase => "phase",
            Kind::Energy => "energy",
            Kind::Ledger => "ledger",
            Kind::Steps => "steps",
            Kind::Gauges => "gauges",
            Kind::Tension => "tension",
            Kind::Reaction => "reaction",
        }
    }

    /// Whether it adds something to the pictures of the other kinds, for the default.
    pub fn adds(self, runs: &[Run]) -> bool {
        let drawn = |field| runs.iter().any(|run| run.fields.iter().any(|f| f == field));
        match self {
            Kind::Ledger => runs.len() == 1,
            // Gauges of these are among the gauges.
            Kind::Tension => drawn("tension"),
            Kind::Reaction => drawn("reaction"),
            _ => true,
        }
    }
}

impl Direction {
    pub(super) fn index(self) -> usize {
        self as usize
    }

    pub(super) fn name(self) -> char {
        match self {
            Direction::X => 'x',
            Direction::Y => 'y',
            Direction::Z => 'z',
        }
    }
}

impl View {
    /// Whether a time [s] is selected.
    pub(super) fn sees(&self, t: f64) -> bool {
        self.from.is_none_or(|from| t >= from) && self.to.is_none_or(|to| t <= to)
    }
}

/// The picture of a kind.
///
/// # Errors
/// Probes, nodes or gauges that do not exist, results that hold nothing of this kind, no selected time, nothing above 0
/// on a logarithmic axis, or a run to subtract that lacks a curve.
pub fn picture(results: &Results, view: &View, kind: Kind) -> Result<Picture, PlotError> {
    let (panels, file) = match kind {
        Kind::Displacement => (vec![trajectory::panel(results, view, Plane::Time)?], "frame"),
        Kind::Phase => (vec![trajectory::panel(results, view, Plane::Phase)?], "frame"),
        _ => (columns::panels(results, view, kind)?, "row"),
    };
    if panels.iter().all(Panel::is_empty) {
        let no_times = if results.base.is_some() { ", and no time is in both runs" } else { "" };
        return Err(PlotError::NotThere(format!("no {file} of the runs is within --from and --to{no_times}")));
    }
    let several = panels.len() > 1;
    let (mut charts, mut remarks, mut refused) = (Vec::new(), Vec::new(), None);
    let (mut left_out, mut all) = (0, 0);
    for panel in panels.into_iter().filter(|panel| !panel.is_empty()) {
        match panel.chart(view.scales) {
            Ok(PanelChart { chart, left_out: without, all: points }) => {
                left_out += without;
                all += points;
                charts.push(if several { Chart { size: PANEL, ..chart } } else { chart });
            }
            Err(error) => {
                remarks.push(error.to_string());
                refused.get_or_insert(error);
            }
        }
    }
    if left_out > 0 {
        let stem = kind.stem();
        remarks.push(format!("{stem}: {left_out} of {all} points are not above 0 and not on the logarithmic axis"));
    }
    match refused {
        Some(error) if charts.is_empty() => Err(error),
        _ => Ok(Picture { svg: svg_grid(&charts, 2)?, remarks }),
    }
}
