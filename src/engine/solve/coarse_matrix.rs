//! The coarse matrix of deflation (`deflation`): W for translations of aggregates.

use super::Cholesky;
use super::linear::{Accuracy, Inertia, LinearError, LinearSolver};
use super::ordering::halve;
use crate::assembly::Pattern;
use crate::mesh::adjacency::Adjacency;
use nalgebra::Vector3;
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;
use wide::f32x4;

/// The aggregates and the coarse matrix.
pub(super) struct CoarseMatrix {
    /// aggregate of every node
    pub(super) aggregate: Vec<u32>,
    /// node of every unknown
    node: Vec<u32>,
    /// higher aggregates that every aggregate is coupled to
    couplings: Adjacency,
    pattern: Arc<Pattern>,
    solver: Cholesky,
    /// C with every column scaled by its aggregate's `weight` `[nonzeros]`
    values: Vec<f64>,
    /// scale of the columns of Z: the least Y^-1 of an aggregate, so that entries of Z are at most one
    pub(super) weight: Vec<f64>,
    /// right-hand side, then solution
    sums: Vec<f64>,
    /// the solution by aggregate
    pub(super) translation: Vec<f32x4>,
}

impl CoarseMatrix {
    /// Divides the nodes of a symmetric pattern, by halves along their positions, into aggregates of at most `largest`.
    /// Returns also the aggregates that every node meets: its own and those of its neighbours, ascending.
    ///
    /// # Errors
    /// When the analysis of the coarse matrix fails.
    pub(super) fn new(pattern: &Pattern, largest: usize) -> Result<(Self, Adjacency), LinearError> {
        let node = pattern.node_of_unknown();
        let (aggregate, count) = aggregates(&pattern.position, largest);
        let rows = rows(pattern, &node, &aggregate);
        let met = (0..).zip(&aggregate).flat_map(|(g, &a)| rows.row(g).iter().map(move |&b| (a, b)));
        let pairs: BTreeSet<(u32, u32)> = met.filter(|(a, b)| a < b).collect();
        let couplings = Adjacency::new(count, pairs.iter().copied());
        let coarse = Arc::new(coarse_pattern(&couplings, &centres(&pattern.position, &aggregate, count)));
        let mut solver = Cholesky::new(Arc::clone(&coarse))?;
        solver.set_accuracy(Accuracy::of_reused());
        let coarse = CoarseMatrix {
            aggregate,
            node,
            couplings,
            solver,
            values: vec![0.0; coarse.nonzeros()],
            weight: vec![0.0; count],
            sums: vec![0.0; 3 * count],
            translation: vec![f32x4::ZERO; count],
            pattern: coarse,
        };
        Ok((coarse, rows))
    }

    /// Sets C from W: `values` [nonzeros] of `fine`, and `scale` Y^-1. Returns whether it is positive definite; if not,
    /// W is not.
    ///
    /// # Errors
    /// Sums that are not finite.
    pub(super) fn set_values(&mut self, fine: &Pattern, values: &[f64], scale: &[f64]) -> Result<bool, LinearError> {
        self.weight.fill(f64::INFINITY);
        for (&node, scale) in self.node.iter().zip(scale) {
            let weight = &mut self.weight[self.aggregate[node as usize] as usize];
            *weight = weight.min(*scale);
        }
        self.values.fill(0.0);
        let direction = |u: usize| (fine.dof[u] % 3) as usize;
        for u in 0..fine.n() {
            let (g, j) = (self.node[u], direction(u));
            let a = self.aggregate[g as usize] as usize;
            for (&r, &value) in fine.column(u).iter().zip(&values[fine.col_ptr[u] as usize..]) {
                let (other, i) = (self.node[r as usize], direction(r as usize));
                let b = self.aggregate[other as usize] as usize;
                // Of two nodes of one aggregate, both triangles come together.
                let share = if a == b && g != other && i == j { 2.0 } else { 1.0 };
                let slot = if b < a { self.slot((b, i), (a, j)) } else { self.slot((a, j), (b, i)) };
                self.values[slot] += share * self.weight[a] * self.weight[b] * value;
            }
        }
        for a in 0..self.weight.len() {
            for j in 0..3 {
                let diagonal = &mut self.values[self.pattern.col_ptr[3 * a + j] as usize];
                if *diagonal == 0.0 {
                    // No node of the aggregate is free along this direction.
                    *diagonal = 1.0;
                }
            }
        }
        // The factor is in single precision where that is exact enough: solves then take half the time.
        let made = self.solver.prepare(&self.values).map_err(|error| self.of_unknowns(error))?;
        Ok(made == Inertia::Definite)
    }

    /// The same error with an unknown of W, one of the aggregate, in place of one of C.
    fn of_unknowns(&self, error: LinearError) -> LinearError {
        let first = |coarse: usize| {
            let of_aggregate = |g: &u32| self.aggregate[*g as usize] as usize == coarse / 3;
            self.node.iter().position(of_aggregate)
        };
        match error {
            LinearError::NotFinite { unknown } => LinearError::NotFinite { unknown: first(unknown).unwrap_or(0) },
            LinearError::Singular { unknown } => LinearError::Singular { unknown: unknown.and_then(first) },
            other => other,
        }
    }

