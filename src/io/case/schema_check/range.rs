//! Ranges of numbers, and lengths of lists.

use serde_json::Value;

use crate::case::diagnostics::excerpt;
use crate::case::schema_parts::kind;
use crate::format_number::{counted, figures};

/// What is allowed, if a number or a list is out of the range of its schema.
pub(super) fn out_of_range(schema: &Value, value: &Value) -> Option<String> {
    let bound = |key| schema.get(key).and_then(Value::as_f64);
    if let Value::Array(list) = value {
        let (least, most) = (bound("minItems")?, bound("maxItems"));
        let length = list.len() as f64;
        let [one, several] = entry_names(schema);
        let allowed = || most.map_or(format!("at least one {one}"), |most| format!("{least} to {most} {several}"));
        return (length < least || most.is_some_and(|most| length > most)).then(allowed);
    }
    let x = value.as_f64()?;
    let (above, least, below, most) =
        (bound("exclusiveMinimum"), bound("minimum"), bound("exclusiveMaximum"), bound("maximum"));
    let high = above.is_none_or(|above| x > above) && least.is_none_or(|least| x >= least);
    let low = below.is_none_or(|below| x < below) && most.is_none_or(|most| x <= most);
    if high && low {
        return None;
    }
    let upper = below.map(|x| ("below", x)).or(most.map(|x| ("", x)));
    let words = match (above, least, upper.map(|(word, x)| format!("{word} {}", figures(x, 6)))) {
        (Some(x), _, None) => format!("above {}", figures(x, 6)),
        (Some(x), _, Some(upper)) => format!("above {} and {}", figures(x, 6), upper.trim_start()),
        (None, Some(x), None) => format!("of {} or more", figures(x, 6)),
        (None, Some(x), Some(upper)) => format!("from {} to {}", figures(x, 6), upper.trim_start()),
        (None, None, upper) => upper.unwrap_or_default(),
    };
    let what = if kind(schema) == "integer" { "a whole number" } else { "a number" };
    Some(format!("{what} {words}"))
}

/// What the entries of a list are called: one, and several.
fn entry_names(schema: &Value) -> [&'static str; 2] {
    let rows = schema.pointer("/items/type").is_some_and(|t| t == "array");
    if rows { ["row", "rows"] } else { ["entry", "entries"] }
}

/// A value in a message: of a list with entries, their number.
pub(super) fn counted_entries(schema: &Value, value: &Value) -> String {
    let [one, several] = entry_names(schema);
    match value.as_array().map(Vec::len) {
        None | Some(0) => excerpt(value),
        Some(length) => counted(length as u64, one, several),
    }
}

/// Whether a schema is that of numbers of any size, or of lists of such.
pub(super) fn plain_numbers(schema: &Value) -> bool {
    let bounded = ["minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum"];
    match kind(schema) {
        "number" | "integer" => bounded.iter().all(|key| schema.get(key).is_none()),
        "array" => schema.get("items").is_some_and(plain_numbers),
        _ => false,
    }
}
