//! The triangles at every edge.

use super::tuples::in_order;

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
        let (count, mut number_of_sides) = (3 * triangles.len(), 0);
        let mut sides = Self {
            nodes: Vec::with_capacity(count / 2),
            start: Vec::with_capacity(count / 2),
            triangles: Vec::with_capacity(count),
            of_triangle: vec![[0; 3]; triangles.len()],
            ..Self::default()
        };
        in_order(sides_of(triangles), |key, number| {
            if sides.nodes.last() != Some(&key) {
                sides.nodes.push(key);
                sides.start.push(sides.triangles.len() as u32);
                number_of_sides += 1;
            }
            sides.triangles.push(number / 3);
            sides.of_triangle[number as usize / 3][number as usize % 3] = number_of_sides - 1;
        });
        sides.start.push(count as u32);
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

    /// For every edge of a mesh its number here, or [`NOT_A_SIDE`].
    pub(super) fn of_edges(&self, edges: &[[u32; 2]]) -> Vec<u32> {
        let mut next = 0;
        let number = |&[a, b]: &[u32; 2]| {
            // Edges are mostly in the same order.
            let side = if self.nodes.get(next) == Some(&edge_key(a, b)) { Some(next) } else { self.find([a, b]) };
            next = side.map_or(next, |side| side + 1);
            side.map_or(NOT_A_SIDE, |side| side as u32)
        };
        edges.iter().map(number).collect()
    }

    /// Whether two triangles have the same nodes, or two edges of a mesh, given as [`Sides::of_edges`] does, are one.
    pub(super) fn has_repeats(&self, triangles: &[[u32; 3]], of_edges: &[u32]) -> bool {
        let mut seen = vec![false; self.nodes.len()];
        let sides = of_edges.iter().filter(|side| **side != NOT_A_SIDE);
        if sides.into_iter().any(|side| std::mem::replace(&mut seen[*side as usize], true)) {
            return true;
        }
        // Two such triangles have all their edges in common; several at an edge are compared by the node beyond it.
        let mut beyond = Vec::new();
        (0..self.nodes.len()).filter(|edge| self.at(*edge).len() > 1).any(|edge| {
            let [a, b] = self.nodes[edge];
            let node = |t: &u32| triangles[*t as usize].into_iter().fold(a ^ b, |all, node| all ^ node);
            beyond.clear();
            beyond.extend(self.at(edge).iter().map(node));
            beyond.sort_unstable();
            beyond.windows(2).any(|pair| pair[0] == pair[1])
        })
    }

    /// The edge between two nodes, if it is a triangle's.
    pub(crate) fn find(&self, pair: [u32; 2]) -> Option<usize> {
        let key = edge_key(pair[0], pair[1]);
        let [from, to] = [0, 1].map(|next| self.of_node.get(key[0] as usize + next).map(|edge| *edge as usize));
        let (from, to) = (from?, to?);
        self.nodes.get(from..to)?.binary_search(&key).ok().map(|at| from + at)
    }
}

/// Number of an edge that no triangle has.
pub(super) const NOT_A_SIDE: u32 = u32::MAX;

/// The edges 0-1, 1-2, 2-0 of triangle after triangle, the smaller node first.
pub(super) fn sides_of(triangles: &[[u32; 3]]) -> impl Iterator<Item = [u32; 2]> + Clone {
    triangles.iter().flat_map(|&[a, b, c]| [edge_key(a, b), edge_key(b, c), edge_key(c, a)])
}

/// All edges of some triangles, each once, the smaller node first, in ascending order.
pub(super) fn unique_edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut edges = Vec::with_capacity(triangles.len() + triangles.len() / 2);
    in_order(sides_of(triangles), |edge, _| {
        if edges.last() != Some(&edge) {
            edges.push(edge);
        }
    });
    edges
}

/// The keys of some edges, ascending.
pub(super) fn edge_keys(edges: &[[usize; 2]]) -> Vec<[u32; 2]> {
    let mut keys: Vec<[u32; 2]> = edges.iter().map(|&[a, b]| edge_key(a as u32, b as u32)).collect();
    keys.sort_unstable();
    keys
}

fn edge_key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
