//! Tables over time.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

/// A vector over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VectorTable {
    /// [s, SI] Rows `[t, x, y, z]` of time and vector, times strictly increasing; linear between rows, constant
    /// outside them.
    #[schemars(length(min = 1))]
    pub table: Vec<[f64; 4]>,
}

/// A factor over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FactorTable {
    /// [s, -] Rows `[t, factor]`, times strictly increasing, factors above 0; linear between rows, constant outside
    /// them.
    #[schemars(length(min = 1))]
    pub table: Vec<[f64; 2]>,
}

/// A factor, constant or over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Factor {
    /// [-] the same at all times
    Constant(f64),
    /// over time
    Table(FactorTable),
}

impl JsonSchema for Factor {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Factor".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let table = generator.subschema_for::<FactorTable>().to_value();
        json_schema!({"oneOf": [{"type": "number"}, table]})
    }
}

/// A value over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ValueTable {
    /// [s, SI] Rows `[t, value]`, times strictly increasing; linear between rows, constant outside them.
    #[schemars(length(min = 1))]
    pub table: Vec<[f64; 2]>,
}

/// A value, constant or over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum OverTime {
    /// [SI] the same at all times
    Constant(f64),
    /// over time
    Table(ValueTable),
}

impl JsonSchema for OverTime {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "OverTime".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let table = generator.subschema_for::<ValueTable>().to_value();
        json_schema!({"oneOf": [{"type": "number"}, table]})
    }
}

/// Rows `[t, x, y, z]` as time and vector.
pub fn vectors(rows: &[[f64; 4]]) -> impl Iterator<Item = (f64, [f64; 3])> {
    rows.iter().map(|&[t, x, y, z]| (t, [x, y, z]))
}
