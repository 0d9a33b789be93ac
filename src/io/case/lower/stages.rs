//! The stages of a run that are known before it: they begin at the start, where canopies begin to fill, where reefing
//! lines and other springs are cut, and where supports let go.

use super::events::PAYLOAD;
use super::geometry::Geometry;
use crate::case::schema::{EdgeSelection, Network};
use crate::case::spec::{StageStart, StagesSpec};
use crate::model::spec::{CanopyAir, NetworkSpec};

/// What names of groups of reefing lines begin with.
const REEFING: &str = "reefing";

/// What happens at the start of a stage, the most telling first.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Begins {
    Disreef,
    Opening,
    Cut(String),
    Release,
}

/// The stages of a run to `end` [s].
pub(super) fn stages(network: &Network, spec: &NetworkSpec, geometry: Option<&Geometry>, end: f64) -> StagesSpec {
    let mut begins = fillings(spec);
    begins.extend(network.springs.iter().filter_map(|rule| Some((rule.cut.as_ref()?.last()?, cut(&rule.on)))));
    begins.extend(spec.releases.iter().map(|release| (release.t, Begins::Release)));
    begins.retain(|(t, _)| *t > 0.0 && *t < end);
    begins.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.cmp(&b.1)));
    // One stage a time.
    begins.dedup_by_key(|(t, _)| *t);
    let mut starts = vec![StageStart { t: 0.0, name: first(spec).to_owned() }];
    let mut counts = std::collections::BTreeMap::new();
    for (t, what) in begins {
        let count: &mut u32 = counts.entry(what.clone()).or_default();
        *count += 1;
        let name = match what {
            Begins::Disreef => format!("disreef {count}"),
            Begins::Opening if *count == 1 => "opening".to_owned(),
            Begins::Opening => format!("opening {count}"),
            Begins::Cut(name) => name,
            Begins::Release => format!("release {count}"),
        };
        starts.push(StageStart { t, name });
    }
    let events = spec.events.iter().any(|event| event.stage.is_some());
    let landing = spec.events.iter().any(|event| event.ends_run);
    StagesSpec { starts, events, payload: payload(spec, geometry), landing }
}

/// [s] Where canopies begin to fill, and where the next stages of their drag areas begin.
fn fillings(spec: &NetworkSpec) -> Vec<(f64, Begins)> {
    let stages = spec.canopies.iter().flat_map(|canopy| canopy.air.stages().iter().enumerate());
    stages.map(|(number, stage)| (stage.start, if number == 0 { Begins::Opening } else { Begins::Disreef })).collect()
}

/// What the cut of these edges begins.
fn cut(on: &EdgeSelection) -> Begins {
    match on.group() {
        Some(name) if name.starts_with(REEFING) => Begins::Disreef,
        Some(name) => Begins::Cut(format!("cut of {name}")),
        None => Begins::Cut("cut".to_owned()),
    }
}

/// The name of the stage that begins where these edges are cut by an event.
pub(super) fn after_cut(on: &EdgeSelection) -> String {
    match cut(on) {
        Begins::Cut(name) => name,
        Begins::Disreef | Begins::Opening | Begins::Release => "disreef".to_owned(),
    }
}

/// The name of the first stage.
fn first(spec: &NetworkSpec) -> &'static str {
    let opens = |air: &CanopyAir| match air {
        CanopyAir::Filling(stages) | CanopyAir::Point(stages) => stages.first().is_none_or(|stage| stage.start <= 0.0),
        CanopyAir::Rings(_) => true,
        CanopyAir::Coefficient | CanopyAir::Cavity(_) => false,
    };
    let waits = |air: &CanopyAir| air.stages().first().is_some_and(|stage| stage.start > 0.0);
    match &spec.canopies[..] {
        canopies if canopies.iter().any(|canopy| opens(&canopy.air)) => "opening",
        canopies if canopies.iter().any(|canopy| waits(&canopy.air)) => "before line stretch",
        _ => "start",
    }
}

/// The nodes of the payload: those of its group, else those where the lines of the canopies meet.
fn payload(spec: &NetworkSpec, geometry: Option<&Geometry>) -> Vec<u32> {
    let group = geometry.and_then(|geometry| geometry.mesh.groups.get(PAYLOAD)).map(|group| &group.nodes);
    match group.filter(|nodes| !nodes.is_empty()) {
        Some(nodes) => nodes.clone(),
        None => spec.canopies.iter().flat_map(|canopy| canopy.confluence.iter().copied()).collect(),
    }
}
