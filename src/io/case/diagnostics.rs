//! A fault of a case: its location, its value, and the allowed values.
//!
//! The checks use pointers only, not the text; [`super::span`] finds the location in the file, and `render` draws it.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde_json::Value;

use super::location::Location;
use super::pointer::Pointer;
use crate::integrate::registry::other_name;
use crate::warning::{Warning, WarningCode};

/// Longest excerpt of a value in a message, in characters.
const EXCERPT: usize = 80;

/// Which part of an entry is wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FaultTarget {
    /// the value that the pointer leads to
    #[default]
    Value,
    /// the key that the pointer ends with
    Key,
    /// the text itself, which is not JSON
    Text,
}

/// One thing that is wrong with a case.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Fault {
    /// JSON pointer, e.g. `/time/step`; empty for the whole case, and where the text is not JSON
    pub pointer: String,
    /// which part of it is wrong
    pub part: FaultTarget,
    /// the value there, shortened
    pub value: String,
    /// what is wrong with it, where that is more than being out of range: "expected a number, found text"
    pub wrong: Option<String>,
    /// what is allowed there, as part of a sentence: "a number above 0"
    pub allowed: String,
    /// advice, if any
    pub hint: Option<String>,
    /// its location in the text, if known
    pub place: Option<Location>,
}

impl Fault {
    /// The first line of a message: location and value.
    pub fn heading(&self) -> String {
        match (self.part, self.pointer.as_str()) {
            (FaultTarget::Text, _) => self.value.clone(),
            (_, "") => format!("/: {}", self.value),
            (_, pointer) => format!("{pointer}: {}", self.value),
        }
    }

    /// The last lines of a message: what is wrong, what is allowed, and advice.
    pub fn advice(&self) -> String {
        let wrong = self.wrong.as_ref().map(|wrong| format!("  wrong: {wrong}\n")).unwrap_or_default();
        let hint = self.hint.as_ref().map(|hint| format!("\n  hint: {hint}")).unwrap_or_default();
        format!("{wrong}  allowed: {}{hint}", self.allowed)
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}\n{}", self.heading(), self.advice())
    }
}

/// A value as a message shows it: compact JSON, cut after 80 characters.
pub fn excerpt(value: &Value) -> String {
    // A mesh in the case can be megabytes long: print no more of it than is shown.
    match value {
        Value::Array(list) if list.len() > EXCERPT => format!("a list of {} entries", list.len()),
        Value::Object(map) if map.len() > EXCERPT => format!("an object with {} keys", map.len()),
        other => shorten(&other.to_string()),
    }
}

/// A text as a message shows it: cut after 80 characters.
pub fn shorten(text: &str) -> String {
    if text.chars().count() <= EXCERPT {
        return text.to_owned();
    }
    let head: String = text.chars().take(EXCERPT - 1).collect();
    format!("{head}…")
}

/// "known keys here: a, b".
pub(crate) fn one_of<T: AsRef<str>>(what: &str, names: &[T]) -> String {
    let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    if names.is_empty() { "no key at all".to_owned() } else { format!("{what}: {}", names.join(", ")) }
}

/// The known name that is most similar to `name`, if any is similar.
pub(crate) fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // 0.6 finds typing errors and swapped letters, but no words of another meaning.
    const ALIKE: f64 = 0.6;
    let likeness = |k: &str| strsim::normalized_damerau_levenshtein(name, k);
    let best = known.into_iter().map(|k| (likeness(k), k)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 >= ALIKE).then_some(best.1)
}

/// "did you mean" with the method that is also called so, else with the known name that is most similar to `name`, if
/// any is similar.
pub(crate) fn did_you_mean<'a>(name: &str, known: impl IntoIterator<Item = &'a str> + Clone) -> Option<String> {
    // First, because "implicit-euler" differs from "explicit-euler" by two letters.
    let other = other_name(name).filter(|other| known.clone().into_iter().any(|known| known == other.method));
    other.map(|other| other.hint()).or_else(|| nearest(name, known).map(|k| format!("did you mean \"{k}\"?")))
}

/// Collects the faults and warnings of one pass over a case.
#[derive(Debug)]
pub(crate) struct Faults<'a> {
    json: &'a Value,
    found: FaultList,
    /// number of faults left out because they follow from others
    kept_back: usize,
    warnings: Vec<Warning>,
}

