//! How the equations of an implicit method are solved.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::solve::LinearChoice;
use crate::solve::newton::Strategy;

/// How the equations of an implicit method are solved.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Solver {
    /// Newton's method.
    pub newton: Option<Newton>,
    /// Linear solver; `auto` if not given.
    #[serde(default)]
    pub linear: LinearChoice,
}

/// Newton's method for the equations of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Newton {
    /// [-] Residual at which a step counts as solved, relative to the largest of |M a|, |f_internal| and |f_external|
    /// at the step's start; 1e-8 if not given.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub relative: Option<f64>,
    /// [-] Largest number of iterations with the exact tangent, after which a step counts as not solvable. With a kept
    /// tangent, as many more are allowed; 100 if not given.
    #[schemars(range(min = 1, max = 1000))]
    pub max_iterations: Option<u32>,
    /// When the tangent is computed again; `auto` if not given.
    #[serde(default)]
    pub strategy: Strategy,
}
