//! Puts the version that `canopy-fem --version` prints into the program: the package's and, if the sources are the
//! top of a git repository, its commit. Without git the same sources give the same text.

use std::process::Command;

/// Sources of the program, as paths below the package.
const SOURCES: [&str; 4] = ["src", "build.rs", "Cargo.toml", "Cargo.lock"];

fn main() {
    // Only where a source changed: a commit alone must not compile the program again, since it is still the same.
    for path in SOURCES {
        println!("cargo:rerun-if-changed={path}");
    }
    let version = env!("CARGO_PKG_VERSION");
    let commit = commit().map(|commit| format!(" ({commit})")).unwrap_or_default();
    println!("cargo:rustc-env=CANOPY_FEM_VERSION={version}{commit}");
}

/// The commit, with a note if the sources differ from it; `None` without git, or where the package lies within the
/// repository of something else.
fn commit() -> Option<String> {
    let top = git(&["rev-parse", "--show-toplevel"])?;
    let here = std::env::var_os("CARGO_MANIFEST_DIR")?;
    if std::fs::canonicalize(top).ok()? != std::fs::canonicalize(here).ok()? {
        return None;
    }
    let commit = git(&["rev-parse", "--short=10", "HEAD"])?;
    let changed = git(&[&["status", "--porcelain", "--"], &SOURCES[..]].concat()).is_some_and(|list| !list.is_empty());
    Some(if changed { format!("{commit} with changes") } else { commit })
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}
