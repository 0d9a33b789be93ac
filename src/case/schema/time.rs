//! How long, by which method and in which steps.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::method::Method;

/// How long, by which method and in which steps. Exactly one of `step` and `tolerance` is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Time {
    /// [s] End of the simulated time, which starts at 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub end: f64,
    /// Method of integration.
    pub method: Method,
    /// [s] Fixed step; only the last one is shortened to meet the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub step: Option<f64>,
    /// Error the run may make, for steps of the size it allows, by any method.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<Tolerance>,
}

/// Error that the run may make in positions: `absolute` plus `relative` times the largest displacement so far, both as
/// the root mean square over the free degrees of freedom. Each step may make its share of it by time. What errors
/// really come to depends on the scene as well: on swinging pendulums and cloths they are within a factor of ten of
/// this.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tolerance {
    /// [-] Share of the largest displacement so far.
    #[schemars(extend("minimum" = 1e-13, "exclusiveMaximum" = 1))]
    pub relative: f64,
    /// [m] Error that is always allowed ([rad] for a pendulum); rules while the motion is small.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub absolute: f64,
}