impl<'a> Faults<'a> {
    /// A collection for this case, with the faults of an earlier pass.
    pub(crate) fn new(json: &'a Value, found: FaultList) -> Self {
        Self { json, found, kept_back: 0, warnings: Vec::new() }
    }

    /// Adds a fault: the value at `at` is not allowed there.
    pub(crate) fn add(&mut self, at: &Pointer, allowed: impl Into<String>) {
        self.add_value(at, self.shown(at), allowed, None);
    }

    /// The same with advice.
    pub(crate) fn add_hint(&mut self, at: &Pointer, allowed: impl Into<String>, hint: impl Into<String>) {
        self.add_value(at, self.shown(at), allowed, Some(hint.into()));
    }

    /// The same for a wrong key at the end of `at`.
    pub(crate) fn add_key(&mut self, at: &Pointer, allowed: impl Into<String>, hint: impl Into<String>) {
        self.put(at, FaultTarget::Key, self.shown(at), allowed.into(), Some(hint.into()));
    }

    /// The same for a wrong value that is not written at `at`, but follows from it.
    pub(crate) fn add_value(
        &mut self,
        at: &Pointer,
        value: impl Into<String>,
        allowed: impl Into<String>,
        hint: Option<String>,
    ) {
        self.put(at, FaultTarget::Value, value.into(), allowed.into(), hint);
    }

    fn put(&mut self, at: &Pointer, part: FaultTarget, value: String, allowed: String, hint: Option<String>) {
        if !self.readable(at) {
            self.kept_back = self.kept_back.saturating_add(1);
            return;
        }
        let hint = hint.filter(|text| !text.is_empty());
        self.found.note(|| Fault { pointer: at.as_str().to_owned(), part, value, allowed, hint, ..Fault::default() });
    }

    /// Whether the case has something at `at`.
    pub(crate) fn is_there(&self, at: &Pointer) -> bool {
        self.json.pointer(at.as_str()).is_some()
    }

    /// Adds a warning, which does not stop a run.
    pub(crate) fn warn(&mut self, code: WarningCode, text: impl Into<String>) {
        self.pass_on(Warning::new(code, text));
    }

    /// The same for a warning that was made elsewhere.
    pub(crate) fn pass_on(&mut self, warning: Warning) {
        self.warnings.push(warning);
    }

    /// Whether the values at `at`, above it and below it are those of the file. Where an earlier pass found a fault,
    /// the value is a stand-in. Faults that follow from a stand-in are not the user's.
    pub(crate) fn readable(&self, at: &Pointer) -> bool {
        self.found.readable(at)
    }

    /// Whether a stand-in is at `at` itself or above it.
    pub(crate) fn unread(&self, at: &Pointer) -> bool {
        self.found.unread(at)
    }

    /// Number of faults so far, including those not shown and those left out.
    pub(crate) fn count(&self) -> usize {
        self.found.count().saturating_add(self.kept_back)
    }

    /// Ends the collection: the warnings if there was no fault, else the faults.
    pub(crate) fn finish(self) -> Result<Vec<Warning>, FaultReport> {
        if self.found.count() == 0 { Ok(self.warnings) } else { Err(self.found.report()) }
    }

    fn shown(&self, at: &Pointer) -> String {
        self.json.pointer(at.as_str()).map_or_else(|| "(missing)".to_owned(), excerpt)
    }
}

/// Largest number of faults to show; the rest is counted.
const SHOWN: usize = 50;

/// Faults, and the entries that they leave unread.
#[derive(Clone, Debug, Default)]
pub(crate) struct FaultList {
    list: Vec<Fault>,
    dropped: usize,
    /// entries with a stand-in, and removed keys
    unread: BTreeSet<String>,
    /// numbers out of range, each with a stand-in of the right range
    outside: BTreeSet<String>,
    /// misspelt keys: the pointer with the known key, and the key as written
    renamed: BTreeMap<String, String>,
}

/// What is reported of the faults of a case.
#[derive(Clone, Debug, Default)]
pub(crate) struct FaultReport {
    /// the faults that are shown
    pub faults: Vec<Fault>,
    /// number of those that are not
    pub more: usize,
}

impl FaultReport {
    /// The faults that another report has too.
    pub(crate) fn in_both(mut self, other: &FaultReport) -> FaultReport {
        self.faults.retain(|fault| other.faults.contains(fault));
        self.more = self.more.min(other.more);
        self
    }
}

