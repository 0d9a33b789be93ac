//! Rules that make triangles membranes, and that give cloth and lines bending stiffness.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use super::select::{EdgeSelection, NodeSelection};

/// Triangles that are a membrane: a sheet of constant strain (St. Venant-Kirchhoff), in place of springs on their
/// edges. A triangle follows the first rule that selects it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MembraneRule {
    /// Which triangles: `"all"`, `{"ids": [...]}` or `{"group": ...}`.
    pub on: NodeSelection,
    /// Name of a cloth, which gives what the rule leaves out of `thickness`, `modulus`, `poisson`, `damping_time` and
    /// `strength`, and `mass.areal_density`; without it the first three are required.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// [m] Thickness t.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub thickness: Option<f64>,
    /// [Pa] Young's modulus E; or `[E1, E2]` along the warp and across it, together with `shear` and `warp`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modulus: Option<Modulus>,
    /// [-] Poisson's ratio nu, in (-1, 1); with two moduli nu12, the contraction across the warp over the stretch along
    /// it, with nu12^2 E2 < E1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = -1))]
    pub poisson: Option<f64>,
    /// [Pa] Shear modulus G12; only with two moduli.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub shear: Option<f64>,
    /// [-] Direction of the warp on the mesh as given, of any length above 0; every triangle takes its projection.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub warp: Option<[f64; 3]>,
    /// Whether the sheet wrinkles in place of carrying compression (tension field); not given: it does not.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub wrinkling: bool,
    /// [s] Time tau of stiffness damping: the stress is that of the strain plus tau times its rate; slack cloth has
    /// none. Not given: no damping.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub damping_time: Option<f64>,
    /// [N/m] Strength: force per width at which the cloth tears. `static` and gauges of stress tell the safety factor,
    /// this over the larger principal stress times the thickness. Nothing tears.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub strength: Option<f64>,
}

/// One Young's modulus, or one along the warp and one across it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Modulus {
    /// [Pa] in all directions
    Isotropic(f64),
    /// [Pa] along the warp and across it
    Orthotropic([f64; 2]),
}

impl JsonSchema for Modulus {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Modulus".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let number = json_schema!({"type": "number", "exclusiveMinimum": 0});
        json_schema!({"oneOf": [number, {"type": "array", "items": number, "minItems": 2, "maxItems": 2}]})
    }
}

/// Bending stiffness, quadratic in the positions (Bergou et al. 2006). At rest cloth is flat and lines are straight,
/// whatever the mesh. Triangles and edges whose corners are all held are a clamp. Exactly one of `stiffness` and
/// `flexural_rigidity` is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BendingRule {
    /// Which edges: hinges of cloth are those between two triangles, chains go along edges without triangles. Others
    /// are passed over.
    pub on: EdgeSelection,
    /// [N m] Bending stiffness of cloth per width, as a cantilever test measures it. Poisson's ratio of bending is 0,
    /// so a strip bends with it as a wide sheet does. Several rules at an edge add up.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub stiffness: Option<f64>,
    /// [N m^2] Flexural rigidity EI of lines, at every node with two of the selected edges.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub flexural_rigidity: Option<f64>,
}
