//! How the equations of an implicit method are solved.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the equations of an implicit method are solved.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Solver {
    /// Newton's method.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub newton: Option<Newton>,
    /// Linear solver; `auto` if not given.
    #[serde(default)]
    pub linear: Linear,
}

/// Newton's method for the equations of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Newton {
    /// [-] Residual at which a step counts as solved, relative to the largest of |M a|, |f_internal| and |f_external|
    /// at the step's start; 1e-8 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub relative: Option<f64>,
    /// [-] Largest number of iterations with the exact tangent, after which a step counts as not solvable. With a kept
    /// tangent, as many more are allowed; 100 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 1000))]
    pub max_iterations: Option<u32>,
    /// When the tangent is computed again; `auto` if not given.
    #[serde(default)]
    pub strategy: Strategy,
}

/// When the tangent is computed again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// As `quasi` where, by counted work, a factorisation costs as much as many iterations with an old factor;
    /// otherwise, and where `quasi` fails, as `full`.
    #[default]
    Auto,
    /// In every iteration.
    Full,
    /// Seldom: the factor of a symmetric tangent is used as long as the iteration converges fast enough with it.
    Modified,
    /// The same, corrected by the iteration's last steps (L-BFGS).
    Quasi,
}

/// Linear solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Linear {
    /// Where a matrix is kept over many steps: Cholesky or conjugate gradients, whichever is less counted work.
    /// Otherwise Cholesky for a symmetric tangent, and LU for any other.
    #[default]
    Auto,
    /// Sparse Cholesky; needs a symmetric tangent.
    Cholesky,
    /// Sparse LU.
    Lu,
    /// Conjugate gradients, preconditioned by an incomplete factorisation of which only the pivots are stored: little
    /// memory, for small steps and large meshes. If the tangent is not symmetric, its symmetric part is used; the
    /// strategy must then not be `full`.
    Cg,
}
