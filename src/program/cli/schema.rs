//! `canopy-fem schema`: prints the JSON Schema of a case file.

/// The JSON Schema of a case file, ready to print.
pub fn run() -> String {
    // Printing a value cannot fail.
    let schema = crate::case::json_schema();
    serde_json::to_string_pretty(&schema).unwrap_or_else(|_| schema.to_string())
}
