//! A vector for every node: one for all, or a list.

use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};

/// One vector for every free degree of freedom, or a list with one vector a node.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Vectors {
    /// The same for every node.
    Same([f64; 3]),
    /// One a node.
    Each(Vec<[f64; 3]>),
}

/// What the list consists of shows only at its first entry.
enum Entry {
    Number(f64),
    Vector([f64; 3]),
}

impl<'de> Deserialize<'de> for Vectors {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(VectorsVisitor)
    }
}

struct VectorsVisitor;

impl<'de> Visitor<'de> for VectorsVisitor {
    type Value = Vectors;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a vector [x, y, z] or a list with one vector a node")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Vectors, A::Error> {
        match seq.next_element()? {
            None => Ok(Vectors::Each(Vec::new())),
            Some(Entry::Number(x)) => {
                let y = seq.next_element()?.ok_or_else(|| A::Error::invalid_length(1, &self))?;
                let z = seq.next_element()?.ok_or_else(|| A::Error::invalid_length(2, &self))?;
                match seq.next_element::<serde::de::IgnoredAny>()? {
                    None => Ok(Vectors::Same([x, y, z])),
                    Some(_) => Err(A::Error::custom("invalid length over 3, expected a vector [x, y, z]")),
                }
            }
            Some(Entry::Vector(first)) => {
                let mut list = vec![first];
                while let Some(vector) = seq.next_element()? {
                    list.push(vector);
                }
                Ok(Vectors::Each(list))
            }
        }
    }
}

impl<'de> Deserialize<'de> for Entry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(EntryVisitor)
    }
}

struct EntryVisitor;

impl<'de> Visitor<'de> for EntryVisitor {
    type Value = Entry;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or a vector [x, y, z]")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Entry, E> {
        Ok(Entry::Number(value))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Entry, E> {
        Ok(Entry::Number(value as f64))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Entry, E> {
        Ok(Entry::Number(value as f64))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Entry, A::Error> {
        <[f64; 3]>::deserialize(serde::de::value::SeqAccessDeserializer::new(seq)).map(Entry::Vector)
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
        let vector = serde_json::json!({"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3});
        json_schema!({"oneOf": [vector, {"type": "array", "items": vector}]})
    }
}