impl FaultList {
    /// Adds a fault; `new` is called only if the fault will be shown.
    pub(crate) fn note(&mut self, fault: impl FnOnce() -> Fault) {
        if self.list.len() < SHOWN {
            self.list.push(fault());
        } else {
            self.dropped = self.dropped.saturating_add(1);
        }
    }

    /// Marks an entry whose value was not read.
    pub(crate) fn leave_unread(&mut self, at: &Pointer) {
        self.unread.insert(at.as_str().to_owned());
    }

    /// Marks a number that is out of range. What stands above it can be read.
    pub(crate) fn leave_outside(&mut self, at: &Pointer) {
        self.outside.insert(at.as_str().to_owned());
    }

    /// Marks an entry whose misspelt key is read as a similar known key.
    pub(crate) fn rename(&mut self, known: &Pointer, written: &Pointer) {
        // Entries below it that the JSON reader left unread still have the written key.
        let below =
            |path: &&String| path.strip_prefix(written.as_str()).is_some_and(|r| r.is_empty() || r.starts_with('/'));
        for path in self.unread.iter().filter(below).cloned().collect::<Vec<_>>() {
            self.unread.remove(&path);
            self.unread.insert(path.replacen(written.as_str(), known.as_str(), 1));
        }
        self.renamed.insert(known.as_str().to_owned(), written.as_str().to_owned());
    }

    /// Whether `at` or something above it was left unread.
    pub(crate) fn unread(&self, at: &Pointer) -> bool {
        let path = at.as_str();
        let unread = |p: &str| self.unread.contains(p);
        path.match_indices('/').filter_map(|(i, _)| path.get(..i)).chain([path]).any(unread)
            || self.outside.contains(path)
    }

    /// Whether nothing at `at`, above it or below it was left unread.
    pub(crate) fn readable(&self, at: &Pointer) -> bool {
        // Quick answer for a case without faults, because this is called for every number.
        if self.unread.is_empty() && self.outside.is_empty() {
            return true;
        }
        let below = format!("{}/", at.as_str());
        let next = self.unread.range(below.clone()..).next();
        !self.unread(at) && !next.is_some_and(|p| p.starts_with(&below))
    }

    /// Number of faults, the ones not shown included.
    pub(crate) fn count(&self) -> usize {
        self.list.len().saturating_add(self.dropped)
    }

    /// Ends the search: the faults with pointers as the file spells them.
    pub(crate) fn report(mut self) -> FaultReport {
        let mut faults = std::mem::take(&mut self.list);
        for fault in &mut faults {
            fault.pointer = self.written(&fault.pointer);
        }
        FaultReport { faults, more: self.dropped }
    }

    /// A pointer with the keys that are in the file.
    fn written(&self, pointer: &str) -> String {
        let ends = pointer.match_indices('/').map(|(i, _)| i).chain([pointer.len()]);
        let found = ends.filter_map(|end| Some((self.renamed.get(pointer.get(..end)?)?, end))).next_back();
        match found {
            // A misspelt key may stand below another one.
            Some((spelt, end)) => {
                let (above, last) = spelt.rsplit_once('/').unwrap_or(("", spelt));
                format!("{}/{last}{}", self.written(above), pointer.get(end..).unwrap_or_default())
            }
            None => pointer.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(path: &str) -> Pointer {
        Pointer::root().below(path)
    }

    /// An unread entry makes those above and below it doubtful, but not its neighbours, even with a similar name.
    #[test]
    fn unread_places_reach_up_and_down() {
        let mut found = FaultList::default();
        found.leave_unread(&at("/a/b"));
        for (path, readable) in [("", false), ("/a", false), ("/a/b", false), ("/a/b/0", false), ("/a/bc", true)] {
            assert_eq!(found.readable(&at(path)), readable, "{path}");
        }
        assert!(found.readable(&at("/a-b")) && found.readable(&at("/c")));
    }

    /// Misspelt keys at several depths lead back to the text.
    #[test]
    fn pointers_are_spelt_as_in_the_file() {
        let mut found = FaultList::default();
        found.rename(&at("/system"), &at("/sytem"));
        found.rename(&at("/system/network"), &at("/system/netwrk"));
        for (read, written) in
            [("/system", "/sytem"), ("/system/network/mesh", "/sytem/netwrk/mesh"), ("/time/end", "/time/end")]
        {
            assert_eq!(found.written(read), written);
        }
    }
}
