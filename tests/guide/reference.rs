//! The case reference: every key of the JSON Schema with its unit, default, range and an example from a case that the
//! program accepts.

use crate::cases::accepted;
use crate::pages::{ROOT, folder};
use canopy_fem::model::gauge::{GaugeQuantity, Quantity};
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;

/// Longest example in a table, in characters.
const LONGEST: usize = 60;

type Object = Map<String, Value>;

/// The schema, and examples by definition and key.
struct Reference {
    schema: Value,
    examples: BTreeMap<(String, String), String>,
}

/// A schema without the `null` that stands for an absent key.
fn strip(node: &Value) -> &Value {
    let choices = node["anyOf"].as_array();
    choices.and_then(|list| list.iter().find(|one| one["type"] != "null")).unwrap_or(node)
}

fn list<'a>(node: &'a Value, key: &str) -> &'a [Value] {
    node[key].as_array().map_or(&[], Vec::as_slice)
}

fn name(node: &Value) -> Option<&str> {
    node["$ref"].as_str().and_then(|r| r.strip_prefix("#/$defs/"))
}

fn properties(node: &Value) -> impl Iterator<Item = (&String, &Value)> {
    node["properties"].as_object().into_iter().flatten()
}

/// One line, with the bars of a table escaped.
fn line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "\\|")
}

/// `[m] Length.` as its unit and the rest.
fn unit(text: &str) -> (&str, &str) {
    text.strip_prefix('[').and_then(|rest| rest.split_once(']')).map_or(("", text), |(unit, rest)| (unit, rest.trim()))
}

impl Reference {
    fn definition<'a>(&'a self, node: &'a Value) -> (&'a str, &'a Value) {
        match name(strip(node)) {
            Some(name) => (name, &self.schema["$defs"][name]),
            None => ("", strip(node)),
        }
    }

    /// Takes the examples of a value that has this schema; `owner` is the definition that it belongs to.
    fn take(&mut self, owner: &str, node: &Value, value: &Value) {
        let (name, inner) = {
            let (name, inner) = self.definition(node);
            (if name.is_empty() { owner.to_owned() } else { name.to_owned() }, inner.clone())
        };
        for choice in list(&inner, "oneOf").iter().chain(list(&inner, "anyOf")) {
            let fits = match value {
                Value::Object(members) => {
                    let keys = self.definition(choice).1["properties"].as_object();
                    let own = self.definition(choice).1;
                    keys.is_some_and(|keys| members.keys().all(|key| keys.contains_key(key)))
                        || !list(own, "oneOf").is_empty()
                        || own["additionalProperties"].is_object()
                }
                Value::Array(_) => choice["type"] == "array",
                _ => false,
            };
            if fits {
                self.take(&name, choice, value);
            }
        }
        if let Value::Array(values) = value {
            values.iter().for_each(|value| self.take(&name, &inner["items"], value));
        }
        let named = &inner["additionalProperties"];
        if named.is_object() {
            value.as_object().into_iter().flatten().for_each(|(_, value)| self.take(&name, named, value));
        }
        let members = value.as_object().cloned().unwrap_or_default();
        for (key, value) in members {
            if let Some(node) = inner["properties"].get(&key) {
                self.keep(&name, &key, &value);
                let node = node.clone();
                self.take(&name, &node, &value);
            }
        }
    }

    /// Keeps the first example that is short, else the shortest.
    fn keep(&mut self, owner: &str, key: &str, value: &Value) {
        let text = value.to_string().replace(',', ", ").replace(":", ": ");
        let text = if value.is_string() { value.to_string() } else { text };
        let kept = self.examples.entry((owner.to_owned(), key.to_owned())).or_insert_with(|| text.clone());
        if kept.len() > LONGEST && text.len() < kept.len() {
            *kept = text;
        }
    }

    /// Sections in the order in which a reader meets them: the path and the definition.
    fn sections(&self) -> Vec<(String, String)> {
        let mut found: Vec<(String, String)> = Vec::new();
        // What moves, and how it is integrated, before how results are written.
        for key in ["system", "time", "solver", "output", "study"] {
            self.enter(key, strip(&self.schema["properties"][key]), &mut found);
        }
        self.visit("", &self.schema, &mut found);
        found
    }

    fn visit(&self, path: &str, node: &Value, found: &mut Vec<(String, String)>) {
        for (key, node) in properties(node) {
            let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            self.enter(&path, strip(node), found);
        }
        for choice in list(node, "oneOf").iter().chain(list(node, "anyOf")) {
            if name(choice).is_some() { self.enter(path, choice, found) } else { self.visit(path, choice, found) }
        }
        for inner in [&node["items"], &node["additionalProperties"]] {
            if inner.is_object() {
                self.enter(path, inner, found);
            }
        }
    }

    fn enter(&self, path: &str, node: &Value, found: &mut Vec<(String, String)>) {
        let (name, inner) = self.definition(node);
        if !name.is_empty() {
            if found.iter().any(|(_, known)| known == name) {
                return;
            }
            found.push((path.to_owned(), name.to_owned()));
        }
        self.visit(path, inner, found);
    }

    /// What a value may be: a link to its section, or its type.
    fn kind(&self, node: &Value, anchors: &BTreeMap<String, String>) -> String {
        let node = strip(node);
        if let Some(name) = name(node) {
            return format!("[{name}](#{})", anchors[name]);
        }
        let choices = list(node, "oneOf");
        if !choices.is_empty() {
            let kinds: Vec<String> = choices.iter().map(|choice| self.kind(choice, anchors)).collect();
            return kinds.join(" or ");
        }
        if let Some(keys) = node["properties"].as_object() {
            return keys.iter().map(|(key, value)| format!("`{{\"{key}\"}}`: {}", self.kind(value, anchors))).collect();
        }
        let kind = match &node["type"] {
            Value::Array(kinds) => kinds.first().and_then(Value::as_str).unwrap_or(""),
            kind => kind.as_str().unwrap_or(""),
        };
        match (kind, node["minItems"].as_u64().filter(|n| node["maxItems"].as_u64() == Some(*n))) {
            ("array", count) => {
                let inner = self.kind(&node["items"], anchors);
                let many =
                    if inner == "number" || inner == "integer" { format!("{inner}s") } else { format!("({inner})") };
                count.map_or_else(|| format!("list of {many}"), |n| format!("{n} {many}"))
            }
            ("string", _) => "text".to_owned(),
            ("boolean", _) => "true or false".to_owned(),
            (kind, _) => kind.to_owned(),
        }
    }

    /// A row: key, unit, default, range, example, type and meaning.
    fn row(&self, owner: &str, key: &str, node: &Value, need: &str, anchors: &BTreeMap<String, String>) -> String {
        let description = node["description"].as_str().unwrap_or("");
        let (unit, meaning) = unit(description);
        let example = self.examples.get(&(owner.to_owned(), key.to_owned())).map_or(String::new(), |e| shorten(e));
        let default = if need.is_empty() { default(node, meaning) } else { need.to_owned() };
        let kind = Some(self.kind(node, anchors)).filter(|kind| kind.matches(" or ").count() < 4);
        let kind = kind.unwrap_or_else(|| "see the meaning".to_owned());
        format!("| `{key}` | {unit} | {default} | {} | {example} | {kind} | {} |", range(node), line(meaning))
    }
}

