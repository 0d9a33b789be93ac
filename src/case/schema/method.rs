//! The method of integration: a name, or a name with parameters. Which there are is [`crate::integrate::registry`]'s
//! business; the JSON Schema is made from its table.

use std::collections::BTreeMap;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde::ser::{Serialize, SerializeMap, Serializer};
use serde::{Deserialize, de};
use serde_json::{Map, Value, json};

use crate::integrate::registry::{MethodInfo, ParameterInfo, methods};

/// A method and the parameters that were given: `"newmark"` or `{"hht": {"alpha": -0.1}}`.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    /// name
    pub name: String,
    /// parameters by name; the others take their defaults
    pub parameters: BTreeMap<String, f64>,
}

impl<'de> Deserialize<'de> for Method {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(MethodVisitor)
    }
}

struct MethodVisitor;

impl<'de> Visitor<'de> for MethodVisitor {
    type Value = Method;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a method, \"newmark\", or a method with parameters, {\"hht\": {\"alpha\": -0.1}}")
    }

    fn visit_str<E: de::Error>(self, name: &str) -> Result<Method, E> {
        Ok(Method { name: name.to_owned(), parameters: BTreeMap::new() })
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Method, A::Error> {
        let one = "expected an object with one key, the method's name";
        let (name, parameters) =
            map.next_entry()?.ok_or_else(|| A::Error::custom(format!("invalid length 0, {one}")))?;
        match map.next_key::<String>()? {
            None => Ok(Method { name, parameters }),
            Some(_) => Err(A::Error::custom(format!("invalid length over 1, {one}"))),
        }
    }
}

impl Serialize for Method {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.parameters.is_empty() {
            return serializer.serialize_str(&self.name);
        }
        let mut map = serializer.serialize_map(Some(1))?;
        map.serialize_entry(&self.name, &self.parameters)?;
        map.end()
    }
}

impl JsonSchema for Method {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Method".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let plain: Vec<Value> = methods()
            .iter()
            .map(|m| json!({"const": m.name, "description": format!("Order {}; {}. {}", m.order, m.stability, m.source)}))
            .collect();
        let tuned = methods().iter().map(tuned);
        let choices: Vec<Value> = plain.into_iter().chain(tuned).collect();
        json_schema!({
            "description": "Method of integration: its name, or an object with its name and its parameters.",
            "oneOf": choices
        })
    }
}

/// `{"name": {parameters}}` of one method.
fn tuned(method: &MethodInfo) -> Value {
    let properties: Map<String, Value> = method.parameters.iter().map(|p| (p.name.to_owned(), parameter(p))).collect();
    json!({
        "type": "object",
        "properties": {method.name: {
            "type": "object",
            "properties": properties,
            "additionalProperties": false
        }},
        "required": [method.name],
        "additionalProperties": false
    })
}

fn parameter(p: &ParameterInfo) -> Value {
    let least = if p.min_included { "minimum" } else { "exclusiveMinimum" };
    // Parameters of methods are ratios, hence the unit.
    let description = if p.doc.starts_with('[') { p.doc.to_owned() } else { format!("[-] {}", p.doc) };
    json!({"type": "number", "description": description, "default": p.default, least: p.min, "maximum": p.max})
}
