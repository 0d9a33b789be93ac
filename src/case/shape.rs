//! Reading the JSON Schema of the case: what a part of it is about, in words, and a value that stands in for a faulty
//! one.

use serde_json::{Map, Value, json};

use super::choice::Choice;

/// [-] Stands in for a number. Large, so that nothing else seems too large beside it.
const NUMBER: u32 = 1_000_000_000;

/// The schema itself, references and the choice between something and null resolved.
pub(super) fn meant<'a>(root: &'a Value, schema: &'a Value) -> &'a Value {
    let referred = schema.get("$ref").and_then(Value::as_str).and_then(|name| name.strip_prefix('#'));
    if let Some(target) = referred.and_then(|pointer| root.pointer(pointer)) {
        return meant(root, target);
    }
    let branches = schema.get("anyOf").and_then(Value::as_array);
    let branch = branches.and_then(|list| list.iter().find(|branch| kind(branch) != "null"));
    branch.map_or(schema, |branch| meant(root, branch))
}

/// The type of a value, null aside; empty where the schema names none.
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

/// What is allowed, in the words of a case file.
pub(super) fn describe(root: &Value, schema: &Value) -> String {
    let schema = meant(root, schema);
    if let Some(choice) = Choice::new(root, schema) {
        return choice.describe(root);
    }
    match (kind(schema), length(schema)) {
        ("object", _) => "an object {...}".to_owned(),
        ("array", Some(3)) if schema.pointer("/items/type").is_some_and(|t| t == "number") => {
            "a vector [x, y, z] of exactly 3 numbers".to_owned()
        }
        ("array", Some(n)) => format!("a list of exactly {n} entries"),
        ("array", None) => "a list [...]".to_owned(),
        ("number", _) => "a number".to_owned(),
        ("integer", _) if largest(schema) < u64::MAX => format!("a whole number, 0 to {}", largest(schema)),
        ("integer", _) => "a whole number, 0 or more".to_owned(),
        ("string", _) => "a text in double quotes".to_owned(),
        ("boolean", _) => "true or false".to_owned(),
        (other, _) => other.to_owned(),
    }
}

/// A value of the right type, so that the rest of the case can be read; its range need not be right.
pub(super) fn stand_in(root: &Value, schema: &Value) -> Value {
    let schema = meant(root, schema);
    if let Some(first) = schema.get("oneOf").and_then(Value::as_array).and_then(|list| list.first()) {
        return first.get("const").cloned().unwrap_or_else(|| stand_in(root, first));
    }
    match kind(schema) {
        "object" => {
            let required = schema.get("required").and_then(Value::as_array).into_iter().flatten();
            let member = |key: &str| Some((key.to_owned(), stand_in(root, schema.get("properties")?.get(key)?)));
            Value::Object(required.filter_map(Value::as_str).filter_map(member).collect::<Map<_, _>>())
        }
        "array" => {
            let item = schema.get("items").map_or(Value::Null, |items| stand_in(root, items));
            Value::Array(vec![item; length(schema).unwrap_or(0)])
        }
        "number" | "integer" => json!(NUMBER),
        "string" => json!("x"),
        "boolean" => json!(false),
        _ => Value::Null,
    }
}
