//! The rules of the house that a compiler does not keep: which folder may name which.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn sources(folder: &str) -> Vec<(PathBuf, String)> {
    sources_below(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(folder))
}

fn sources_below(root: &Path) -> Vec<(PathBuf, String)> {
    let mut open = vec![root.to_owned()];
    let mut found = Vec::new();
    while let Some(dir) = open.pop() {
        for entry in std::fs::read_dir(&dir).expect("a folder of the crate") {
            let path = entry.expect("readable").path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&path).expect("readable");
                found.push((path, text));
            }
        }
    }
    assert!(!found.is_empty(), "{} holds no sources", root.display());
    found
}

fn code(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.lines().enumerate().filter(|(_, line)| !line.trim_start().starts_with("//")).map(|(i, line)| (i + 1, line))
}

/// Within a crate the compiler lets every folder name every other one. Between crates their manifests decide.
#[test]
fn folders_of_a_crate_name_only_what_is_below_them() {
    let rules: [(&str, &[&str]); 14] = [
        ("mesh/vtk", &["crate::"]),
        ("engine/model", &["force", "assembly", "integrate", "solve", "drive", "scene", "faer"]),
        ("engine/preflight", &["force", "integrate", "solve", "scene", "drive", "faer"]),
        ("engine/force", &["integrate", "solve", "drive", "scene", "faer"]),
        ("engine/assembly", &["integrate", "solve", "scene", "drive"]),
        ("engine/solve", &["force", "integrate", "scene", "drive"]),
        ("engine/integrate", &["force", "scene", "drive", "faer"]),
        ("engine/scene", &["integrate", "drive", "faer"]),
        ("engine/drive", &["force", "faer"]),
        ("engine/sensitivity", &["force", "drive", "faer"]),
        ("engine/statics", &["force", "drive", "faer"]),
        ("io/case", &["scene", "force", "output", "simulation"]),
        ("io/output", &["simulation"]),
        ("study/plot", &["integrate", "scene", "case"]),
    ];
    for (folder, forbidden) in rules {
        for (path, text) in sources(folder) {
            for (number, line) in code(&text) {
                for name in forbidden {
                    let named = if matches!(*name, "crate::" | "faer") {
                        line.contains(name)
                    } else {
                        line.contains(&format!("crate::{name}::"))
                    };
                    assert!(!named, "{}:{number} names {name}: {}", path.display(), line.trim());
                }
            }
        }
    }
}

#[test]
fn nothing_a_user_can_cause_panics_by_design() {
    for folder in ["engine", "io", "mesh", "program", "study"] {
        for (path, text) in sources(folder) {
            let in_tests = |line: &str| line.starts_with("#[cfg(") && line.contains("test");
            for (number, line) in code(&text).take_while(|(_, line)| !in_tests(line)) {
                for word in [".unwrap()", ".expect(", "panic!(", "todo!(", "unimplemented!(", "unreachable!("] {
                    assert!(!line.contains(word), "{}:{number} has {word}: {}", path.display(), line.trim());
                }
            }
        }
    }
}

/// What a diagnosis or a scheme wants to know of a force is in its `TermInfo`: a list of names would miss the next
/// force.
#[test]
fn forces_are_known_by_what_they_say_and_not_by_name() {
    let after = |line: &str, mark: &str| Some(line.split_once(mark)?.1.split_once('"')?.0.to_owned());
    let named = |line: &str| after(line, "name: \"").or_else(|| after(line, "TermInfo::of(\""));
    let forces = sources("engine/force");
    let names: Vec<String> = forces.iter().flat_map(|(_, text)| code(text).filter_map(|(_, l)| named(l))).collect();
    assert!(names.len() >= 9, "{names:?}");
    for folder in ["engine/analysis", "engine/drive", "engine/integrate"] {
        for (path, text) in sources(folder) {
            for (number, line) in code(&text).take_while(|(_, line)| !line.starts_with("#[cfg(test)]")) {
                let quoted = names.iter().any(|name| line.contains(&format!("\"{name}\"")));
                assert!(!quoted, "{}:{number} knows a force by name: {}", path.display(), line.trim());
            }
        }
    }
}

/// `cargo test` after `cargo build` compiles what is new for the tests and nothing again: a development dependency that
/// turns a feature on in a crate that the program is built from would have that crate and all that use it compiled
/// twice.
#[test]
fn dependencies_of_the_tests_change_no_features_of_the_program() {
    let features = |edges: &str| -> BTreeMap<String, String> {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let args = ["tree", "--locked", "--offline", "--no-dedupe", "--prefix", "none", "--format", "{p}|{f}"];
        let mut command = std::process::Command::new(cargo);
        command.args(args).args(["--edges", edges]).current_dir(env!("CARGO_MANIFEST_DIR"));
        let out = command.output().expect("cargo runs");
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        let text = String::from_utf8(out.stdout).expect("text");
        text.lines().filter_map(|line| line.split_once('|')).map(|(p, f)| (p.to_owned(), f.to_owned())).collect()
    };
    let (program, tests) = (features("normal,build"), features("normal,build,dev"));
    assert!(program.len() > 50 && tests.len() > program.len(), "{} and {}", program.len(), tests.len());
    for (package, with) in &program {
        assert_eq!(with, &tests[package], "the features of {package}");
    }
}

/// Comments are no wider than code, which rustfmt checks without them. Formulas between fences may be wider.
#[test]
fn comments_are_at_most_120_columns_wide() {
    let mut too_wide = Vec::new();
    for folder in ["src", "tests", "benches", "examples"] {
        for (path, text) in sources_below(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)) {
            let mut fenced = false;
            for (number, line) in text.lines().enumerate() {
                let comment = line.trim_start().starts_with("//");
                fenced = comment && (fenced != line.contains("```"));
                if comment && !fenced && line.chars().count() > 120 {
                    too_wide.push(format!("{}:{}", path.display(), number + 1));
                }
            }
        }
    }
    assert!(too_wide.is_empty(), "{}", too_wide.join("\n"));
}
