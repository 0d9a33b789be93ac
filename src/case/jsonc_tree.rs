//! JSON read with forgiveness, for the second pass: missing commas, other quotes, other numbers and repeated keys
//! are noted where they stand and read over, so that they hide nothing. What cannot be read over ends the reading.

use std::ops::Range;

use jsonc_parser::ast::{self, ObjectPropName};
use jsonc_parser::common::Ranged;
use jsonc_parser::{CollectOptions, ParseOptions, parse_to_ast};
use serde_json::{Map, Number, Value};

use super::diagnostics::Findings;
use super::diagnostics::{Fault, FaultTarget, excerpt};
use super::pointer::Pointer;
use super::span::Location;

/// A text with its comments and trailing commas blanked, as a tree that knows where everything stands.
#[derive(Clone, Debug)]
pub(crate) struct Tree<'a> {
    clean: &'a str,
    root: ast::Value<'a>,
}

/// One thing in the text that JSON does not have.
struct Slip {
    range: Range<usize>,
    value: String,
    allowed: &'static str,
}

impl<'a> Tree<'a> {
    /// Reads a text without comments.
    ///
    /// # Errors
    /// The byte from which nothing more can be read.
    pub fn parse(clean: &'a str) -> Result<Self, usize> {
        let tree = parse_to_ast(clean, &CollectOptions::default(), &ParseOptions::default());
        match tree.map(|tree| tree.value) {
            Ok(Some(root)) => Ok(Self { clean, root }),
            Ok(None) => Err(clean.len()),
            Err(error) => Err(error.range().start),
        }
    }

    /// The value, with every slip noted. Of a repeated key the first value is taken.
    pub fn value(&self, findings: &mut Findings) -> Value {
        Reader { clean: self.clean, findings }.value(&self.root, &Pointer::root())
    }

    /// How much of a pointer leads to something in the text: `/time` of `/time/step`, where there is no step.
    pub fn reach<'p>(&self, pointer: &'p str) -> &'p str {
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

    /// [byte] Where the value of a pointer stands, or its key; of a place that is not there the opening brace above it.
    pub fn range(&self, pointer: &str, part: FaultTarget) -> Range<usize> {
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

/// What one step of a pointer leads to, and where its key stands.
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

struct Reader<'a, 'f> {
    clean: &'a str,
    findings: &'f mut Findings,
}

impl Reader<'_, '_> {
    fn value(&mut self, node: &ast::Value<'_>, at: &Pointer) -> Value {
        match node {
            ast::Value::NullKeyword(_) => Value::Null,
            ast::Value::BooleanLit(b) => Value::Bool(b.value),
            ast::Value::NumberLit(n) => self.number(n, at),
            ast::Value::StringLit(s) => self.string(s, at),
            ast::Value::Array(array) => self.array(array, at),
            ast::Value::Object(object) => self.object(object, at),
        }
    }

    fn number(&mut self, node: &ast::NumberLit<'_>, at: &Pointer) -> Value {
        if let Ok(number) = serde_json::from_str::<Number>(node.value) {
            return Value::Number(number);
        }
        let finite = node.value.parse::<f64>().is_ok_and(f64::is_finite);
        let allowed = if finite {
            "a number as JSON writes it: -0.5, 12, 1e-3"
        } else {
            "a number that fits a double, whose size is at most 1.797e308; NaN and Infinity are not JSON"
        };
        self.slip(at, Slip { range: span(node), value: node.value.to_owned(), allowed });
        // A whole number, so that it is a number wherever one may stand.
        self.findings.leave_unread(at);
        Value::from(1)
    }

    fn string(&mut self, node: &ast::StringLit<'_>, at: &Pointer) -> Value {
        let range = span(node);
        let written = self.clean.get(range.clone()).unwrap_or_default();
        if let Ok(text) = serde_json::from_str::<String>(written) {
            return Value::String(text);
        }
        let allowed = if written.starts_with('"') {
            "a text without control characters, a line break written as \\n, and with JSON's escapes only"
        } else {
            "a text in double quotes"
        };
        let value = excerpt(&Value::from(written));
        self.slip(at, Slip { range, value, allowed });
        Value::String(node.value.as_ref().to_owned())
    }

    fn array(&mut self, node: &ast::Array<'_>, at: &Pointer) -> Value {
        let ranges: Vec<Range<usize>> = node.elements.iter().map(span).collect();
        self.commas(at, &ranges);
        Value::Array(node.elements.iter().enumerate().map(|(i, e)| self.value(e, &at.index(i))).collect())
    }

    fn object(&mut self, node: &ast::Object<'_>, at: &Pointer) -> Value {
        let ranges: Vec<Range<usize>> = node.properties.iter().map(span).collect();
        self.commas(at, &ranges);
        let mut map = Map::new();
        for property in &node.properties {
            let name = match &property.name {
                ObjectPropName::String(name) => match self.string(name, at) {
                    Value::String(name) => name,
                    _ => name.value.as_ref().to_owned(),
                },
                ObjectPropName::Word(word) => {
                    let allowed = "keys in double quotes";
                    self.slip(at, Slip { range: span(word), value: format!("the key {}", word.value), allowed });
                    word.value.to_owned()
                }
            };
            let below = at.key(&name);
            if map.contains_key(&name) {
                let value = format!("the key \"{name}\" is given twice in the same object");
                let allowed = "one of the two; the later one does not win";
                self.slip(&below, Slip { range: span(&property.name), value, allowed });
                continue;
            }
            let value = self.value(&property.value, &below);
            map.insert(name, value);
        }
        Value::Object(map)
    }

    /// One comma between two entries.
    fn commas(&mut self, at: &Pointer, entries: &[Range<usize>]) {
        for (entry, next) in entries.iter().zip(entries.iter().skip(1)) {
            let gap = entry.end..next.start;
            if !self.clean.get(gap.clone()).is_some_and(|between| between.contains(',')) {
                let value = "a missing comma".to_owned();
                self.slip(at, Slip { range: gap, value, allowed: "a comma between two entries" });
            }
        }
    }

    fn slip(&mut self, at: &Pointer, slip: Slip) {
        let clean = self.clean;
        self.findings.note(|| Fault {
            pointer: at.as_str().to_owned(),
            value: slip.value,
            allowed: slip.allowed.to_owned(),
            place: Some(Location::in_text(clean, slip.range)),
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
        let mut findings = Findings::default();
        let tree = Tree::parse(text).expect("readable");
        let value = tree.value(&mut findings);
        assert_eq!(value, json!({"a": [1, 2], "b": "x", "c": 1, "d": 1, "e": "1\t2", "f": [1, 2]}));
        let faults = findings.told().faults;
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
}
