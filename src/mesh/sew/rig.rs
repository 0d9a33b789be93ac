//! The groups of a canopy of sewn gores, and its lines.

use super::join::Joined;
use super::ring::Ring;
use super::{Seam, SewError};
use crate::{Group, Mesh, Topology, topology};
use nalgebra::Vector3;
use std::collections::BTreeSet;

/// [-] Least height of the confluence below the skirt over the length of the lines.
const LEAST_HEIGHT: f64 = 1e-3;

/// Names the parts of the canopy as those of a generated parachute, and adds lines from its seams.
///
/// # Errors
/// Lines that do not reach the axis.
pub(super) fn rig(mesh: &mut Mesh, seam: &Seam, ring: &Ring, joined: &Joined) -> Result<(), SewError> {
    let new = |nodes: &[u32]| -> Vec<u32> { nodes.iter().map(|node| joined.node[*node as usize]).collect() };
    let (top, bottom) = (new(&ring.top), new(&ring.bottom));
    let triangles: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    let cloth: BTreeSet<[u32; 2]> = topology::unique_edges(&mesh.triangles).into_iter().collect();
    let key = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let cloth = (0..).zip(&mesh.edges).filter(|(_, edge)| cloth.contains(&key(**edge))).map(|(number, _)| number);
    let cloth = Group::of_edges(cloth);
    name(mesh, "canopy", Group { triangles, ..Group::default() });
    name(mesh, "cloth", cloth);
    for (part, end) in [("skirt", &bottom), ("vent", &top)] {
        if let Some(group) = rim(mesh, end) {
            name(mesh, part, group);
        }
    }
    let apex: BTreeSet<u32> = top.iter().copied().collect();
    if apex.len() == 1 {
        name(mesh, "apex", Group::of_nodes(apex));
    }
    let Some(lines) = seam.lines else { return Ok(()) };
    let radius = bottom.iter().map(|node| mesh.point(*node).xy().norm()).fold(0.0, f64::max);
    let height = (lines.length * lines.length - radius * radius).sqrt();
    if height.is_nan() || height < LEAST_HEIGHT * lines.length {
        return Err(SewError::ShortLines { length: lines.length, radius });
    }
    let confluence = add_node(mesh, Vector3::new(0.0, 0.0, -height));
    let first = mesh.edges.len() as u32;
    for corner in bottom {
        let (from, to) = (mesh.point(corner), mesh.point(confluence));
        let mut before = corner;
        for i in 1..=lines.segments {
            let at = i as f64 / lines.segments as f64;
            let next = if i == lines.segments { confluence } else { add_node(mesh, from.lerp(&to, at)) };
            mesh.edges.push([before, next]);
            mesh.cut.iter_mut().for_each(|cut| cut.lengths.push(lines.length / lines.segments as f64));
            before = next;
        }
    }
    name(mesh, "lines", Group::of_edges(first..mesh.edges.len() as u32));
    name(mesh, "confluence", Group::of_nodes([confluence]));
    name(mesh, "payload", Group::of_nodes([confluence]));
    Ok(())
}

fn add_node(mesh: &mut Mesh, at: Vector3<f64>) -> u32 {
    mesh.nodes.push(at.into());
    mesh.nodes.len() as u32 - 1
}

/// Adds members to a group.
fn name(mesh: &mut Mesh, name: &str, more: Group) {
    let group = mesh.groups.entry(name.to_owned()).or_default();
    let lists =
        [(&mut group.nodes, more.nodes), (&mut group.edges, more.edges), (&mut group.triangles, more.triangles)];
    for (list, more) in lists {
        list.extend(more);
        list.sort_unstable();
        list.dedup();
    }
}

/// The edges and nodes of the boundary loop through the ends of seams; none at a pointed apex.
fn rim(mesh: &Mesh, ends: &[u32]) -> Option<Group> {
    let topology = Topology::new(mesh).ok()?;
    let around = topology.loops().iter().find(|one| ends.iter().all(|node| one.nodes.contains(node)))?;
    let next = around.nodes.iter().skip(1).chain(around.nodes.first());
    let sides: BTreeSet<[u32; 2]> = around.nodes.iter().zip(next).map(|(a, b)| [*a.min(b), *a.max(b)]).collect();
    let has = |edge: &[u32; 2]| sides.contains(&[edge[0].min(edge[1]), edge[0].max(edge[1])]);
    let edges = (0..).zip(&mesh.edges).filter(|(_, edge)| has(edge)).map(|(number, _)| number);
    let edges = Group::of_edges(edges).edges;
    Some(Group { nodes: Group::of_nodes(around.nodes.iter().copied()).nodes, edges, triangles: Vec::new() })
}
