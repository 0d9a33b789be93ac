//! What README and docs promise exists: the table of methods agrees with the registry, and the files that are named are
//! there.

use crate::common::run::{asset, run};
use canopy_fem::drive::Status;
use canopy_fem::integrate::registry::methods;
use std::path::Path;

fn document(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn the_table_of_methods_is_the_registry() {
    let text = document("docs/methods.md");
    let section = text.split("## The twenty-one methods").nth(1).and_then(|s| s.split("\n## ").next());
    let section = section.expect("a section on methods");
    let rows: Vec<(String, u32)> = section
        .lines()
        .filter(|line| line.starts_with("| `"))
        .map(|line| {
            let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
            (cells[0].trim_matches('`').to_owned(), cells[1].parse().expect("an order"))
        })
        .collect();
    let registered: Vec<(String, u32)> = methods().iter().map(|m| (m.name.to_owned(), m.order)).collect();
    assert_eq!(rows, registered);
}

#[test]
fn the_files_it_names_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = document("README.md");
    let named = text
        .split(|c: char| c.is_whitespace() || "()[]`'\"".contains(c))
        .filter(|word| ["assets/", "docs/", "tests/"].iter().any(|folder| word.starts_with(folder)));
    let mut count = 0;
    for word in named {
        assert!(root.join(word).exists(), "{word}");
        count += 1;
    }
    assert!(count >= 6, "only {count} files are named");
}

/// The cases that README solves run, each a little way.
#[test]
fn the_cases_it_solves_run() {
    let text = document("README.md");
    let commands = text.split("solve assets/cases/").skip(1).filter_map(|rest| rest.split(".json").next());
    let stems: Vec<&str> = commands.collect();
    assert_eq!(stems, ["parachute/c9-filling", "parachute/rescue-115kg"]);
    for stem in stems {
        let ran = run(&asset(stem, &[("time.end", "0.1")]));
        assert!(
            ran.outcome.status == Status::Completed && ran.outcome.energy_error < 1e-3,
            "{stem}: {:?}",
            ran.outcome
        );
    }
}

/// The tables over time that it shows are read, each at its place in a case.
#[test]
fn the_tables_it_shows_are_read() {
    let text = document("docs/using.md");
    let shown = |key: &str| {
        let opening = format!("`\"{key}\": ");
        let found = text.split(&opening).nth(1).and_then(|rest| rest.split('`').next());
        found.unwrap_or_else(|| panic!("no {key}")).to_owned()
    };
    for (key, place) in [
        ("rest_scale", "system.network.springs.0.rest_scale"),
        ("motion", "system.network.supports.0.motion"),
        ("base_acceleration", "system.network.base_acceleration"),
    ] {
        let value = shown(key);
        assert!(value.contains("table"), "{key}: {value}");
        let case = asset("oscillator", &[(place, &value)]);
        assert!(case.problem().time.end > 0.0, "{key}");
    }
}

/// Every path in backticks that has a folder is a file or folder, of `src` or of the repository, with or without its
/// ending.
#[test]
fn the_paths_of_the_architecture_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = document("ARCHITECTURE.md");
    let is_path = |word: &&str| {
        let plain = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
        word.contains('/') && word.chars().all(plain)
    };
    let named: Vec<&str> = text.split('`').skip(1).step_by(2).filter(is_path).collect();
    assert!(named.len() > 60, "{}", named.len());
    let there = |word: &str| {
        let mut places = [root.join("src"), root.to_owned()].into_iter();
        places.any(|base| base.join(word).exists() || base.join(format!("{word}.rs")).exists())
    };
    let missing: Vec<&&str> = named.iter().filter(|word| !there(word)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}
