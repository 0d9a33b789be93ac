//! What may touch what.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use super::select::Ball;
use super::table::VectorTable;

/// Parts of the scene that may touch each other, or a rigid body. Below the distance `gap` they push each other apart.
/// Parts that share a node never touch. Without this section everything passes through everything.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// What may touch what: `"self"`, all cloth, lines with springs and lone nodes with themselves, or a list of two.
    /// The first is a group of the mesh or `"all"`; the second is a group, `"all"`, or a rigid body: `["cloth",
    /// {"sphere": {...}}]`. The same name twice is contact of that group with itself. A group brings its triangles,
    /// those of its edges that are lines, and its lone nodes.
    pub between: Between,
    /// [m] Distance below which the two push each other apart, such as the thickness of cloth. Not given: a fifth of
    /// the shortest edge of the parts at the start, initial displacements included. Lone nodes have no edges, and need
    /// it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub gap: Option<f64>,
    /// [-] Coulomb's coefficient of friction; 0 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub friction: Option<f64>,
}

/// The two sides of a contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Between {
    /// everything with itself
    Word(EverythingWord),
    /// two sides
    Pair([TouchingSide; 2]),
}

/// The word for contact of everything with itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum EverythingWord {
    /// all cloth, lines with springs and lone nodes
    #[serde(rename = "self")]
    Itself,
}

/// One side of a contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum TouchingSide {
    /// a group of the mesh, or all
    Named(String),
    /// a rigid body
    Obstacle(Box<Obstacle>),
}

impl JsonSchema for Between {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Between".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let side = generator.subschema_for::<TouchingSide>().to_value();
        let pair = serde_json::json!({"type": "array", "items": side, "minItems": 2, "maxItems": 2});
        json_schema!({"oneOf": [{"type": "string", "const": "self"}, pair]})
    }
}

impl JsonSchema for TouchingSide {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "TouchingSide".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let obstacle = generator.subschema_for::<Obstacle>().to_value();
        json_schema!({"oneOf": [{"type": "string"}, obstacle]})
    }
}

/// A rigid body that nothing moves but its own table. Exactly one of `plane`, `sphere`, `cylinder`, `box` and `file` is
/// given. No node that can move is inside of it at the start.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Obstacle {
    /// The half-space below a plane, such as the ground.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plane: Option<Plane>,
    /// A ball.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sphere: Option<Ball>,
    /// A round bar with half a ball at either end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cylinder: Option<Bar>,
    /// A box with its sides along the axes.
    #[serde(default, rename = "box", skip_serializing_if = "Option::is_none")]
    pub cuboid: Option<Cuboid>,
    /// Name of a mesh file whose triangles are a closed surface; a relative path counts from the case file's folder.
    /// Coordinates are in metres. Triangles are turned so that their normals point out of each closed part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// [m] How the body moves: `{"table": [[t, x, y, z], ...]}`, the displacement from where its shape is given. It
    /// does not turn. Not given: it stands still.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<VectorTable>,
}

/// A half-space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Plane {
    /// [m] A point of its surface.
    pub point: [f64; 3],
    /// [-] Direction out of it, of any length above 0: `[0, 0, 1]` for the ground.
    pub normal: [f64; 3],
}

/// A round bar with half a ball at either end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bar {
    /// [m] One end of its axis; the half ball is beyond it.
    pub from: [f64; 3],
    /// [m] The other end of its axis.
    pub to: [f64; 3],
    /// [m] Radius.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: f64,
}

/// A box with its sides along the axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cuboid {
    /// [m] Its corner with the smallest coordinates.
    pub min: [f64; 3],
    /// [m] Its corner with the largest coordinates, each above that of `min`.
    pub max: [f64; 3],
}
