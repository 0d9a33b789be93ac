//! The location of a fault: a range of the file's text, or an assignment on the command line.

use super::diagnostics::{Fault, FaultTarget, shorten};
use super::jsonc::Tree;
use super::location::Location;
use super::pointer::Pointer;

/// The text and the assignments of a case.
#[derive(Clone, Debug)]
pub(crate) struct CaseText<'a> {
    /// the file
    pub text: &'a str,
    /// the tree of the text with its comments blanked, as far as it can be read
    pub tree: Option<Tree<'a>>,
    /// assignments of the command line, in the order they apply
    pub overrides: &'a [(String, String)],
}

impl CaseText<'_> {
    /// Gives every fault its location and sorts them: those of the text in its order, then those of the assignments in
    /// the order of the command line.
    pub(crate) fn locate(&self, faults: &mut [Fault]) {
        for fault in faults.iter_mut().filter(|fault| fault.place.is_none() && fault.part != FaultTarget::Text) {
            fault.place = self.place(fault);
        }
        faults.sort_by_key(|fault| match &fault.place {
            Some(Location::Text { range, .. }) => (0, range.start),
            Some(Location::Assignment { key, .. }) => {
                (1, self.overrides.iter().rposition(|(k, _)| k == key).unwrap_or(0))
            }
            None => (2, 0),
        });
    }

    fn place(&self, fault: &Fault) -> Option<Location> {
        // The longest part of the pointer that exists in the text, and one more key: an assignment to or below it has
        // made it.
        let made = self.tree.as_ref().map(|tree| tree.reach(&fault.pointer).len()).and_then(|reached| {
            let step = fault.pointer.get(reached + 1..)?;
            fault.pointer.get(..reached + 1 + step.find('/').unwrap_or(step.len()))
        });
        let assigned = self.overrides.iter().rev().find(|(key, _)| {
            let at = key.split('.').fold(Pointer::root(), |at, step| at.key(step));
            within(&fault.pointer, at.as_str()) || made.is_some_and(|made| within(at.as_str(), made))
        });
        if let Some((key, value)) = assigned {
            return Some(Location::Assignment { key: key.clone(), value: shorten(value) });
        }
        Some(Location::in_text(self.text, self.tree.as_ref()?.range(&fault.pointer, fault.part)))
    }
}

/// Whether a pointer leads to the same value as another one, or into it.
fn within(pointer: &str, other: &str) -> bool {
    pointer.strip_prefix(other).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines and columns are counted from 1, columns in characters; offsets within a character or beyond the end are
    /// moved.
    #[test]
    fn lines_and_columns() {
        let text = "a\n  é b";
        for (offset, expected) in [(0, (1, 1)), (2, (2, 1)), (4, (2, 3)), (5, (2, 3)), (7, (2, 5)), (99, (2, 6))] {
            let Location::Text { line, column, .. } = Location::in_text(text, offset..offset + 1) else {
                panic!("a text")
            };
            assert_eq!((line, column), expected, "byte {offset}");
        }
    }
}
