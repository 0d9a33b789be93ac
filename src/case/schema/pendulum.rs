//! The simple pendulum.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A simple pendulum: m L^2 theta'' = -m g L sin(theta) - c theta'. Its bob is node 0 at (L sin, 0, -L cos).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pendulum {
    /// [m] Length L of the line.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length: f64,
    /// [kg] Mass m of the bob.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mass: f64,
    /// [N m s] Damping c of the rotation; 0 if not given.
    #[serde(default)]
    #[schemars(range(min = 0))]
    pub damping: f64,
    /// [m/s^2] Gravity g, downwards along -z.
    #[schemars(range(min = 0))]
    pub gravity: f64,
    /// [rad] Initial angle from the lowest position.
    pub angle: f64,
    /// [rad/s] Initial angular velocity; 0 if not given.
    #[serde(default)]
    pub rate: f64,
}
