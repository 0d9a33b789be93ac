//! Compares a case with the JSON Schema. Of a case that serde has read, it checks the ranges. Of one that serde has
//! refused or whose ranges are wrong, it finds every wrong type, key and range, while serde stops at the first.
//!
//! A wrong value is replaced by a stand-in, so that the rest can be read and its meaning checked as well. Faults that
//! follow from a stand-in are not the user's: a case is read with two kinds of stand-ins, and only the faults of both
//! readings count. The check supports the part of JSON Schema that schemars uses for this case: `$ref`, `oneOf` of
//! words, of objects with one key and of different types, objects that refuse other keys, maps with values of one kind,
//! arrays, bounds of numbers and of the lengths of lists, and nullable types.

use std::sync::LazyLock;

use serde_json::{Map, Value};

use super::diagnostics::{Fault, FaultList, FaultTarget, did_you_mean, excerpt, nearest, one_of, shorten};
use super::hints;
use super::pointer::Pointer;
use super::schema::json_schema;
use super::schema_parts::{kind, largest, length, meant, nullable};

mod one_of;
mod range;
mod stand_in;
use one_of::{OneOf, describe};
use range::{counted_entries, out_of_range, plain_numbers};
pub(crate) use stand_in::StandIns;
use stand_in::stand_in;

static SCHEMA: LazyLock<Value> = LazyLock::new(json_schema);

/// Finds every wrong type, key and range of a case and replaces the values by stand-ins.
pub(crate) fn walk(json: &mut Value, findings: &mut FaultList, stand_ins: StandIns) {
    SchemaCheck { root: &SCHEMA, findings, stand_ins: Some(stand_ins) }.visit(&SCHEMA, json, &Pointer::root());
}

/// Whether the ranges of a case that serde has read are right. The case stays as it is.
pub(crate) fn ranges_hold(json: &mut Value) -> bool {
    let mut findings = FaultList::default();
    SchemaCheck { root: &SCHEMA, findings: &mut findings, stand_ins: None }.visit(&SCHEMA, json, &Pointer::root());
    findings.count() == 0
}

/// Whether the ranges at `at` are checked elsewhere: a mesh and a method check their own, without a case too.
fn checked_elsewhere(at: &Pointer) -> bool {
    let places = ["/system/network/mesh", "/time/method", "/study/methods/"];
    places.iter().any(|place| at.as_str().starts_with(place))
}

struct SchemaCheck<'a> {
    root: &'a Value,
    findings: &'a mut FaultList,
    /// `None`: serde has read the case, and values stay
    stand_ins: Option<StandIns>,
}

impl<'a> SchemaCheck<'a> {
    fn visit(&mut self, schema: &'a Value, value: &mut Value, at: &Pointer) {
        if value.is_null() && nullable(schema) || self.stand_ins.is_none() && checked_elsewhere(at) {
            return;
        }
        let outer = schema;
        let schema = meant(self.root, schema);
        if let Some(choice) = OneOf::new(self.root, schema) {
            self.choose(&choice, schema, value, at);
            return self.range(outer, value, at);
        }
        match (kind(schema), &mut *value) {
            ("object", Value::Object(map)) => self.object(schema, map, at),
            ("array", Value::Array(list)) if length(schema).is_none_or(|n| list.len() == n) => {
                let Some(items) = schema.get("items") else { return };
                // Serde has read them, and there may be millions.
                if self.stand_ins.is_some() || !plain_numbers(items) {
                    list.iter_mut().enumerate().for_each(|(i, item)| self.visit(items, item, &at.index(i)));
                }
                self.range(schema, value, at);
            }
            // The reader of the text has put any number where it could not read one.
            ("number", Value::Number(_)) if self.findings.unread(at) => self.replace(schema, value, at),
            ("string", Value::String(_)) | ("boolean", Value::Bool(_)) => {}
            ("number", Value::Number(_)) => self.range(schema, value, at),
            ("integer", Value::Number(n)) if n.as_u64().is_some_and(|n| n <= largest(schema)) => {
                self.range(schema, value, at);
            }
            _ => self.refuse(schema, value, at, describe(self.root, schema)),
        }
    }

    /// Adds a fault for the whole value, and replaces it by a stand-in.
    fn refuse(&mut self, schema: &Value, value: &mut Value, at: &Pointer, allowed: String) {
        let (pointer, shown) = (at.as_str().to_owned(), excerpt(value));
        let (wrong, hint) = (wrong_type(kind(schema), value), self.hint(schema, value));
        self.findings.note(|| Fault { pointer, value: shown, wrong, allowed, hint, ..Fault::default() });
        self.replace(schema, value, at);
    }

