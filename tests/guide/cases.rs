//! Cases and parts of cases that the guide shows are accepted by the program.
//!
//! A block of JSON on a page has a comment directly above it:
//!
//! ```text
//! <!-- ci: shown flag.json -->                a whole case, which the commands of the page also read
//! <!-- ci: part flag.json system.network -->  members of an object of another case (without a path: of the case): of
//!                                             a block of the page, of a shipped case, or of docs/guide/cases
//! ```

use crate::pages::{Page, ROOT, pages};
use canopy_fem::case::Case;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// A case that the program accepted, with where it came from.
pub struct Accepted {
    pub name: String,
    pub value: Value,
}

fn accept(name: &str, value: Value, base: &Path) -> Result<Accepted, String> {
    match Case::from_text(value.to_string(), name, base.to_owned(), &[]) {
        Ok(_) => Ok(Accepted { name: name.to_owned(), value }),
        Err(error) => Err(format!("{name}: {error}")),
    }
}

/// The object at a path with dots, made where it is not there.
fn at<'a>(value: &'a mut Value, path: &str) -> &'a mut Value {
    path.split('.').filter(|word| !word.is_empty()).fold(value, |value, word| match word.parse::<usize>() {
        Ok(index) if value.is_array() => &mut value[index],
        _ => &mut value[word],
    })
}

fn case_file(name: &str, shown: &Map<String, Value>) -> Value {
    if let Some(value) = shown.get(name) {
        return value.clone();
    }
    let places = ["assets/cases", "assets/cases/parachute", "docs/guide/cases"];
    let found = places.iter().map(|place| Path::new(ROOT).join(place).join(name)).find(|path| path.is_file());
    let text = std::fs::read_to_string(found.unwrap_or_else(|| panic!("no case {name}"))).expect("a case");
    serde_json::from_str(&text).expect("JSON")
}

/// The cases of a page, parts put into the cases that they belong to.
fn of_page(page: &Page) -> Vec<(String, Value)> {
    let mut shown = Map::new();
    let mut found = Vec::new();
    for block in page.blocks().iter().filter(|block| block.language == "json") {
        let place = format!("{}:{}", page.name, block.line);
        match &block.comment[..] {
            [kind, name] if kind == "shown" => {
                let value: Value = serde_json::from_str(&block.body).unwrap_or_else(|e| panic!("{place}: {e}"));
                let file = Path::new(ROOT).join("docs/guide/cases").join(name);
                let same = std::fs::read_to_string(file).map_or(true, |text| text == block.body);
                assert!(same, "{place}: docs/guide/cases/{name} differs");
                shown.insert(name.clone(), value.clone());
                found.push((place, value));
            }
            [kind, name, path @ ..] if kind == "part" && path.len() < 2 => {
                let members: Map<String, Value> =
                    serde_json::from_str(&format!("{{{}}}", block.body)).unwrap_or_else(|e| panic!("{place}: {e}"));
                let mut case = case_file(name, &shown);
                let object = at(&mut case, path.first().map_or("", String::as_str));
                members.into_iter().for_each(|(key, value)| object[key] = value);
                found.push((place, case));
            }
            other => panic!("{place}: a case needs a comment above it, not {other:?}"),
        }
    }
    found
}

/// The shipped cases and those of the guide's folder.
fn of_files() -> Vec<(PathBuf, Value)> {
    let mut found = Vec::new();
    for folder in ["assets/cases", "assets/cases/parachute", "docs/guide/cases"] {
        let mut paths: Vec<PathBuf> = std::fs::read_dir(Path::new(ROOT).join(folder))
            .expect(folder)
            .map(|e| e.expect("an entry").path())
            .collect();
        paths.retain(|path| path.extension().is_some_and(|ext| ext == "json"));
        paths.sort();
        for path in paths {
            let text = std::fs::read_to_string(&path).expect("a case");
            found.push((path, serde_json::from_str(&text).expect("JSON")));
        }
    }
    found
}

/// All cases of the guide and of the shipped files that the program accepts, and the faults of the others.
pub fn accepted() -> (Vec<Accepted>, Vec<String>) {
    let base = Path::new(ROOT).join("docs/guide/cases");
    let pages = pages();
    let shown = pages.iter().flat_map(of_page).map(|(name, value)| accept(&name, value, &base));
    let files = of_files().into_iter().map(|(path, value)| {
        let folder = path.parent().expect("a folder");
        accept(&path.file_name().expect("a name").to_string_lossy(), value, folder)
    });
    let (good, bad): (Vec<_>, Vec<_>) = files.chain(shown).partition(Result::is_ok);
    (good.into_iter().filter_map(Result::ok).collect(), bad.into_iter().filter_map(Result::err).collect())
}

#[test]
fn what_the_guide_shows_is_accepted() {
    let (good, bad) = accepted();
    assert!(bad.is_empty(), "{}", bad.join("\n\n"));
    assert!(good.iter().filter(|case| case.name.contains(".md:")).count() > 10, "few cases are shown");
}

/// The page on messages has a row for every warning that a case can acknowledge, and no other.
#[test]
fn every_warning_has_its_remedy() {
    let pages = pages();
    let page = pages.iter().find(|page| page.name == "troubleshooting.md").expect("the page");
    let table = page.text.split("| code | cause | remedy |").nth(1).and_then(|rest| rest.split("\n\n").next());
    let rows = table.expect("the table of codes").lines().filter_map(|line| line.strip_prefix("| `"));
    let told: Vec<&str> = rows.filter_map(|row| row.split('`').next()).collect();
    let schema = canopy_fem::case::json_schema();
    let codes = schema["$defs"]["WarningCode"]["oneOf"].as_array().expect("the codes");
    let codes: Vec<&str> = codes.iter().filter_map(|code| code["const"].as_str()).collect();
    assert_eq!(told, codes);
}

/// All sources of the program, with line breaks and their indentation as single spaces.
fn sources(folder: &Path, into: &mut String) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, into);
        } else {
            let text = std::fs::read_to_string(&path).unwrap_or_default();
            into.push_str(&text.split_whitespace().collect::<Vec<_>>().join(" "));
        }
    }
}

/// The messages in the tables of the page are messages of the program.
#[test]
fn messages_are_those_of_the_program() {
    let mut text = String::new();
    sources(&Path::new(ROOT).join("src"), &mut text);
    let pages = pages();
    let page = pages.iter().find(|page| page.name == "troubleshooting.md").expect("the page");
    let table = page.text.split("| message | cause | remedy |").nth(1).and_then(|rest| rest.split("\n\n").next());
    let messages = table.expect("the table").lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next());
    let messages: Vec<&str> = messages.map(|message| message.trim_end_matches(" ...").trim_end_matches(':')).collect();
    assert!(messages.len() > 8, "{messages:?}");
    for message in messages {
        assert!(text.contains(message), "no message of the program has the words {message:?}");
    }
}
