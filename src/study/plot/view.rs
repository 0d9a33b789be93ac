//! The selected part of finished runs, and its charts.

use super::chart::Scale;
use super::results::Run;

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
    /// most charts of a kind, those first that the report of a run tells; `None`: all
    pub most: Option<usize>,
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
