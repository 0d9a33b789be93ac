//! The branches of a `oneOf`.

use serde_json::{Map, Value};

use crate::case::diagnostics::one_of;
use crate::case::schema_parts::{kind, largest, length, meant};

/// A `oneOf` sorted by how its branches differ.
pub(super) struct OneOf<'a> {
    /// plain words: `"all"`
    pub words: Vec<&'a str>,
    /// objects with one key: `{"ids": [...]}`
    pub tags: Vec<(&'a str, &'a Value)>,
    /// objects with several keys, by the first that they need: `{"file": ..., "scale": ...}`
    records: Vec<(&'a str, &'a Value)>,
    /// numbers, texts, objects with several keys, and lists
    others: Vec<&'a Value>,
}

impl<'a> OneOf<'a> {
    /// The `oneOf` of a schema, if it has one.
    pub(super) fn new(root: &'a Value, schema: &'a Value) -> Option<Self> {
        let mut choice = Self { words: Vec::new(), tags: Vec::new(), records: Vec::new(), others: Vec::new() };
        for branch in schema.get("oneOf")?.as_array()? {
            let branch = meant(root, branch);
            let key = branch.get("required").and_then(Value::as_array).and_then(|keys| keys.first()?.as_str());
            // An object with several keys is known by its type.
            let several = branch.get("properties").and_then(Value::as_object).is_some_and(|keys| keys.len() > 1);
            match (branch.get("const").and_then(Value::as_str), key) {
                (Some(word), _) => choice.words.push(word),
                (None, Some(key)) if !several => choice.tags.push((key, branch)),
                (None, key) => {
                    choice.others.push(branch);
                    choice.records.extend(key.map(|key| (key, branch)));
                }
            }
        }
        // Without objects of one key beside them they are known by their type.
        if choice.tags.is_empty() {
            choice.records.clear();
        }
        Some(choice)
    }

    /// The branch of an object with this key.
    pub(super) fn tag(&self, key: &str) -> Option<&'a Value> {
        self.tags.iter().chain(&self.records).find(|(tag, _)| *tag == key).map(|(_, branch)| *branch)
    }

    /// The branch of an object with several keys that has the one it needs.
    pub(super) fn record(&self, map: &Map<String, Value>) -> Option<&'a Value> {
        self.records.iter().find(|(key, _)| map.contains_key(*key)).map(|(_, branch)| *branch)
    }

    /// The keys of the objects.
    pub(super) fn tag_names(&self) -> Vec<&'a str> {
        self.tags.iter().chain(&self.records).map(|(tag, _)| *tag).collect()
    }

    /// All names, of words and of objects, each once.
    pub(super) fn names(&self) -> Vec<&'a str> {
        let tags = self.tag_names().into_iter().filter(|tag| !self.words.contains(tag));
        self.words.iter().copied().chain(tags).collect()
    }

    /// The branch for a number, a text, an object with several keys, or a list. Between two kinds of list, the majority
    /// of the entries decides.
    pub(super) fn of_type(&self, value: &Value) -> Option<&'a Value> {
        let Value::Array(list) = value else {
            let fits = |branch: &&Value| match kind(branch) {
                "number" => value.is_number(),
                "string" => value.is_string(),
                "object" => value.is_object(),
                _ => false,
            };
            return self.others.iter().copied().find(fits);
        };
        let nested = 2 * list.iter().filter(|entry| entry.is_array()).count() >= list.len();
        let lists = || self.others.iter().copied().filter(|branch| kind(branch) == "array");
        let fits = |branch: &&Value| branch.pointer("/items/type").is_some_and(|t| t == "array") == nested;
        lists().find(|branch| fits(branch)).or_else(|| lists().next())
    }

    /// What is allowed, in the words of a case file.
    pub(super) fn describe(&self, root: &Value) -> String {
        let mut parts: Vec<String> = self.others.iter().map(|branch| describe(root, branch)).collect();
        match (self.words.is_empty(), self.tags.is_empty()) {
            (true, true) => {}
            (true, false) => parts.push("an object {...} with one key".to_owned()),
            (false, true) => parts.push("a word in double quotes".to_owned()),
            (false, false) => parts.push("a word in double quotes or an object {...} with one key".to_owned()),
        }
        let names = self.names();
        let known = if names.is_empty() { String::new() } else { format!("; {}", one_of("known names here", &names)) };
        format!("{}{known}", parts.join(" or "))
    }
}

/// Keys of an object that are named where something else stands in its place.
const FEW: usize = 8;

/// What is allowed, in the words of a case file.
pub(super) fn describe(root: &Value, schema: &Value) -> String {
    let schema = meant(root, schema);
    if let Some(choice) = OneOf::new(root, schema) {
        return choice.describe(root);
    }
    match (kind(schema), length(schema)) {
        ("object", _) => match schema.get("properties").and_then(Value::as_object) {
            Some(keys) if keys.len() <= FEW => {
                format!("an object {{...}}; {}", one_of("known keys", &keys.keys().collect::<Vec<_>>()))
            }
            _ => "an object {...}".to_owned(),
        },
        ("array", Some(3)) if schema.pointer("/items/type").is_some_and(|t| t == "number") => {
            "a vector [x, y, z] of exactly 3 numbers".to_owned()
        }
        ("array", Some(n)) => format!("a list of exactly {n} entries"),
        ("array", None) => "a list [...]".to_owned(),
        ("number", _) => "a number".to_owned(),
        ("integer", _) if largest(schema) < u64::MAX => format!("a whole number, 0 to {}", largest(schema)),
        ("integer", _) => "a whole number, 0 or more".to_owned(),
        ("string", _) => "a text in double quotes".to_owned(),
        ("boolean", _) => "true or false".to_owned(),
        (other, _) => other.to_owned(),
    }
}
