//! The case file: read, checked, and turned into what a run needs.
//!
//! ```text
//! file --text--> text --comments, strict JSON--> value --set--> value --typed--> CaseFile --build--> Problem
//! ```
//!
//! Errors come in passes: text that is no JSON, then the first wrong type or key, then every range and meaning at
//! once. [`fault`] holds what a fault looks like; a fault carries a JSON pointer, and [`CaseError::Faults`] the source
//! text that pictures of the place can be made from.

mod build;
mod comments;
mod ergun;
mod error;
pub mod fault;
pub mod fingerprint;
mod overrides;
pub mod pointer;
pub mod schema;
pub mod spec;
mod strict;
mod text;
mod typed;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;

pub use error::CaseError;
pub use fault::Fault;
pub use schema::json_schema;
pub use spec::Problem;

use build::geometry::Geometry;
use fault::Faults;
use schema::CaseFile;

/// A case that was read and found good.
#[derive(Clone, Debug)]
pub struct Case {
    path: String,
    base: PathBuf,
    text: String,
    file: CaseFile,
    problem: Problem,
    geometry: Option<Arc<Geometry>>,
}

impl Case {
    /// Reads a case file, puts the `--set` values in their places (dotted path and value), checks everything, and makes
    /// or reads the mesh, whose path counts from the case file's folder.
    ///
    /// # Errors
    /// A file that cannot be read, text that is no JSON, an assignment without a place, or the faults of the case.
    pub fn from_file(path: &Path, overrides: &[(String, String)]) -> Result<Self, CaseError> {
        let text = text::read(path)?;
        let base = path.parent().unwrap_or(Path::new("")).to_owned();
        Self::from_text(text, &path.display().to_string(), base, overrides)
    }

    /// The same for a text that is already in memory; `name` stands for the file's name in messages, and paths count
    /// from `base`.
    ///
    /// # Errors
    /// As [`Case::from_file`], but for the file itself.
    pub fn from_text(
        text: String,
        name: &str,
        base: PathBuf,
        overrides: &[(String, String)],
    ) -> Result<Self, CaseError> {
        let mut json = text::parse(&text, name)?;
        for (key, value) in overrides {
            overrides::apply(&mut json, key, value)?;
        }
        Source { path: name.to_owned(), base, text }.resolve(json, None)
    }

    /// The same case with some values replaced, as a study needs it; the mesh is not made again unless its section changes.
    ///
    /// # Errors
    /// An assignment without a place, or the faults of the changed case.
    pub fn with(&self, overrides: &[(String, String)]) -> Result<Self, CaseError> {
        let mut json = self.problem.case_json.clone();
        for (key, value) in overrides {
            overrides::apply(&mut json, key, value)?;
        }
        let source = Source { path: self.path.clone(), base: self.base.clone(), text: self.text.clone() };
        source.resolve(json, self.geometry.clone())
    }

    /// What a run needs.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// What a run needs, without a copy.
    pub fn into_problem(self) -> Problem {
        self.problem
    }

    /// The case as written, `--set` included, before defaults are filled in.
    pub fn file(&self) -> &CaseFile {
        &self.file
    }

    /// What is doubtful but runs.
    pub fn warnings(&self) -> &[String] {
        &self.problem.warnings
    }
}

/// Where a case comes from.
struct Source {
    path: String,
    base: PathBuf,
    text: String,
}

impl Source {
    fn resolve(self, json: Value, known: Option<Arc<Geometry>>) -> Result<Case, CaseError> {
        match resolve(&json, &self.base, known) {
            Ok((file, mut problem, geometry)) => {
                problem.case_json = json;
                Ok(Case { path: self.path, base: self.base, text: self.text, file, problem, geometry })
            }
            Err(faults) => Err(CaseError::Faults { path: self.path, text: self.text, faults }),
        }
    }
}

type Resolved = (CaseFile, Problem, Option<Arc<Geometry>>);

fn resolve(json: &Value, base: &Path, known: Option<Arc<Geometry>>) -> Result<Resolved, Vec<Fault>> {
    let file = typed::typed(json).map_err(|fault| vec![fault])?;
    let mut faults = Faults::new(json);
    let built = build::build(&file, base, known, &mut faults);
    let before = faults.count();
    let warnings = faults.finish()?;
    match built {
        Some((mut problem, geometry)) => {
            problem.warnings = warnings;
            Ok((file, problem, geometry))
        }
        None => Err(vec![Fault {
            pointer: String::new(),
            value: format!("{before} faults"),
            allowed: "a case that can be built".to_owned(),
            hint: Some("this is a defect of the program: please report it with the case".to_owned()),
        }]),
    }
}
