//! Aggregates of nodes that lie side by side, and interpolation from them:
//!
//! ```text
//! P = (I - omega D^-1 A) P0          P0 moves all nodes of an aggregate alike
//! ```
//! with the matrix of the coarse level P^T A P.

use super::block_rows::{BlockRows, Columns, SECTION, sections_mut};
use super::numbers::{COLUMNS, CoarseNumbers, Numbers};
use super::smoother::Smoother;
use crate::mesh::adjacency::Adjacency;
use crate::model::workers::Workers;
use multiversion::multiversion;
use nalgebra::Matrix3;
use wide::f32x4;

/// [-] omega: 4/3 over the largest eigenvalue of D^-1 A, which is 2 at most where all couplings are springs.
const OMEGA: f32 = 2.0 / 3.0;
/// No aggregate.
const NONE: u32 = u32::MAX;

/// The aggregate of every node, and their number. `around` are the nodes that every node is coupled to, and itself.
/// Nodes take all that is around them, in their order, where nothing of it is taken yet; those that are left join what
/// lies beside them.
pub(super) fn aggregates(around: &Adjacency) -> (Vec<u32>, usize) {
    let n = around.rows();
    let (mut aggregate, mut count) = (vec![NONE; n], 0);
    for i in 0..n as u32 {
        let all = around.row(i);
        if all.iter().all(|&j| aggregate[j as usize] == NONE) {
            all.iter().for_each(|&j| aggregate[j as usize] = count);
            count += 1;
        }
    }
    let first = aggregate.clone();
    for i in 0..n as u32 {
        if first[i as usize] == NONE {
            let beside = around.row(i).iter().map(|&j| first[j as usize]).find(|&a| a != NONE);
            aggregate[i as usize] = beside.unwrap_or(0);
        }
    }
    (aggregate, count as usize)
}

/// The nodes whose column of A adds to every section of the coarse matrix. `rows` are the aggregates that move a node.
fn reaching(around: &Adjacency, rows: &Adjacency, count: usize) -> Adjacency {
    let (mut pairs, mut met) = (Vec::new(), Vec::new());
    for g in 0..around.rows() as u32 {
        met.clear();
        for &b in around.row(g).iter().filter(|h| **h >= g).flat_map(|&h| rows.row(h)) {
            for section in rows.row(g).iter().map(|&a| a.min(b) / COLUMNS as u32) {
                if !met.contains(&section) {
                    met.push(section);
                }
            }
        }
        pairs.extend(met.iter().map(|&section| (section, g)));
    }
    Adjacency::new(count.div_ceil(COLUMNS), pairs.iter().copied())
}

/// The interpolation.
#[derive(Debug)]
pub(super) struct Prolongation {
    /// aggregate of every node
    aggregate: Vec<u32>,
    /// blocks of P: of a node, the aggregates that it and its neighbours are in, ascending
    rows: BlockRows,
    /// the nodes that every aggregate moves
    members: Columns,
    /// the nodes whose column of A adds to every section of the coarse matrix
    reaching: Adjacency,
}

impl Prolongation {
    /// Zeros. `around` as for [`aggregates`].
    pub(super) fn new(around: &Adjacency, (aggregate, count): (Vec<u32>, usize), workers: &Workers) -> Self {
        let (mut start, mut met) = (vec![0], Vec::new());
        let mut of_node = Vec::new();
        for i in 0..around.rows() as u32 {
            of_node.clear();
            of_node.extend(around.row(i).iter().map(|&j| aggregate[j as usize]));
            of_node.sort_unstable();
            of_node.dedup();
            met.extend_from_slice(&of_node);
            start.push(met.len() as u32);
        }
        let rows = Adjacency { start, items: met };
        let (members, reaching) = workers.join(|| Columns::new(&rows, count), || reaching(around, &rows, count));
        Prolongation { aggregate, rows: BlockRows::new(rows), members, reaching }
    }

    /// Number of aggregates.
    pub(super) fn count(&self) -> usize {
        self.members.count()
    }

    /// [m] The middles of the aggregates of nodes at `position`.
    pub(super) fn middles(&self, position: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let mut sums = vec![([0.0; 3], 0.0); self.count()];
        for (x, &a) in position.iter().zip(&self.aggregate) {
            let (sum, nodes) = &mut sums[a as usize];
            sum.iter_mut().zip(x).for_each(|(sum, x)| *sum += x);
            *nodes += 1.0;
        }
        sums.into_iter().map(|(sum, nodes)| sum.map(|sum| sum / nodes)).collect()
    }

