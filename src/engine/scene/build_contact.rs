//! Builds what may touch, with the stiffness of contact from masses and springs.
//!
//! kappa of a node is a twentieth of the stiffness of its springs and membranes at rest. A node without has m a/g0,
//! with the acceleration a of gravity, or that which stops its first speed within the gap, whichever is larger. So no
//! number of the user's decides how stiff contact is.

use super::build::Builder;
use crate::contact::bodies::{Body, Contact, Contacts, Other};
use crate::force::ForceTerm;
use crate::model::spec::{ContactParts, ContactSide};
use nalgebra::Vector3;

/// [-] kappa over the stiffness of the springs at a node.
const SHARE: f64 = 0.05;
/// [m/s^2] Acceleration that stands for that of a scene in which nothing falls or moves.
const LEAST: f64 = 1.0;
/// [-] Skin over the mean length of edges, and at least over the gap.
const SKIN: f64 = 0.25;

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
        self.acting.terms.iter().for_each(|term: &Box<dyn ForceTerm>| term.add_stiffness(&mut springs));
        let gravity = self.spec.gravity.map_or(0.0, |g| Vector3::from(g).norm());
        let speed = nodes.velocity.iter().map(|v| Vector3::from(*v).norm()).fold(0.0, f64::max);
        let of_gap = |gap: f64| {
            let acceleration = gravity.max(speed * speed / gap);
            let acceleration = if acceleration > 0.0 { acceleration } else { LEAST };
            let held = nodes.fixed.iter().map(|fixed| *fixed == [true; 3]);
            let of_node = |((k, m), held): ((&f64, &f64), bool)| match (held, *k > 0.0) {
                (true, _) => 0.0,
                (false, true) => SHARE * k,
                (false, false) => m * acceleration / gap,
            };
            springs.iter().zip(nodes.mass).zip(held).map(of_node).collect()
        };
        contacts.list.iter().map(|contact| of_gap(contact.gap)).collect()
    }
}

/// [m] How far pairs beyond their gaps count as near.
fn skin(contacts: &Contacts, start: &[Vector3<f64>]) -> f64 {
    let gap = contacts.list.iter().map(|contact| contact.gap).fold(0.0, f64::max);
    let edges = || contacts.list.iter().flat_map(|contact| &contact.body.edges);
    let length: f64 = edges().map(|&[a, b]| (start[a as usize] - start[b as usize]).norm()).sum();
    let mean = if edges().next().is_some() { length / edges().count() as f64 } else { 0.0 };
    f64::max(gap, SKIN * mean)
}