    /// How to write what a value of another type probably means.
    fn hint(&self, schema: &Value, value: &Value) -> Option<String> {
        match (kind(schema), value) {
            ("number" | "integer", Value::String(text)) => hints::of_text(text, hints::unit(schema)),
            ("object" | "", Value::Number(_)) => {
                hints::example(self.root, schema, value).map(|example| format!("for example {example}"))
            }
            ("array", Value::Object(_)) => {
                let objects = schema.get("items").is_some_and(|items| kind(meant(self.root, items)) == "object");
                objects.then(|| "put the object into a list: [{...}]".to_owned())
            }
            _ => None,
        }
    }

    fn replace(&mut self, schema: &Value, value: &mut Value, at: &Pointer) {
        let Some(stand_ins) = self.stand_ins else { return };
        *value = stand_in(self.root, schema, stand_ins);
        self.findings.leave_unread(at);
    }

    /// Adds a fault for a number or a list out of the range of its schema, and replaces it by a stand-in.
    fn range(&mut self, schema: &Value, value: &mut Value, at: &Pointer) {
        // A stand-in for a list is empty.
        if checked_elsewhere(at) || self.findings.unread(at) {
            return;
        }
        let Some(allowed) = out_of_range(schema, value) else { return };
        let pointer = at.as_str().to_owned();
        let (shown, hint) = (counted_entries(schema, value), hints::of_range(at.as_str()));
        self.findings.note(|| Fault { pointer, value: shown, allowed, hint, ..Fault::default() });
        match self.stand_ins.filter(|_| value.is_number()) {
            Some(stand_ins) => {
                *value = stand_ins.number(schema);
                self.findings.leave_outside(at);
            }
            None => self.replace(schema, value, at),
        }
    }

    fn note(&mut self, at: &Pointer, part: FaultTarget, value: &Value, allowed: String, hint: Option<String>) {
        let pointer = at.as_str().to_owned();
        self.findings.note(|| Fault { pointer, part, value: excerpt(value), allowed, hint, ..Fault::default() });
    }

    fn object(&mut self, schema: &'a Value, map: &mut Map<String, Value>, at: &Pointer) {
        let known = schema.get("properties").and_then(Value::as_object);
        // A map from any name to values of one kind.
        if let Some(values) = schema.get("additionalProperties").filter(|values| values.is_object()) {
            return map.iter_mut().for_each(|(key, value)| self.visit(values, value, &at.key(key)));
        }
        if let Some(stand_ins) = self.stand_ins {
            self.keys(schema, map, at, stand_ins);
        }
        for (key, value) in map {
            if let Some(schema) = known.and_then(|known| known.get(key)) {
                self.visit(schema, value, &at.key(key));
            }
        }
    }

    /// Adds the faults of unknown and missing keys; the known keys that they stand for get the values, or stand-ins.
    fn keys(&mut self, schema: &'a Value, map: &mut Map<String, Value>, at: &Pointer, stand_ins: StandIns) {
        let known = schema.get("properties").and_then(Value::as_object);
        let names: Vec<&str> = known.into_iter().flat_map(Map::keys).map(String::as_str).collect();
        let required = || {
            let list = schema.get("required").and_then(Value::as_array).into_iter().flatten();
            list.filter_map(Value::as_str)
        };
        let unknown: Vec<String> = map.keys().filter(|key| !names.contains(&key.as_str())).cloned().collect();
        for key in unknown {
            let Some(value) = map.remove(&key) else { continue };
            let missing = |name: &str| required().any(|key| key == name) && !map.contains_key(name);
            let meant = hints::keys_like(&key, &names, missing);
            self.unknown_key(&key, &value, &names, &meant, at);
            match meant[..] {
                [near] if !map.contains_key(near) => {
                    self.findings.rename(&at.key(near), &at.key(&key));
                    map.insert(near.to_owned(), value);
                }
                _ => self.findings.leave_unread(&at.key(&key)),
            }
        }
        for key in required().filter(|key| !map.contains_key(*key)).collect::<Vec<_>>() {
            let (below, allowed) = (at.key(key), format!("the key \"{key}\" is required here"));
            let pointer = below.as_str().to_owned();
            self.findings.note(|| Fault { pointer, value: "(missing)".to_owned(), allowed, ..Fault::default() });
            self.findings.leave_unread(&below);
            map.insert(
                key.to_owned(),
                known.and_then(|k| k.get(key)).map_or(Value::Null, |s| stand_in(self.root, s, stand_ins)),
            );
        }
    }

