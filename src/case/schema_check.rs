//! The second pass over a case that serde refused: a walk over the JSON Schema that finds every wrong type and key,
//! where serde stops at the first.
//!
//! What is wrong is replaced by a stand-in, so that the rest can be read and its ranges checked as well. Ranges are not
//! checked here. The walk knows the part of JSON Schema that schemars makes of this case: `$ref`, `oneOf` of
//! words, of objects with one key and of different types, objects that refuse other keys, arrays, and nullable types.

use serde_json::{Map, Value};

use super::choice::Choice;
use super::fault::{Fault, Part, did_you_mean, excerpt, nearest, one_of};
use super::findings::Findings;
use super::pointer::Pointer;
use super::schema::json_schema;
use super::shape::{describe, kind, largest, length, meant, nullable, stand_in};

/// Finds every wrong type and key of a case and puts stand-ins in their places.
pub(crate) fn walk(json: &mut Value, findings: &mut Findings) {
    let root = json_schema();
    Walk { root: &root, findings }.visit(&root, json, &Pointer::root());
}

struct Walk<'a> {
    root: &'a Value,
    findings: &'a mut Findings,
}

impl<'a> Walk<'a> {
    fn visit(&mut self, schema: &'a Value, value: &mut Value, at: &Pointer) {
        if value.is_null() && nullable(schema) {
            return;
        }
        let schema = meant(self.root, schema);
        if let Some(choice) = Choice::new(self.root, schema) {
            return self.choose(&choice, schema, value, at);
        }
        match (kind(schema), &mut *value) {
            ("object", Value::Object(map)) => self.object(schema, map, at),
            ("array", Value::Array(list)) if length(schema).is_none_or(|n| list.len() == n) => {
                let Some(items) = schema.get("items") else { return };
                list.iter_mut().enumerate().for_each(|(i, item)| self.visit(items, item, &at.index(i)));
            }
            ("number", Value::Number(_)) | ("string", Value::String(_)) | ("boolean", Value::Bool(_)) => {}
            ("integer", Value::Number(n)) if n.as_u64().is_some_and(|n| n <= largest(schema)) => {}
            _ => self.refuse(schema, value, at, describe(self.root, schema)),
        }
    }

    /// Notes that the whole value is wrong, and puts a stand-in in its place.
    fn refuse(&mut self, schema: &Value, value: &mut Value, at: &Pointer, allowed: String) {
        self.note(at, Part::Value, value, allowed, None);
        self.replace(schema, value, at);
    }

    fn replace(&mut self, schema: &Value, value: &mut Value, at: &Pointer) {
        *value = stand_in(self.root, schema);
        self.findings.leave_unread(at);
    }

    fn note(&mut self, at: &Pointer, part: Part, value: &Value, allowed: String, hint: Option<String>) {
        let pointer = at.as_str().to_owned();
        self.findings.note(|| Fault { pointer, part, value: excerpt(value), allowed, hint, place: None });
    }

    fn object(&mut self, schema: &'a Value, map: &mut Map<String, Value>, at: &Pointer) {
        let empty = Map::new();
        let known = schema.get("properties").and_then(Value::as_object);
        let names: Vec<&str> = known.unwrap_or(&empty).keys().map(String::as_str).collect();
        let unknown: Vec<String> = map.keys().filter(|key| !names.contains(&key.as_str())).cloned().collect();
        for key in unknown {
            let Some(value) = map.remove(&key) else { continue };
            let hint = did_you_mean(&key, names.iter().copied());
            self.note(&at.key(&key), Part::Key, &value, one_of("known keys here", &names), hint);
            match nearest(&key, names.iter().copied()).filter(|near| !map.contains_key(*near)) {
                Some(near) => {
                    self.findings.rename(&at.key(near), &at.key(&key));
                    map.insert(near.to_owned(), value);
                }
                None => self.findings.leave_unread(&at.key(&key)),
            }
        }
        let required = schema.get("required").and_then(Value::as_array).into_iter().flatten();
        for key in required.filter_map(Value::as_str).filter(|key| !map.contains_key(*key)).collect::<Vec<_>>() {
            let (below, allowed) = (at.key(key), format!("the key \"{key}\" is required here"));
            let pointer = below.as_str().to_owned();
            self.findings.note(|| Fault { pointer, value: "(missing)".to_owned(), allowed, ..Fault::default() });
            self.findings.leave_unread(&below);
            map.insert(key.to_owned(), known.and_then(|k| k.get(key)).map_or(Value::Null, |s| stand_in(self.root, s)));
        }
        for (key, value) in map {
            if let Some(schema) = known.and_then(|known| known.get(key)) {
                self.visit(schema, value, &at.key(key));
            }
        }
    }

    fn choose(&mut self, choice: &Choice<'a>, schema: &'a Value, value: &mut Value, at: &Pointer) {
        match &mut *value {
            Value::String(word) if choice.words.contains(&word.as_str()) => {}
            Value::String(word) if choice.tag(word).is_some() => {
                let allowed = format!("an object with this name as its key: {{\"{word}\": ...}}");
                self.refuse(schema, value, at, allowed);
            }
            Value::String(word) if !choice.words.is_empty() => {
                let names = choice.names();
                let hint = did_you_mean(word, names.iter().copied());
                self.note(at, Part::Value, value, one_of("known names here", &names), hint);
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

    /// Visits an object whose one key is a name of the choice; whether what is left of it can be read.
    fn tagged(&mut self, choice: &Choice<'a>, map: &mut Map<String, Value>, at: &Pointer) -> bool {
        let mut keys = map.keys().cloned();
        let (Some(key), None) = (keys.next(), keys.next()) else {
            let allowed =
                format!("an object with exactly one key; {}", one_of("known names here", &choice.tag_names()));
            self.note(at, Part::Value, &Value::Object(map.clone()), allowed, None);
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
            self.note(&below, Part::Key, &value, allowed, None);
            return false;
        }
        let names = choice.names();
        let hint = did_you_mean(&key, names.iter().copied());
        self.note(&below, Part::Key, &value, one_of("known names here", &names), hint);
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
