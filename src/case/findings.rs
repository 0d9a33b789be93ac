//! What the passes over a case have found so far: the faults, and which parts of the case were left unread for them.

use std::collections::{BTreeMap, BTreeSet};

use super::fault::Fault;
use super::pointer::Pointer;

/// More than this many faults help nobody; the rest is counted.
const SHOWN: usize = 50;

/// Faults, and what they leave unread.
#[derive(Clone, Debug, Default)]
pub(crate) struct Findings {
    list: Vec<Fault>,
    dropped: usize,
    /// places with a stand-in, and keys that were taken away
    unread: BTreeSet<String>,
    /// places of misspelt keys: read as the known key, written otherwise
    renamed: BTreeMap<String, String>,
}

/// What is told of the faults of a case.
#[derive(Clone, Debug, Default)]
pub(crate) struct Told {
    /// the faults that are shown
    pub faults: Vec<Fault>,
    /// number of those that are not
    pub more: usize,
}

impl Findings {
    /// Notes a fault; it is only made if it will be shown.
    pub fn note(&mut self, fault: impl FnOnce() -> Fault) {
        if self.list.len() < SHOWN {
            self.list.push(fault());
        } else {
            self.dropped = self.dropped.saturating_add(1);
        }
    }

    /// Marks a place whose value was not read.
    pub fn leave_unread(&mut self, at: &Pointer) {
        self.unread.insert(at.as_str().to_owned());
    }

    /// Marks a place where a misspelt key is read as the known one it looks like.
    pub fn rename(&mut self, known: &Pointer, written: &Pointer) {
        // What the reader of the text left unread below goes by the written key still.
        let below =
            |path: &&String| path.strip_prefix(written.as_str()).is_some_and(|r| r.is_empty() || r.starts_with('/'));
        for path in self.unread.iter().filter(below).cloned().collect::<Vec<_>>() {
            self.unread.remove(&path);
            self.unread.insert(path.replacen(written.as_str(), known.as_str(), 1));
        }
        self.renamed.insert(known.as_str().to_owned(), written.as_str().to_owned());
    }

    /// Whether `at` or something above it was left unread.
    pub fn unread(&self, at: &Pointer) -> bool {
        let path = at.as_str();
        path.match_indices('/').filter_map(|(i, _)| path.get(..i)).chain([path]).any(|p| self.unread.contains(p))
    }

    /// Whether nothing at `at`, above it or below it was left unread.
    pub fn readable(&self, at: &Pointer) -> bool {
        // Most cases have no fault, and ask this for every number.
        if self.unread.is_empty() {
            return true;
        }
        let below = format!("{}/", at.as_str());
        let next = self.unread.range(below.clone()..).next();
        !self.unread(at) && !next.is_some_and(|p| p.starts_with(&below))
    }

    /// Number of faults, the ones not shown included.
    pub fn count(&self) -> usize {
        self.list.len().saturating_add(self.dropped)
    }

    /// Ends the search: the faults with pointers as the file spells them.
    pub fn told(mut self) -> Told {
        let mut faults = std::mem::take(&mut self.list);
        for fault in &mut faults {
            fault.pointer = self.written(&fault.pointer);
        }
        Told { faults, more: self.dropped }
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

    /// A case with a fault in every entry of a long list gives a message of bounded length that says what it left out.
    #[test]
    fn bounds_the_number_of_faults() {
        let mut found = Findings::default();
        for _ in 0..1000 {
            found.note(Fault::default);
        }
        assert_eq!(found.count(), 1000);
        let told = found.told();
        assert_eq!((told.faults.len(), told.more), (SHOWN, 950));
    }

    /// A place is doubtful with what is above and below it; its neighbours, also those of a similar name, are not.
    #[test]
    fn unread_places_reach_up_and_down() {
        let mut found = Findings::default();
        found.leave_unread(&at("/a/b"));
        for (path, readable) in [("", false), ("/a", false), ("/a/b", false), ("/a/b/0", false), ("/a/bc", true)] {
            assert_eq!(found.readable(&at(path)), readable, "{path}");
        }
        assert!(found.readable(&at("/a-b")) && found.readable(&at("/c")));
    }

    /// Misspelt keys at several depths lead back to the text.
    #[test]
    fn pointers_are_spelt_as_in_the_file() {
        let mut found = Findings::default();
        found.rename(&at("/system"), &at("/sytem"));
        found.rename(&at("/system/network"), &at("/system/netwrk"));
        for (read, written) in
            [("/system", "/sytem"), ("/system/network/mesh", "/sytem/netwrk/mesh"), ("/time/end", "/time/end")]
        {
            assert_eq!(found.written(read), written);
        }
    }
}
