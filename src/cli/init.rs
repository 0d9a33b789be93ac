//! `canopy-fem init NAME`: writes a commented example case to start from.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The example, with comments, which case files may have; `{{name}}` stands for the case's name.
const EXAMPLE: &str = include_str!("example-case.jsonc");

/// Write a commented example case.
#[derive(Clone, Debug, clap::Args)]
pub struct InitArgs {
    /// Name of the case; the file is NAME.json
    pub name: String,
    /// Overwrite an existing file
    #[arg(long)]
    pub force: bool,
}

/// Why no example was written.
#[derive(Debug, thiserror::Error)]
pub enum InitError {
    /// The name cannot be a file name.
    #[error("\"{name}\" cannot name a case here; use letters, digits, '-', '_' and '.', not beginning with '.' or '-'")]
    Name {
        /// what was asked for
        name: String,
    },
    /// The file exists already.
    #[error("{path} exists already; --force overwrites it")]
    Exists {
        /// the file
        path: String,
    },
    /// The file cannot be written.
    #[error("{path}: {source}")]
    Write {
        /// the file
        path: String,
        /// the system's reason
        source: std::io::Error,
    },
}

/// Writes the example into `folder`; returns the file's path.
///
/// # Errors
/// A name that cannot be a file name, a file that exists (without `force`), or a failed write.
pub fn run(args: &InitArgs, folder: &Path) -> Result<PathBuf, InitError> {
    let name = args.name.strip_suffix(".json").unwrap_or(&args.name);
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
    if name.is_empty() || name.starts_with(['.', '-']) || name.chars().count() > 200 || !name.chars().all(plain) {
        return Err(InitError::Name { name: args.name.clone() });
    }
    let path = folder.join(format!("{name}.json"));
    let shown = path.display().to_string();
    // `create_new` fails if another program makes the file between the check and the write.
    let mut options = OpenOptions::new();
    let options = if args.force { options.create(true).truncate(true) } else { options.create_new(true) };
    let written =
        options.write(true).open(&path).and_then(|mut f| f.write_all(EXAMPLE.replace("{{name}}", name).as_bytes()));
    match written {
        Ok(()) => Ok(path),
        Err(source) if source.kind() == std::io::ErrorKind::AlreadyExists => Err(InitError::Exists { path: shown }),
        Err(source) => Err(InitError::Write { path: shown, source }),
    }
}
