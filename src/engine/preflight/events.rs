//! Events whose conditions hold at the start already, and those that open canopies of cloth.

use super::canopies::name;
use crate::format_number::figures;
use crate::model::spec::{CanopyAir, CanopySpec, Condition, EventSpec, NetworkSpec, Trigger, Watched};
use crate::warning::{Warning, WarningCode};
use std::fmt;

/// An event that happens at t = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct AtStart {
    /// its name
    pub name: String,
    /// what holds, in words
    pub condition: String,
    /// what is there at the start, in words
    pub found: String,
}

/// Finds events by height or speed, or that wait for a descent, whose conditions hold at the start.
pub fn at_start(spec: &NetworkSpec) -> Vec<AtStart> {
    spec.events.iter().filter_map(|event| holds(spec, event)).collect()
}

fn holds(spec: &NetworkSpec, event: &EventSpec) -> Option<AtStart> {
    let (Trigger::When(condition), Watched::Nodes(nodes)) = (&event.trigger, &event.of) else { return None };
    let mean = |of: &dyn Fn(usize) -> [f64; 3]| {
        nodes.iter().fold([0.0; 3], |sum, &(node, share)| {
            let own = of(node as usize);
            std::array::from_fn(|axis| sum[axis] + share * own[axis])
        })
    };
    let or_zero = |list: &[[f64; 3]], node: usize| list.get(node).copied().unwrap_or_default();
    let [_, _, z] = mean(&|node| {
        let (place, moved) = (or_zero(&spec.mesh.nodes, node), or_zero(&spec.displacement, node));
        std::array::from_fn(|axis| place[axis] + moved[axis])
    });
    let [vx, vy, vz] = mean(&|node| or_zero(&spec.velocity, node));
    let speed = vx.hypot(vy).hypot(vz);
    let met = match *condition {
        Condition::HeightBelow(limit) => z <= limit,
        Condition::HeightAbove(limit) => z >= limit,
        Condition::SpeedBelow(limit) => speed <= limit,
        Condition::SpeedAbove(limit) => speed >= limit,
        Condition::Descending => vz <= 0.0,
        Condition::PressureBelow(_) | Condition::PressureAbove(_) | Condition::TensionAbove(_) => false,
    };
    let [height, speed] = [z, speed].map(|number| figures(number, 5));
    met.then(|| AtStart {
        name: event.name.clone(),
        condition: condition.to_string(),
        found: format!("z = {height} m and {speed} m/s at the start"),
    })
}

impl fmt::Display for AtStart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let AtStart { name, condition, found } = self;
        write!(f, "the event \"{name}\" waits for {condition}, which holds with {found}, so it happens at t = 0")
    }
}

impl From<AtStart> for Warning {
    fn from(found: AtStart) -> Self {
        Warning::new(WarningCode::EventAtStart, found.to_string())
    }
}

/// A canopy of cloth that is free and has no pressure until an event.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SlackOpening {
    /// which one, in words
    pub canopy: String,
    /// name of the event
    pub event: String,
}

/// Finds canopies of cloth whose first stage waits for an event, and whose skirt no support holds until then.
pub fn slack_openings(spec: &NetworkSpec) -> Vec<SlackOpening> {
    let free = |node: &u32| spec.fixed.get(*node as usize).is_some_and(|fixed| *fixed == [false; 3]);
    let opens = |(i, canopy): (usize, &CanopySpec)| {
        let CanopyAir::Filling(stages) = &canopy.air else { return None };
        let event = spec.events.get(stages.first()?.event?)?.name.clone();
        canopy.skirt.iter().any(free).then(|| SlackOpening { canopy: name(spec, i), event })
    };
    spec.canopies.iter().enumerate().filter_map(opens).collect()
}

impl fmt::Display for SlackOpening {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SlackOpening { canopy, event } = self;
        write!(
            f,
            "{canopy} has no pressure before the event \"{event}\" opens it: it falls with slack lines, and when they snap taut, \
             Newton's iteration mostly stops; begin the run at line stretch, or take the network's \"model\": \"point\""
        )
    }
}

impl From<SlackOpening> for Warning {
    fn from(found: SlackOpening) -> Self {
        Warning::new(WarningCode::SlackOpening, found.to_string())
    }
}
