//! From the bytes of a case file to a JSON value: encoding, comments, syntax.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde_json::Value;

use super::comments::blank;
use super::error::CaseError;
use super::strict::Strict;

/// [bytes] Largest case file: one that is larger is a mistake (or `/dev/zero`).
const LIMIT: u64 = 1 << 30;

/// Reads a file as text.
pub(crate) fn read(path: &Path) -> Result<String, CaseError> {
    let shown = path.display().to_string();
    let failed = |source| CaseError::Read { path: shown.clone(), source };
    let file = File::open(path).map_err(failed)?;
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

/// Text to JSON: comments blanked, duplicate keys refused.
pub(crate) fn parse(text: &str, path: &str) -> Result<Value, CaseError> {
    let clean = blank(text).map_err(|open| {
        let (line, column) = position(text, open.offset);
        let reason = "this block comment is never closed".to_owned();
        CaseError::Syntax { path: path.to_owned(), line, column, reason, hint: Some("end it with */".to_owned()) }
    })?;
    if clean.trim().is_empty() {
        return Err(CaseError::Empty { path: path.to_owned() });
    }
    serde_json::from_str::<Strict>(&clean).map(|Strict(value)| value).map_err(|error| syntax(&error, path))
}

fn syntax(error: &serde_json::Error, path: &str) -> CaseError {
    let text = error.to_string();
    // serde_json ends its messages with " at line L column C", which the error's own fields carry.
    let reason = text.split(" at line ").next().unwrap_or(&text).to_owned();
    let hint = HINTS.iter().find(|(part, _)| reason.contains(part)).map(|(_, hint)| (*hint).to_owned());
    CaseError::Syntax { path: path.to_owned(), line: error.line(), column: error.column(), reason, hint }
}

/// Parts of `serde_json`'s messages and what to do about them.
const HINTS: &[(&str, &str)] = &[
    ("given twice", "keep one of the two; the later one does not win"),
    ("EOF while", "the file ends too early: a bracket, brace or quote is open, or the file was cut off"),
    ("number out of range", "a number must fit a double: its size is at most 1.797e308"),
    ("recursion limit", "a case never nests as deeply as 128 levels"),
    ("trailing comma", "JSON allows no comma before a closing bracket or brace"),
    ("trailing characters", "a case is one JSON object; nothing may follow it"),
    ("expected value", "here a number, \"text\", [list], {object}, true, false or null; NaN and Infinity are not JSON"),
    ("key must be a string", "keys are in double quotes, and none may be missing after a comma"),
    ("expected `,` or", "a comma between two entries is missing"),
    ("control character", "write a line break inside a text as \\n"),
];

/// Line and column, both from 1, of a byte offset.
fn position(text: &str, offset: usize) -> (usize, usize) {
    let head = &text.as_bytes()[..offset.min(text.len())];
    let line_start = head.iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
    (1 + head.iter().filter(|b| **b == b'\n').count(), 1 + head.len() - line_start)
}
