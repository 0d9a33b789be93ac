//! Events that wait for a state of the scene, and springs that break: what they look at, and how far their conditions
//! are from being met.

use super::acting::SpringBatch;
use super::network::{Network, by_node};
use super::numbering::Numbering;
use crate::mesh::adjacency::Adjacency;
use crate::model::abilities::{SpringPlace, Springs};
use crate::model::spec::{Condition, EventSpec, NetworkSpec, Trigger, Watched};
use crate::model::state::StateRef;
use nalgebra::Vector3;
use std::ops::Range;

/// The events of a scene besides those of its phases.
#[derive(Debug, Default)]
pub(super) struct Triggers {
    pub events: Vec<EventSpec>,
    /// which of them are that a spring breaks
    pub breaks: Range<usize>,
    /// what each of them looks at
    watched: Vec<Seen>,
}

/// What an event looks at, in internal numbers.
#[derive(Debug)]
enum Seen {
    Nodes(Vec<(u32, f64)>),
    Springs(Vec<SpringPlace>),
}

/// Number of events of a specification, springs that break included.
pub(super) fn count(spec: &NetworkSpec) -> usize {
    spec.events.len() + spec.springs.iter().map(|group| group.breaks.len()).sum::<usize>()
}

impl Triggers {
    /// Those of a specification; the events of springs that break come last, group after group.
    pub(super) fn new(spec: &NetworkSpec, numbering: &Numbering, springs: &[SpringBatch]) -> Self {
        let mut events = spec.events.clone();
        let groups = spec.springs.iter().filter(|group| !group.edges.is_empty()).enumerate();
        for (number, group) in groups {
            let name = group.strength.as_ref().map_or_else(|| format!("springs[{number}]"), |known| known.name.clone());
            for (&edge, &tension) in group.edges.iter().zip(&group.breaks) {
                events.push(EventSpec {
                    name: format!("{name}, edge {edge}"),
                    what: "a spring breaks".to_owned(),
                    stage: None,
                    trigger: Trigger::When(Condition::TensionAbove(tension)),
                    of: Watched::Springs { edges: vec![edge], group: Some(number) },
                    ends_run: false,
                });
            }
        }
        // Events may be as many as springs.
        let watches_springs = events.iter().any(|event| matches!(event.of, Watched::Springs { .. }));
        let placed = watches_springs.then(|| PlacedSprings::new(spec.mesh.edges.len(), springs));
        let seen = |event: &EventSpec| match &event.of {
            Watched::Nodes(nodes) => {
                let internal = nodes.iter().map(|&(node, share)| (numbering.internal[node as usize], share));
                Seen::Nodes(internal.collect())
            }
            Watched::Springs { edges, group } => {
                let of_group = |place: &SpringPlace| {
                    group.is_none_or(|group| springs[place.batch as usize].group as usize == group)
                };
                let found = placed.iter().flat_map(|placed| placed.on(edges));
                Seen::Springs(found.filter(of_group).collect())
            }
        };
        let watched = events.iter().map(seen).collect();
        Triggers { breaks: spec.events.len()..events.len(), events, watched }
    }
}

/// The places of springs by their edges.
struct PlacedSprings {
    places: Vec<SpringPlace>,
    /// those of every edge, by their numbers in `places`
    on_edge: Adjacency,
}

impl PlacedSprings {
    fn new(edges: usize, springs: &[SpringBatch]) -> Self {
        let all = || {
            (0_u32..).zip(springs).flat_map(|(batch, springs)| (0_u32..).zip(&*springs.edges).map(move |s| (batch, s)))
        };
        let places = all().map(|(batch, (number, _))| SpringPlace { batch, number }).collect();
        let on_edge = Adjacency::new(edges, (0..).zip(all()).map(|(place, (_, (_, &edge)))| (edge, place)));
        PlacedSprings { places, on_edge }
    }

    /// Springs on some edges, in the order of batches.
    fn on(&self, edges: &[u32]) -> Vec<SpringPlace> {
        let mut found: Vec<u32> = edges.iter().flat_map(|&edge| self.on_edge.row(edge)).copied().collect();
        found.sort_unstable();
        found.dedup();
        found.into_iter().map(|place| self.places[place as usize]).collect()
    }
}

impl Network {
    /// How far the condition of an event is from being met.
    pub(super) fn margin_of(&self, event: usize, at: StateRef<'_>) -> f64 {
        let (Some(spec), Some(seen)) = (self.built.triggers.events.get(event), self.built.triggers.watched.get(event))
        else {
            return f64::INFINITY;
        };
        let Trigger::When(condition) = spec.trigger else { return f64::INFINITY };
        let height = || self.mean(seen, at.x).z;
        let velocity = || self.mean(seen, at.v);
        match condition {
            Condition::HeightBelow(limit) => height() - limit,
            Condition::HeightAbove(limit) => limit - height(),
            Condition::SpeedBelow(limit) => velocity().norm() - limit,
            Condition::SpeedAbove(limit) => limit - velocity().norm(),
            Condition::PressureBelow(limit) => self.dynamic_pressure(at.t, height(), velocity()) - limit,
            Condition::PressureAbove(limit) => limit - self.dynamic_pressure(at.t, height(), velocity()),
            Condition::TensionAbove(limit) => limit - self.largest_tension(seen, at),
            Condition::Descending => velocity().z,
        }
    }

    /// [m, m/s] Place and velocity of what an event looks at.
    pub(super) fn place_of_event(&self, event: usize, at: StateRef<'_>) -> [[f64; 3]; 2] {
        let seen = self.built.triggers.watched.get(event);
        seen.map_or([[f64::NAN; 3]; 2], |seen| [at.x, at.v].map(|of| self.mean(seen, of).into()))
    }

    /// The mean over nodes, or over the ends of springs.
    fn mean(&self, seen: &Seen, of: &[f64]) -> Vector3<f64> {
        let of = by_node(of);
        match seen {
            Seen::Nodes(nodes) => nodes.iter().map(|&(node, share)| share * of[node as usize]).sum(),
            Seen::Springs(springs) => {
                let ends =
                    |place: &SpringPlace| self.acting.springs[place.batch as usize].data.nodes[place.number as usize];
                let all = springs.iter().flat_map(ends).map(|node| of[node as usize]);
                all.sum::<Vector3<f64>>() / (2 * springs.len()) as f64
            }
        }
    }

    /// [Pa] of a body at a height [m] with a velocity [m/s]; 0 without air.
    fn dynamic_pressure(&self, t: f64, height: f64, velocity: Vector3<f64>) -> f64 {
        self.acting.stream.as_ref().map_or(0.0, |stream| {
            let air = stream.at(t, height);
            0.5 * air.density[0] * (velocity - air.wind[0]).norm_squared()
        })
    }

    /// [N] The largest tension of springs, those that are cut included with 0.
    fn largest_tension(&self, seen: &Seen, at: StateRef<'_>) -> f64 {
        let Seen::Springs(springs) = seen else { return 0.0 };
        springs.iter().map(|&spring| self.spring_tension(at, spring)).fold(f64::NEG_INFINITY, f64::max)
    }
}
