//! What may touch what: the parts of either side, the distance at which they begin to push, and rigid bodies.

mod inside;
mod obstacle;
mod parts;
mod surface;

use super::geometry::Geometry;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Between, Contact, TouchingSide};
use crate::model::spec::{ContactParts, ContactSide, ContactSpec, ObstacleSpec};
use crate::preflight::contact::counted_parts;
use nalgebra::Vector3;
use obstacle::obstacle;
use parts::{all, edge_lengths, named, nodes_of};
use std::path::Path;

/// [-] The gap over the shortest edge, if it is not given.
const GAP_OF_EDGE: f64 = 0.2;

/// The scene whose parts may touch something.
pub(super) struct Scene<'a> {
    /// its mesh
    pub geometry: &'a Geometry,
    /// the folder that names of files count from
    pub base: &'a Path,
    /// whether an edge has a spring
    pub has_spring: &'a dyn Fn(u32) -> bool,
    /// [m] displacement at the start, `[n_nodes][3]`; empty = none
    pub displacement: &'a [[f64; 3]],
    /// whether a node moves at any time
    pub moves: &'a dyn Fn(u32) -> bool,
}

impl Scene<'_> {
    /// [m] Where a node is at the start; not a number for one that the mesh does not have.
    fn start(&self, node: u32) -> Vector3<f64> {
        let of = |list: &[[f64; 3]]| list.get(node as usize).map(|x| Vector3::from(*x));
        let moved = of(self.displacement).unwrap_or_else(Vector3::zeros);
        of(&self.geometry.mesh.nodes).map_or(Vector3::repeat(f64::NAN), |x| x + moved)
    }
}

/// Checks and resolves the section.
pub(super) fn contacts(at: &Pointer, list: &[Contact], scene: &Scene<'_>, faults: &mut Faults<'_>) -> Vec<ContactSpec> {
    let mut found = Vec::new();
    for (i, contact) in list.iter().enumerate() {
        found.extend(one(&at.index(i), contact, scene, faults).map(|spec| (at.index(i), spec)));
    }
    // A body with a stand-in for one of its numbers is not where the user wants it.
    if faults.count() == 0 {
        found.iter().for_each(|(at, spec)| inside::at_start(at, spec, scene, faults));
    }
    found.into_iter().map(|(_, spec)| spec).collect()
}

fn one(at: &Pointer, contact: &Contact, scene: &Scene<'_>, faults: &mut Faults<'_>) -> Option<ContactSpec> {
    let between = at.key("between");
    let (parts, other) = match &contact.between {
        Between::Word(_) => (all(scene), ContactSide::Itself),
        Between::Pair(pair) => sides(&between, pair, scene, faults)?,
    };
    if let (ContactSide::Itself, 0 | 1) = (&other, count(&parts)) {
        let value = format!("only {}, which cannot touch itself", counted_parts(&parts));
        faults.add_value(&between, value, "at least two triangles, lines or nodes", None);
        return None;
    }
    let gap = match contact.gap {
        Some(gap) => gap,
        None => default_gap(&at.key("gap"), (&parts, &other), scene, faults)?,
    };
    Some(ContactSpec { parts, other, gap, friction: contact.friction.unwrap_or(0.0) })
}

/// The parts of a list of two, and what they may touch.
fn sides(
    at: &Pointer,
    [first, second]: &[TouchingSide; 2],
    scene: &Scene<'_>,
    faults: &mut Faults<'_>,
) -> Option<(ContactParts, ContactSide)> {
    let places = [at.index(0), at.index(1)];
    let own = match (first, second) {
        (TouchingSide::Named(name), _) => named(&places[0], name, scene, faults),
        (TouchingSide::Obstacle(_), TouchingSide::Obstacle(_)) => {
            let hint = "rigid bodies do not touch each other; name a group of the mesh, or \"all\", and then one body";
            faults.add_value(at, "two rigid bodies", "a part of the mesh and a rigid body", Some(hint.to_owned()));
            None
        }
        (TouchingSide::Obstacle(_), TouchingSide::Named(name)) => {
            let hint = format!("write it second: [\"{name}\", {{...}}]");
            let allowed = "the name of a group of the mesh, or \"all\"; a rigid body is the second of the two";
            faults.add_hint(&places[0], allowed, hint);
            None
        }
    };
    let other = match second {
        TouchingSide::Named(name) => named(&places[1], name, scene, faults).map(ContactSide::Parts),
        TouchingSide::Obstacle(body) => obstacle(&places[1], body, scene.base, faults).map(ContactSide::Obstacle),
    };
    let (own, other) = own.zip(other)?;
    let same = matches!(&other, ContactSide::Parts(parts) if *parts == own);
    Some((own, if same { ContactSide::Itself } else { other }))
}

/// Number of triangles, edges and nodes.
fn count(parts: &ContactParts) -> usize {
    parts.triangles.len() + parts.edges.len() + parts.nodes.len()
}

/// [m] The gap of a contact that gives none.
fn default_gap(
    at: &Pointer,
    (parts, other): (&ContactParts, &ContactSide),
    scene: &Scene<'_>,
    faults: &mut Faults<'_>,
) -> Option<f64> {
    let also = match other {
        ContactSide::Parts(parts) => Some(parts),
        ContactSide::Itself | ContactSide::Obstacle(_) => None,
    };
    let lengths = [Some(parts), also].into_iter().flatten().flat_map(|parts| edge_lengths(parts, scene));
    let gap = lengths.reduce(f64::min).map(|shortest| GAP_OF_EDGE * shortest);
    let value = match gap {
        Some(gap) if gap.is_normal() => return Some(gap),
        Some(_) => "(missing), and an edge without length at the start",
        None => "(missing), and lone nodes without an edge that could tell it",
    };
    faults.add_value(at, value, "the key \"gap\" is required here: a distance above 0, in metres", None);
    None
}

/// A rigid body as messages call it.
fn name_of(body: &ObstacleSpec) -> (&'static str, &'static str) {
    use crate::model::spec::ObstacleShape::{Box, Cylinder, Plane, Sphere, Surface};
    match body.shape {
        Plane { .. } => ("plane", "plane"),
        Sphere { .. } => ("sphere", "sphere"),
        Cylinder { .. } => ("cylinder", "cylinder"),
        Box { .. } => ("box", "box"),
        Surface { .. } => ("file", "closed surface"),
    }
}
