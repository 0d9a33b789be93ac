//! How far a scene may reach: along paths of its springs and sheets at their rest lengths, however it is packed.

use crate::mesh::Mesh;
use crate::mesh::adjacency::Adjacency;
use crate::model::spec::{NetworkSpec, Series};

/// [-] Share of its longest path that a scene may be wide at least: paths along a square net are twice as long as the
/// distance of their ends.
const STRAIGHT: f64 = 0.5;

/// [m] Half the extent that the longest path allows. A part is searched from the node of it that is farthest from
/// another, as two searches find the longest path of a line or a tree.
pub(super) fn reach(spec: &NetworkSpec) -> f64 {
    let mesh = &spec.mesh;
    let mut lengths: Vec<f64> = mesh.edges.iter().map(|&ends| distance(mesh, ends)).collect();
    for group in &spec.springs {
        let largest = |scale: &Series<f64>| scale.value.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let most = group.rest_scale.as_ref().map_or(1.0, largest);
        for (rest, &edge) in group.rest_length.iter().zip(&group.edges) {
            lengths.get_mut(edge as usize).into_iter().for_each(|length| *length = most * rest);
        }
    }
    let n = mesh.nodes.len();
    let of_edges = (0..).zip(&mesh.edges).flat_map(|(edge, &[a, b])| [(a, edge), (b, edge)]);
    let of_triangles = (0..).zip(&mesh.triangles).flat_map(|(triangle, nodes)| nodes.map(|node| (node, triangle)));
    let (edges, triangles) = (Adjacency::new(n, of_edges), Adjacency::new(n, of_triangles));
    let graph = Graph { mesh, edges, triangles, lengths };
    let (mut seen, mut queue) = (vec![0; n], Vec::with_capacity(n));
    let mut longest: f64 = 0.0;
    for node in 0..n as u32 {
        if seen[node as usize] == 0 {
            let (far, _) = graph.farthest(node, (&mut seen, 1), &mut queue);
            longest = longest.max(graph.farthest(far, (&mut seen, 2), &mut queue).1);
        }
    }
    0.5 * STRAIGHT * longest
}

/// [m] Between two nodes.
fn distance(mesh: &Mesh, ends: [u32; 2]) -> f64 {
    let [a, b] = ends.map(|node| mesh.nodes[node as usize]);
    (0..3).map(|c| (b[c] - a[c]).powi(2)).sum::<f64>().sqrt()
}

struct Graph<'a> {
    mesh: &'a Mesh,
    /// edges at every node
    edges: Adjacency,
    /// triangles at every node
    triangles: Adjacency,
    /// [m] of every edge
    lengths: Vec<f64>,
}

impl Graph<'_> {
    /// The node at the end of the longest path with the fewest edges from a node, and the length of that path [m].
    fn farthest(&self, from: u32, (seen, mark): (&mut [u8], u8), queue: &mut Vec<(u32, f64)>) -> (u32, f64) {
        queue.clear();
        queue.push((from, 0.0));
        seen[from as usize] = mark;
        let (mut farthest, mut next) = ((from, 0.0), 0);
        while let Some(&(node, way)) = queue.get(next) {
            next += 1;
            if way > farthest.1 {
                farthest = (node, way);
            }
            let mut go = |other: u32, length: &dyn Fn() -> f64| {
                if seen[other as usize] < mark {
                    seen[other as usize] = mark;
                    queue.push((other, way + length()));
                }
            };
            for &edge in self.edges.row(node) {
                let [a, b] = self.mesh.edges[edge as usize];
                go(if a == node { b } else { a }, &|| self.lengths[edge as usize]);
            }
            for &triangle in self.triangles.row(node) {
                for other in self.mesh.triangles[triangle as usize] {
                    go(other, &|| distance(self.mesh, [node, other]));
                }
            }
        }
        farthest
    }
}
