//! Values in place of those that cannot be read.

use serde_json::{Map, Value, json};

use crate::case::schema_parts::{kind, length, meant};

/// Which values stand for those that cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StandIns {
    /// large numbers, the first of several names
    First,
    /// larger numbers, the last of several names
    Second,
}

impl StandIns {
    /// [-] Stand-in for a number: within its range, else large, so that no other number seems too large beside it.
    pub(super) fn number(self, schema: &Value) -> Value {
        let (part, large) = match self {
            StandIns::First => (2_u32, 1_000_000_000_u32),
            StandIns::Second => (3, 3_000_000_000),
        };
        let most = schema.get("maximum").or(schema.get("exclusiveMaximum"));
        let whole = most.filter(|_| kind(schema) == "integer").and_then(Value::as_u64);
        let share = most.and_then(Value::as_f64).map(|most| json!(most / f64::from(part)));
        whole.map(|most| json!(most / u64::from(part))).or(share).unwrap_or(json!(large))
    }
}

/// A value of the right type, so that the rest of the case can be read; the length of a list need not be right.
pub(super) fn stand_in(root: &Value, schema: &Value, kind_of: StandIns) -> Value {
    let schema = meant(root, schema);
    let branches = schema.get("oneOf").and_then(Value::as_array);
    let chosen = branches.and_then(|list| match kind_of {
        StandIns::First => list.first(),
        StandIns::Second => list.last(),
    });
    if let Some(branch) = chosen {
        return branch.get("const").cloned().unwrap_or_else(|| stand_in(root, branch, kind_of));
    }
    match kind(schema) {
        "object" => {
            let required = schema.get("required").and_then(Value::as_array).into_iter().flatten();
            let member =
                |key: &str| Some((key.to_owned(), stand_in(root, schema.get("properties")?.get(key)?, kind_of)));
            Value::Object(required.filter_map(Value::as_str).filter_map(member).collect::<Map<_, _>>())
        }
        "array" => {
            let item = schema.get("items").map_or(Value::Null, |items| stand_in(root, items, kind_of));
            Value::Array(vec![item; length(schema).unwrap_or(0)])
        }
        "number" | "integer" => kind_of.number(schema),
        "string" => json!("x"),
        "boolean" => json!(kind_of == StandIns::Second),
        _ => Value::Null,
    }
}