    /// Slot of the entry of two translations, of aggregates a <= b.
    fn slot(&self, (a, j): (usize, usize), (b, i): (usize, usize)) -> usize {
        if a == b {
            return self.pattern.col_ptr[3 * a + j.min(i)] as usize + j.abs_diff(i);
        }
        let place = self.couplings.row(a as u32).binary_search(&(b as u32)).unwrap_or(0);
        self.pattern.col_ptr[3 * a + j] as usize + 3 - j + 3 * place + i
    }

    /// translation <- share C^-1 (sum of the parts); `parts` are by aggregate.
    ///
    /// # Errors
    /// Sums that are not finite.
    pub(super) fn solve<'a>(
        &mut self,
        parts: impl Iterator<Item = &'a [f32x4]>,
        share: f32,
    ) -> Result<(), LinearError> {
        self.sums.fill(0.0);
        for part in parts {
            for (sum, part) in self.sums.chunks_exact_mut(3).zip(part) {
                sum.iter_mut().zip(part.to_array()).for_each(|(sum, part)| *sum += f64::from(part));
            }
        }
        self.solver.solve(&self.values, &mut self.sums).map_err(|error| self.of_unknowns(error))?;
        for (translation, sum) in self.translation.iter_mut().zip(self.sums.chunks_exact(3)) {
            *translation = f32x4::new([sum[0] as f32, sum[1] as f32, sum[2] as f32, 0.0]) * share;
        }
        Ok(())
    }
}

/// Nodes of an aggregate, at most. On nets of 100,000 nodes half as many take 0.9 times the iterations, twice as many
/// 1.2 times.
const LARGEST: usize = 64;
/// Aggregates of larger scenes have more nodes, so that there are no more of them than this: a solve with the coarse
/// matrix takes a seventh of an iteration at 100,000 nodes.
const MOST: usize = 8192;

/// Largest number of nodes of an aggregate in a scene of `nodes`.
pub(super) fn largest_aggregate(nodes: usize) -> usize {
    nodes.div_ceil(MOST).max(LARGEST)
}

/// The aggregate of every node, of at most `largest` nodes, and their number.
fn aggregates(position: &[[f64; 3]], largest: usize) -> (Vec<u32>, usize) {
    let mut nodes: Vec<u32> = (0..position.len() as u32).collect();
    let (mut aggregate, mut count) = (vec![0; position.len()], 0);
    let mut open: Vec<Range<usize>> = std::iter::once(0..nodes.len()).collect();
    while let Some(range) = open.pop() {
        let part = &mut nodes[range.clone()];
        if part.len() <= largest {
            part.iter().for_each(|&g| aggregate[g as usize] = count);
            count += 1;
            continue;
        }
        let [first, _] = halve(part, position);
        let middle = range.start + first.len();
        open.extend([range.start..middle, middle..range.end]);
    }
    (aggregate, count as usize)
}

/// Nodes and the aggregates that they meet, each pair once.
fn rows(pattern: &Pattern, node: &[u32], aggregate: &[u32]) -> Adjacency {
    let of = |g: u32| aggregate[g as usize];
    let mut pairs: Vec<(u32, u32)> = (0..).zip(aggregate.iter().copied()).collect();
    let apart = pattern.coupled_nodes(node).filter(|&(g, other)| of(g) != of(other));
    pairs.extend(apart.flat_map(|(g, other)| [(g, of(other)), (other, of(g))]));
    pairs.sort_unstable();
    pairs.dedup();
    Adjacency::new(aggregate.len(), pairs.iter().copied())
}

/// [m] the middle of every aggregate
fn centres(position: &[[f64; 3]], aggregate: &[u32], count: usize) -> Vec<[f64; 3]> {
    let mut sums = vec![(Vector3::zeros(), 0.0); count];
    for (&x, &a) in position.iter().zip(aggregate) {
        let (sum, nodes) = &mut sums[a as usize];
        *sum += Vector3::from(x);
        *nodes += 1.0;
    }
    sums.into_iter().map(|(sum, nodes)| (sum / nodes).into()).collect()
}

/// The pattern of C: three unknowns for each aggregate.
fn coarse_pattern(couplings: &Adjacency, centres: &[[f64; 3]]) -> Pattern {
    let count = centres.len() as u32;
    let (mut col_ptr, mut row_idx) = (vec![0], Vec::new());
    for a in 0..count {
        for u in 3 * a..3 * a + 3 {
            row_idx.extend(u..3 * a + 3);
            couplings.row(a).iter().for_each(|b| row_idx.extend(3 * b..3 * b + 3));
            col_ptr.push(row_idx.len() as u32);
        }
    }
    Pattern {
        col_ptr,
        row_idx,
        symmetric: true,
        dof: (0..3 * count).collect(),
        node_start: (0..=count).map(|a| 3 * a).collect(),
        position: centres.to_vec(),
    }
}