    /// The lower triangle of P^T A P: itself and the aggregates behind it that every aggregate is coupled to.
    pub(super) fn coarse(&self, around: &Adjacency) -> Adjacency {
        let mut last = vec![NONE; self.count()];
        let mut found = Adjacency { start: vec![0], items: Vec::new() };
        for a in 0..self.count() as u32 {
            let first = found.items.len();
            for &j in self.members.rows(a as usize).iter().flat_map(|&i| around.row(i)) {
                for &b in self.rows.columns(j as usize) {
                    if b >= a && last[b as usize] != a {
                        last[b as usize] = a;
                        found.items.push(b);
                    }
                }
            }
            found.items[first..].sort_unstable();
            found.start.push(found.items.len() as u32);
        }
        found
    }

    /// Sets P from A and D^-1 of every node.
    pub(super) fn set(&mut self, workers: &Workers, smoother: &Smoother) {
        let Prolongation { aggregate, rows, .. } = self;
        workers.each_section(rows.sections_mut().enumerate(), |(section, mut rows)| {
            rows.clear();
            smoother.each_block(section, |i, j, block| rows.add(i, aggregate[j], block));
            for (i, &own) in aggregate.iter().enumerate().skip(section * SECTION).take(SECTION) {
                let inverse = smoother.inverse(i);
                rows.replace(i, |a, sum| {
                    let mut block = inverse * sum * -OMEGA;
                    if a == own {
                        // I - omega D^-1 D, both 0 at fixed components.
                        (0..3).filter(|&j| inverse[(j, j)] != 0.0).for_each(|j| block[(j, j)] += 1.0 - OMEGA);
                    }
                    block
                });
            }
        });
    }

    /// coarse <- P^T A P, in double precision: it keeps what inertia adds to stiff springs. With half of the diagonal
    /// and what lies below it, H, it is B + B^T with B = P^T H P.
    pub(super) fn restrict_matrix(
        &self,
        workers: &Workers,
        matrix: &(impl Numbers + Sync),
        coarse: &mut CoarseNumbers,
    ) {
        let block = |place| self.rows.block(place).cast::<f64>();
        workers.each_section(coarse.sections_mut().enumerate(), |(section, mut coarse)| {
            coarse.clear();
            // A column of P^T H.
            let mut column: Vec<(u32, Matrix3<f64>)> = Vec::new();
            for &g in self.reaching.row(section as u32) {
                column.clear();
                matrix.column(g, |h, entry| {
                    let entry = if h == g { entry * 0.5 } else { *entry };
                    for (place, &b) in self.rows.places(h as usize).zip(self.rows.columns(h as usize)) {
                        let part = block(place).tr_mul(&entry);
                        match column.iter_mut().find(|(other, _)| *other == b) {
                            Some((_, sum)) => *sum += part,
                            None => column.push((b, part)),
                        }
                    }
                });
                for (place, &a) in self.rows.places(g as usize).zip(self.rows.columns(g as usize)) {
                    let right = block(place);
                    column.iter().for_each(|(b, left)| coarse.add_both(*b, a, || left * right));
                }
            }
        });
    }

    /// coarse <- P^T v
    pub(super) fn restrict(&self, workers: &Workers, v: &[f32x4], coarse: &mut [f32x4]) {
        let vectors = sections_mut(coarse).enumerate();
        workers.each_section(vectors, |(section, coarse)| restrict(self, section * SECTION, coarse, v));
    }

    /// x <- x + P e
    pub(super) fn correct(&self, workers: &Workers, e: &[f32x4], x: &mut [f32x4]) {
        workers.each_section(sections_mut(x).enumerate(), |(section, x)| correct(&self.rows, section * SECTION, x, e));
    }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn restrict(up: &Prolongation, first: usize, coarse: &mut [f32x4], v: &[f32x4]) {
    for (sum, a) in coarse.iter_mut().zip(first..) {
        *sum = up.members.transposed_sum(&up.rows, a, v);
    }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn correct(rows: &BlockRows, first: usize, x: &mut [f32x4], e: &[f32x4]) {
    for (x, i) in x.iter_mut().zip(first..) {
        *x += rows.sum(i, e);
    }
}