/// An example for a table.
fn shorten(example: &str) -> String {
    let text = if example.chars().count() > LONGEST {
        example.chars().take(LONGEST - 2).chain(" …".chars()).collect()
    } else {
        example.to_owned()
    };
    format!("`{}`", text.replace('|', "\\|"))
}

/// The default: that of the schema, or what the description says of a key that is not given.
fn default(node: &Value, meaning: &str) -> String {
    if !node["default"].is_null() {
        return format!("`{}`", node["default"]);
    }
    let text = line(meaning);
    let told = ["if not given", "if absent"].iter().find_map(|end| {
        let before = &text[..text.find(end)?];
        let start = ["; ", ", ", ". "].iter().filter_map(|mark| before.rfind(mark)).max().map_or(0, |i| i + 2);
        Some(before[start..].trim().to_owned()).filter(|told| !told.is_empty() && told.len() < 30)
    });
    told.unwrap_or_else(|| "–".to_owned())
}

fn range(node: &Value) -> String {
    let node = &node;
    let bound = |key: &str| node[key].as_f64().map(|value| format!("{value}"));
    let low = bound("exclusiveMinimum").map(|v| format!("> {v}")).or(bound("minimum").map(|v| format!(">= {v}")));
    let high = bound("exclusiveMaximum").map(|v| format!("< {v}")).or(bound("maximum").map(|v| format!("<= {v}")));
    [low, high].into_iter().flatten().collect::<Vec<_>>().join(", ")
}

const HEAD: &str = "| key | unit | default | range | example | value | meaning |\n|---|---|---|---|---|---|---|\n";

