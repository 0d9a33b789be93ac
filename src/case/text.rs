//! From the bytes of a case file to a JSON value: encoding, comments, syntax.

use std::io::Read;
use std::path::Path;

use serde_json::Value;

use super::error::CaseError;
use super::jsonc::Strict;
use super::jsonc::blank;
use crate::input_file::open_stream;

/// [bytes] Largest case file: one that is larger is a mistake (or `/dev/zero`).
const LIMIT: u64 = 1 << 30;

/// Reads a file as text.
pub(crate) fn read(path: &Path) -> Result<String, CaseError> {
    let shown = path.display().to_string();
    let failed = |source| CaseError::Read { path: shown.clone(), source };
    let file = open_stream(path).map_err(failed)?;
    let mut bytes = Vec::new();
    file.take(LIMIT + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > LIMIT {
        return Err(CaseError::TooLarge { path: shown, limit: LIMIT });
    }
    decode(bytes, &shown)
}

/// Bytes to text. A byte order mark of UTF-8 is replaced by spaces, which keeps offsets.
pub(crate) fn decode(mut bytes: Vec<u8>, path: &str) -> Result<String, CaseError> {
    if let Some(mark) = bytes.first_chunk_mut::<3>()
        && *mark == [0xEF, 0xBB, 0xBF]
    {
        *mark = *b"   ";
    }
    String::from_utf8(bytes).map_err(|error| {
        let offset = error.utf8_error().valid_up_to();
        let utf16 = matches!(error.as_bytes(), [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..]);
        let advice = if utf16 { "it looks like UTF-16: save it as UTF-8" } else { "save the file as UTF-8" };
        CaseError::NotUtf8 { path: path.to_owned(), offset, advice }
    })
}

/// Why a text is not a JSON value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum NoJson {
    /// There is nothing but white space and comments.
    Empty,
    /// A place where JSON ends.
    Broken {
        /// [byte] where
        offset: usize,
        /// what is wrong
        reason: String,
        /// what is allowed there
        allowed: &'static str,
    },
}

/// Text to JSON: comments and trailing commas blanked, duplicate keys refused.
///
/// # Errors
/// The first thing that is not JSON.
pub(crate) fn parse(text: &str) -> Result<Value, NoJson> {
    let clean = blank(text).map_err(|open| NoJson::Broken {
        offset: open.offset,
        reason: "this block comment is never closed".to_owned(),
        allowed: "a comment that ends with */",
    })?;
    if clean.trim().is_empty() {
        return Err(NoJson::Empty);
    }
    serde_json::from_str::<Strict>(&clean).map(|Strict(value)| value).map_err(|error| broken(text, &error))
}

fn broken(text: &str, error: &serde_json::Error) -> NoJson {
    let message = error.to_string();
    // serde_json ends its messages with " at line L column C", which the error's own fields carry.
    let reason = message.split(" at line ").next().unwrap_or(&message).to_owned();
    let allowed = HINTS.iter().find(|(part, _)| reason.contains(part)).map_or("JSON", |(_, hint)| hint);
    let line = text.split_inclusive('\n').take(error.line().saturating_sub(1)).map(str::len).sum::<usize>();
    NoJson::Broken { offset: line + error.column().saturating_sub(1), reason, allowed }
}

/// Parts of `serde_json`'s messages and what is allowed instead.
const HINTS: &[(&str, &str)] = &[
    ("given twice", "one of the two; the later one does not win"),
    ("EOF while", "the rest: the file ends too early, a bracket, brace or quote is open, or the file was cut off"),
    ("number out of range", "a number that fits a double: its size is at most 1.797e308"),
    ("recursion limit", "less depth: a case never nests as deeply as 128 levels"),
    ("trailing characters", "one JSON object; nothing may follow it"),
    ("expected value", "a number, \"text\", [list], {object}, true, false or null; NaN and Infinity are not JSON"),
    ("key must be a string", "keys in double quotes, and none missing after a comma"),
    ("expected `,` or", "a comma between two entries"),
    ("control character", "a text without control characters; write a line break as \\n"),
];
