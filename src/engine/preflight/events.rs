//! Events whose conditions hold at the start already.

use crate::format_number::figures;
use crate::model::spec::{Condition, EventSpec, NetworkSpec, Trigger, Watched};
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
