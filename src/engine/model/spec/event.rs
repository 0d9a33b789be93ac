//! Events: what happens once in a run, at a time, by the state of the scene, or after another event.

use crate::format_number::figures;
use serde::Serialize;
use std::fmt;

/// Something that happens once in a run. Releases, cuts and stages refer to it by its place in
/// [`NetworkSpec::events`](super::NetworkSpec::events).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EventSpec {
    /// its name, by which other events refer to it
    pub name: String,
    /// what happens, in words
    #[serde(skip)]
    pub what: String,
    /// what the stage of a run is called that begins there; none does at an event that is only told, where a single
    /// spring breaks, nor at the end of a flight
    #[serde(skip)]
    pub stage: Option<String>,
    /// when it happens
    pub trigger: Trigger,
    /// what is looked at: its place and speed are those of this in reports too
    pub of: Watched,
    /// whether a run that [looks for its end](crate::drive::RunSpec::ends_by_event) ends there
    pub ends_run: bool,
}

/// When an event happens.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Trigger {
    /// [s] at a time; a step ends there
    At(f64),
    /// [s] at a time that tables and supports have too: it is only told
    Told(f64),
    /// once a condition holds, at the start of the run or later
    When(Condition),
    /// some time after another event
    After {
        /// place of the other one
        event: usize,
        /// [s] 0 or more
        delay: f64,
    },
}

/// A condition on the nodes or springs that an event looks at. It holds at its limit, too.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Condition {
    /// [m] z is at most this
    HeightBelow(f64),
    /// [m] z is at least this
    HeightAbove(f64),
    /// [m/s] the speed is at most this
    SpeedBelow(f64),
    /// [m/s] the speed is at least this
    SpeedAbove(f64),
    /// [Pa] the dynamic pressure of the speed against the air is at most this
    PressureBelow(f64),
    /// [Pa] the dynamic pressure of the speed against the air is at least this
    PressureAbove(f64),
    /// [N] the largest tension, with that of the dashpots, is at least this
    TensionAbove(f64),
    /// the vertical velocity is 0 or downward
    Descending,
}

/// What an event looks at.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Watched {
    /// the mean of nodes, each with its share; the shares sum to 1
    Nodes(Vec<(u32, f64)>),
    /// springs on these edges, ascending, of one group or of all
    Springs {
        /// edges of the mesh
        edges: Vec<u32>,
        /// place of the group in [`NetworkSpec::springs`](super::NetworkSpec::springs)
        group: Option<usize>,
    },
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, limit, unit) = match *self {
            Condition::HeightBelow(limit) => ("a height below", limit, "m"),
            Condition::HeightAbove(limit) => ("a height above", limit, "m"),
            Condition::SpeedBelow(limit) => ("a speed below", limit, "m/s"),
            Condition::SpeedAbove(limit) => ("a speed above", limit, "m/s"),
            Condition::PressureBelow(limit) => ("a dynamic pressure below", limit, "Pa"),
            Condition::PressureAbove(limit) => ("a dynamic pressure above", limit, "Pa"),
            Condition::TensionAbove(limit) => ("a tension above", limit, "N"),
            Condition::Descending => return f.write_str("a descent"),
        };
        write!(f, "{what} {} {unit}", figures(limit, 6))
    }
}

impl EventSpec {
    /// When it happens, in words; `all` are the events that it is one of.
    pub fn moment(&self, all: &[EventSpec]) -> String {
        match &self.trigger {
            Trigger::At(t) | Trigger::Told(t) => format!("t = {} s", figures(*t, 6)),
            Trigger::When(condition) => condition.to_string(),
            Trigger::After { event, delay } => {
                let other = all.get(*event).map_or("another event", |other| &other.name);
                format!("{} s after {other}", figures(*delay, 6))
            }
        }
    }

    /// Whether steps must end at it.
    pub fn acts(&self) -> bool {
        !matches!(self.trigger, Trigger::Told(_))
    }

    /// The edges whose springs it looks at; none if it looks at nodes.
    pub fn edges(&self) -> &[u32] {
        match &self.of {
            Watched::Springs { edges, .. } => edges,
            Watched::Nodes(_) => &[],
        }
    }
}
