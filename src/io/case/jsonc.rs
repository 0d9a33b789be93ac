//! The text of a case: JSON with comments and trailing commas.
//!
//! `jsonc-parser` first reads it strictly, into a tree with the locations of all values. If that fails, a tolerant
//! reading follows: it reports missing commas, other quotes, other numbers and repeated keys, and continues, so that
//! faults behind them are found too. The message on the first part that is not JSON is that of `serde_json`.

use std::io::Read;
use std::ops::Range;
use std::path::Path;

use jsonc_parser::ast::{self, ObjectPropName};
use jsonc_parser::common::Ranged;
use jsonc_parser::errors::ParseErrorKind;
use jsonc_parser::tokens::Token;
use jsonc_parser::{CollectOptions, ParseOptions, Scanner, ScannerOptions, parse_to_ast};
use serde_json::{Map, Number, Value};

use super::diagnostics::{Fault, FaultList, FaultTarget, excerpt};
use super::error::CaseError;
use super::hints::of_broken;
use super::location::Location;
use super::pointer::Pointer;
use crate::input_file::open_stream;

/// [byte] Largest case file: one that is larger is a mistake (or `/dev/zero`).
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
#[derive(Clone, Debug)]
pub(crate) enum ParseFailure {
    /// The text has only white space and comments.
    Empty,
    /// The first part that is not JSON; `None` if that is a repeated key.
    Broken(Option<Box<Fault>>),
}

/// Text to JSON: ignores comments and trailing commas, refuses repeated keys.
///
/// # Errors
/// The first part that is not JSON.
pub(crate) fn parse(text: &str) -> Result<Value, ParseFailure> {
    let strict = ParseOptions {
        allow_comments: true,
        allow_trailing_commas: true,
        allow_loose_object_property_names: false,
        allow_missing_commas: false,
        allow_single_quoted_strings: false,
        allow_hexadecimal_numbers: false,
        allow_unary_plus_numbers: false,
        allow_bare_decimal_point_numbers: false,
        allow_non_finite_numbers: false,
        allow_extended_string_escapes: false,
    };
    let mut found = FaultList::default();
    match parse_to_ast(text, &CollectOptions::default(), &strict).map(|tree| tree.value) {
        Ok(None) => return Err(ParseFailure::Empty),
        Ok(Some(root)) => {
            let value = Tree { text, root }.value(&mut found);
            // Characters that only this parser takes for white space.
            let odd = |c: char| c.is_whitespace() && !matches!(c, ' ' | '\t' | '\n' | '\r');
            if found.count() == 0 && !text.contains(odd) {
                return Ok(value);
            }
        }
        Err(_) => {}
    }
    let clean = blank(text).map_err(|offset| {
        let reason = "this block comment is never closed";
        ParseFailure::Broken(Some(Box::new(no_json(text, offset, reason, "a comment that ends with */"))))
    })?;
    match serde_json::from_str(&clean) {
        Ok(value) if found.count() == 0 => Ok(value),
        Ok(_) => Err(ParseFailure::Broken(None)),
        Err(error) => Err(ParseFailure::Broken(Some(Box::new(broken(text, &error))))),
    }
}

/// A fault of the text itself.
pub(crate) fn no_json(text: &str, offset: usize, reason: &str, allowed: &str) -> Fault {
    Fault {
        part: FaultTarget::Text,
        value: format!("not JSON: {reason}"),
        allowed: allowed.to_owned(),
        place: Some(Location::in_text(text, offset..offset + 1)),
        ..Fault::default()
    }
}

fn broken(text: &str, error: &serde_json::Error) -> Fault {
    let message = error.to_string();
    // serde_json ends its messages with " at line L column C", which the error's own fields carry.
    let reason = message.split(" at line ").next().unwrap_or(&message).to_owned();
    let allowed = HINTS.iter().find(|(part, _)| reason.contains(part)).map_or("JSON", |(_, hint)| hint);
    let line = text.split_inclusive('\n').take(error.line().saturating_sub(1)).map(str::len).sum::<usize>();
    let offset = line + error.column().saturating_sub(1);
    Fault { hint: of_broken(text, offset), ..no_json(text, offset, &reason, allowed) }
}

