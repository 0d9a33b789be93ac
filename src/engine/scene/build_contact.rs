//! Builds what may touch, with the stiffness of contact from masses and springs.
//!
//! ```text
//! kappa of a node = max(k/20, m |g|/g0)       with springs or membranes of the stiffness k at rest
//!                   m e/g0^2                  without,     e = max(|g| max(H, g0), v^2)
//! ```
//! with the extent H of what may touch, and the largest speed v at the start. So contact is softer than the springs of
//! what touches, and carries its weight; a lone mass that falls through the scene is stopped within the gap. No number
//! of the user's decides.

use super::build::Builder;
use crate::contact::bodies::{Body, Contact, Contacts, Other, Plane};
use crate::mesh::box_tree::Bounds;
use crate::model::spec::{ContactParts, ContactSide};
use nalgebra::Vector3;

/// [-] kappa over the stiffness of the springs at a node.
const SHARE: f64 = 0.05;
/// [m^2/s^2] e over the square of the extent of a scene in which nothing falls or moves.
const LEAST: f64 = 1.0;
/// [-] Skin over the mean length of edges, and at least over the gap.
const SKIN: f64 = 0.4;

/// The nodes of a scene, as contact needs them; in the scene's numbering.
pub(super) struct Nodes<'a> {
    /// [m] as built, and at the start
    pub reference: &'a [Vector3<f64>],
    pub start: &'a [Vector3<f64>],
    /// [kg]
    pub mass: &'a [f64],
    /// what is held for ever
    pub fixed: &'a [[bool; 3]],
    /// [m/s] empty if nothing moves
    pub velocity: &'a [[f64; 3]],
}

impl Builder<'_> {
    /// What may touch; `None` if nothing may.
    pub(super) fn contacts(&self, nodes: Nodes<'_>) -> Option<Contacts> {
        if self.spec.contacts.is_empty() {
            return None;
        }
        let Nodes { reference, mass, fixed, .. } = nodes;
        let inverse = |(m, fixed): (&f64, &[bool; 3])| if *fixed == [true; 3] { 0.0 } else { 1.0 / m };
        let inverse_mass = mass.iter().zip(fixed).map(inverse).collect();
        let mut contacts = Contacts { rest: reference.to_vec(), inverse_mass, ..Contacts::default() };
        for spec in &self.spec.contacts {
            let body = self.body(&spec.parts);
            let laws @ (gap, friction) = (spec.gap, spec.friction);
            let other = match &spec.other {
                ContactSide::Obstacle(obstacle) => {
                    contacts.add_obstacle(body, obstacle, laws);
                    continue;
                }
                ContactSide::Itself => Other::Itself,
                ContactSide::Parts(parts) => Other::Body(self.body(parts)),
            };
            contacts.list.push(Contact { body, other, thickness: 0.0, gap, friction, motion: None });
        }
        contacts.stiffness = self.contact_stiffness(&contacts, &nodes);
        contacts.skin = skin(&contacts, nodes.start);
        Some(contacts)
    }

    fn body(&self, parts: &ContactParts) -> Body {
        let mesh = &self.spec.mesh;
        let triangles = parts.triangles.iter().map(|&t| mesh.triangles[t as usize].map(|node| self.node(node)));
        let lines = parts.edges.iter().map(|&e| mesh.edges[e as usize].map(|node| self.node(node)));
        let points = parts.nodes.iter().map(|&node| self.node(node));
        Body::new(triangles.collect(), lines.collect(), points.collect())
    }

    /// [N/m] kappa of every node, by contact.
    fn contact_stiffness(&self, contacts: &Contacts, nodes: &Nodes<'_>) -> Vec<Vec<f64>> {
        let mut springs = vec![0.0; nodes.mass.len()];
        self.acting.terms.iter().for_each(|term| term.add_stiffness(&mut springs));
        let gravity = self.spec.gravity.map_or(0.0, |g| Vector3::from(g).norm());
        let speed = nodes.velocity.iter().map(|v| Vector3::from(*v).norm()).fold(0.0, f64::max);
        let extent = extent(contacts, nodes.start);
        let of_gap = |gap: f64| {
            let found = f64::max(gravity * extent.max(gap), speed * speed);
            let energy = if found > 0.0 { found } else { LEAST * extent * extent };
            let held = nodes.fixed.iter().map(|fixed| *fixed == [true; 3]);
            let of_node = |((k, m), held): ((&f64, &f64), bool)| match (held, *k > 0.0) {
                (true, _) => 0.0,
                (false, true) => f64::max(SHARE * k, m * gravity / gap),
                (false, false) => m * energy / (gap * gap),
            };
            springs.iter().zip(nodes.mass).zip(held).map(of_node).collect()
        };
        contacts.list.iter().map(|contact| of_gap(contact.gap)).collect()
    }
}

/// [m] The largest extent of what may touch, with obstacles and the heights above planes.
fn extent(contacts: &Contacts, start: &[Vector3<f64>]) -> f64 {
    let nodes = contacts.list.iter().flat_map(|contact| &contact.body.nodes).map(|node| start[*node as usize]);
    let all = Bounds::of(&nodes.chain(contacts.corners.iter().copied()).map(Into::into).collect::<Vec<[f64; 3]>>());
    let height = |contact: &Contact| match contact.other {
        Other::Plane(Plane { point, normal }) => {
            let nodes = contact.body.nodes.iter();
            nodes.map(|node| normal.dot(&(start[*node as usize] - point))).fold(0.0, f64::max)
        }
        _ => 0.0,
    };
    contacts.list.iter().map(height).fold(all.extent().max(0.0), f64::max)
}

/// [m] How far pairs beyond their gaps count as near.
fn skin(contacts: &Contacts, start: &[Vector3<f64>]) -> f64 {
    let gap = contacts.list.iter().map(|contact| contact.gap).fold(0.0, f64::max);
    let edges = || contacts.list.iter().flat_map(|contact| &contact.body.edges);
    let length: f64 = edges().map(|&[a, b]| (start[a as usize] - start[b as usize]).norm()).sum();
    let mean = if edges().next().is_some() { length / edges().count() as f64 } else { 0.0 };
    f64::max(gap, SKIN * mean)
}
