//! Whether the payload still hangs on a canopy at the end of a run in which springs broke.

use super::event::Fired;
use crate::mesh::components::components;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// The break that has parted the payload from every canopy.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LostPayload {
    /// [s] when
    pub time: f64,
    /// the spring that broke last, by the name of its event
    pub last: String,
}

impl LostPayload {
    /// Of these nodes, after a run in which this happened. `None` where springs or cloth still join one of them to a
    /// triangle of a canopy, and where they were parted by something else than springs that break.
    pub fn find(scene: &dyn Scene, payload: &[u32], fired: &[Fired]) -> Option<Self> {
        let (events, whole) = (scene.events()?, scene.springs()?.whole_edges());
        let named = events.named();
        let breaks: Vec<&Fired> = fired.iter().filter(|one| events.breaks().contains(&one.event)).collect();
        let (edges, triangles) = (scene.edges(), scene.triangles());
        let ends = |edge: &u32| edges.get(*edge as usize).copied();
        let sides = || triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c]]);
        // With the first `broken` breaks only.
        let hangs = |broken: usize| {
            let later =
                breaks.iter().skip(broken).filter_map(|one| named.get(one.event)).flat_map(|event| event.edges());
            let joined = whole.iter().chain(later).filter_map(ends).chain(sides());
            let part = components(scene.reference().len(), joined);
            let part_of = |node: &u32| part.get(*node as usize);
            let cloth = triangles.as_flattened().iter().filter(|node| !payload.contains(node));
            let canopies: Vec<_> = cloth.filter_map(part_of).collect();
            payload.iter().filter_map(part_of).any(|own| canopies.contains(&own))
        };
        if breaks.is_empty() || triangles.is_empty() || hangs(breaks.len()) || !hangs(0) {
            return None;
        }
        // What hangs no more hangs no more after the next break either.
        let numbers: Vec<usize> = (1..=breaks.len()).collect();
        let last = breaks.get(numbers.partition_point(|&broken| hangs(broken)))?;
        Some(LostPayload { time: last.t, last: last.name.clone() })
    }
}
