//! The triangles, lines and lone nodes that a name stands for.

use super::{Geometry, Scene};
use crate::case::diagnostics::{Faults, did_you_mean, one_of};
use crate::case::pointer::Pointer;
use crate::mesh::{EdgeKind, Group};
use crate::model::spec::ContactParts;
use std::collections::BTreeSet;

/// The name of everything.
const ALL: &str = "all";

/// All triangles, all edges with a spring that are no side of one, all nodes that are in neither.
pub(super) fn all(Scene { geometry, has_spring, .. }: &Scene<'_>) -> ContactParts {
    let mesh = &geometry.mesh;
    let triangles: Vec<u32> = (0_u32..).take(mesh.triangles.len()).collect();
    let lines = (0_u32..).take(mesh.edges.len());
    let is_line = |edge: &u32| geometry.topology.edge_kind(*edge as usize) == EdgeKind::Line && has_spring(*edge);
    let edges: Vec<u32> = lines.filter(is_line).collect();
    let mut lone = vec![true; mesh.nodes.len()];
    let ends = edges.iter().filter_map(|edge| mesh.edges.get(*edge as usize)).flatten();
    mesh.triangles.as_flattened().iter().chain(ends).for_each(|node| lone[*node as usize] = false);
    let nodes = (0_u32..).zip(lone).filter(|(_, lone)| *lone).map(|(node, _)| node).collect();
    ContactParts { triangles, edges, nodes }
}

/// The parts of a group, or all; a name that no group has is a fault.
pub(super) fn named(at: &Pointer, name: &str, scene: &Scene<'_>, faults: &mut Faults<'_>) -> Option<ContactParts> {
    if name == ALL {
        return Some(all(scene));
    }
    let geometry = scene.geometry;
    let groups = &geometry.mesh.groups;
    if let Some(group) = groups.get(name) {
        return Some(of_group(group, geometry));
    }
    let names: Vec<&str> = [ALL].into_iter().chain(groups.keys().map(String::as_str)).collect();
    let hint = match name {
        "self" => Some("contact of everything with itself is the plain word: \"between\": \"self\"".to_owned()),
        _ => did_you_mean(name, names.iter().copied()),
    };
    let none = if groups.is_empty() { "; this mesh has no groups" } else { "" };
    faults.add_hint(at, one_of("known names here", &names) + none, hint.unwrap_or_default());
    None
}

fn of_group(group: &Group, geometry: &Geometry) -> ContactParts {
    let mesh = &geometry.mesh;
    let triangles = group.triangles.clone();
    let side = |edge: &u32| {
        let beside = geometry.topology.edge_triangles(*edge as usize);
        beside.iter().any(|triangle| triangles.binary_search(triangle).is_ok())
    };
    let edges: Vec<u32> = group.edges.iter().copied().filter(|edge| !side(edge)).collect();
    let corners = triangles.iter().filter_map(|t| mesh.triangles.get(*t as usize)).flatten();
    let ends = edges.iter().filter_map(|edge| mesh.edges.get(*edge as usize)).flatten();
    let used: BTreeSet<u32> = corners.chain(ends).copied().collect();
    let nodes = group.nodes.iter().copied().filter(|node| !used.contains(node)).collect();
    ContactParts { triangles, edges, nodes }
}

/// All nodes of some parts, ascending.
pub(super) fn nodes_of(parts: &ContactParts, geometry: &Geometry) -> BTreeSet<u32> {
    let mesh = &geometry.mesh;
    let corners = parts.triangles.iter().filter_map(|t| mesh.triangles.get(*t as usize)).flatten();
    let ends = parts.edges.iter().filter_map(|edge| mesh.edges.get(*edge as usize)).flatten();
    corners.chain(ends).chain(&parts.nodes).copied().collect()
}

/// [m] Lengths of the edges and of the sides of the triangles at the start.
pub(super) fn edge_lengths<'a>(parts: &'a ContactParts, scene: &'a Scene<'_>) -> impl Iterator<Item = f64> + 'a {
    let mesh = &scene.geometry.mesh;
    let corners = parts.triangles.iter().filter_map(|t| mesh.triangles.get(*t as usize));
    let sides = corners.flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let lines = parts.edges.iter().filter_map(|edge| mesh.edges.get(*edge as usize)).copied();
    sides.chain(lines).map(|[a, b]| (scene.start(a) - scene.start(b)).norm())
}
