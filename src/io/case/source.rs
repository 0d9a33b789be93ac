//! The source of a case, and the way from there to a case or to all its faults.

use std::path::PathBuf;
use std::sync::Arc;

use serde_json::Value;
use serde_path_to_error::{Path, Segment};

use super::diagnostics::{Fault, FaultList, FaultReport, Faults, excerpt};
use super::jsonc::{ParseFailure, Tree, blank, no_json, parse};
use super::location::Location;
use super::lower::geometry::Geometry;
use super::lower::{LoweredCase, build};
use super::pointer::Pointer;
use super::schema::CaseFile;
use super::schema_check::{StandIns, ranges_hold, walk};
use super::span::CaseText;
use super::{Case, CaseError, materials, overrides};

/// The source of a case.
#[derive(Clone, Debug)]
pub struct Source {
    /// name of the file, for messages
    pub(crate) path: String,
    /// folder to which paths are relative
    pub(crate) base: PathBuf,
    /// the file
    pub(crate) text: String,
    /// assignments of the command line, in the order they apply
    pub(crate) overrides: Vec<(String, String)>,
}

impl Source {
    /// The error for a fault that shows only when the scene is built: the value at a JSON pointer of `case_json` does
    /// not fit the rest.
    pub fn refuse(self, case_json: &Value, pointer: &str, allowed: &str, hint: String) -> CaseError {
        let mut faults = Faults::new(case_json, FaultList::default());
        faults.add_hint(&Pointer::root().below(pointer), allowed, hint);
        let faults = faults.finish().err().unwrap_or_default();
        self.refused(faults)
    }

    /// Reads the text.
    pub(crate) fn read(self) -> Result<Case, CaseError> {
        match parse(&self.text) {
            Ok(json) => {
                let json = self.overridden(json)?;
                self.resolve(json, None)
            }
            Err(ParseFailure::Empty) => Err(CaseError::Empty { path: self.path }),
            Err(ParseFailure::Broken(first)) => Err(self.broken(first)),
        }
    }

    /// Checks and builds a case; `known` is a geometry that may be the same.
    pub(crate) fn resolve(self, mut json: Value, known: Option<Arc<Geometry>>) -> Result<Case, CaseError> {
        if let Err(fault) = materials::read_file(&mut json, &self.base) {
            return Err(self.refused(FaultReport { faults: vec![*fault], more: 0 }));
        }
        let first = match typed(&json) {
            Ok(_) if !ranges_hold(&mut json) => None,
            Ok(file) => {
                return match self.build(&json, &file, FaultList::default(), known) {
                    Ok((mut problem, geometry)) => {
                        problem.case_json = json;
                        Ok(Case { source: self, file, problem, geometry })
                    }
                    Err(faults) => Err(self.refused(faults)),
                };
            }
            Err(first) => Some(first),
        };
        let faults = self.all_faults(&json, FaultList::default(), first, known);
        Err(self.refused(faults))
    }

    /// All faults of a text that is not JSON: those of the text, and those of what can be read of it.
    fn broken(self, first: Option<Box<Fault>>) -> CaseError {
        // The tolerant reader could not read a comment that is not closed.
        let clean = blank(&self.text).unwrap_or_default();
        let mut found = FaultList::default();
        let mut json = match Tree::parse(&clean) {
            Ok(tree) => tree.value(&mut found),
            Err(later) => {
                let mut faults: Vec<Fault> = first.into_iter().map(|first| *first).collect();
                let from = match faults.first().and_then(|first| first.place.as_ref()) {
                    Some(Location::Text { range, .. }) => range.start,
                    _ => later,
                };
                if self.text.get(from..later).is_some_and(|between| between.contains('\n')) {
                    let value = "not JSON either, and nothing can be read from here on".to_owned();
                    faults.push(Fault { value, ..no_json(&self.text, later, "", "JSON") });
                }
                return self.refused(FaultReport { faults, more: 0 });
            }
        };
        // The tolerant reader reports all it reads that is not JSON, except white space.
        if let (0, Some(first)) = (found.count(), first) {
            found.note(|| *first);
        }
        json = match self.overridden(json) {
            Ok(json) => json,
            Err(error) => return error,
        };
        let faults = self.all_faults(&json, found, None, None);
        self.refused(faults)
    }

