//! Aggregates of nodes that lie side by side, and interpolation from them:
//!
//! ```text
//! P = (I - omega D^-1 A) P0          P0 moves all nodes of an aggregate alike
//! ```
//! with the matrix of the coarse level P^T A P.

use super::numbers::{CoarseNumbers, Numbers};
use super::smoother::{BlockRows, SECTION, each_section, sections_mut};
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

/// The interpolation.
#[derive(Debug)]
pub(super) struct Prolongation {
    /// aggregate of every node
    aggregate: Vec<u32>,
    /// blocks of P: of a node, the aggregates that it and its neighbours are in, ascending
    rows: BlockRows,
    /// the nodes that every aggregate moves, with the places of their blocks
    members: Adjacency,
    places: Vec<u32>,
}

impl Prolongation {
    /// Zeros. `around` as for [`aggregates`].
    pub(super) fn new(around: &Adjacency, (aggregate, count): (Vec<u32>, usize)) -> Self {
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
        let places = (0..).zip(&met).map(|(k, &a)| (a, k));
        let nodes = (0..).zip(start.windows(2)).flat_map(|(i, row)| (row[0]..row[1]).map(move |_| i));
        let members = Adjacency::new(count, met.iter().copied().zip(nodes));
        let places = Adjacency::new(count, places).items;
        Prolongation { aggregate, rows: BlockRows::new(Adjacency { start, items: met }), members, places }
    }

    /// Number of aggregates.
    pub(super) fn count(&self) -> usize {
        self.members.rows()
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
            for &j in self.members.row(a).iter().flat_map(|&i| around.row(i)) {
                for b in self.rows.places(j as usize).map(|k| self.rows.column(k)) {
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
    pub(super) fn set(&mut self, matrix: &impl Numbers, inverse: impl Fn(usize) -> Matrix3<f32>) {
        let Prolongation { aggregate, rows, .. } = self;
        rows.clear();
        for g in 0..aggregate.len() as u32 {
            matrix.column(g, |h, block| {
                rows.add(rows.place(h, aggregate[g as usize]), block);
                if h != g {
                    rows.add(rows.place(g, aggregate[h as usize]), &block.transpose());
                }
            });
        }
        for (i, &own) in aggregate.iter().enumerate() {
            let inverse = inverse(i);
            for k in rows.places(i) {
                let mut block = inverse * rows.block(k) * -OMEGA;
                if rows.column(k) == own {
                    // D^-1 is 0 at fixed components.
                    (0..3).filter(|&j| inverse[(j, j)] != 0.0).for_each(|j| block[(j, j)] += 1.0);
                }
                rows.set(k, &block);
            }
        }
    }

    /// coarse <- P^T A P, in double precision: it keeps what inertia adds to stiff springs.
    pub(super) fn restrict_matrix(&self, matrix: &impl Numbers, coarse: &mut CoarseNumbers) {
        coarse.blocks.fill(Matrix3::zeros());
        let block = |k: usize| self.rows.block(k).cast::<f64>();
        for g in 0..self.aggregate.len() {
            matrix.column(g as u32, |h, entry| {
                for k in self.rows.places(g) {
                    let (a, right) = (self.rows.column(k), entry * block(k));
                    for l in self.rows.places(h as usize) {
                        let b = self.rows.column(l);
                        // Two nodes count both ways.
                        if b >= a {
                            coarse.add(b, a, &block(l).tr_mul(&right));
                        }
                        if h as usize != g && b <= a {
                            coarse.add(a, b, &right.tr_mul(&block(l)));
                        }
                    }
                }
            });
        }
    }

    /// coarse <- P^T v
    pub(super) fn restrict(&self, workers: &Workers, v: &[f32x4], coarse: &mut [f32x4]) {
        let vectors = sections_mut(coarse).enumerate();
        each_section(workers, vectors, |(section, coarse)| restrict(self, section * SECTION, coarse, v));
    }

    /// x <- x + P e
    pub(super) fn correct(&self, workers: &Workers, e: &[f32x4], x: &mut [f32x4]) {
        each_section(workers, sections_mut(x).enumerate(), |(section, x)| correct(&self.rows, section * SECTION, x, e));
    }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn restrict(up: &Prolongation, first: usize, coarse: &mut [f32x4], v: &[f32x4]) {
    for (sum, a) in coarse.iter_mut().zip(first..) {
        let members = up.members.start[a] as usize..up.members.start[a + 1] as usize;
        let nodes = up.members.items[members.clone()].iter().map(|&i| v[i as usize]);
        *sum = up.rows.transposed(up.places[members].iter().map(|&k| k as usize).zip(nodes));
    }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn correct(rows: &BlockRows, first: usize, x: &mut [f32x4], e: &[f32x4]) {
    for (x, i) in x.iter_mut().zip(first..) {
        *x += rows.sum(i, e);
    }
}
