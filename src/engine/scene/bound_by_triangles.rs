//! A bound on edges whose blocks c I are alike in all directions, such as relative dashpots: the sum of [c, -c; -c, c]
//! is a Laplacian of their graph, and its triangles hold it closer than single edges do.
//!
//! The Laplacian L of a triangle lies below s G for any positive diagonal G, where s is the largest eigenvalue of
//! G^-1/2 L G^-1/2. G has the sums of c at the nodes, times their shares. With equal c and shares s is 3/2; of a single
//! edge it is 2. Edges are divided equally among their triangles.

use crate::mesh::adjacency::row_starts;

/// Edges with both ends free, by triangles.
#[derive(Clone, Debug, Default)]
pub(super) struct AlikeEdges {
    edges: Vec<Edge>,
    triangles: Vec<Triangle>,
    /// whether all edges are there
    complete: bool,
}

#[derive(Clone, Copy, Debug)]
struct Edge {
    /// the smaller one first
    nodes: [u32; 2],
    c: f64,
    /// number of triangles
    triangles: f64,
}

#[derive(Clone, Copy, Debug)]
struct Triangle {
    /// ascending
    nodes: [u32; 3],
    /// edges i-j, i-k and j-k
    edges: [usize; 3],
}

impl AlikeEdges {
    /// Takes an edge with the block c I, unless all are there. One with c below 0, as of a hinge, lies below 0.
    pub(super) fn push(&mut self, [a, b]: [u32; 2], c: f64) {
        if !self.complete && c > 0.0 {
            self.edges.push(Edge { nodes: [a.min(b), a.max(b)], c, triangles: 0.0 });
        }
    }

    /// Calls `add(node, value)` with the parts of a diagonal matrix above the sum of the edges. Every node has a share.
    pub(super) fn bound(&mut self, share: &[f64], mut add: impl FnMut(u32, f64)) {
        if !std::mem::replace(&mut self.complete, true) {
            self.find_triangles(share.len());
        }
        for Triangle { nodes, edges } in &self.triangles {
            let [ij, ik, jk] = edges.map(|edge| self.edges[edge].c / self.edges[edge].triangles);
            let [i, j, k] = nodes.map(|node| share[node as usize]);
            let g = [(ij + ik) * i, (ij + jk) * j, (ik + jk) * k];
            // One eigenvalue is 0; the others follow from the trace and the sum of the minors.
            let trace = 1.0 / i + 1.0 / j + 1.0 / k;
            let minor = |share: f64, c: f64, ends: [f64; 2]| 1.0 / share - c * c / (ends[0] * ends[1]);
            let minors =
                minor(i * j, ij, [g[0], g[1]]) + minor(i * k, ik, [g[0], g[2]]) + minor(j * k, jk, [g[1], g[2]]);
            let s = 0.5 * (trace + (trace * trace - 4.0 * minors).max(0.0).sqrt());
            nodes.iter().zip(g).for_each(|(node, g)| add(*node, s * g));
        }
        for Edge { nodes, c, .. } in self.edges.iter().filter(|edge| edge.triangles == 0.0) {
            let [a, b] = nodes.map(|node| share[node as usize]);
            add(nodes[0], (1.0 + a / b) * c);
            add(nodes[1], (1.0 + b / a) * c);
        }
    }

    /// Merges edges between the same nodes, and finds where the neighbours of both ends of an edge meet.
    fn find_triangles(&mut self, n: usize) {
        self.edges.sort_unstable_by_key(|edge| edge.nodes);
        self.edges.dedup_by(|next, kept| {
            let same = next.nodes == kept.nodes;
            kept.c += if same { next.c } else { 0.0 };
            same
        });
        let start = row_starts(n, self.edges.iter().map(|edge| edge.nodes[0]));
        let row = |node: u32| start[node as usize] as usize..start[node as usize + 1] as usize;
        for ij in 0..self.edges.len() {
            let [i, j] = self.edges[ij].nodes;
            let (mut of_i, mut of_j) = (ij + 1..row(i).end, row(j));
            while !of_i.is_empty() && !of_j.is_empty() {
                let [k, other] = [of_i.start, of_j.start].map(|edge| self.edges[edge].nodes[1]);
                if k == other {
                    let edges = [ij, of_i.start, of_j.start];
                    edges.into_iter().for_each(|edge| self.edges[edge].triangles += 1.0);
                    self.triangles.push(Triangle { nodes: [i, j, k], edges });
                }
                of_i.start += usize::from(k <= other);
                of_j.start += usize::from(other <= k);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    fn bound(edges: &[([u32; 2], f64)], share: &[f64]) -> Vec<f64> {
        let mut alike = AlikeEdges::default();
        edges.iter().for_each(|&(nodes, c)| alike.push(nodes, c));
        let mut diagonal = vec![0.0; share.len()];
        alike.bound(share, |node, value| diagonal[node as usize] += value);
        diagonal
    }

    /// D - L has no negative eigenvalue, whatever the edges and shares are: some edges are in no triangle, some in
    /// several, some there twice.
    #[test]
    fn the_diagonal_lies_above_the_sum() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1_u32 << 31)
        };
        for n in [3_u32, 4, 6, 9] {
            for density in [0.3, 0.6, 1.0] {
                let pairs = (0..n).flat_map(|a| (0..n).filter(move |&b| b != a).map(move |b| [a, b]));
                let mut edges: Vec<([u32; 2], f64)> = pairs.map(|pair| (pair, 0.1 + random())).collect();
                edges.retain(|_| random() < density);
                let share: Vec<f64> = (0..n).map(|_| 0.5 + random()).collect();
                let diagonal = bound(&edges, &share);
                let n = n as usize;
                let mut rest = DMatrix::from_fn(n, n, |i, j| if i == j { diagonal[i] } else { 0.0 });
                for &([a, b], c) in &edges {
                    let [a, b] = [a as usize, b as usize];
                    rest[(a, a)] -= c;
                    rest[(b, b)] -= c;
                    rest[(a, b)] += c;
                    rest[(b, a)] += c;
                }
                let least = rest.symmetric_eigenvalues().min();
                assert!(least > -1e-12, "{n} nodes, {density}: {least}");
            }
        }
    }

    /// Six equal triangles around a node, each spoke in two of them: 9 c, the largest eigenvalue of an endless net.
    #[test]
    fn a_triangular_net_has_its_own_eigenvalue() {
        let spokes = (1..=6).map(|i| ([0, i], 2.0));
        // The rim belongs to one of these triangles each, so half of its c is given here.
        let rim = (1..=6).map(|i| ([i, i % 6 + 1], 1.0));
        let diagonal = bound(&spokes.chain(rim).collect::<Vec<_>>(), &[1.0; 7]);
        assert!((diagonal[0] / 18.0 - 1.0).abs() < 1e-7, "{diagonal:?}");
    }
}
