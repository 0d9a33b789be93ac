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
    /// Error a step may make, for adaptive steps. Not available in this version: give `step`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<Tolerance>,
}

/// Error a step may make, relative to the motion and absolute.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tolerance {
    /// [-] Part of the motion.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub relative: f64,
    /// [m] Length below which errors do not count.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub absolute: f64,
}
