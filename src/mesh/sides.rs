//! The triangles at every edge.

use super::tuples::ascending;

/// The triangles' edges (each once, sorted by its nodes) and the triangles at each of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Sides {
    /// smaller node, larger node; ascending
    pub nodes: Vec<[u32; 2]>,
    /// where the edges of each smaller node start in `nodes`, with the end of the last
    of_node: Vec<u32>,
    /// where each edge's triangles start in `triangles`; one more entry than edges
    pub start: Vec<u32>,
    /// triangles by edge, ascending within an edge
    pub triangles: Vec<u32>,
    /// the edges 0-1, 1-2, 2-0 of every triangle
    pub of_triangle: Vec<[u32; 3]>,
}

impl Sides {
    pub(super) fn new(triangles: &[[u32; 3]]) -> Self {
        let mut keys = Vec::with_capacity(3 * triangles.len());
        for corners in triangles {
            keys.extend((0..3).map(|side| edge_key(corners[side], corners[(side + 1) % 3])));
        }
        let mut sides = Self { of_triangle: vec![[0; 3]; triangles.len()], ..Self::default() };
        for (i, number) in (0..).zip(ascending(&keys)) {
            let key = keys[number as usize];
            if sides.nodes.last() != Some(&key) {
                sides.nodes.push(key);
                sides.start.push(i);
            }
            sides.triangles.push(number / 3);
            sides.of_triangle[number as usize / 3][number as usize % 3] = sides.nodes.len() as u32 - 1;
        }
        sides.start.push(keys.len() as u32);
        for (edge, [node, _]) in (0..).zip(&sides.nodes) {
            let missing = (*node as usize + 1).saturating_sub(sides.of_node.len());
            sides.of_node.extend(std::iter::repeat_n(edge, missing));
        }
        sides.of_node.push(sides.nodes.len() as u32);
        sides
    }

    /// Triangles at an edge.
    pub(crate) fn at(&self, edge: usize) -> &[u32] {
        &self.triangles[self.start[edge] as usize..self.start[edge + 1] as usize]
    }

    /// The edge between two nodes, if it is a triangle's.
    pub(crate) fn find(&self, pair: [u32; 2]) -> Option<usize> {
        let key = edge_key(pair[0], pair[1]);
        let [from, to] = [0, 1].map(|next| self.of_node.get(key[0] as usize + next).map(|edge| *edge as usize));
        let (from, to) = (from?, to?);
        self.nodes.get(from..to)?.binary_search(&key).ok().map(|at| from + at)
    }
}

fn edge_key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
