//! The wind, and the density of the air over height.

use super::event::When;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Wind velocity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Wind {
    /// of one kind
    Part(WindPart),
    /// the sum of several
    Sum(WindSum),
}

/// The sum of several winds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WindSum {
    /// the parts
    pub sum: Vec<WindPart>,
}

/// Wind velocity of one kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub enum WindPart {
    /// [m/s] the same at all times and heights
    Constant([f64; 3]),
    /// over time
    Table {
        /// [s, m/s] rows of time and velocity, times strictly increasing; linear between rows, constant outside them
        table: Vec<[f64; 4]>,
        /// the event from which the times count
        #[serde(default, skip_serializing_if = "Option::is_none")]
        when: Option<Box<When>>,
    },
    /// over time, from a file
    File {
        /// a text file with such rows, separated by commas, beside the case
        file: String,
        /// the event from which the times count
        #[serde(default, skip_serializing_if = "Option::is_none")]
        when: Option<Box<When>>,
    },
    /// over height
    Profile {
        /// [m, m/s] rows of height above sea level and velocity, likewise
        profile: Vec<[f64; 4]>,
    },
    /// over a short time
    Gust {
        /// its shape
        gust: Gust,
        /// the event from which its start counts
        #[serde(default, skip_serializing_if = "Option::is_none")]
        when: Option<Box<When>>,
    },
}

impl WindPart {
    /// The event that it begins with, if there is one.
    pub fn when(&self) -> Option<&When> {
        match self {
            WindPart::Table { when, .. } | WindPart::File { when, .. } | WindPart::Gust { when, .. } => when.as_deref(),
            WindPart::Constant(_) | WindPart::Profile { .. } => None,
        }
    }
}

/// A one-minus-cosine gust: velocity/2 (1 - cos(2 pi (t - start)/duration)), 0 before and after. Where it lasts less
/// than eight fixed steps, its mean is kept, but not its shape.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gust {
    /// [m/s] Velocity at the peak.
    pub velocity: [f64; 3],
    /// [s] Start.
    pub start: f64,
    /// [s] Duration.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub duration: f64,
}

/// A list of exactly `n` numbers.
pub(super) fn numbers(n: usize) -> Value {
    json!({"type": "array", "items": {"type": "number"}, "minItems": n, "maxItems": n})
}

/// An object with one key.
fn tagged(key: &str, description: &str, value: Value) -> Value {
    json!({"type": "object", "properties": {key: described(description, value)}, "required": [key], "additionalProperties": false})
}

/// An object with one key, and perhaps the event from which its times count.
fn timed(key: &str, description: &str, value: Value, when: &Value) -> Value {
    let mut made = tagged(key, description, value);
    let about =
        "The event from which the times count. There is none of this wind before it; with it, other winds go on.";
    made["properties"]["when"] = described(about, when.clone());
    made
}

fn described(description: &str, mut value: Value) -> Value {
    if let Some(value) = value.as_object_mut() {
        value.insert("description".to_owned(), json!(description));
    }
    value
}

impl WindPart {
    fn schemas(generator: &mut SchemaGenerator) -> Vec<Value> {
        let rows = || json!({"type": "array", "items": numbers(4), "minItems": 1});
        let gust = generator.subschema_for::<Gust>().to_value();
        let when = generator.subschema_for::<When>().to_value();
        vec![
            numbers(3),
            timed(
                "table",
                "[s, m/s] Rows of time and velocity, times strictly increasing; linear between rows, constant outside them.",
                rows(),
                &when,
            ),
            timed(
                "file",
                "Path of a text file with such rows of time and velocity, separated by commas; from the folder of the case.",
                json!({"type": "string"}),
                &when,
            ),
            tagged(
                "profile",
                "[m, m/s] Rows of height above sea level and velocity, heights strictly increasing; linear between rows, constant outside them.",
                rows(),
            ),
            timed("gust", "A one-minus-cosine gust.", gust, &when),
        ]
    }
}

impl JsonSchema for WindPart {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "WindPart".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({"oneOf": WindPart::schemas(generator)})
    }
}

impl JsonSchema for Wind {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Wind".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut kinds = WindPart::schemas(generator);
        let parts = json!({"type": "array", "items": {"oneOf": kinds.clone()}, "minItems": 1});
        kinds.push(tagged("sum", "[m/s] The sum of several winds.", parts));
        json_schema!({"oneOf": kinds})
    }
}

/// Density of the air over the height above sea level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Atmosphere {
    /// The standard atmosphere (ISO 2533), from -5 to 86 km.
    Isa,
    /// [kg/m^3] The same density at all heights.
    Density(#[schemars(extend("exclusiveMinimum" = 0))] f64),
    /// density exp(-height/scale_height).
    Exponential(ExponentialAtmosphere),
}

/// Density of the air that decays exponentially with height.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExponentialAtmosphere {
    /// [kg/m^3] Density at sea level.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub density: f64,
    /// [m] Height over which it falls by a factor of e.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub scale_height: f64,
}
