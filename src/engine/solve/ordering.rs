//! Fill-reducing ordering of the unknowns.
//!
//! The graph of the *nodes* is ordered, not that of the degrees of freedom: it is nine times smaller and keeps the
//! three unknowns of a node together, as supernodes need. Up to [`AMD_LIMIT`] nodes the order is approximate minimum
//! degree (Amestoy, Davis & Duff 1996, from faer). Above, it is nested dissection (George 1973) along the node
//! coordinates; the separator is the part of one half that touches the other, and nodes with very many neighbours come
//! last. The elimination tree is then postordered (Liu 1990), because faer uses a given permutation as it is.

use crate::assembly::Pattern;
use crate::mesh::adjacency::Adjacency;
use crate::model::workers::{ALONE, Workers};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;
use std::sync::atomic::{AtomicU32, Ordering};

/// Nodes up to which minimum degree is as good as dissection and faster.
const AMD_LIMIT: usize = 2000;
/// Maximum number of nodes of a part that is not divided further.
const LEAF: usize = 24;
/// A node is dense if it has more neighbours than this times the root of the number of nodes, and more than [`FEW`].
/// Dense nodes are left out of the dissection and eliminated last (the rule of Amestoy, Davis & Duff 2004, Algorithm
/// 837). Otherwise all neighbours of a hub of lines on the other side of a cut would be in the separator.
const DENSE: f64 = 10.0;
/// [-] neighbours up to which no node is dense
const FEW: usize = 64;
/// Nodes of a part from which on its halves are worth a thread each.
const LARGE_PART: usize = 8192;
/// The separator in the other half is taken if it is smaller by this factor.
const MUCH_SMALLER: usize = 2;
const NONE: u32 = u32::MAX;

/// A permutation of the unknowns: `new_to_old[i]` is eliminated as number `i`.
#[derive(Clone, Debug, PartialEq)]
pub struct Permutation {
    /// old number of every new one
    pub new_to_old: Vec<u32>,
    /// new number of every old one
    pub old_to_new: Vec<u32>,
}

/// An ordering and what a factorisation in it costs, counted on the nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Elimination {
    /// the ordering
    pub order: Permutation,
    /// entries of L if every node had three unknowns; supernodes store some more
    pub nonzeros: f64,
    /// multiplications and additions of the factorisation
    pub operations: f64,
}

/// Orders the unknowns of a pattern, the same on any number of threads. `None` if the library reports a failure; the
/// caller then uses the library's default.
pub fn fill_reducing(pattern: &Pattern, workers: &Workers) -> Option<Elimination> {
    let graph = Graph::new(pattern);
    let order =
        if graph.len() <= AMD_LIMIT { graph.minimum_degree()? } else { graph.dissect(&pattern.position, workers) };
    let (order, [nonzeros, operations]) = graph.postorder(&order);
    let mut new_to_old = Vec::with_capacity(pattern.n());
    for node in order {
        new_to_old.extend(pattern.node_start[node as usize]..pattern.node_start[node as usize + 1]);
    }
    let old_to_new = invert(&new_to_old);
    Some(Elimination { order: Permutation { new_to_old, old_to_new }, nonzeros, operations })
}

fn invert(order: &[u32]) -> Vec<u32> {
    let mut inverse = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        inverse[old as usize] = new as u32;
    }
    inverse
}

/// Adjacency of the nodes that have unknowns, both directions, without loops.
struct Graph(Adjacency);

impl Graph {
    fn new(pattern: &Pattern) -> Self {
        let n = pattern.node_start.len() - 1;
        let node = pattern.node_of_unknown();
        // Every pair is there once, sorted, so that neighbours ascend.
        let pairs: Vec<_> = pattern.coupled_nodes(&node).map(|(a, b)| [a, b]).collect();
        Graph(Adjacency::of_edges(n, pairs.iter().copied()))
    }

    fn len(&self) -> usize {
        self.0.rows()
    }

    fn neighbours(&self, g: u32) -> &[u32] {
        self.0.row(g)
    }

    fn minimum_degree(&self) -> Option<Vec<u32>> {
        let n = self.len();
        let pattern = SymbolicSparseColMatRef::<u32>::new_checked(n, n, &self.0.start, None, &self.0.items);
        let (mut order, mut inverse) = (vec![0; n], vec![0; n]);
        let mut memory = MemBuffer::try_new(amd::order_scratch::<u32>(n, self.0.items.len())).ok()?;
        amd::order(&mut order, &mut inverse, pattern, amd::Control::default(), MemStack::new(&mut memory)).ok()?;
        Some(order)
    }

    fn dissect(&self, position: &[[f64; 3]], workers: &Workers) -> Vec<u32> {
        let most = (DENSE * (self.len() as f64).sqrt()).max(FEW as f64) as usize;
        let (mut nodes, dense): (Vec<u32>, Vec<u32>) =
            (0..self.len() as u32).partition(|&g| self.neighbours(g).len() <= most);
        let marks = Marks { of: (0..self.len()).map(|_| AtomicU32::new(0)).collect(), last: AtomicU32::new(0) };
        self.divide(&mut nodes, position, &marks, workers);
        nodes.extend(dense);
        nodes
    }

