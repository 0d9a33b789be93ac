//! The case file: reads and checks it, and makes the data of a run.
//!
//! ```text
//! file --jsonc--> value --set--> value --serde--> CaseFile --schema_check--> ranges are right --lower--> Problem
//! ```
//!
//! The fast path stops at the first fault of JSON, of a type or of a range. Then a second pass finds all faults at
//! once. It reads the text tolerantly (`jsonc`), compares types, keys and ranges with the schema (`schema_check`),
//! replaces wrong values by stand-ins, and checks the meaning of the rest. [`diagnostics`] describes a fault, and
//! [`span`] has its location in the text.

mod cloth_model;
pub mod diagnostics;
mod error;
pub mod fingerprint;
mod hints;
mod jsonc;
mod location;
mod lower;
pub mod materials;
mod overrides;
pub mod pointer;
mod render;
pub mod schema;
mod schema_check;
mod schema_parts;
mod source;
pub mod span;
pub mod spec;

use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use cloth_model::ClothModelError;
pub use diagnostics::{Fault, FaultTarget};
pub use error::CaseError;
pub use location::Location;
pub use schema::json_schema;
pub use source::Source;
pub use spec::Problem;

use crate::warning::Warning;
use lower::geometry::Geometry;
use schema::CaseFile;

/// A case that was read and has no faults.
#[derive(Clone, Debug)]
pub struct Case {
    source: Source,
    file: CaseFile,
    problem: Problem,
    geometry: Option<Arc<Geometry>>,
}

/// The `time` section of a case that is not run.
const AT_REST: &str = r#"{"end": 1, "step": 1, "method": "newmark"}"#;

impl Case {
    /// Reads a case file, applies the `--set` assignments (dotted path and value), checks everything, and makes or
    /// reads the mesh. Paths are relative to the folder of the case file.
    ///
    /// # Errors
    /// A file that cannot be read, text that is not JSON, an assignment that cannot be applied, or the faults of the
    /// case.
    pub fn from_file(path: &Path, overrides: &[(String, String)]) -> Result<Self, CaseError> {
        let text = jsonc::read(path)?;
        let base = path.parent().unwrap_or(Path::new("")).to_owned();
        Self::from_text(text, &path.display().to_string(), base, overrides)
    }

    /// The same for a scene at rest: a case without a `time` section gets one, on which no equilibrium depends.
    ///
    /// # Errors
    /// As [`Case::from_file`].
    pub fn from_file_at_rest(path: &Path, overrides: &[(String, String)]) -> Result<Self, CaseError> {
        let text = jsonc::read(path)?;
        let base = path.parent().unwrap_or(Path::new("")).to_owned();
        Self::from_text_at_rest(text, &path.display().to_string(), base, overrides)
    }

    /// Whether its `time` section stands in for one that is not there.
    pub fn is_at_rest(&self) -> bool {
        let first = self.source.overrides.first();
        first.is_some_and(|(key, value)| key == "time" && value == AT_REST)
    }

    /// The same for a text that is already in memory.
    ///
    /// # Errors
    /// As [`Case::from_text`].
    pub fn from_text_at_rest(
        text: String,
        name: &str,
        base: PathBuf,
        overrides: &[(String, String)],
    ) -> Result<Self, CaseError> {
        let timeless = jsonc::parse(&text).is_ok_and(|json| json.is_object() && json.get("time").is_none());
        let time = timeless.then(|| ("time".to_owned(), AT_REST.to_owned()));
        let overrides: Vec<(String, String)> = time.into_iter().chain(overrides.iter().cloned()).collect();
        Self::from_text(text, name, base, &overrides)
    }

    /// The same for the bytes of a file that are already in memory.
    ///
    /// # Errors
    /// As [`Case::from_text`], and bytes that are not UTF-8.
    pub fn from_bytes(
        bytes: Vec<u8>,
        name: &str,
        base: PathBuf,
        overrides: &[(String, String)],
    ) -> Result<Self, CaseError> {
        Self::from_text(jsonc::decode(bytes, name)?, name, base, overrides)
    }

    /// The same for a text that is already in memory; `name` is the file name in messages, and paths are relative to
    /// `base`.
    ///
    /// # Errors
    /// As [`Case::from_file`], except for reading the file.
    pub fn from_text(
        text: String,
        name: &str,
        base: PathBuf,
        overrides: &[(String, String)],
    ) -> Result<Self, CaseError> {
        let overrides = overrides.to_vec();
        Source { path: name.to_owned(), base, text, overrides }.read()
    }

    /// The same case with some values replaced, as a study needs it; the mesh is made again only if its section
    /// changes.
    ///
    /// # Errors
    /// An assignment that cannot be applied, or the faults of the changed case.
    pub fn with(&self, overrides: &[(String, String)]) -> Result<Self, CaseError> {
        let mut source = self.source.clone();
        source.overrides.extend_from_slice(overrides);
        let mut json = self.problem.case_json.clone();
        for (key, value) in overrides {
            overrides::apply(&mut json, key, value)?;
        }
        source.resolve(json, self.geometry.clone())
    }

    /// The data of a run.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The data of a run, without a copy.
    pub fn into_problem(self) -> Problem {
        self.problem
    }

    /// The source of the case, to locate a later fault.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// The data of a run, and the source of the case.
    pub fn split(self) -> (Problem, Source) {
        (self.problem, self.source)
    }

    /// The case as written, `--set` included, before defaults are filled in.
    pub fn file(&self) -> &CaseFile {
        &self.file
    }

    /// The case as JSON with its materials and defaults by type written out, which runs to the same bits by itself.
    ///
    /// # Errors
    /// A value that has no JSON, which does not happen for those of a case.
    pub fn expanded(&self) -> Result<serde_json::Value, serde_json::Error> {
        let mut json = self.problem.case_json.clone();
        if let Some(network) = &self.problem.expanded {
            let mut network = serde_json::to_value(&**network)?;
            drop_nulls(&mut network);
            if let Some(place) = json.pointer_mut("/system/network") {
                *place = network;
            }
        }
        if let Some(keys) = json.as_object_mut() {
            keys.remove("materials");
        }
        Ok(json)
    }

    /// Warnings that are not acknowledged.
    pub fn warnings(&self) -> &[Warning] {
        &self.problem.warnings
    }
}

/// Removes the keys without a value.
fn drop_nulls(json: &mut serde_json::Value) {
    match json {
        serde_json::Value::Object(map) => {
            map.retain(|_, value| !value.is_null());
            map.values_mut().for_each(drop_nulls);
        }
        // The numbers of a mesh are many, and none is null.
        serde_json::Value::Array(list) if list.iter().any(serde_json::Value::is_object) => {
            list.iter_mut().for_each(drop_nulls);
        }
        _ => {}
    }
}