/// What stands in place of a default: `needed`, or nothing.
fn need(node: &Value, key: &str) -> &'static str {
    if list(node, "required").iter().any(|r| r == key) { "needed" } else { "" }
}

impl Reference {
    fn section(&self, path: &str, name: &str, anchors: &BTreeMap<String, String>) -> String {
        let node = if name.is_empty() { &self.schema } else { &self.schema["$defs"][name] };
        let title = if name.is_empty() { "The whole case".to_owned() } else { name.to_owned() };
        let mut page = format!("## {title}\n\n");
        if !path.is_empty() {
            let _ = write!(page, "At `{path}`. ");
        }
        let _ = write!(page, "{}\n\n", line(node["description"].as_str().unwrap_or("")));
        let rows: String =
            properties(node).map(|(key, value)| self.row(name, key, value, need(node, key), anchors) + "\n").collect();
        if !rows.is_empty() {
            let _ = writeln!(page, "{HEAD}{rows}");
        }
        page + &self.choices(name, node, anchors)
    }

    fn choices(&self, name: &str, node: &Value, anchors: &BTreeMap<String, String>) -> String {
        let mut words = String::new();
        let mut objects = String::new();
        let mut records = String::new();
        for choice in list(node, "oneOf").iter().chain(list(node, "anyOf")) {
            if let Some(word) = choice["const"].as_str() {
                let (unit, text) = unit(choice["description"].as_str().unwrap_or(""));
                let unit = if unit.is_empty() { String::new() } else { format!("[{unit}] ") };
                let _ = writeln!(words, "| `\"{word}\"` | {unit}{} |", line(text));
            }
            // Among objects with one key, one with several.
            if let Some(record) = self::name(choice).filter(|_| list(node, "oneOf").len() > 1) {
                let text = line(choice["description"].as_str().unwrap_or(""));
                let _ = writeln!(records, "Or the keys of [{record}](#{}): {text}\n", anchors[record]);
            }
            for (key, value) in properties(choice) {
                if value["properties"].as_object().is_some_and(Object::is_empty) {
                    continue;
                }
                let inner = properties(value).map(|(key, value)| self.row(name, key, value, "", anchors) + "\n");
                let inner: String = inner.collect();
                if inner.is_empty() {
                    let mut value = value.clone();
                    if value["description"].is_null() || name_only(&value) {
                        value["description"] = choice["description"].clone();
                    }
                    objects += &(self.row(name, key, &value, "one of these", anchors) + "\n");
                } else {
                    let _ = writeln!(words, "| `{{\"{key}\": {{...}}}}` | parameters below |");
                    objects += &inner;
                }
            }
        }
        let mut page = String::new();
        if !words.is_empty() {
            let _ = write!(page, "| choice | meaning |\n|---|---|\n{words}\n");
        }
        if !objects.is_empty() {
            let _ = writeln!(page, "{HEAD}{objects}");
        }
        page + &records
    }

    fn page(&self) -> String {
        let sections = self.sections();
        let anchors: BTreeMap<String, String> =
            sections.iter().map(|(_, name)| (name.clone(), name.to_lowercase())).collect();
        let mut page = INTRODUCTION.to_owned();
        for (path, name) in std::iter::once((String::new(), String::new())).chain(sections) {
            page += &self.section(&path, &name, &anchors);
        }
        page.trim_end().to_owned() + "\n"
    }

    /// Keys without an example.
    fn without_example(&self) -> Vec<String> {
        let mut keys = Vec::new();
        for (name, node) in std::iter::once((String::new(), self.schema.clone())).chain(self.definitions()) {
            let choices = list(&node, "oneOf").iter().chain(list(&node, "anyOf")).flat_map(properties);
            let empty = |value: &Value| value["properties"].as_object().is_some_and(Object::is_empty);
            for (key, _) in properties(&node).chain(choices.filter(|(_, value)| !empty(value))) {
                if !self.examples.contains_key(&(name.clone(), key.clone())) {
                    keys.push(format!("{name}.{key}"));
                }
            }
        }
        keys
    }

    fn definitions(&self) -> Vec<(String, Value)> {
        let all = self.schema["$defs"].as_object().expect("definitions");
        all.iter().map(|(name, node)| (name.clone(), node.clone())).collect()
    }
}

/// Whether a schema is a reference with a description of its own or none.
fn name_only(node: &Value) -> bool {
    node["$ref"].is_string() && node["description"].is_null()
}

const INTRODUCTION: &str = r#"# Case reference

