//! The node paths to draw, with their colours, direction and names.

use super::PlotError;
use super::chart::Marker;
use super::results::{ProbePath, Run, RunEnd};
use super::view::{Direction, Results, View};
use crate::drive::Status;
use crate::method_look::{method_colors, method_mark};
use std::collections::BTreeSet;

/// Up to this many nodes of a single probe get a colour each.
const COLORS: usize = 7;

/// Node paths that share a colour and an entry of the legend.
pub(super) struct Group<'a> {
    /// their run
    pub run: &'a Run,
    /// entry of the legend
    pub label: String,
    /// at least one
    pub tracks: Vec<&'a ProbePath>,
}

/// The node paths of a view: one group per run; for a single run, one group per probe, or per node if these are few.
///
/// # Errors
/// Probes or nodes that do not exist.
pub(super) fn groups<'a>(results: &'a Results, view: &View) -> Result<Vec<Group<'a>>, PlotError> {
    let mut groups = Vec::new();
    let probed = results.runs.iter().any(|run| !run.tracks.is_empty());
    for (run, label) in results.runs.iter().zip(results.labels()) {
        if probed && run.tracks.is_empty() {
            continue;
        }
        let tracks = tracks(run, view)?;
        if results.runs.len() > 1 {
            groups.push(Group { run, label, tracks });
            continue;
        }
        let probes: BTreeSet<&str> = tracks.iter().map(|t| t.probe.as_str()).collect();
        let split = |key: &dyn Fn(&ProbePath) -> String| {
            let mut split: Vec<Group<'a>> = Vec::new();
            for &track in &tracks {
                let label = joined(&key(track), &label);
                match split.iter_mut().find(|g| g.label == label) {
                    Some(group) => group.tracks.push(track),
                    None => split.push(Group { run, label, tracks: vec![track] }),
                }
            }
            split
        };
        groups = match (probes.len(), tracks.len()) {
            (_, 1) => vec![Group { run, label, tracks }],
            (1, 2..=COLORS) => split(&|t| format!("node {}", t.node)),
            _ => split(&|t| t.probe.clone()),
        };
    }
    Ok(groups)
}

/// Text for the node paths in a title: "tip" (node 1), or "inner" (12 nodes), or nothing if they differ. Nodes are
/// those of every run.
pub(super) fn subject(groups: &[Group<'_>]) -> String {
    let all = || groups.iter().flat_map(|g| g.tracks.iter());
    let nodes: BTreeSet<u32> = all().map(|t| t.node).collect();
    let probes: BTreeSet<&str> = all().map(|t| t.probe.as_str()).collect();
    // One group per run, if there are several.
    let several = groups.first().is_some_and(|f| groups.iter().any(|g| !std::ptr::eq(g.run, f.run)));
    if several && groups.iter().any(|g| g.tracks.iter().map(|t| t.node).collect::<BTreeSet<_>>() != nodes) {
        return probes
            .first()
            .filter(|_| probes.len() == 1)
            .map_or_else(String::new, |probe| format!(" of \"{probe}\""));
    }
    match (nodes.len(), nodes.first(), nodes.last(), probes.first()) {
        (1, Some(node), _, Some(probe)) if probes.len() == 1 => format!(" of \"{probe}\" (node {node})"),
        (1, Some(node), _, _) => format!(" of node {node}"),
        (n, _, _, Some(probe)) if probes.len() == 1 => format!(" of \"{probe}\" ({n} nodes)"),
        (n, Some(first), Some(last), _) if (last - first) as usize == n - 1 => format!(" of nodes {first} to {last}"),
        _ => String::new(),
    }
}

fn tracks<'a>(run: &'a Run, view: &View) -> Result<Vec<&'a ProbePath>, PlotError> {
    let folder = run.folder.display();
    if run.tracks.is_empty() {
        return Err(PlotError::NotHeld {
            folder: run.folder.clone(),
            what: "no node was probed, so no motion can be plotted",
            add: "probes",
        });
    }
    let probed: BTreeSet<&str> = run.tracks.iter().map(|t| t.probe.as_str()).collect();
    if let Some(name) = view.probes.iter().find(|name| !probed.contains(name.as_str())) {
        let there = probed.into_iter().collect::<Vec<_>>().join(", ");
        return Err(PlotError::NotThere(format!("{folder}: no probe is called \"{name}\"; there are: {there}")));
    }
    let of_probes = run.tracks.iter().filter(|t| view.probes.is_empty() || view.probes.contains(&t.probe));
    let wanted: BTreeSet<u32> = view.nodes.iter().copied().collect();
    let chosen: Vec<&ProbePath> = of_probes.filter(|t| wanted.is_empty() || wanted.contains(&t.node)).collect();
    let found: BTreeSet<u32> = chosen.iter().map(|t| t.node).collect();
    match wanted.difference(&found).next() {
        Some(node) => Err(PlotError::NotThere(format!("{folder}: node {node} was not probed"))),
        None => Ok(chosen),
    }
}

