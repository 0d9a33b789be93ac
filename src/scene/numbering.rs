//! Internal node numbers: reverse Cuthill-McKee (Cuthill & McKee 1969; George 1971), so that the ends of a spring lie
//! close in memory whatever order the mesh came in.

use glam::DVec3;

/// The two directions of a renumbering.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Numbering {
    /// user's number of every internal node
    pub user: Vec<u32>,
    /// internal number of every user's node
    pub internal: Vec<u32>,
}

impl Numbering {
    /// Numbers `n` nodes along the graph of `edges` (pairs may repeat).
    pub fn reverse_cuthill_mckee(n: usize, edges: impl Iterator<Item = [u32; 2]> + Clone) -> Self {
        let graph = Adjacency::new(n, edges);
        let mut order: Vec<u32> = Vec::with_capacity(n);
        let mut seen = vec![false; n];
        let mut probe = (vec![false; n], Vec::new());
        let mut by_degree: Vec<u32> = (0..n as u32).collect();
        by_degree.sort_unstable_by_key(|&i| (graph.of(i).len(), i));
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

    /// Vectors of nodes in the user's order; written one after the other, since what is written is often far away
    /// (another thread had it last).
    pub fn to_user(&self, internal: &[DVec3], user: &mut [[f64; 3]]) {
        for (to, &from) in user.iter_mut().zip(&self.internal) {
            *to = internal[from as usize].to_array();
        }
    }
}

struct Adjacency {
    start: Vec<u32>,
    neighbour: Vec<u32>,
}

impl Adjacency {
    fn new(n: usize, edges: impl Iterator<Item = [u32; 2]> + Clone) -> Self {
        let mut start = vec![0u32; n + 1];
        for [a, b] in edges.clone() {
            start[a as usize + 1] += 1;
            start[b as usize + 1] += 1;
        }
        for i in 0..n {
            start[i + 1] += start[i];
        }
        let mut next = start.clone();
        let mut neighbour = vec![0; start[n] as usize];
        for [a, b] in edges {
            for (from, to) in [(a, b), (b, a)] {
                neighbour[next[from as usize] as usize] = to;
                next[from as usize] += 1;
            }
        }
        Adjacency { start, neighbour }
    }

    fn of(&self, i: u32) -> &[u32] {
        &self.neighbour[self.start[i as usize] as usize..self.start[i as usize + 1] as usize]
    }

    /// Appends the component of `start` in breadth-first order, neighbours by degree.
    fn walk(&self, start: u32, seen: &mut [bool], order: &mut Vec<u32>) {
        let mut at = order.len();
        seen[start as usize] = true;
        order.push(start);
        while let Some(&node) = order.get(at) {
            at += 1;
            let first = order.len();
            for &next in self.of(node) {
                if !std::mem::replace(&mut seen[next as usize], true) {
                    order.push(next);
                }
            }
            order[first..].sort_unstable_by_key(|&i| (self.of(i).len(), i));
        }
    }

    /// A node far from `start` in its component: the last of a walk. `probe` is scratch, left as it was but for this
    /// component.
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
