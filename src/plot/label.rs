//! What runs are called in legends and titles.

use super::results::{Ending, Run};
use crate::drive::Status;
use std::collections::BTreeSet;

/// One label a run: case, method and step where the runs differ in these, their folders where that does not tell them
/// apart; and how a run ended, if not well. A single run has no name beside the title's.
pub(super) fn labels(runs: &[Run]) -> Vec<String> {
    let differ = |of: &dyn Fn(&Run) -> String| runs.iter().map(of).collect::<BTreeSet<_>>().len() > 1;
    let step = |run: &Run| match (run.step, run.tolerance) {
        (Some(h), _) => format!("h = {} s", short(h)),
        (None, Some(relative)) => format!("tolerance {}", short(relative)),
        (None, None) => "adaptive".to_owned(),
    };
    let names = differ(&|r| r.name.clone());
    let (methods, steps) = (differ(&|r| r.method.clone()), differ(&step));
    let told = |run: &Run| {
        let words = [names.then(|| run.name.clone()), methods.then(|| run.method.clone()), steps.then(|| step(run))];
        words.into_iter().flatten().collect::<Vec<_>>().join(", ")
    };
    let distinct = runs.iter().map(told).collect::<BTreeSet<_>>().len() == runs.len();
    let folder = |run: &Run| {
        let last = run.folder.file_name().map(|n| n.to_string_lossy().into_owned());
        last.unwrap_or_else(|| run.folder.display().to_string())
    };
    let folders_differ = differ(&folder);
    let name = |run: &Run| match (runs.len(), distinct, folders_differ) {
        (0 | 1, _, _) => String::new(),
        (_, true, _) => told(run),
        (_, false, true) => folder(run),
        (_, false, false) => run.folder.display().to_string(),
    };
    runs.iter().map(|run| joined(&name(run), &ending(run.ending))).collect()
}

/// Words in a row, without empty ones.
pub(super) fn joined(first: &str, second: &str) -> String {
    [first, second].into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join(", ")
}

/// A title: what the runs have in common, and what is shown.
pub(super) fn title(runs: &[Run], what: &str) -> String {
    let name = runs.first().map_or("", |run| run.name.as_str());
    if runs.iter().all(|run| run.name == name) { format!("{name}: {what}") } else { what.to_owned() }
}

/// How a run ended; nothing if it reached its end.
fn ending(Ending { status, time }: Ending) -> String {
    let word = match status {
        Status::Completed => return String::new(),
        Status::Diverged => "diverged",
        Status::NotConverged => "not converged",
        Status::Interrupted => "interrupted",
    };
    format!("{word} at {} s", short(time))
}

/// A number with at most four digits that count.
fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    let everyday = rounded == 0.0 || (1e-3..1e5).contains(&rounded.abs());
    if everyday { format!("{rounded}") } else { format!("{rounded:e}") }
}