    /// All faults of a case that cannot be read: those found before or else the first that its types have, and those
    /// of the rest. Those of the rest must not depend on what stands for the values that cannot be read.
    fn all_faults(
        &self,
        json: &Value,
        before: FaultList,
        first: Option<Box<Fault>>,
        known: Option<Arc<Geometry>>,
    ) -> FaultReport {
        let [found, other] = [StandIns::First, StandIns::Second].map(|stand_ins| {
            let (mut json, mut found) = (json.clone(), before.clone());
            walk(&mut json, &mut found, stand_ins);
            if found.count() == 0
                && let Some(first) = first.clone()
            {
                found.note(|| *first);
            }
            self.rest(&json, found, known.clone())
        });
        found.in_both(&other)
    }

    fn overridden(&self, mut json: Value) -> Result<Value, CaseError> {
        for (key, value) in &self.overrides {
            overrides::apply(&mut json, key, value)?;
        }
        Ok(json)
    }

    /// All faults of a case, including those of ranges and meaning.
    fn rest(&self, json: &Value, mut found: FaultList, known: Option<Arc<Geometry>>) -> FaultReport {
        match typed(json) {
            Ok(file) => self.build(json, &file, found, known).err().unwrap_or_default(),
            Err(fault) => {
                if found.readable(&Pointer::root().below(&fault.pointer)) {
                    found.note(|| *fault);
                }
                found.report()
            }
        }
    }

    fn build(
        &self,
        json: &Value,
        file: &CaseFile,
        found: FaultList,
        known: Option<Arc<Geometry>>,
    ) -> Result<LoweredCase, FaultReport> {
        let mut faults = Faults::new(json, found);
        let built = build(file, &self.base, known, &mut faults);
        let warnings = faults.finish()?;
        match built {
            Some((mut problem, geometry)) => {
                (problem.acknowledged, problem.warnings) = problem.sort_out(warnings);
                Ok((problem, geometry))
            }
            None => {
                let fault = Fault {
                    value: "a case without faults that cannot be built".to_owned(),
                    allowed: "a case that can be built".to_owned(),
                    hint: Some("this is a defect of the program: please report it with the case".to_owned()),
                    ..Fault::default()
                };
                Err(FaultReport { faults: vec![fault], more: 0 })
            }
        }
    }

    /// The error with these faults and their locations.
    fn refused(self, report: FaultReport) -> CaseError {
        let FaultReport { mut faults, more } = report;
        let tree = Tree::parse(&self.text).ok();
        CaseText { text: &self.text, tree, overrides: &self.overrides }.locate(&mut faults);
        CaseError::Faults { path: self.path, text: self.text, faults, more }
    }
}

/// From JSON to the schema's structs. Serde stops at the first fault; [`walk`] finds them all.
///
/// # Errors
/// The first wrong type, unknown or missing key, with serde's message.
fn typed(json: &Value) -> Result<CaseFile, Box<Fault>> {
    serde_path_to_error::deserialize(json).map_err(|error| {
        let at = pointer(json, error.path());
        let value = json.pointer(at.as_str()).map_or_else(|| "(missing)".to_owned(), excerpt);
        let pointer = at.as_str().to_owned();
        Box::new(Fault { pointer, value, allowed: error.inner().to_string(), ..Fault::default() })
    })
}

/// The path as a JSON pointer. Serde also reports the variant of an enum given as a plain word, where JSON has no key.
fn pointer(json: &Value, path: &Path) -> Pointer {
    let mut at = Pointer::root();
    for segment in path {
        let here = json.pointer(at.as_str());
        match (segment, here) {
            (Segment::Seq { index }, Some(Value::Array(_))) => at = at.index(*index),
            (Segment::Map { key } | Segment::Enum { variant: key }, Some(Value::Object(_))) => at = at.key(key),
            _ => break,
        }
    }
    at
}
