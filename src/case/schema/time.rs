//! End, method and steps of a run, and what a study of the case tries.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::method::Method;

/// End, method and steps of the run. Exactly one of `step` and `tolerance` is given.
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
    /// Error that the run may make; the size of the steps follows from it, with any method.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<Tolerance>,
}

/// Error that the run may make in positions: `absolute` plus `relative` times the largest displacement so far, both as
/// the root mean square over the free degrees of freedom. Each step may make a share of it in proportion to its size.
/// The error of a run also depends on the scene: on swinging pendulums and cloths it is within a factor of ten of this.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tolerance {
    /// [-] Share of the largest displacement so far.
    #[schemars(extend("minimum" = 1e-13, "exclusiveMaximum" = 1))]
    pub relative: f64,
    /// [m] Error that is always allowed ([rad] for a pendulum); it matters while the motion is small.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub absolute: f64,
}

/// What `canopy-fem tradeoff` and `canopy-fem stability` try; a list that is not given is chosen by the command.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// Methods to compare; at least one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1))]
    pub methods: Option<Vec<Method>>,
    /// [s] Fixed steps to try, each above 0; at least one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1), extend("items" = {"type": "number", "exclusiveMinimum": 0}))]
    pub steps: Option<Vec<f64>>,
    /// [-] Relative tolerances to try, each above 0 and below 1; at least one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1), extend("items" = {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1}))]
    pub tolerances: Option<Vec<f64>>,
    /// [-] Number of times each run is made to measure its cost; the cost is their median.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 1000))]
    pub repeat: Option<u32>,
    /// [s] Wall-clock time the study may take.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub budget_seconds: Option<f64>,
}