/// Parts of `serde_json`'s messages and what is allowed instead.
const HINTS: &[(&str, &str)] = &[
    ("EOF while", "more text: the file ends too early, with an open bracket, brace or quote, or it was cut off"),
    ("number out of range", "a number that fits a double: its size is at most 1.797e308"),
    ("recursion limit", "fewer levels: a case is nested less than 128 levels deep"),
    ("trailing characters", "one JSON object; nothing may follow it"),
    ("expected value", "a number, \"text\", [list], {object}, true, false or null; NaN and Infinity are not JSON"),
    ("expected ident", "a number, \"text\", [list], {object}, true, false or null"),
    ("key must be a string", "keys in double quotes, and none missing after a comma"),
    ("expected `,` or", "a comma between two entries"),
    ("control character", "a text without control characters; write a line break as \\n"),
];

/// Replaces comments by spaces, and the comma behind the last entry of a list or an object, so that every line, column
/// and byte offset stays.
///
/// # Errors
/// The byte offset of a block comment that is never closed.
pub(crate) fn blank(text: &str) -> Result<String, usize> {
    let mut out = text.as_bytes().to_vec();
    let mut scanner = Scanner::new(text, &ScannerOptions::default());
    // The last two tokens that are no comments, and where the last one is.
    let (mut before, mut last, mut at) = (None, None, 0);
    loop {
        let token = match scanner.scan() {
            Ok(Some(token)) => token,
            Err(e) if matches!(e.kind(), ParseErrorKind::UnterminatedCommentBlock) => return Err(e.range().start),
            // Text after an invalid token is not read in any case.
            Ok(None) | Err(_) => break,
        };
        let range = scanner.token_start()..scanner.token_end();
        if let Token::CommentLine(_) | Token::CommentBlock(_) = token {
            // Line ends are kept, and with them the line numbers; a multi-byte character becomes as many spaces as it
            // has bytes.
            let hidden = out.get_mut(range).into_iter().flatten();
            hidden.filter(|byte| !matches!(**byte, b'\n' | b'\r')).for_each(|byte| *byte = b' ');
            continue;
        }
        let closes = matches!(token, Token::CloseBracket | Token::CloseBrace);
        // A comma without an entry before it is kept, and is a fault.
        let none = matches!(before, None | Some(Token::OpenBracket | Token::OpenBrace | Token::Comma | Token::Colon));
        if closes && last == Some(Token::Comma) && !none {
            out[at] = b' ';
        }
        (before, last, at) = (last, Some(token), range.start);
    }
    // Whole characters were replaced by ASCII, so the result is still UTF-8.
    Ok(String::from_utf8_lossy(&out).into_owned())
}

/// A text as a tree with the locations of all values.
#[derive(Clone, Debug)]
pub(crate) struct Tree<'a> {
    text: &'a str,
    root: ast::Value<'a>,
}

/// One deviation of the text from JSON.
struct NonJson {
    range: Range<usize>,
    value: String,
    allowed: &'static str,
}

impl<'a> Tree<'a> {
    /// Reads a text as far as possible.
    ///
    /// # Errors
    /// The byte from which nothing more can be read.
    pub(crate) fn parse(text: &'a str) -> Result<Self, usize> {
        let tree = parse_to_ast(text, &CollectOptions::default(), &ParseOptions::default());
        match tree.map(|tree| tree.value) {
            Ok(Some(root)) => Ok(Self { text, root }),
            Ok(None) => Err(text.len()),
            Err(error) => Err(error.range().start),
        }
    }

    /// The value; every deviation from JSON becomes a fault. The text must have no comments. Of a repeated key the
    /// first value is used.
    pub(crate) fn value(&self, findings: &mut FaultList) -> Value {
        Reader { text: self.text, findings }.value(&self.root, ValuePath::Root)
    }

