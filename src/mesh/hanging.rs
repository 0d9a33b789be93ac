//! Nodes on the edge of a triangle that they do not belong to: the sheets on both sides are not joined there.

use super::box_tree::{Bounds, BoxTree};
use super::{Mesh, Topology};

/// [-] Distance over the length of an edge within which a node lies on it: mesh files round to few digits.
const WITHIN: f64 = 1e-4;

/// Boxes that the search may look at for each node and edge, in the mean: a heap of edges at one place ends it early.
const LOOKS: u64 = 400;

/// A node between the ends of an edge that only one triangle has, and that without the node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HangingNode {
    /// the node
    pub node: u32,
    /// ends of the edge, the smaller one first
    pub edge: [u32; 2],
    /// its triangle
    pub triangle: u32,
}

/// All hanging nodes, ascending, each with one edge. Nodes at an end of the edge are coincident nodes instead, and
/// nodes on edges of two triangles are on cloth that is joined there. O(n log n).
pub fn hanging_nodes(mesh: &Mesh, topology: &Topology) -> Vec<HangingNode> {
    let edges: Vec<([u32; 2], u32)> = topology.boundary_edges().collect();
    let length = |[a, b]: [u32; 2]| (mesh.point(a) - mesh.point(b)).norm();
    let around = |&(edge, _): &([u32; 2], u32)| {
        Bounds::of(edge.map(|node| &mesh.nodes[node as usize])).grown(WITHIN * length(edge))
    };
    let tree = BoxTree::new(&edges.iter().map(around).collect::<Vec<_>>());
    let lies_on = |node: u32, [a, b]: [u32; 2]| {
        let [start, along, to] = [mesh.point(a), mesh.point(b) - mesh.point(a), mesh.point(node) - mesh.point(a)];
        let length = along.norm();
        let place = to.dot(&along) / length;
        let inside = WITHIN * length < place && place < (1.0 - WITHIN) * length;
        inside && (mesh.point(node) - start - along * (place / length)).norm() < WITHIN * length
    };
    let mut looks = LOOKS * (mesh.nodes.len() + edges.len()) as u64;
    let mut found = Vec::new();
    for (node, x) in (0..).zip(&mesh.nodes) {
        let mut first = None;
        tree.within(&Bounds::of([x]), &mut looks, |number| {
            let (edge, triangle) = edges[number as usize];
            let belongs = mesh.triangles[triangle as usize].contains(&node);
            if !belongs && lies_on(node, edge) && first.is_none_or(|first| number < first) {
                first = Some(number);
            }
        });
        found.extend(first.map(|number| {
            let (edge, triangle) = edges[number as usize];
            HangingNode { node, edge, triangle }
        }));
    }
    found
}

/// A sentence about hanging nodes; `None` if there are none.
pub fn describe(found: &[HangingNode]) -> Option<String> {
    let &HangingNode { node, edge: [a, b], triangle } = found.first()?;
    let more = if found.len() > 1 { format!(" (the first of {} such nodes)", found.len()) } else { String::new() };
    Some(format!(
        "node {node} lies on the edge {a}-{b} of triangle {triangle}{more} and does not belong to it, so the cloth is open \
         there: split the triangle at the node, or give both sides the same nodes"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle above the x axis from 0 to 3, and two below it that meet in a node at (x, y).
    fn half_split(x: f64, y: f64) -> Mesh {
        let nodes = vec![[0.0; 3], [3.0, 0.0, 0.0], [x, y, 0.0], [1.0, -1.0, 0.0], [1.0, 2.0, 0.0]];
        let triangles = vec![[0, 1, 4], [0, 3, 2], [2, 3, 1]];
        Mesh { edges: crate::topology::unique_edges(&triangles), nodes, triangles, ..Mesh::default() }
    }

    fn of(mesh: &Mesh) -> Vec<HangingNode> {
        hanging_nodes(mesh, &Topology::new(mesh).expect("a mesh"))
    }

    #[test]
    fn a_node_on_an_edge_is_found() {
        let there = HangingNode { node: 2, edge: [0, 1], triangle: 0 };
        // On it, and beside it by less than a ten-thousandth of its 3 m.
        assert_eq!(of(&half_split(1.0, 0.0)), [there]);
        assert_eq!(of(&half_split(1.0, -2.9e-4)), [there]);
        assert_eq!(of(&half_split(1.0, -3.1e-4)), []);
        let text = describe(&of(&half_split(1.0, 0.0))).expect("a sentence");
        assert!(text.starts_with("node 2 lies on the edge 0-1 of triangle 0 and does not belong to it"), "{text}");
        assert_eq!(describe(&[]), None);
    }

    /// A thin triangle between the node and the edge closes the gap; a node at the end of an edge is a coincident one.
    #[test]
    fn joined_and_coincident_nodes_do_not_hang() {
        let mut closed = half_split(1.0, -1e-4);
        closed.triangles.push([0, 2, 1]);
        assert_eq!(of(&closed), []);
        assert_eq!(of(&half_split(2.9999, -1e-5)), []);
    }

    /// Halves of a square of unlike numbers of cells hang together at the nodes they have in common only.
    #[test]
    fn halves_that_do_not_fit_are_found_at_once() {
        let half = |n: u32, side: f64, first: u32| {
            let at = move |i: u32, j: u32| first + i * (n + 1) + j;
            let nodes = (0..=n).flat_map(move |i| (0..=n).map(move |j| [side * f64::from(i), f64::from(j), 0.0]));
            let nodes = nodes.map(move |[x, y, z]| [x / f64::from(n), y / f64::from(n), z]);
            let cells = (0..n).flat_map(move |i| (0..n).map(move |j| (i, j)));
            let cells = cells.flat_map(move |(i, j)| {
                [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
            });
            (nodes.collect::<Vec<_>>(), cells.collect::<Vec<_>>())
        };
        let ((mut nodes, mut triangles), (more, further)) = (half(20, 1.0, 0), half(30, -1.0, 441));
        nodes.extend(more);
        triangles.extend(further);
        let mesh = Mesh { edges: crate::topology::unique_edges(&triangles), nodes, triangles, ..Mesh::default() };
        // Of 19 and 29 nodes between the ends, nine are on both sides.
        assert_eq!(of(&mesh).len(), 19 - 9 + 29 - 9);
    }
}
