//! The study section, checked with the rest so that a study does not fail after its first hour.

use super::numbers::{fraction, positive};
use super::time::method;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::Study;

/// Checks the `study` section.
pub(super) fn check(study: Option<&Study>, faults: &mut Faults<'_>) {
    let Some(study) = study else { return };
    let at = Pointer::root().key("study");
    for (i, choice) in some(&at.key("methods"), study.methods.as_deref(), faults).iter().enumerate() {
        method(&at.key("methods").index(i), choice, faults);
    }
    for (i, step) in some(&at.key("steps"), study.steps.as_deref(), faults).iter().enumerate() {
        positive(&at.key("steps").index(i), *step, faults);
    }
    for (i, tolerance) in some(&at.key("tolerances"), study.tolerances.as_deref(), faults).iter().enumerate() {
        fraction(&at.key("tolerances").index(i), *tolerance, faults);
    }
    if study.repeat.is_some_and(|n| !(1..=1000).contains(&n)) {
        faults.add(&at.key("repeat"), "a whole number from 1 to 1000");
    }
    if let Some(budget) = study.budget_seconds {
        positive(&at.key("budget_seconds"), budget, faults);
    }
}

/// The entries of a list that, if given, must not be empty.
fn some<'a, T>(at: &Pointer, list: Option<&'a [T]>, faults: &mut Faults<'_>) -> &'a [T] {
    match list {
        Some([]) => {
            faults.add(at, "at least one entry; leave the key out to let the study choose");
            &[]
        }
        Some(list) => list,
        None => &[],
    }
}
