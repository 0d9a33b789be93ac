//! Which tracks of which runs are drawn, in which colours, and along which direction.

use super::PlotError;
use super::label::{joined, labels};
use super::results::{Run, Track};
use super::view::{Direction, View};
use std::collections::BTreeSet;

/// Up to so many nodes of a single probe get a colour each.
const COLORS: usize = 7;

/// Tracks that share a colour and an entry of the legend.
pub(super) struct Group<'a> {
    /// whose they are
    pub run: &'a Run,
    /// entry of the legend
    pub label: String,
    /// at least one
    pub tracks: Vec<&'a Track>,
}

/// The tracks a view asks for: a group a run; of a single run, a group a probe, or a node where these are few.
///
/// # Errors
/// Probes or nodes that are not there.
pub(super) fn groups<'a>(runs: &'a [Run], view: &View) -> Result<Vec<Group<'a>>, PlotError> {
    let labels = labels(runs);
    let mut groups = Vec::new();
    for (run, label) in runs.iter().zip(labels) {
        let tracks = tracks(run, view)?;
        if runs.len() > 1 {
            groups.push(Group { run, label, tracks });
            continue;
        }
        let probes: BTreeSet<&str> = tracks.iter().map(|t| t.probe.as_str()).collect();
        let split = |key: &dyn Fn(&Track) -> String| {
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

/// What the tracks are, for a title: "node 1", or "inner", or nothing where they differ. A range of nodes is that of
/// every run.
pub(super) fn subject(groups: &[Group<'_>]) -> String {
    let all = || groups.iter().flat_map(|g| g.tracks.iter());
    let nodes: BTreeSet<u32> = all().map(|t| t.node).collect();
    let probes: BTreeSet<&str> = all().map(|t| t.probe.as_str()).collect();
    // A group a run, where there are several.
    let several = groups.first().is_some_and(|f| groups.iter().any(|g| !std::ptr::eq(g.run, f.run)));
    if several && groups.iter().any(|g| g.tracks.iter().map(|t| t.node).collect::<BTreeSet<_>>() != nodes) {
        return probes
            .first()
            .filter(|_| probes.len() == 1)
            .map_or_else(String::new, |probe| format!(" of \"{probe}\""));
    }
    match (nodes.len(), nodes.first(), nodes.last(), probes.first()) {
        (1, Some(node), _, _) => format!(" of node {node}"),
        (n, Some(first), Some(last), _) if (last - first) as usize == n - 1 => format!(" of nodes {first} to {last}"),
        (n, _, _, Some(probe)) if probes.len() == 1 => format!(" of \"{probe}\" ({n} nodes)"),
        _ => String::new(),
    }
}

fn tracks<'a>(run: &'a Run, view: &View) -> Result<Vec<&'a Track>, PlotError> {
    let folder = run.folder.display();
    if run.tracks.is_empty() {
        return Err(PlotError::NotThere(format!(
            "{folder}: no node was probed, so no motion can be plotted; add probes to the output section of the case"
        )));
    }
    let probed: BTreeSet<&str> = run.tracks.iter().map(|t| t.probe.as_str()).collect();
    if let Some(name) = view.probes.iter().find(|name| !probed.contains(name.as_str())) {
        let there = probed.into_iter().collect::<Vec<_>>().join(", ");
        return Err(PlotError::NotThere(format!("{folder}: no probe is called \"{name}\"; there are: {there}")));
    }
    let of_probes = run.tracks.iter().filter(|t| view.probes.is_empty() || view.probes.contains(&t.probe));
    let wanted: BTreeSet<u32> = view.nodes.iter().copied().collect();
    let chosen: Vec<&Track> = of_probes.filter(|t| wanted.is_empty() || wanted.contains(&t.node)).collect();
    let found: BTreeSet<u32> = chosen.iter().map(|t| t.node).collect();
    match wanted.difference(&found).next() {
        Some(node) => Err(PlotError::NotThere(format!("{folder}: node {node} was not probed"))),
        None => Ok(chosen),
    }
}

/// The direction the tracks move farthest along while their runs are sound.
pub(super) fn main_direction(groups: &[Group<'_>], view: &View) -> Direction {
    let directions = [Direction::X, Direction::Y, Direction::Z];
    let travel = |direction: Direction| {
        let c = direction.index();
        let of_track = |end: f64, track: &Track| {
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