    /// The longest part of a pointer that exists in the text: `/time` of `/time/step`, if there is no step.
    pub(crate) fn reach<'p>(&self, pointer: &'p str) -> &'p str {
        let mut node = Some(&self.root);
        let mut reached = 0;
        for step in pointer.split('/').skip(1) {
            node = node.and_then(|node| Some(below(node, step)?.0));
            if node.is_none() {
                break;
            }
            reached += 1 + step.len();
        }
        pointer.get(..reached).unwrap_or_default()
    }

    /// [byte] Location of the value of a pointer, or of its key; for a missing entry, of the opening brace above it.
    pub(crate) fn range(&self, pointer: &str, part: FaultTarget) -> Range<usize> {
        let mut node = &self.root;
        let mut key = span(node);
        for step in pointer.split('/').skip(1) {
            let Some(next) = below(node, step) else {
                let start = node.range().start;
                return start..start + 1;
            };
            (node, key) = next;
        }
        if part == FaultTarget::Key { key } else { span(node) }
    }
}

/// The value that one step of a pointer leads to, and the location of its key.
fn below<'n, 'a>(node: &'n ast::Value<'a>, step: &str) -> Option<(&'n ast::Value<'a>, Range<usize>)> {
    let name = step.replace("~1", "/").replace("~0", "~");
    match node {
        ast::Value::Object(object) => {
            let property = object.properties.iter().find(|p| p.name.as_str() == name)?;
            Some((&property.value, span(&property.name)))
        }
        ast::Value::Array(array) => {
            name.parse::<usize>().ok().and_then(|i| array.elements.get(i)).map(|e| (e, span(e)))
        }
        _ => None,
    }
}

fn span(node: &impl Ranged) -> Range<usize> {
    node.range().start..node.range().end
}

/// The present location of the reader, without a pointer, which is needed for few locations only.
#[derive(Clone, Copy)]
enum ValuePath<'p> {
    Root,
    Key(&'p ValuePath<'p>, &'p str),
    Entry(&'p ValuePath<'p>, usize),
}

impl ValuePath<'_> {
    fn pointer(self) -> Pointer {
        match self {
            ValuePath::Root => Pointer::root(),
            ValuePath::Key(above, key) => above.pointer().key(key),
            ValuePath::Entry(above, index) => above.pointer().index(index),
        }
    }
}

struct Reader<'a, 'f> {
    text: &'a str,
    findings: &'f mut FaultList,
}

impl Reader<'_, '_> {
    fn value(&mut self, node: &ast::Value<'_>, at: ValuePath<'_>) -> Value {
        match node {
            ast::Value::NullKeyword(_) => Value::Null,
            ast::Value::BooleanLit(b) => Value::Bool(b.value),
            ast::Value::NumberLit(n) => self.number(n, at),
            ast::Value::StringLit(s) => self.string(s, at),
            ast::Value::Array(array) => self.array(array, at),
            ast::Value::Object(object) => self.object(object, at),
        }
    }

    fn number(&mut self, node: &ast::NumberLit<'_>, at: ValuePath<'_>) -> Value {
        if let Ok(number) = serde_json::from_str::<Number>(node.value) {
            return Value::Number(number);
        }
        let finite = node.value.parse::<f64>().is_ok_and(f64::is_finite);
        let allowed = if finite {
            "a number as JSON writes it: -0.5, 12, 1e-3"
        } else {
            "a number that fits a double, whose size is at most 1.797e308; NaN and Infinity are not JSON"
        };
        self.slip(at, NonJson { range: span(node), value: node.value.to_owned(), allowed });
        // A whole number, so that it is valid for every kind of number.
        self.findings.leave_unread(&at.pointer());
        Value::from(1)
    }

    fn string(&mut self, node: &ast::StringLit<'_>, at: ValuePath<'_>) -> Value {
        let range = span(node);
        let written = self.text.get(range.clone()).unwrap_or_default();
        if let Ok(text) = serde_json::from_str::<String>(written) {
            return Value::String(text);
        }
        let allowed = if written.starts_with('"') {
            "a text without control characters, a line break written as \\n, and with JSON's escapes only"
        } else {
            "a text in double quotes"
        };
        let value = excerpt(&Value::from(written));
        self.slip(at, NonJson { range, value, allowed });
        Value::String(node.value.as_ref().to_owned())
    }

    fn array(&mut self, node: &ast::Array<'_>, at: ValuePath<'_>) -> Value {
        self.commas(at, &node.elements);
        Value::Array(node.elements.iter().enumerate().map(|(i, e)| self.value(e, ValuePath::Entry(&at, i))).collect())
    }

