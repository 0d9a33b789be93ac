//! The selected part of finished runs, and its charts.

use super::chart::{Chart, svg_grid};
use super::results::Run;
use super::{PlotError, energy, trajectory};

/// The kind of a chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Kind {
    /// displacement, or a pendulum's angle, over time
    Displacement,
    /// velocity over displacement, or a pendulum's angular velocity over its angle
    Phase,
    /// the energy account over time
    Energy,
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

/// The selected part of the results.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// direction of motion; `None`: an angle for pendulums, else where the motion is largest
    pub axis: Option<Direction>,
    /// probes by name; empty = all
    pub probes: Vec<String>,
    /// nodes; empty = all probed nodes
    pub nodes: Vec<u32>,
    /// [s] first time to show
    pub from: Option<f64>,
    /// [s] last time to show
    pub to: Option<f64>,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Kind; 3] = [Kind::Displacement, Kind::Phase, Kind::Energy];

    /// The name of its file.
    pub fn file(self) -> &'static str {
        match self {
            Kind::Displacement => "displacement.svg",
            Kind::Phase => "phase.svg",
            Kind::Energy => "energy.svg",
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

/// The charts of some runs: one for motion or for the energy of one run; for the energy of several runs, one per entry
/// of the account.
///
/// # Errors
/// Probes or nodes that do not exist, or no selected time.
pub fn charts(runs: &[Run], view: &View, kind: Kind) -> Result<Vec<Chart>, PlotError> {
    match kind {
        Kind::Displacement => Ok(vec![trajectory::displacement(runs, view)?]),
        Kind::Phase => Ok(vec![trajectory::phase(runs, view)?]),
        Kind::Energy => energy::charts(runs, view),
    }
}

/// The charts as an SVG picture.
///
/// # Errors
/// Those of [`charts`].
pub fn picture(runs: &[Run], view: &View, kind: Kind) -> Result<String, PlotError> {
    svg_grid(&charts(runs, view, kind)?, 2)
}
