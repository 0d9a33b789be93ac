//! Comments in a case file, `// to the end of the line` and `/* block */`, and trailing commas, as editors know them
//! from "JSON with comments". They are replaced by spaces of the same length in bytes, so that every line, column and
//! byte offset of a later message is the one in the file.
//!
//! A JSON value that refuses duplicate keys: of two `"step"` in one object, `serde_json` would take the last.

use std::fmt;

use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};

/// A block comment without end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OpenComment {
    /// byte offset of its `/*`
    pub offset: usize,
}

/// What the scanner is inside of.
#[derive(Clone, Copy, PartialEq)]
enum Inside {
    Json,
    Text,
    Line,
    Block { start: usize },
}

/// Blanks the comments outside strings, and the comma behind the last entry of a list or an object.
///
/// # Errors
/// A block comment that is never closed.
pub fn blank(text: &str) -> Result<String, OpenComment> {
    let bytes = text.as_bytes();
    let mut out = bytes.to_vec();
    let mut inside = Inside::Json;
    let mut last = LastTwo::default();
    let mut i = 0;
    while i < bytes.len() {
        let pair = (bytes[i], bytes.get(i + 1).copied());
        let (next, used, hidden) = step(inside, pair, i);
        if hidden {
            // Line ends stay, so that line numbers do; a multi-byte character becomes as many spaces.
            for byte in out.iter_mut().skip(i).take(used).filter(|byte| !matches!(**byte, b'\n' | b'\r')) {
                *byte = b' ';
            }
        } else if let Some(comma) =
            last.trailing_comma(i, if matches!(inside, Inside::Json | Inside::Line) { bytes[i] } else { b'"' })
        {
            out[comma] = b' ';
        }
        inside = next;
        i += used;
    }
    match inside {
        Inside::Block { start } => Err(OpenComment { offset: start }),
        // Whole comments were replaced by ASCII, so what is left is still UTF-8.
        _ => Ok(String::from_utf8_lossy(&out).into_owned()),
    }
}

/// The last two bytes outside comments that are no white space.
#[derive(Default)]
struct LastTwo {
    before: u8,
    last: u8,
    /// byte offset of the last
    at: usize,
}

impl LastTwo {
    /// Goes one byte further (a quote for every byte of a string); returns the place of a comma between the last entry
    /// and this closing bracket.
    fn trailing_comma(&mut self, at: usize, byte: u8) -> Option<usize> {
        if byte.is_ascii_whitespace() {
            return None;
        }
        // A comma without an entry before it stays, and is a fault.
        let entry = !matches!(self.before, 0 | b'[' | b'{' | b',' | b':');
        let trailing = matches!(byte, b']' | b'}') && self.last == b',' && entry;
        let comma = trailing.then_some(self.at);
        *self = LastTwo { before: if trailing { b' ' } else { self.last }, last: byte, at };
        comma
    }
}

/// The next state, how many bytes were used, and whether they belong to a comment.
fn step(inside: Inside, pair: (u8, Option<u8>), at: usize) -> (Inside, usize, bool) {
    match (inside, pair) {
        (Inside::Json, (b'"', _)) => (Inside::Text, 1, false),
        (Inside::Json, (b'/', Some(b'/'))) => (Inside::Line, 2, true),
        (Inside::Json, (b'/', Some(b'*'))) => (Inside::Block { start: at }, 2, true),
        (Inside::Text, (b'\\', Some(_))) => (Inside::Text, 2, false),
        (Inside::Text, (b'"', _)) => (Inside::Json, 1, false),
        (Inside::Line, (b'\n' | b'\r', _)) => (Inside::Json, 1, false),
        (Inside::Line, _) => (Inside::Line, 1, true),
        (Inside::Block { .. }, (b'*', Some(b'/'))) => (Inside::Json, 2, true),
        (Inside::Block { .. }, _) => (inside, 1, true),
        _ => (inside, 1, false),
    }
}

/// A [`Value`] read without duplicate keys.
#[derive(Debug)]
pub struct Strict(pub Value);

impl<'de> Deserialize<'de> for Strict {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(StrictVisitor).map(Strict)
    }
}

struct StrictVisitor;

impl<'de> Visitor<'de> for StrictVisitor {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(Value::Bool(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(Value::Number(value.into()))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(Value::Number(value.into()))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Value, E> {
        Number::from_f64(value).map(Value::Number).ok_or_else(|| E::custom("number out of range"))
    }

    fn visit_str<E>(self, value: &str) -> Result<Value, E> {
        Ok(Value::String(value.to_owned()))
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Value, A::Error> {
        let mut list = Vec::new();
        while let Some(Strict(value)) = seq.next_element()? {
            list.push(value);
        }
        Ok(Value::Array(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Value, A::Error> {
        let mut object = Map::new();
        while let Some(key) = map.next_key::<String>()? {
            if object.contains_key(&key) {
                return Err(A::Error::custom(format!("the key \"{key}\" is given twice in the same object")));
            }
            let Strict(value) = map.next_value()?;
            object.insert(key, value);
        }
        Ok(Value::Object(object))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing moves: same length, same line ends, and slashes in strings stay.
    #[test]
    fn keeps_every_offset() {
        let text = "{ // größe\r\n \"a\": \"http://x /* no */ \\\" // \", /* 1\n2 */ \"b\": 1 }";
        let clean = blank(text).expect("closed");
        assert_eq!(clean.len(), text.len());
        assert_eq!(clean.find("\"b\""), text.find("\"b\""));
        let value: serde_json::Value = serde_json::from_str(&clean).expect("JSON");
        assert_eq!(value, serde_json::json!({"a": "http://x /* no */ \" // ", "b": 1}));
    }

    /// A comma behind the last entry goes; one without an entry before it, or within a string, stays.
    #[test]
    fn trailing_commas_are_blanked() {
        for (text, clean) in [
            ("[1, 2, ]", "[1, 2  ]"),
            ("{\"a\": [1,], /* b */ }", "{\"a\": [1 ]          }"),
            ("[[1, // one\n],\n]", "[[1        \n] \n]"),
            ("[\",]\", \"a,\",]", "[\",]\", \"a,\" ]"),
            ("[,]", "[,]"),
            ("{,}", "{,}"),
            ("[1,,]", "[1,,]"),
            ("{\"a\":,}", "{\"a\":,}"),
        ] {
            assert_eq!(blank(text).as_deref(), Ok(clean));
        }
    }

    /// The start of the comment is what a reader of the message needs.
    #[test]
    fn reports_where_an_open_comment_starts() {
        assert_eq!(blank("{} /* to the end"), Err(OpenComment { offset: 3 }));
        // "/*/" opens a comment and does not close it.
        assert_eq!(blank("/*/"), Err(OpenComment { offset: 0 }));
    }
}
