//! From JSON to the schema's structs. Stops at the first fault (a wrong type, an unknown or a missing key) and puts
//! serde's message into the words of a case file.

use serde_json::Value;
use serde_path_to_error::{Path, Segment};

use super::fault::{Fault, excerpt};
use super::pointer::Pointer;
use super::schema::CaseFile;

/// Reads a case.
pub(crate) fn typed(json: &Value) -> Result<CaseFile, Fault> {
    serde_path_to_error::deserialize(json).map_err(|error| translate(json, error.path(), &error.inner().to_string()))
}

/// Puts serde's message at the pointer it belongs to.
fn translate(json: &Value, path: &Path, message: &str) -> Fault {
    let at = pointer(json, path);
    let names = quoted(message);
    match names.split_first() {
        Some((key, known)) if message.starts_with("unknown field") => {
            let at = if at.last() == *key { at } else { at.key(key) };
            fault(json, &at, one_of("known keys here", known), nearest(key, known))
        }
        Some((name, known)) if message.starts_with("unknown variant") => {
            fault(json, &at, one_of("known names here", known), nearest(name, known))
        }
        Some((key, _)) if message.starts_with("missing field") => {
            fault(json, &at.key(key), format!("the key \"{key}\" is required here"), None)
        }
        _ => fault(json, &at, expected(message), None),
    }
}

fn fault(json: &Value, at: &Pointer, allowed: String, hint: Option<String>) -> Fault {
    let value = json.pointer(at.as_str()).map_or_else(|| "(missing)".to_owned(), excerpt);
    Fault { pointer: at.as_str().to_owned(), value, allowed, hint }
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

/// The names between back quotes.
fn quoted(message: &str) -> Vec<String> {
    message.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

fn one_of(what: &str, names: &[String]) -> String {
    if names.is_empty() { "no key at all".to_owned() } else { format!("{what}: {}", names.join(", ")) }
}

/// "did you mean" the known name that looks most like `name`, if one does.
pub(crate) fn nearest<T: AsRef<str>>(name: &str, known: &[T]) -> Option<String> {
    // 0.6 finds slips and swaps of letters, and lets words of another meaning go.
    const ALIKE: f64 = 0.6;
    let likeness = |k: &T| strsim::normalized_damerau_levenshtein(name, k.as_ref());
    let best = known.iter().map(|k| (likeness(k), k)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 >= ALIKE).then(|| format!("did you mean \"{}\"?", best.1.as_ref()))
}

/// What was expected, in the words of a case file; serde names Rust's types.
fn expected(message: &str) -> String {
    const WORDS: &[(&str, &str)] = &[
        ("f64", "a number"),
        ("u32", "a whole number, 0 to 4294967295"),
        ("u64", "a whole number, 0 or more"),
        ("usize", "a whole number, 0 or more"),
        ("a string", "a text in double quotes"),
        ("a boolean", "true or false"),
        ("a sequence", "a list [...]"),
        ("an array of length 2", "a list of exactly 2 entries"),
        ("an array of length 3", "a list of exactly 3 entries"),
        ("an array of length 4", "a list of exactly 4 entries"),
        ("fewer elements in array", "a list of fewer entries"),
        ("a map", "an object {...}"),
        ("string or map", "a word in double quotes or an object {...} with one key"),
        ("map with a single key", "an object with exactly one key"),
        ("newtype variant", "an object with this name as its key: {\"name\": value}"),
        ("struct variant", "an object with this name as its key: {\"name\": {...}}"),
        ("unit", "the plain word in double quotes, without braces"),
        ("unit variant", "the plain word in double quotes, without braces"),
    ];
    let Some((_, wanted)) = message.rsplit_once("expected ") else {
        return message.to_owned();
    };
    if wanted.starts_with("struct ") {
        return "an object {...}".to_owned();
    }
    if wanted.starts_with("enum ") {
        return "a word in double quotes or an object {...} with one key".to_owned();
    }
    WORDS.iter().find(|(rust, _)| *rust == wanted).map_or(wanted, |(_, words)| words).to_owned()
}