    fn object(&mut self, node: &ast::Object<'_>, at: ValuePath<'_>) -> Value {
        self.commas(at, &node.properties);
        let mut map = Map::new();
        for property in &node.properties {
            let name = match &property.name {
                ObjectPropName::String(name) => match self.string(name, at) {
                    Value::String(name) => name,
                    _ => name.value.as_ref().to_owned(),
                },
                ObjectPropName::Word(word) => {
                    let allowed = "keys in double quotes";
                    self.slip(at, NonJson { range: span(word), value: format!("the key {}", word.value), allowed });
                    word.value.to_owned()
                }
            };
            let below = ValuePath::Key(&at, &name);
            if map.contains_key(&name) {
                let value = format!("the key \"{name}\" is given twice in the same object");
                let allowed = "only one of the two";
                self.slip(below, NonJson { range: span(&property.name), value, allowed });
                continue;
            }
            let value = self.value(&property.value, below);
            map.insert(name, value);
        }
        Value::Object(map)
    }

    /// One comma between two entries.
    fn commas(&mut self, at: ValuePath<'_>, entries: &[impl Ranged]) {
        for (entry, next) in entries.iter().zip(entries.iter().skip(1)) {
            let gap = entry.range().end..next.range().start;
            if !self.text.get(gap.clone()).is_some_and(|between| between.contains(',')) {
                let value = "a missing comma".to_owned();
                self.slip(at, NonJson { range: gap, value, allowed: "a comma between two entries" });
            }
        }
    }

    fn slip(&mut self, at: ValuePath<'_>, slip: NonJson) {
        self.findings.note(|| Fault {
            pointer: at.pointer().as_str().to_owned(),
            value: slip.value,
            allowed: slip.allowed.to_owned(),
            place: Some(Location::in_text(self.text, slip.range)),
            ..Fault::default()
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// Every slip is noted at its own place, and all values are read.
    #[test]
    fn slips_are_noted_and_read_over() {
        let text = "{\"a\": [1, 2 ], b: 'x' \"c\": NaN, \"a\": 3, \"d\": +1,\n \"e\": \"1\t2\", \"f\": [1 2] }";
        let mut findings = FaultList::default();
        let tree = Tree::parse(text).expect("readable");
        let value = tree.value(&mut findings);
        assert_eq!(value, json!({"a": [1, 2], "b": "x", "c": 1, "d": 1, "e": "1\t2", "f": [1, 2]}));
        let faults = findings.report().faults;
        let found: Vec<(&str, &str)> = faults.iter().map(|f| (f.pointer.as_str(), f.value.as_str())).collect();
        let expected = [
            ("", "a missing comma"),
            ("", "the key b"),
            ("/b", "\"'x'\""),
            ("/c", "NaN"),
            ("/a", "the key \"a\" is given twice in the same object"),
            ("/d", "+1"),
            ("/e", "\"\\\"1\\t2\\\"\""),
            ("/f", "a missing comma"),
        ];
        assert_eq!(found, expected);
        let columns = faults.iter().map(|f| f.place.as_ref().map(ToString::to_string).unwrap_or_default());
        let columns: Vec<String> = columns.collect();
        assert_eq!(columns, ["1:22", "1:16", "1:19", "1:28", "1:33", "1:46", "2:7", "2:21"]);
    }

    /// Values, keys and the brace above what is missing are found again.
    #[test]
    fn pointers_lead_to_the_text() {
        let text = "{\"a\": {\"b/c\": [10, 20]}}";
        let tree = Tree::parse(text).expect("JSON");
        let shown = |pointer, part| text.get(tree.range(pointer, part)).expect("in the text");
        assert_eq!(shown("/a/b~1c/1", FaultTarget::Value), "20");
        assert_eq!(shown("/a/b~1c", FaultTarget::Key), "\"b/c\"");
        assert_eq!(shown("", FaultTarget::Value), text);
        assert_eq!(tree.range("/a/x/y", FaultTarget::Value), 6..7);
    }

    /// What cannot be read over is reported at its place.
    #[test]
    fn some_text_is_no_json_at_all() {
        for (text, at) in [("{\"a\" 1}", 5), ("[1,,2]", 3), ("{} {}", 3)] {
            assert_eq!(Tree::parse(text).err(), Some(at), "{text}");
        }
    }

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
}
