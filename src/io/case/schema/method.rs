//! The method of integration: a name, or a name with parameters. The methods are those of
//! [`crate::integrate::registry`]; the JSON Schema is made from its table.

use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::integrate::registry::{MethodInfo, ParameterInfo, methods};

/// A method and the parameters that were given: `"newmark"` or `{"hht": {"alpha": -0.1}}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "MethodInput", into = "MethodInput")]
pub struct Method {
    /// name
    pub name: String,
    /// parameters by name; the others take their defaults
    pub parameters: BTreeMap<String, f64>,
}

/// A method as the case file has it.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum MethodInput {
    Name(String),
    Tuned(BTreeMap<String, BTreeMap<String, f64>>),
}

impl TryFrom<MethodInput> for Method {
    type Error = &'static str;

    fn try_from(written: MethodInput) -> Result<Self, Self::Error> {
        let (name, parameters) = match written {
            MethodInput::Name(name) => (name, BTreeMap::new()),
            MethodInput::Tuned(map) if map.len() == 1 => map.into_iter().next().unwrap_or_default(),
            MethodInput::Tuned(_) => return Err("expected an object with one key, the method's name"),
        };
        Ok(Method { name, parameters })
    }
}

impl From<Method> for MethodInput {
    fn from(Method { name, parameters }: Method) -> Self {
        if parameters.is_empty() { MethodInput::Name(name) } else { MethodInput::Tuned([(name, parameters)].into()) }
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
    // Parameters of methods are ratios, so their unit is [-].
    let description = if p.doc.starts_with('[') { p.doc.to_owned() } else { format!("[-] {}", p.doc) };
    let kind = if p.whole { "integer" } else { "number" };
    json!({"type": kind, "description": description, "default": p.default, least: p.min, "maximum": p.max})
}
