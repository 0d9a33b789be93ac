//! Where a case comes from, and the way from there to a case or to all its faults.

use std::path::PathBuf;
use std::sync::Arc;

use serde_json::Value;

use super::diagnostics::{Fault, FaultTarget, Faults};
use super::diagnostics::{Findings, Reported};
use super::jsonc::blank;
use super::jsonc_tree::Tree;
use super::lower::geometry::Geometry;
use super::lower::{Built, build};
use super::pointer::Pointer;
use super::schema::CaseFile;
use super::schema_check::walk;
use super::span::{Location, Written};
use super::text::{NoJson, parse};
use super::typed::typed;
use super::{Case, CaseError, overrides};

/// Where a case comes from.
#[derive(Clone, Debug)]
pub struct Source {
    /// name of the file, for messages
    pub(crate) path: String,
    /// folder that paths count from
    pub(crate) base: PathBuf,
    /// the file
    pub(crate) text: String,
    /// assignments of the command line, in the order they apply
    pub(crate) overrides: Vec<(String, String)>,
}

impl Source {
    /// The error for a fault that shows only when the case is made ready: the value at a JSON pointer of `case_json`
    /// does not go with the rest.
    pub fn refuse(self, case_json: &Value, pointer: &str, allowed: &str, hint: String) -> CaseError {
        let mut faults = Faults::new(case_json, Findings::default());
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
            Err(NoJson::Empty) => Err(CaseError::Empty { path: self.path }),
            Err(NoJson::Broken { offset, reason, allowed }) => Err(self.broken(offset, &reason, allowed)),
        }
    }

    /// Checks and builds a case; `known` is a geometry that may be the same.
    pub(crate) fn resolve(self, mut json: Value, known: Option<Arc<Geometry>>) -> Result<Case, CaseError> {
        let first = match typed(&json) {
            Ok(file) => {
                return match self.build(&json, &file, Findings::default(), known) {
                    Ok((mut problem, geometry)) => {
                        problem.case_json = json;
                        Ok(Case { source: self, file, problem, geometry })
                    }
                    Err(faults) => Err(self.refused(faults)),
                };
            }
            Err(first) => first,
        };
        let mut found = Findings::default();
        walk(&mut json, &mut found);
        if found.count() == 0 {
            found.note(|| *first);
        }
        let faults = self.rest(&json, found, known);
        Err(self.refused(faults))
    }

    /// All faults of a text that is not JSON: those of the text, and those of what can be read of it.
    fn broken(self, offset: usize, reason: &str, allowed: &str) -> CaseError {
        let at = |offset: usize, value: String, allowed: &str| Fault {
            part: FaultTarget::Text,
            value,
            allowed: allowed.to_owned(),
            place: Some(Location::in_text(&self.text, offset..offset + 1)),
            ..Fault::default()
        };
        let first = at(offset, format!("not JSON: {reason}"), allowed);
        // The tolerant reader would see a comment that is open to the end as nonsense.
        let clean = blank(&self.text).unwrap_or_default();
        let mut found = Findings::default();
        let mut json = match Tree::parse(&clean) {
            Ok(tree) => tree.value(&mut found),
            Err(later) => {
                let mut faults = vec![first];
                let lines = self.text.get(offset..later).unwrap_or_default();
                if lines.contains('\n') {
                    faults.push(at(later, "not JSON either, and nothing can be read from here on".to_owned(), "JSON"));
                }
                return self.refused(Reported { faults, more: 0 });
            }
        };
        // What the tolerant reader allows and JSON does not, it notes; depth is the rest.
        if found.count() == 0 {
            found.note(|| first);
        }
        json = match self.overridden(json) {
            Ok(json) => json,
            Err(error) => return error,
        };
        walk(&mut json, &mut found);
        let faults = self.rest(&json, found, None);
        self.refused(faults)
    }

    fn overridden(&self, mut json: Value) -> Result<Value, CaseError> {
        for (key, value) in &self.overrides {
            overrides::apply(&mut json, key, value)?;
        }
        Ok(json)
    }

    /// The faults of a case in which faults were found, with those of its ranges and meaning.
    fn rest(&self, json: &Value, mut found: Findings, known: Option<Arc<Geometry>>) -> Reported {
        match typed(json) {
            Ok(file) => self.build(json, &file, found, known).err().unwrap_or_default(),
            Err(fault) => {
                if found.readable(&Pointer::root().below(&fault.pointer)) {
                    found.note(|| *fault);
                }
                found.told()
            }
        }
    }

    fn build(
        &self,
        json: &Value,
        file: &CaseFile,
        found: Findings,
        known: Option<Arc<Geometry>>,
    ) -> Result<Built, Reported> {
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
                Err(Reported { faults: vec![fault], more: 0 })
            }
        }
    }

    /// The error that shows these faults at their places.
    fn refused(self, told: Reported) -> CaseError {
        let Reported { mut faults, more } = told;
        let clean = blank(&self.text).unwrap_or_default();
        let tree = Tree::parse(&clean).ok();
        Written { text: &self.text, tree, overrides: &self.overrides }.locate(&mut faults);
        CaseError::Faults { path: self.path, text: self.text, faults, more }
    }
}
