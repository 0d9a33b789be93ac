//! Internal node numbers by reverse Cuthill-McKee (Cuthill & McKee 1969; George 1971), so that the ends of a spring are
//! close in memory whatever the numbering of the mesh.

use crate::mesh::adjacency::Adjacency;
use nalgebra::Vector3;

/// A renumbering and its inverse.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Numbering {
    /// user's number of every internal node
    pub user: Vec<u32>,
    /// internal number of every user's node
    pub internal: Vec<u32>,
}

impl Numbering {
    /// Numbers `n` nodes along the graph of `edges` (pairs may repeat).
    pub fn reverse_cuthill_mckee(n: usize, edges: impl Iterator<Item = [u32; 2]> + Clone) -> Self {
        let graph = Graph(Adjacency::of_edges(n, edges));
        let mut order: Vec<u32> = Vec::with_capacity(n);
        let mut seen = vec![false; n];
        let mut probe = (vec![false; n], Vec::new());
        let mut by_degree: Vec<u32> = (0..n as u32).collect();
        by_degree.sort_unstable_by_key(|&i| (graph.degree(i), i));
        for start in by_degree {
            if !seen[start as usize] {
                let start = graph.far_end(start, &mut probe);
                graph.walk(start, &mut seen, &mut order);
            }
        }
        order.reverse();
        let mut internal = vec![0; n];
        for (new, &old) in order.iter().enumerate() {
            internal[old as usize] = new as u32;
        }
        Numbering { user: order, internal }
    }

    /// Copies vectors of nodes to the user's order. Writes are sequential, as the destination is often not in cache.
    pub fn to_user(&self, internal: &[Vector3<f64>], user: &mut [[f64; 3]]) {
        for (to, &from) in user.iter_mut().zip(&self.internal) {
            *to = internal[from as usize].into();
        }
    }
}

/// Breadth-first orders of a graph's components.
struct Graph(Adjacency);

impl Graph {
    fn degree(&self, i: u32) -> usize {
        self.0.row(i).len()
    }

    /// Appends the component of `start` in breadth-first order, neighbours by degree.
    fn walk(&self, start: u32, seen: &mut [bool], order: &mut Vec<u32>) {
        let mut at = order.len();
        seen[start as usize] = true;
        order.push(start);
        while let Some(&node) = order.get(at) {
            at += 1;
            let first = order.len();
            for &next in self.0.row(node) {
                if !std::mem::replace(&mut seen[next as usize], true) {
                    order.push(next);
                }
            }
            order[first..].sort_unstable_by_key(|&i| (self.degree(i), i));
        }
    }

    /// A node far from `start` in its component: the last in breadth-first order. `probe` is a buffer; only entries of
    /// this component change.
    fn far_end(&self, start: u32, (seen, order): &mut (Vec<bool>, Vec<u32>)) -> u32 {
        order.clear();
        self.walk(start, seen, order);
        order.last().copied().unwrap_or(start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bandwidth(numbering: &Numbering, edges: &[[u32; 2]]) -> u32 {
        let number = |i: u32| numbering.internal[i as usize];
        edges.iter().map(|&[a, b]| number(a).abs_diff(number(b))).max().unwrap_or(0)
    }

    #[test]
    fn a_shuffled_chain_becomes_a_chain_again() {
        let n = 101u32;
        let shuffled = |i: u32| i * 37 % n;
        let edges: Vec<_> = (0..n - 1).map(|i| [shuffled(i), shuffled(i + 1)]).collect();
        let numbering = Numbering::reverse_cuthill_mckee(n as usize, edges.iter().copied());
        assert_eq!(bandwidth(&numbering, &edges), 1);
    }

    #[test]
    fn it_is_a_permutation_of_all_components() {
        let numbering = Numbering::reverse_cuthill_mckee(7, [[0, 6], [1, 5], [5, 0]].into_iter());
        let mut sorted = numbering.user.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..7).collect::<Vec<_>>());
        for (new, &old) in numbering.user.iter().enumerate() {
            assert_eq!(numbering.internal[old as usize] as usize, new);
        }
    }
}
