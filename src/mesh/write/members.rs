//! What the text formats write of edges and groups.

use crate::topology::unique_edges;
use crate::{Group, Mesh};

/// Edges that a format of faces and lines has to write: those of no triangle, and those of groups of edges.
pub(super) fn lines(mesh: &Mesh) -> Vec<u32> {
    let sides = unique_edges(&mesh.triangles);
    let mut listed = vec![false; mesh.edges.len()];
    for &edge in mesh.groups.values().flat_map(|group| &group.edges) {
        if let Some(listed) = listed.get_mut(edge as usize) {
            *listed = true;
        }
    }
    let lone = |[a, b]: [u32; 2]| sides.binary_search(&[a.min(b), a.max(b)]).is_err();
    let numbered = (0_u32..).zip(&mesh.edges);
    numbered.filter(|(edge, nodes)| listed[*edge as usize] || lone(**nodes)).map(|(edge, _)| edge).collect()
}

/// The groups of each of `count` members, by their positions among all groups.
pub(super) fn groups_of(mesh: &Mesh, count: usize, members: impl Fn(&Group) -> &[u32]) -> Vec<Vec<usize>> {
    let mut of = vec![Vec::new(); count];
    for (number, group) in mesh.groups.values().enumerate() {
        for member in members(group) {
            of.get_mut(*member as usize).into_iter().for_each(|list: &mut Vec<usize>| list.push(number));
        }
    }
    of
}
