//! A number for every node: one for all, or a list.

use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};

/// One number for every node, or a list with one a node.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum PerNode {
    /// The same for every node.
    Same(f64),
    /// One a node.
    Each(Vec<f64>),
}

// serde's own untagged reader only says "did not match any variant"; this one says what was expected and where.
impl<'de> Deserialize<'de> for PerNode {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(PerNodeVisitor)
    }
}

struct PerNodeVisitor;

impl<'de> Visitor<'de> for PerNodeVisitor {
    type Value = PerNode;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or a list with one number a node")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<PerNode, E> {
        Ok(PerNode::Same(value))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<PerNode, E> {
        Ok(PerNode::Same(value as f64))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<PerNode, E> {
        Ok(PerNode::Same(value as f64))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<PerNode, A::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(seq)).map(PerNode::Each)
    }
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
