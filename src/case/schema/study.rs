//! What a study tries. Flags of the command win over it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::method::Method;

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
    /// [-] Times every run is repeated to measure its cost; the median counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 1000))]
    pub repeat: Option<u32>,
    /// [s] Wall-clock time the study may take.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub budget_seconds: Option<f64>,
}
