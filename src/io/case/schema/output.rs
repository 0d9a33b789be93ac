//! What is written.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::select::{NodeOrEdgeSelection, NodeSelection};
use crate::model::gauge::GaugeQuantity;
use crate::vtk::{Compression, FrameFormat, Precision};

/// What is written.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// The files of frames: `vtu`, one for each frame, as every ParaView since 4 reads them, or `vtkhdf`, one file for
    /// the run with the mesh once, for ParaView 5.12 and later; `vtu` if not given.
    #[serde(default, skip_serializing_if = "is_default")]
    pub format: FrameFormat,
    /// Frames for ParaView and rows of `probes.csv`; not given: the first and the last state only.
    pub frames: Option<Every>,
    /// Fields in a frame beside `displacement` and `velocity`, which are always there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fields: Vec<Field>,
    /// Whether ParaView draws the edges that are sides of triangles over them; `false` if not given. They are cells of
    /// every frame in any case, and triangles show the mean of their sides.
    #[serde(default, skip_serializing_if = "is_default")]
    pub edges: bool,
    /// Nodes whose motion goes to `probes.csv` at every frame time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub probes: Vec<Probe>,
    /// What is measured at every step, for `gauges.csv` and the largest values in `summary.json`. Steps are then made
    /// one by one, which costs explicit methods on small nets up to a few times their time. Canopies measure themselves
    /// without a gauge, at the rows of `history.csv`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gauges: Vec<Gauge>,
    /// Rows of `history.csv`; not given: the interval at which the file has at most 10,000 rows, computed for the end
    /// with which the run began.
    pub history: Option<EverySteps>,
    /// Checkpoints that `solve --resume` goes on from; not given: one when the run is interrupted.
    pub checkpoint: Option<EveryCheckpoint>,
    /// Whether the arrays of frames are compressed; not given: `zlib` in a `vtkhdf` file, else `none`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compression: Option<Compression>,
    /// Where cloth is searched for triangles that pass through others, as sheets without `contact` may. Frames get the
    /// cell array `crossing`, 1 on triangles that pass through others, `summary.json` and a warning what was found;
    /// `frames` if not given. A scene without triangles has nothing to search.
    #[serde(default, skip_serializing_if = "is_default")]
    pub crossings: CrossingSearch,
    /// Digits of the fields in frames; `f64` if not given. Positions are always `f64`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub precision: Precision,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Where cloth is searched for triangles that pass through others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CrossingSearch {
    /// In every frame.
    #[default]
    Frames,
    /// At the end of every step too, which are then made one by one.
    Steps,
    /// Nowhere: frames have no array `crossing`.
    None,
}

/// An interval of simulated time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Every {
    /// [s] At t = 0, at every multiple of this, and at the end.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub every: f64,
}

/// An interval of simulated time between checkpoints.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EveryCheckpoint {
    /// [s] At t = 0, after the first step that reaches a multiple of this, and before the last step, so that a finished
    /// run in fixed steps can be resumed with a later end.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub every: f64,
}

/// An interval in steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EverySteps {
    /// [-] Steps per row; the first and the last state always have a row.
    #[schemars(range(min = 1))]
    pub every: u64,
}

/// A field of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Field {
    /// Velocity of the nodes, m/s; always written.
    Velocity,
    /// Net force on the nodes, N: of springs, dampers, weight, air and loads; 0 in held directions, where the support's
    /// reaction balances it. Of a pendulum: its weight and damping, without the force of the rod.
    Force,
    /// Support reaction on the nodes, N.
    Reaction,
    /// Tension of the springs with their axial dashpots, N; below 0 in compression. Relative dashpots and Rayleigh
    /// damping do not act along the springs and are not in it.
    Tension,
    /// Strain of the springs.
    Strain,
    /// Rest length of the springs, m: the cell array `rest_length`, -1 on cells without a spring. `static` always
    /// writes it, and the tension.
    RestLength,
    /// Pressure difference that the air and gases put on the triangles, Pa, positive along their right-hand normals; 0
    /// without them. Loads are not in it. Always written where the mesh has groups and there is a law, a canopy or a
    /// gas.
    Pressure,
    /// What membranes carry: on every triangle the principal stresses `stress_1` and `stress_2`, Pa (force per current
    /// width over the thickness at rest), the principal Green strains `strain_1` and `strain_2`, `wrinkling` (0 taut, 1
    /// wrinkled, 2 slack, -1 no membrane) and the unit vector `warp`.
    Membrane,
}

/// Nodes whose motion is written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Name in `probes.csv`; no two probes share one.
    #[schemars(length(min = 1, max = 200))]
    pub name: String,
    /// Which nodes.
    pub on: NodeSelection,
}

/// Something that is measured at every step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gauge {
    /// Name in `gauges.csv`; no two gauges share one.
    #[schemars(length(min = 1, max = 200))]
    pub name: String,
    /// Where: edges for `tension`, triangles for `stress`, `strain`, `wrinkling` and `gas`, a contact for `contact`,
    /// else nodes.
    pub on: NodeOrEdgeSelection,
    /// What: sums, means and largest values over the selection.
    pub of: GaugeQuantity,
    /// [-] Steps per row of `gauges.csv`, 1 if not given; the first and the last state always have a row. Largest
    /// values are found at every step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub every: Option<u64>,
}
