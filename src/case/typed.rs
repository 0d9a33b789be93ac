//! From JSON to the schema's structs. Serde stops at the first fault; [`super::schema_check`] finds them all, and what it
//! cannot know is told in serde's words.

use serde_json::Value;
use serde_path_to_error::{Path, Segment};

use super::diagnostics::{Fault, excerpt};
use super::pointer::Pointer;
use super::schema::CaseFile;

/// Reads a case.
///
/// # Errors
/// The first wrong type, unknown or missing key, as serde says it.
pub(crate) fn typed(json: &Value) -> Result<CaseFile, Box<Fault>> {
    serde_path_to_error::deserialize(json).map_err(|error| {
        let at = pointer(json, error.path());
        let value = json.pointer(at.as_str()).map_or_else(|| "(missing)".to_owned(), excerpt);
        let pointer = at.as_str().to_owned();
        Box::new(Fault { pointer, value, allowed: error.inner().to_string(), ..Fault::default() })
    })
}

/// The path as a JSON pointer. Serde also reports the variant of an enum given as a plain word, where JSON has no key.
fn pointer(json: &Value, path: &Path) -> Pointer {
    let mut at = Pointer::root();
    for segment in path {
        let here = json.pointer(at.as_str());
        match (segment, here) {
            (Segment::Seq { index }, Some(Value::Array(_))) => at = at.index(*index),
            (Segment::Map { key } | Segment::Enum { variant: key }, Some(Value::Object(_))) => at = at.key(key),
            _ => break,
        }
    }
    at
}
