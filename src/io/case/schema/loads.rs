//! Given pressures and forces, and snow.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::select::NodeSelection;

/// A pressure or snow on triangles, or a force on nodes; exactly one of `pressure`, `force` and `snow` is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Load {
    /// Where it acts: for a pressure and for snow `"all"`, `{"ids": [...]}` or `{"group": ...}`, which are triangles;
    /// for a force any nodes.
    pub on: NodeSelection,
    /// [Pa] Pressure along the triangles' right-hand normals (or along `direction`).
    pub pressure: Option<f64>,
    /// How a pressure follows the surface; `follower` if not given. Only with `pressure`.
    pub kind: Option<PressureKindKey>,
    /// [-] Direction of a dead pressure, of any length above 0; not given: each triangle's normal at t = 0, initial
    /// displacements included.
    pub direction: Option<[f64; 3]>,
    /// [N] Force on each of the nodes.
    pub force: Option<[f64; 3]>,
    /// [N/m^2] Load per area of the plan, such as snow: on the area of each triangle at t = 0, initial displacements
    /// included, as seen along gravity (along -z without it), and in this direction. The plan is that of the structure
    /// as built, as codes have it: where cloth sags, as much snow lies on it as before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub snow: Option<f64>,
    /// [-] Shape coefficient, by which `snow` is multiplied; a load for each group that has one of its own. 1 if not
    /// given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub shape: Option<f64>,
    /// [s, -] Factor over time: rows of time and factor, times strictly increasing; linear between rows, constant
    /// outside them. Not given: 1 at all times. Fixed steps with rows inside them keep the integral of the factor, but
    /// not its shape.
    #[schemars(length(min = 1))]
    pub table: Option<Vec<[f64; 2]>>,
}

/// How a pressure follows the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PressureKindKey {
    /// p A N on the current area along the current normal.
    #[default]
    Follower,
    /// p A0 on the area at t = 0, initial displacements included, in a fixed direction.
    Dead,
}