    /// Orders a part: its halves, each divided further, then their separator.
    fn divide(&self, part: &mut [u32], position: &[[f64; 3]], marks: &Marks, workers: &Workers) {
        if part.len() <= LEAF {
            return;
        }
        let [left, right, separator] = self.cut(halve(part, position), marks);
        let reordered = left.iter().chain(&right).chain(&separator);
        part.iter_mut().zip(reordered).for_each(|(slot, &g)| *slot = g);
        let workers = if part.len() < LARGE_PART { &ALONE } else { workers };
        let (first, rest) = part.split_at_mut(left.len());
        let halves = [first, &mut rest[..right.len()]];
        let [first, second] = halves.map(|half| move || self.divide(half, position, marks, workers));
        workers.join(first, second);
    }

    /// Two halves and their separator: the nodes of the first part that touch the second, or the other way round if
    /// those are far fewer.
    fn cut(&self, [first, second]: [&[u32]; 2], marks: &Marks) -> [Vec<u32>; 3] {
        let (left, separator) = self.apart(first, second, marks);
        // No separator can be smaller by that factor.
        if separator.len() <= MUCH_SMALLER {
            return [left, second.to_vec(), separator];
        }
        let (right, other) = self.apart(second, first, marks);
        if MUCH_SMALLER * other.len() < separator.len() {
            [first.to_vec(), right, other]
        } else {
            [left, second.to_vec(), separator]
        }
    }

    /// The nodes of a part that do not touch the other part, and those that do.
    fn apart(&self, part: &[u32], other: &[u32], marks: &Marks) -> (Vec<u32>, Vec<u32>) {
        let mark = marks.mark(other);
        part.iter().partition(|&&g| !self.neighbours(g).iter().any(|&o| marks.of(o) == mark))
    }

    /// Entries of L and operations of the factorisation, 3x3 for every node: a row of L is the part of the elimination
    /// tree between its entries in W and itself (Liu 1990, section 5).
    fn count(&self, order: &[u32], new: &[u32], parent: &[u32]) -> [f64; 2] {
        let mut rows = vec![0_u32; order.len()];
        let mut marks = vec![NONE; order.len()];
        for (i, &node) in order.iter().enumerate() {
            marks[i] = i as u32;
            for &old in self.neighbours(node) {
                let mut k = new[old as usize];
                while k < i as u32 && marks[k as usize] != i as u32 {
                    marks[k as usize] = i as u32;
                    rows[k as usize] += 1;
                    k = parent[k as usize];
                }
            }
        }
        let column = |rows: u32| {
            let r = 3.0 * f64::from(rows);
            [6.0 + 3.0 * r, 9.0 + 9.0 * r + 3.0 * r * r]
        };
        rows.into_iter().map(column).fold([0.0; 2], |sum, one| [sum[0] + one[0], sum[1] + one[1]])
    }

    /// The same elimination in depth-first order of the elimination tree, with its entries and operations.
    fn postorder(&self, order: &[u32]) -> (Vec<u32>, [f64; 2]) {
        let n = order.len();
        let new = invert(order);
        let (mut parent, mut ancestor) = (vec![NONE; n], vec![NONE; n]);
        for i in 0..n as u32 {
            for &old in self.neighbours(order[i as usize]) {
                let mut k = new[old as usize];
                while k < i && k != NONE {
                    let next = std::mem::replace(&mut ancestor[k as usize], i);
                    if next == NONE {
                        parent[k as usize] = i;
                    }
                    k = next;
                }
            }
        }
        let counts = self.count(order, &new, &parent);
        let (mut first_child, mut sibling) = (vec![NONE; n + 1], vec![NONE; n]);
        for i in (0..n).rev() {
            let p = if parent[i] == NONE { n } else { parent[i] as usize };
            sibling[i] = std::mem::replace(&mut first_child[p], i as u32);
        }
        let mut result = Vec::with_capacity(n);
        let mut node = first_child[n];
        let mut path = Vec::new();
        loop {
            while node != NONE {
                path.push(node);
                node = first_child[node as usize];
            }
            let Some(done) = path.pop() else { return (result, counts) };
            result.push(order[done as usize]);
            node = sibling[done as usize];
        }
    }
}

/// The mark of every node; threads divide parts that have no nodes in common.
struct Marks {
    of: Vec<AtomicU32>,
    last: AtomicU32,
}

impl Marks {
    /// Marks nodes with a mark that no other node has.
    fn mark(&self, nodes: &[u32]) -> u32 {
        let mark = 1 + self.last.fetch_add(1, Ordering::Relaxed);
        nodes.iter().for_each(|&g| self.of[g as usize].store(mark, Ordering::Relaxed));
        mark
    }

    fn of(&self, node: u32) -> u32 {
        self.of[node as usize].load(Ordering::Relaxed)
    }
}

/// Divides nodes into two halves across their longest extent; on a tie the lower numbers come first.
pub(super) fn halve<'a>(part: &'a mut [u32], position: &[[f64; 3]]) -> [&'a [u32]; 2] {
    let axis = longest_axis(part, position);
    let middle = part.len() / 2;
    part.select_nth_unstable_by(middle, |&a, &b| {
        let coordinate = |g: u32| position[g as usize][axis];
        coordinate(a).total_cmp(&coordinate(b)).then(a.cmp(&b))
    });
    let (first, second) = part.split_at(middle);
    [first, second]
}

fn longest_axis(part: &[u32], position: &[[f64; 3]]) -> usize {
    let mut extent = [0.0; 3];
    for (axis, extent) in extent.iter_mut().enumerate() {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for &g in part {
            low = low.min(position[g as usize][axis]);
            high = high.max(position[g as usize][axis]);
        }
        *extent = high - low;
    }
    (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0)
}
