//! Materials by name: what cloth, lines, tapes and cables are.

use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use super::aero::PermeableLaw;

/// Materials by name.
pub type MaterialMap = BTreeMap<String, Material>;

/// Materials beside those of the program, which they replace if they have the same name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Materials {
    /// a file with them
    File(String),
    /// the materials themselves
    Here(MaterialMap),
}

impl JsonSchema for Materials {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Materials".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let material = generator.subschema_for::<Material>().to_value();
        json_schema!({"oneOf": [{"type": "string"}, {"type": "object", "additionalProperties": material}]})
    }
}

/// A material. Its numbers are those of a rule that names it, unless the rule gives them itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Material {
    /// A cloth or a coated membrane.
    Cloth(ClothMaterial),
    /// A line, cord, tape, webbing or cable.
    Line(LineMaterial),
}

/// A cloth. It has no compression, and damping along its threads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClothMaterial {
    /// What it is, for the reader.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub about: Option<String>,
    /// [Pa] Young's modulus E.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub modulus: f64,
    /// [m] Thickness t; only E t matters.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub thickness: f64,
    /// [-] Poisson's ratio, for rules of `membranes`; nets of springs have their own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = -1))]
    pub poisson: Option<f64>,
    /// [kg/m^2] Mass per area.
    #[schemars(range(min = 0))]
    pub areal_density: f64,
    /// [N/m] Strength per width, for the reader: no run holds stresses of cloth against it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub strength: Option<f64>,
    /// The air through it; none if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub permeability: Option<PermeableLaw>,
    /// [s] Retardation time of its dashpots; none if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub damping_time: Option<f64>,
    /// Where the numbers are from, for the reader: `stiffness`, `mass`, `strength`, `permeability`, `damping`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub sources: BTreeMap<String, String>,
}

/// A line, cord, tape, webbing or cable. It has no compression. Either `axial_rigidity` or `modulus` and `diameter` are
/// given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LineMaterial {
    /// What it is, for the reader.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub about: Option<String>,
    /// [N] Axial rigidity EA.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub axial_rigidity: Option<f64>,
    /// [Pa] Young's modulus E of the full circle of `diameter`, in place of EA.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub modulus: Option<f64>,
    /// [kg/m] Mass per length.
    #[schemars(range(min = 0))]
    pub linear_density: f64,
    /// [N] Strength.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub strength: Option<f64>,
    /// [m] Diameter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub diameter: Option<f64>,
    /// [-] Drag coefficient on the wind across it; the suspension lines of a parachute have no drag without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub drag_coefficient: Option<f64>,
    /// [s] Retardation time of its dashpots; none if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub damping_time: Option<f64>,
    /// Where the numbers are from, for the reader: `stiffness`, `mass`, `strength`, `diameter`, `drag`, `damping`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub sources: BTreeMap<String, String>,
}