/// The direction of the largest motion, before any divergence.
pub(super) fn main_direction(groups: &[Group<'_>], view: &View) -> Direction {
    let directions = [Direction::X, Direction::Y, Direction::Z];
    let travel = |direction: Direction| {
        let c = direction.index();
        let of_track = |end: f64, track: &ProbePath| {
            let seen = track.moments.iter().filter(|m| view.sees(m.t) && m.t <= end && m.x[c].is_finite());
            let (low, high) = seen.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), m| (l.min(m.x[c]), h.max(m.x[c])));
            (high - low).max(0.0)
        };
        let tracks = groups.iter().flat_map(|g| g.tracks.iter().map(|t| of_track(g.run.ending.time, t)));
        tracks.fold(0.0, f64::max)
    };
    let mut best = (Direction::X, travel(Direction::X));
    for direction in &directions[1..] {
        let farther = travel(*direction);
        if farther > best.1 {
            best = (*direction, farther);
        }
    }
    best.0
}

/// One name per run: case, method and step if the runs differ in these, or their folders if they do not. A single run
/// has none, because the title names it.
pub(super) fn names(runs: &[&Run]) -> Vec<String> {
    let differ = |of: &dyn Fn(&Run) -> String| runs.iter().map(|run| of(run)).collect::<BTreeSet<_>>().len() > 1;
    let step = |run: &Run| match (run.step, run.tolerance) {
        (Some(h), _) => format!("h = {} s", short(h)),
        (None, Some(relative)) => format!("tolerance {}", short(relative)),
        (None, None) => "adaptive".to_owned(),
    };
    let names = differ(&|r| r.name.clone());
    let (methods, steps) = (differ(&|r| r.method.clone()), differ(&step));
    let labelled = |run: &Run| {
        let words = [names.then(|| run.name.clone()), methods.then(|| run.method.clone()), steps.then(|| step(run))];
        words.into_iter().flatten().collect::<Vec<_>>().join(", ")
    };
    let distinct = runs.iter().map(|run| labelled(run)).collect::<BTreeSet<_>>().len() == runs.len();
    let folder = |run: &Run| {
        let last = run.folder.file_name().map(|n| n.to_string_lossy().into_owned());
        last.unwrap_or_else(|| run.folder.display().to_string())
    };
    let folders_differ = differ(&folder);
    let name = |run: &&Run| match (runs.len(), distinct, folders_differ) {
        (0 | 1, _, _) => String::new(),
        (_, true, _) => labelled(run),
        (_, false, true) => folder(run),
        (_, false, false) => run.folder.display().to_string(),
    };
    runs.iter().map(name).collect()
}

impl Results {
    /// All names, that of the run which is subtracted last.
    fn names(&self) -> Vec<String> {
        names(&self.runs.iter().chain(&self.base).collect::<Vec<_>>())
    }

    /// One label per run: its name if there are several, and how it ended, if it failed.
    pub(super) fn labels(&self) -> Vec<String> {
        let name = |name: String| if self.runs.len() > 1 { name } else { String::new() };
        self.runs.iter().zip(self.names()).map(|(run, own)| joined(&name(own), &ending(run.ending))).collect()
    }

    /// Colours and marks of the runs, where each is of another method.
    pub(super) fn looks(&self) -> Option<Vec<(usize, Marker)>> {
        let methods: BTreeSet<&str> = self.runs.iter().map(|run| run.method.as_str()).collect();
        let names = self.runs.iter().map(|run| run.method.as_str());
        let looks = || method_colors(names.clone()).into_iter().zip(names.clone().map(method_mark)).collect();
        (self.runs.len() > 1 && methods.len() == self.runs.len()).then(looks)
    }

    /// The number of a run.
    pub(super) fn number_of(&self, run: &Run) -> Option<usize> {
        self.runs.iter().position(|own| std::ptr::eq(own, run))
    }

    /// A title: what the runs have in common, the quantity shown, and what is subtracted.
    pub(super) fn title(&self, what: &str) -> String {
        let name = self.runs.first().map_or("", |run| run.name.as_str());
        let one = self.runs.iter().chain(&self.base).all(|run| run.name == name);
        let title = if one { format!("{name}: {what}") } else { what.to_owned() };
        match (self.base.is_some(), self.names().as_slice()) {
            (true, [own, base]) => format!("{title}, {own} minus {base}"),
            (true, [.., base]) => format!("{title}, minus {base}"),
            _ => title,
        }
    }

    /// The label of an axis.
    pub(super) fn axis(&self, label: &str) -> String {
        if self.base.is_some() { format!("Δ {label}") } else { label.to_owned() }
    }
}

/// Joins words, without empty ones.
pub(super) fn joined(first: &str, second: &str) -> String {
    [first, second].into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join(", ")
}

/// How a run ended; empty if it reached its end.
fn ending(RunEnd { status, time }: RunEnd) -> String {
    let word = match status {
        Status::Completed => return String::new(),
        Status::Diverged => "diverged",
        Status::NotConverged => "not converged",
        Status::Interrupted => "interrupted",
    };
    format!("{word} at {} s", short(time))
}

/// A number with at most four significant digits.
fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    let everyday = rounded == 0.0 || (1e-3..1e5).contains(&rounded.abs());
    if everyday { format!("{rounded}") } else { format!("{rounded:e}") }
}
