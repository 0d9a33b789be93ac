//! The air that blows through and against the cloth.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

/// The air: a pressure jump over every triangle, driven by the wind's velocity along the triangle's normal relative to
/// the cloth, v_n. The jump acts along the relative wind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Aero {
    /// [m/s] Wind velocity: a vector, or `{"table": [[t, x, y, z], ...]}` over time [s].
    pub wind: Wind,
    /// Pressure jump as a function of v_n.
    pub law: PorousLaw,
}

/// Wind velocity, constant or over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub enum Wind {
    /// [m/s] the same at all times
    Constant([f64; 3]),
    /// [s, m/s] over time
    Table {
        /// [s, m/s] rows of time and velocity, times strictly increasing; linear between rows, constant outside them
        table: Vec<[f64; 4]>,
    },
}

impl JsonSchema for Wind {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Wind".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let row =
            |n: usize| serde_json::json!({"type": "array", "items": {"type": "number"}, "minItems": n, "maxItems": n});
        json_schema!({"oneOf": [
            row(3),
            {
                "type": "object",
                "properties": {"table": {
                    "description": "[s, m/s] Rows of time and velocity, times strictly increasing; linear between rows, constant outside them.",
                    "type": "array", "items": row(4), "minItems": 1
                }},
                "required": ["table"],
                "additionalProperties": false
            }
        ]})
    }
}

/// Pressure jump as a function of v_n.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PorousLaw {
    /// Ergun's equation for a porous layer.
    Ergun(ErgunLaw),
    /// Measured permeability of a cloth: dp = e (a v_n + b v_n |v_n|).
    Permeable(PermeableLaw),
    /// A plain pressure coefficient: dp = cp rho/2 v_n |v_n|.
    PressureCoefficient(PressureCoefficientLaw),
}

/// Ergun's equation (Ergun 1952) for a layer of thickness e: dp = e (A v_s + B v_s |v_s|).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ErgunLaw {
    /// [-] Porosity: the part of the volume that is air.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub porosity: f64,
    /// [m] Pore diameter D.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub pore_diameter: f64,
    /// [m] Thickness e of the cloth.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub thickness: f64,
    /// [kg/m^3] Density of the air; 1.225 if not given (sea level, standard atmosphere).
    #[serde(default = "standard_density")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub air_density: f64,
    /// [Pa s] Dynamic viscosity of the air; 1.81e-5 if not given (15 to 20 degrees Celsius).
    #[serde(default = "standard_viscosity")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub air_viscosity: f64,
    /// Which reading of the equation.
    #[serde(default)]
    pub form: ErgunForm,
}

/// Which reading of Ergun's equation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ErgunForm {
    /// As Ergun wrote it: eps^3 in the denominators, v_s = v_n.
    #[default]
    Corrected,
    /// As the thesis prints it, Eq. 7 to 9: eps^2 twice and v_s = eps v_n. Only to reproduce the thesis.
    Paper,
}

/// Measured permeability of a cloth: dp = e (a v_n + b v_n |v_n|). At least one of a and b is above 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PermeableLaw {
    /// [Pa s/m^2] Viscous coefficient a.
    #[schemars(range(min = 0))]
    pub a: f64,
    /// [Pa s^2/m^3] Inertial coefficient b.
    #[schemars(range(min = 0))]
    pub b: f64,
    /// [m] Thickness e of the cloth.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub thickness: f64,
}

/// A plain pressure coefficient: dp = cp rho/2 v_n |v_n|.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressureCoefficientLaw {
    /// [-] Pressure coefficient cp.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub cp: f64,
    /// [kg/m^3] Density of the air; 1.225 if not given (sea level, standard atmosphere).
    #[serde(default = "standard_density")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub air_density: f64,
}

fn standard_density() -> f64 {
    1.225
}

fn standard_viscosity() -> f64 {
    1.81e-5
}
