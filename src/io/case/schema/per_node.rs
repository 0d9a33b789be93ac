//! A number or a vector for every node or edge: one for all, or a list.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use serde_json::json;

/// One number for every node, or a list with one number per node.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum PerNode {
    /// The same for every node.
    Same(f64),
    /// One per node.
    Each(Vec<f64>),
}

/// One length for every edge, or a list with one length per edge of the mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum PerEdge {
    /// [m] the same for every edge
    Same(f64),
    /// [m] one per edge
    Each(Vec<f64>),
}

/// One vector for every free degree of freedom, or a list with one vector per node.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Vectors {
    /// The same for every node.
    Same([f64; 3]),
    /// One per node.
    Each(Vec<[f64; 3]>),
}

impl JsonSchema for PerNode {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "PerNode".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"oneOf": [{"type": "number"}, {"type": "array", "items": {"type": "number"}}]})
    }
}

impl JsonSchema for PerEdge {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "PerEdge".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let length = json!({"type": "number", "minimum": 0});
        json_schema!({"oneOf": [length, {"type": "array", "items": length}]})
    }
}

impl JsonSchema for Vectors {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Vectors".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let vector = json!({"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3});
        json_schema!({"oneOf": [vector, {"type": "array", "items": vector}]})
    }
}
