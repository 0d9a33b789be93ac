//! `canopy-fem init NAME`: writes a commented example case to start from, and the JSON Schema for editors beside it.

use super::schema;
use clap::ValueEnum;
use std::fmt::Write as _;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

/// Name of the file with the JSON Schema, which the templates refer to.
const SCHEMA_FILE: &str = "case.schema.json";
/// Title of the JSON Schema: another file of that name is left alone.
const SCHEMA_TITLE: &str = "\"title\": \"canopy-fem case\"";

/// What an example case shows; each is a file with comments, in which `{{name}}` stands for the case's name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Template {
    /// A round cloth with a vent, held at its outer edge, in the wind
    #[default]
    Canopy,
    /// A flag on its pole, in the wind
    Flag,
    /// A round parachute with lines and a payload that opens and descends
    Drop,
    /// A simple pendulum, without a mesh
    Pendulum,
    /// A cloth that hangs by two corners and falls into its folds
    Cloth,
}

impl Template {
    /// Its name on the command line.
    fn name(self) -> String {
        self.to_possible_value().unwrap_or_default().get_name().to_owned()
    }

    fn text(self) -> &'static str {
        match self {
            Template::Canopy => include_str!("templates/canopy.jsonc"),
            Template::Flag => include_str!("templates/flag.jsonc"),
            Template::Drop => include_str!("templates/drop.jsonc"),
            Template::Pendulum => include_str!("templates/pendulum.jsonc"),
            Template::Cloth => include_str!("templates/cloth.jsonc"),
        }
    }
}

/// Write a commented example case.
#[derive(Clone, Debug, clap::Args)]
pub struct InitArgs {
    /// Name of the case; the file is NAME.json [default: the name of the template that is given]
    #[arg(required_unless_present_any = ["list", "template"])]
    pub name: Option<String>,
    /// Example to write
    #[arg(long, value_enum, default_value_t, value_name = "TEMPLATE")]
    pub template: Template,
    /// List the templates
    #[arg(long, conflicts_with_all = ["name", "force"])]
    pub list: bool,
    /// Overwrite an existing file
    #[arg(long)]
    pub force: bool,
}

/// Why no example was written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
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

/// Runs the command in the present folder; returns what goes to standard output.
pub(super) fn run(args: &InitArgs) -> Result<String, InitError> {
    if args.list {
        return Ok(list());
    }
    let path = write(args, Path::new(""))?;
    Ok(format!("{0} written; try: canopy-fem check {0}\n", path.display()))
}

fn list() -> String {
    let mut text = String::new();
    for template in Template::value_variants() {
        let value = template.to_possible_value().unwrap_or_default();
        let help = value.get_help().map(ToString::to_string).unwrap_or_default();
        let _ = writeln!(text, "{:<12}{help}", value.get_name());
    }
    text + "\ncanopy-fem init NAME --template TEMPLATE writes one of them.\n"
}

/// Writes the example and the JSON Schema into `folder`; returns the path of the example.
///
/// # Errors
/// A name that cannot be a file name, a file that exists (without `force`), or a failed write.
pub fn write(args: &InitArgs, folder: &Path) -> Result<PathBuf, InitError> {
    let given = &args.name.clone().unwrap_or_else(|| args.template.name());
    let name = given.strip_suffix(".json").unwrap_or(given);
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
    if name.is_empty() || name.starts_with(['.', '-']) || name.chars().count() > 200 || !name.chars().all(plain) {
        return Err(InitError::Name { name: given.clone() });
    }
    let path = folder.join(format!("{name}.json"));
    let shown = path.display().to_string();
    // `create_new` fails if another program makes the file between the check and the write.
    let mut options = OpenOptions::new();
    let options = if args.force { options.create(true).truncate(true) } else { options.create_new(true) };
    let text = args.template.text().replace("{{name}}", name);
    match options.write(true).open(&path).and_then(|mut file| file.write_all(text.as_bytes())) {
        Ok(()) => write_schema(folder).map(|()| path),
        Err(source) if source.kind() == ErrorKind::AlreadyExists => Err(InitError::Exists { path: shown }),
        Err(source) => Err(InitError::Write { path: shown, source }),
    }
}

/// Writes the JSON Schema; an older one is replaced, a file of another content is left alone.
fn write_schema(folder: &Path) -> Result<(), InitError> {
    let path = folder.join(SCHEMA_FILE);
    let fault = |source| InitError::Write { path: path.display().to_string(), source };
    match std::fs::read_to_string(&path) {
        Ok(found) if !found.contains(SCHEMA_TITLE) => return Ok(()),
        Ok(_) => {}
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(error) => return Err(fault(error)),
    }
    std::fs::write(&path, schema::run() + "\n").map_err(fault)
}