    /// Adds the fault of a key that is not known here, with those that it may stand for.
    fn unknown_key(&mut self, key: &str, value: &Value, names: &[&str], meant: &[&str], at: &Pointer) {
        let elsewhere = || {
            let places = hints::places_of(self.root, key);
            (!places.is_empty()).then(|| hints::listed("this key is known elsewhere", &places))
        };
        let hint = hints::did_you_mean_keys(meant).or_else(elsewhere);
        let (pointer, allowed) = (at.key(key).as_str().to_owned(), one_of("known keys here", names));
        let wrong = Some(format!("there is no key \"{}\" here", shorten(key)));
        let (part, value) = (FaultTarget::Key, excerpt(value));
        self.findings.note(|| Fault { pointer, part, value, wrong, allowed, hint, ..Fault::default() });
    }

    fn choose(&mut self, choice: &OneOf<'a>, schema: &'a Value, value: &mut Value, at: &Pointer) {
        match &mut *value {
            Value::String(word) if choice.words.contains(&word.as_str()) => {}
            Value::String(word) if choice.tag(word).is_some() => {
                let allowed = format!("an object with this name as its key: {{\"{word}\": ...}}");
                self.refuse(schema, value, at, allowed);
            }
            Value::String(word) if !choice.words.is_empty() => {
                let names = choice.names();
                let group = choice
                    .tag("group")
                    .map(|_| format!("for a group of the mesh: {{\"group\": \"{}\"}}", shorten(word)));
                let hint = did_you_mean(word, names.iter().copied()).or(group);
                self.note(at, FaultTarget::Value, value, one_of("known names here", &names), hint);
                self.replace(schema, value, at);
            }
            Value::Object(map) if !choice.tags.is_empty() => {
                if !self.tagged(choice, map, at) {
                    self.replace(schema, value, at);
                }
            }
            other => match choice.of_type(other) {
                Some(branch) => self.visit(branch, value, at),
                None => self.refuse(schema, value, at, choice.describe(self.root)),
            },
        }
    }

    /// Visits an object whose only key is a name of the `oneOf`. Returns whether the rest of it can be read.
    fn tagged(&mut self, choice: &OneOf<'a>, map: &mut Map<String, Value>, at: &Pointer) -> bool {
        if let Some(branch) = choice.record(map) {
            self.object(branch, map, at);
            return true;
        }
        let mut keys = map.keys().cloned();
        let (Some(key), None) = (keys.next(), keys.next()) else {
            let allowed =
                format!("an object with exactly one key; {}", one_of("known names here", &choice.tag_names()));
            self.note(at, FaultTarget::Value, &Value::Object(map.clone()), allowed, None);
            return false;
        };
        drop(keys);
        if let Some(branch) = choice.tag(&key) {
            self.object(branch, map, at);
            return true;
        }
        let below = at.key(&key);
        let value = map.remove(&key).unwrap_or_default();
        if choice.words.contains(&key.as_str()) {
            let allowed = format!("the plain word \"{key}\" in double quotes, without braces");
            self.note(&below, FaultTarget::Key, &value, allowed, None);
            return false;
        }
        let names = choice.names();
        let hint = did_you_mean(&key, names.iter().copied());
        self.note(&below, FaultTarget::Key, &value, one_of("known names here", &names), hint);
        let Some((near, branch)) = nearest(&key, choice.tag_names()).and_then(|near| Some((near, choice.tag(near)?)))
        else {
            return false;
        };
        self.findings.rename(&at.key(near), &below);
        map.insert(near.to_owned(), value);
        self.object(branch, map, at);
        true
    }
}

/// "expected a number, found a text": where a value has another type than its schema, whose type is `expected`.
fn wrong_type(expected: &str, value: &Value) -> Option<String> {
    let wanted = match expected {
        "object" => "an object",
        "array" => "a list",
        "number" => "a number",
        "integer" => "a whole number",
        "string" => "a text",
        "boolean" => "true or false",
        _ => return None,
    };
    let found = match value {
        Value::Null => "null",
        Value::Bool(_) => "true or false",
        Value::Number(number) if expected == "integer" && number.is_f64() => "one with a fraction",
        Value::Number(number) if expected == "integer" && number.is_i64() && !number.is_u64() => "a negative one",
        Value::Number(_) if expected == "integer" => "one that is too large",
        Value::Number(_) => "a number",
        Value::String(text) if matches!(expected, "number" | "integer") && text.trim().parse::<f64>().is_ok() => {
            "a text in double quotes"
        }
        Value::String(_) => "a text",
        Value::Array(list) if expected == "array" => {
            return Some(format!("the list has {} entries", list.len()));
        }
        Value::Array(_) => "a list",
        Value::Object(_) => "an object",
    };
    Some(format!("expected {wanted}, found {found}"))
}
