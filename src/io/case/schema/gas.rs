//! Gas in a closed volume.

use super::select::NodeSelection;
use super::table::OverTime;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Gas that triangles enclose, with the pressure p = p_a (V_a/V)^gamma - p_a on them, from inside to outside. V is the
/// volume, p_a the absolute pressure outside, V_a the amount of gas as its volume at that pressure. So p V^gamma of the
/// absolute pressure is constant while the amount is. Exactly one of `pressure` and `amount` is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gas {
    /// Which triangles: `"all"`, `{"ids": [...]}` or `{"group": ...}`. They close a volume. Where they are open, all
    /// nodes of the rim are held in x, y and z, as on the ground, and a flat cover closes it, on which nothing pushes.
    /// It does not matter whether their normals point in or out.
    pub on: NodeSelection,
    /// [Pa] Pressure above that outside, which the gas has in the volume at the start, initial displacements included:
    /// a number, or `{"table": [[t, pressure], ...]}` over time [s] while it is filled. When the volume changes, so
    /// does the pressure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pressure: Option<OverTime>,
    /// [m^3] Amount of gas, as its volume at the pressure outside: its mass over its density there. A number above 0,
    /// or `{"table": [[t, amount], ...]}` over time [s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub amount: Option<OverTime>,
    /// [-] Exponent gamma: 1.4 if not given, which is air without an exchange of heat; 1 is a constant temperature.
    #[serde(default = "air")]
    #[schemars(range(min = 1))]
    pub gamma: f64,
    /// [Pa] Absolute pressure outside, p_a; 101325 Pa if not given (sea level, standard atmosphere).
    #[serde(default = "sea_level")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub ambient: f64,
    /// [m^3] Volume at the start, if it is not what the triangles enclose with flat covers: with a base that is not
    /// flat, with ducts, or of cloth that lies flat. What is more or less than that stays constant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub volume: Option<f64>,
}

fn air() -> f64 {
    1.4
}

fn sea_level() -> f64 {
    101_325.0
}