This page is made from the JSON Schema that `canopy-fem schema` prints. Examples are from cases that the program accepts. Do not edit
this page: `GUIDE_WRITE=1 cargo test --release --test guide` writes it anew.

<!-- ci: skip "canopy-fem (tradeoff|stability)" "names of commands" -->
All values are SI. An unknown key is a fault. A key with the default "–" may be left out, and what it describes is then not modelled,
or is chosen by the program as its description says.

"#;

fn reference() -> Reference {
    let mut reference = Reference { schema: canopy_fem::case::json_schema(), examples: BTreeMap::new() };
    let schema = reference.schema.clone();
    for case in accepted().0 {
        reference.take("", &schema, &case.value);
    }
    reference
}

#[test]
fn the_case_reference_is_that_of_the_schema() {
    is_kept(&folder().join("case-reference.md"), &reference().page());
}

/// The file is as it was made just now; `GUIDE_WRITE` makes it so.
fn is_kept(path: &Path, made: &str) {
    if std::env::var_os("GUIDE_WRITE").is_some() {
        std::fs::write(path, made).expect("the file is written");
    }
    let kept = std::fs::read_to_string(path).expect("the file");
    let differs = made.lines().zip(kept.lines()).find(|(made, kept)| made != kept);
    let name = path.display();
    assert!(
        made == kept,
        "{name} is out of date, at {differs:?}: GUIDE_WRITE=1 cargo test --release --test guide writes it anew"
    );
}

/// Adds the keys and the words that are values below a schema.
fn words(node: &Value, found: &mut BTreeSet<String>) {
    if let Value::Object(map) = node {
        found.extend(properties(node).map(|(key, _)| key.clone()));
        found.extend(list(node, "enum").iter().chain(map.get("const")).filter_map(Value::as_str).map(str::to_owned));
        map.values().for_each(|inner| words(inner, found));
    } else {
        node.as_array().into_iter().flatten().for_each(|inner| words(inner, found));
    }
}

/// The dictionary of the fuzzer has every key and word of the schema, beside numbers and the like.
#[test]
fn the_dictionary_of_the_fuzzer_is_that_of_the_schema() {
    let path = Path::new(ROOT).join("tests/fuzz/dictionaries/case.dict");
    let mut found = BTreeSet::new();
    words(&canopy_fem::case::json_schema(), &mut found);
    let kept = std::fs::read_to_string(&path).expect("the dictionary");
    let mut made: BTreeSet<String> = found.iter().map(|word| format!("\"\\\"{word}\\\"\"")).collect();
    made.extend(kept.lines().map(str::to_owned));
    is_kept(&path, &made.iter().map(|line| format!("{line}\n")).collect::<String>());
}

/// The table of gauges has a row for each quantity, with all of its columns; `_y` stands for what ends so.
#[test]
fn results_say_what_gauges_measure() {
    let page = std::fs::read_to_string(folder().join("results.md")).expect("results.md");
    let schema = canopy_fem::case::json_schema();
    let choices = list(&schema["$defs"]["GaugeQuantity"], "oneOf");
    assert_eq!(choices.len(), GaugeQuantity::ALL.len(), "{choices:?}");
    for choice in choices {
        let of: GaugeQuantity = serde_json::from_value(choice["const"].clone()).expect("a quantity");
        let start = format!("| `{}` |", choice["const"].as_str().expect("a word"));
        let row = page.lines().skip_while(|line| *line != "## gauges.csv").find(|line| line.starts_with(&start));
        let row = row.unwrap_or_else(|| panic!("results.md has no row \"{start}\""));
        for Quantity { name, .. } in of.columns() {
            let short = name.rsplit_once('_').map_or(*name, |(_, end)| end);
            let told = row.contains(&format!("`{name}`")) || row.contains(&format!("`_{short}`"));
            assert!(told, "results.md does not name {name}: {row}");
        }
    }
}

#[test]
fn every_key_has_an_example() {
    let missing = reference().without_example();
    assert!(missing.is_empty(), "{} keys are in no case: {missing:#?}", missing.len());
}

#[test]
fn units_and_defaults_are_read_from_descriptions() {
    assert_eq!(unit("[m/s^2] Gravity."), ("m/s^2", "Gravity."));
    assert_eq!(default(&Value::Null, "Exponent of the growth; 2 if not given."), "2");
    assert_eq!(default(&Value::Null, "Steps per row of `gauges.csv`, 1 if not given; more."), "1");
    assert_eq!(default(&Value::Null, "Which edges."), "–");
}
