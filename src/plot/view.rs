//! What is looked at in finished runs, and the charts of it.

use super::chart::{Chart, svg_grid};
use super::results::Run;
use super::{PlotError, energy, trajectory};

/// What a picture shows.
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

/// The part of the results that is looked at.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// direction of motion; `None`: an angle for pendulums, else where the motion is largest
    pub axis: Option<Direction>,
    /// probes by name; empty = all
    pub probes: Vec<String>,
    /// nodes; empty = all that are probed
    pub nodes: Vec<u32>,
    /// [s] not before
    pub from: Option<f64>,
    /// [s] not after
    pub to: Option<f64>,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Kind; 3] = [Kind::Displacement, Kind::Phase, Kind::Energy];

    /// The file it is written to.
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
    /// Whether a time [s] is looked at.
    pub(super) fn sees(&self, t: f64) -> bool {
        self.from.is_none_or(|from| t >= from) && self.to.is_none_or(|to| t <= to)
    }
}

/// The charts of some runs: one for motion and for the energy of one run, one an entry of the account for several runs.
///
/// # Errors
/// Probes or nodes that are not there, or no time left to look at.
pub fn charts(runs: &[Run], view: &View, kind: Kind) -> Result<Vec<Chart>, PlotError> {
    match kind {
        Kind::Displacement => Ok(vec![trajectory::displacement(runs, view)?]),
        Kind::Phase => Ok(vec![trajectory::phase(runs, view)?]),
        Kind::Energy => energy::charts(runs, view),
    }
}

/// The same as an SVG picture.
///
/// # Errors
/// Those of [`charts`].
pub fn picture(runs: &[Run], view: &View, kind: Kind) -> Result<String, PlotError> {
    svg_grid(&charts(runs, view, kind)?, 2)
}
