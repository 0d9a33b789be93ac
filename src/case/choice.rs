//! A choice in the schema: plain words, objects whose one key is a name, and values told apart by their type.

use serde_json::Value;

use super::fault::one_of;
use super::shape::{describe, kind, meant};

/// A `oneOf` sorted by how its branches are told apart.
pub(super) struct Choice<'a> {
    /// plain words: `"all"`
    pub words: Vec<&'a str>,
    /// objects with one key: `{"ids": [...]}`
    pub tags: Vec<(&'a str, &'a Value)>,
    /// numbers and lists
    others: Vec<&'a Value>,
}

impl<'a> Choice<'a> {
    /// The choice that a schema is, if it is one.
    pub fn new(root: &'a Value, schema: &'a Value) -> Option<Self> {
        let mut choice = Self { words: Vec::new(), tags: Vec::new(), others: Vec::new() };
        for branch in schema.get("oneOf")?.as_array()? {
            let branch = meant(root, branch);
            let key = branch.get("required").and_then(Value::as_array).and_then(|keys| keys.first()?.as_str());
            match (branch.get("const").and_then(Value::as_str), key) {
                (Some(word), _) => choice.words.push(word),
                (None, Some(key)) => choice.tags.push((key, branch)),
                (None, None) => choice.others.push(branch),
            }
        }
        Some(choice)
    }

    /// The branch of an object with this key.
    pub fn tag(&self, key: &str) -> Option<&'a Value> {
        self.tags.iter().find(|(tag, _)| *tag == key).map(|(_, branch)| *branch)
    }

    /// The keys of the objects.
    pub fn tag_names(&self) -> Vec<&'a str> {
        self.tags.iter().map(|(tag, _)| *tag).collect()
    }

    /// All names, of words and of objects, each once.
    pub fn names(&self) -> Vec<&'a str> {
        let tags = self.tag_names().into_iter().filter(|tag| !self.words.contains(tag));
        self.words.iter().copied().chain(tags).collect()
    }

    /// The branch for a number or a list. Of two kinds of list most of the entries tell which is meant.
    pub fn of_type(&self, value: &Value) -> Option<&'a Value> {
        let Value::Array(list) = value else {
            let number = |branch: &&Value| value.is_number() && kind(branch) == "number";
            return self.others.iter().copied().find(|branch| number(branch));
        };
        let nested = 2 * list.iter().filter(|entry| entry.is_array()).count() >= list.len();
        let lists = || self.others.iter().copied().filter(|branch| kind(branch) == "array");
        let fits = |branch: &&Value| branch.pointer("/items/type").is_some_and(|t| t == "array") == nested;
        lists().find(|branch| fits(branch)).or_else(|| lists().next())
    }

    /// What is allowed, in the words of a case file.
    pub fn describe(&self, root: &Value) -> String {
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
