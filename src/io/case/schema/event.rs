//! Events that happen by the state of the scene, or after one another.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::select::NodeOrEdgeSelection;

/// When something happens, in place of a time that is given: once, the first time that a condition holds. A condition
/// that holds at the start is met at t = 0. Exactly one of the conditions, `time` and `after` is given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct When {
    /// Name of the event, for `after` and for reports; its place in the case if not given, such as `supports[0]`,
    /// `springs[2]`, `canopy.schedule[1]` or `wind`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = 100))]
    pub name: Option<String>,
    /// What the condition looks at: the mean of some nodes by their masses, or the springs of some edges for
    /// `tension_above`, which needs it. If not given, the mesh's group `payload`, or else the centre of mass of all
    /// nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<NodeOrEdgeSelection>,
    /// [s] At this time: an event by time that has a name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub time: Option<f64>,
    /// [m] The height z is at most this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_below: Option<f64>,
    /// [m] The height z is at least this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_above: Option<f64>,
    /// [m/s] The speed is at most this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub speed_below: Option<f64>,
    /// [m/s] The speed is at least this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub speed_above: Option<f64>,
    /// [Pa] The dynamic pressure rho V^2/2 of the speed against the air is at most this; needs `aero` with a canopy or
    /// drag.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub dynamic_pressure_below: Option<f64>,
    /// [Pa] The dynamic pressure is at least this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub dynamic_pressure_above: Option<f64>,
    /// [N] The largest tension of the springs `of`, with that of their dashpots, is at least this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub tension_above: Option<f64>,
    /// `true`: the vertical velocity has turned downward, or is 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub descending: Option<bool>,
    /// Name of another event that this one follows; events that a time is given for have names too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub after: Option<String>,
    /// [s] Time from the other event to this one; 0 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub delay: Option<f64>,
}

/// What ends a run before its time: the ground, at a height z.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Until {
    /// [m] Height z of the ground.
    pub ground: f64,
    /// Which nodes reach it: their mean by their masses. If not given, the mesh's group `payload`, or else the centre
    /// of mass of all nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<NodeOrEdgeSelection>,
}
