//! Parts of a JSON Schema, as it is written here.

use serde_json::Value;

/// The schema itself, with references and the choice between a value and null resolved.
pub(super) fn meant<'a>(root: &'a Value, schema: &'a Value) -> &'a Value {
    let referred = schema.get("$ref").and_then(Value::as_str).and_then(|name| name.strip_prefix('#'));
    if let Some(target) = referred.and_then(|pointer| root.pointer(pointer)) {
        return meant(root, target);
    }
    let branches = schema.get("anyOf").and_then(Value::as_array);
    let branch = branches.and_then(|list| list.iter().find(|branch| kind(branch) != "null"));
    branch.map_or(schema, |branch| meant(root, branch))
}

/// The type of a value, except null; empty if the schema names none.
pub(super) fn kind(schema: &Value) -> &str {
    match schema.get("type") {
        Some(Value::String(name)) => name,
        Some(Value::Array(names)) => names.iter().filter_map(Value::as_str).find(|n| *n != "null").unwrap_or("null"),
        _ => "",
    }
}

/// Whether null may stand for an absent value.
pub(super) fn nullable(schema: &Value) -> bool {
    let null = |v: &Value| v == "null";
    let named = schema.get("type").and_then(Value::as_array).is_some_and(|names| names.iter().any(null));
    let branches = schema.get("anyOf").and_then(Value::as_array);
    named || branches.is_some_and(|list| list.iter().any(|branch| kind(branch) == "null"))
}

/// The length of a list that has exactly one.
pub(super) fn length(schema: &Value) -> Option<usize> {
    let bound = |key| schema.get(key).and_then(Value::as_u64).and_then(|n| usize::try_from(n).ok());
    bound("maxItems").filter(|n| bound("minItems") == Some(*n))
}

/// The largest whole number that its Rust type holds.
pub(super) fn largest(schema: &Value) -> u64 {
    if schema.get("format").is_some_and(|format| format == "uint32") { u64::from(u32::MAX) } else { u64::MAX }
}
