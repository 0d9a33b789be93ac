//! The pivots of M: those of a relaxed incomplete factorisation without fill, part of which is added to the diagonal
//! instead.
//!
//! ```text
//! P_g = (1 + delta) D_g - sum_j N_gj P_j^-1 N_gj^T - omega_g sym sum_j sum_s N_gj P_j^-1 N_sj^T Y_s Y_g^-1,      j < g,   s > j, s != g
//! ```
//! with Y_g = diag(1/scale), three translations that all nodes share in the scaled W; its inverse is 0 at fixed
//! components. Without the sum over s these are the pivots of D-ILU (Pommerell, in Barrett et al., Templates, SIAM
//! 1994, section 3.4). The dropped fill is added to the diagonal instead (Dupont, Kendall & Rachford, SIAM J. Numer.
//! Anal. 5, 1968; Gustafsson, BIT 18, 1978). So M acts on a translation nearly as W does, and on the smooth modes that
//! need most iterations. omega < 1 keeps pivots away from zero (relaxed: Axelsson & Lindskog, Numer. Math. 48, 1986).
//! It is halved at nodes whose pivot would lose too much, as where stiff springs meet soft ones. delta is a shift
//! (Manteuffel, Math. Comp. 34, 1980). If even the pivot without fill is not positive definite, P_g = D_g. Eisenstat's
//! product (`eisenstat`) costs the same with any pivots, and M is positive definite if they are.

use super::bsr::{ELSEWHERE, NodeBlocks, SymmetricBlock};
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// [-] omega. On taut nets of 703 to a million nodes 0.9, 0.98 and 1 took as many iterations within an eighth.
pub(super) const RELAXATION: f64 = 0.95;
/// [-] Least share of a pivot that the fill must leave. With 0.8 smooth nets take up to 1.4 times the iterations, with
/// 0.3 as many or 1.2 times.
const LEAST_LEFT: f64 = 0.5;
/// Maximum number of halvings of omega at a node; then it takes no fill.
const HALVINGS: i32 = 3;
/// [-] delta, the share of the diagonal block added to a pivot: without it, a light node on stiff springs loses the
/// digits of single precision.
const SHIFT: f64 = 0.01;
/// Bound on entries of a positive definite matrix scaled by its diagonal, with a margin for rounding.
const LARGEST: f32 = 1.0 + 1e-5;

impl NodeBlocks {
    /// Sets the off-diagonal values of W, scaled by the diagonal; `values` [nonzeros], `scale` `[n]`. Returns whether
    /// all are small enough.
    pub(super) fn begin(&mut self, values: &[f64], scale: &[f64]) -> bool {
        // Until a node is eliminated, these hold what earlier nodes subtract from its pivot, and the fill.
        self.inverse_root.fill(Matrix3::zeros());
        self.surplus.fill(SymmetricBlock::default());
        let columns = self.unknowns().into_iter().flatten();
        let NodeBlocks { pattern, below, entry, .. } = self;
        let mut entries = entry.iter();
        columns.into_iter().all(|u| {
            let first = pattern.col_ptr[u] as usize;
            let beside = pattern.column(u).iter().zip(&values[first..]).zip(&mut entries);
            // Visits all of the column, so that the next one continues at its own entries.
            beside.fold(true, |small, ((&r, value), &entry)| {
                small & (entry == ELSEWHERE || store(below, entry, value * scale[u] * scale[r as usize]))
            })
        })
    }

    /// Adds what the elimination of a section subtracts from the pivots of this separator, which is `here` in it.
    pub(super) fn add_elimination_of(&mut self, section: &NodeBlocks, here: Range<usize>) {
        for (own, other) in self.inverse_root.iter_mut().zip(&section.inverse_root[here.clone()]) {
            *own += *other;
        }
        for (own, other) in self.surplus.iter_mut().zip(&section.surplus[here]) {
            own.add(&other.matrix());
        }
    }

    /// Copies the pivots of a separator, which is `here` in this section.
    pub(super) fn copy_separator_pivots(&mut self, separator: &NodeBlocks, here: Range<usize>) {
        self.inverse_root[here.clone()].copy_from_slice(&separator.inverse_root);
        self.surplus[here].copy_from_slice(&separator.surplus);
    }

    /// Eliminates all nodes in order, with the share `omega` [-] of the fill in the pivots. Returns whether all
    /// diagonal blocks are positive definite.
    pub(super) fn eliminate(&mut self, values: &[f64], scale: &[f64], omega: f64) -> bool {
        (0..self.nodes()).all(|g| {
            let taken = [self.inverse_root[g], self.surplus[g].matrix()].map(|block| block.cast::<f64>());
            let Some(pivot) = Pivot::new(&self.diagonal(g, values, scale), taken, omega) else { return false };
            self.inverse_root[g] = pivot.inverse_root;
            self.surplus[g] = pivot.surplus;
            self.eliminate_node(g, scale);
            true
        })
    }

    /// The lower triangle of a node's diagonal block, scaled.
    fn diagonal(&self, g: usize, values: &[f64], scale: &[f64]) -> Matrix3<f64> {
        let (pattern, unknowns) = (&self.pattern, self.unknowns_of(g));
        let mut diagonal = Matrix3::identity();
        for u in unknowns.clone() {
            let first = pattern.col_ptr[u] as usize;
            for (r, value) in (u..unknowns.end).zip(&values[first..]) {
                diagonal[(self.direction(r), self.direction(u))] = value * scale[u] * scale[r];
            }
        }
        diagonal
    }

    /// Scales a node's column from the right and subtracts its elimination from the pivots of its neighbours.
    fn eliminate_node(&mut self, g: usize, scale: &[f64]) {
        let right = self.inverse_root[g].transpose();
        let mut all = Matrix3::zeros();
        for k in self.column(g) {
            let block = self.block(k) * right;
            self.set_block(k, &block);
            let inverse = self.scale_of(self.row[k] as usize, scale);
            let translation = inverse.map(|inverse| if inverse > 0.0 { inverse.recip() } else { 0.0 });
            all += scale_columns(block.transpose(), translation);
        }
        for k in self.column(g) {
            let row = self.row[k] as usize;
            let block = self.block(k);
            let own = block * block.transpose();
            let fill = block * scale_columns(all, self.scale_of(row, scale)) - own;
            self.inverse_root[row] += own;
            self.surplus[row].add(&((fill + fill.transpose()) * 0.5));
        }
    }

    /// Scales of a node's three components, 0 at fixed ones.
    fn scale_of(&self, place: usize, scale: &[f64]) -> Vector3<f32> {
        self.node_vector(place, |u| scale[u] as f32)
    }

    /// Scales all rows from the left. Returns whether entries are as small as in a positive definite W.
    pub(super) fn scale_rows(&mut self) -> bool {
        let mut small = true;
        for g in 0..self.nodes() {
            let own = self.surplus[g].diagonal().add_scalar(1.0) * (LARGEST * LARGEST);
            for k in self.column(g) {
                let row = self.row[k] as usize;
                let block = self.inverse_root[row] * self.block(k);
                self.set_block(k, &block);
                let other = self.surplus[row].diagonal().add_scalar(1.0);
                for (column, own) in block.column_iter().zip(&own) {
                    // False for NaN.
                    small &= column.component_mul(&column) <= other * *own;
                }
            }
        }
        small
    }
}

/// Stores a scaled value of W. Returns whether it is as small as in a positive definite matrix.
#[inline(always)]
fn store(below: &mut [f32], entry: u32, scaled: f64) -> bool {
    let small = scaled.abs() <= f64::from(LARGEST);
    if small {
        below[entry as usize] = scaled as f32;
    }
    small
}

fn scale_columns(m: Matrix3<f32>, by: Vector3<f32>) -> Matrix3<f32> {
    Matrix3::from_columns(&[m.column(0) * by.x, m.column(1) * by.y, m.column(2) * by.z])
}

/// A pivot P = E E^T of a block D = E (I + J) E^T.
struct Pivot {
    /// E^-1
    inverse_root: Matrix3<f32>,
    /// J
    surplus: SymmetricBlock,
}

impl Pivot {
    /// From the lower triangle of D, what eliminations have subtracted, and their fill. `None` if no pivot is positive
    /// definite.
    fn new(lower: &Matrix3<f64>, [taken, fill]: [Matrix3<f64>; 2], omega: f64) -> Option<Self> {
        let mut block = *lower;
        block.fill_upper_triangle_with_lower_triangle();
        let pivot = less_fill(&(block * (1.0 + SHIFT) - taken), &(fill * omega));
        Pivot::of(&pivot, &block).or_else(|| Pivot::of(&block, &block))
    }

    /// `None` if the pivot is not positive definite.
    fn of(pivot: &Matrix3<f64>, block: &Matrix3<f64>) -> Option<Self> {
        let inverse_root: Matrix3<f32> = inverse_root(pivot)?.cast();
        // Uses the rounded root: rounding then changes M, not W.
        let root = inverse_root.cast::<f64>();
        let surplus = root * *block * root.transpose() - Matrix3::identity();
        Some(Pivot { inverse_root, surplus: SymmetricBlock::of(&surplus.cast()) })
    }
}

/// A pivot less its share of the fill, halved until enough of the pivot is left.
fn less_fill(pivot: &Matrix3<f64>, fill: &Matrix3<f64>) -> Matrix3<f64> {
    let most = *pivot * (1.0 - LEAST_LEFT);
    let shares = (0..=HALVINGS).map(|i| *fill * 0.5_f64.powi(i));
    shares.into_iter().find(|share| inverse_root(&(most - *share)).is_some()).map_or(*pivot, |share| *pivot - share)
}

/// E^-1 of a block E E^T; reads the lower triangle. `None` if it is not positive definite.
fn inverse_root(block: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let root = |pivot: f64| (pivot > 0.0).then(|| pivot.sqrt());
    let a = root(block.m11)?;
    let (b, c) = (block.m21 / a, block.m31 / a);
    let d = root(block.m22 - b * b)?;
    let e = (block.m32 - c * b) / d;
    let f = root(block.m33 - c * c - e * e)?;
    let (ia, id, i_f) = (1.0 / a, 1.0 / d, 1.0 / f);
    let below = -b * ia * id;
    let corner = -(c * ia + e * below) * i_f;
    Some(Matrix3::new(ia, 0.0, 0.0, below, id, 0.0, corner, -e * id * i_f, i_f))
}

#[cfg(test)]
mod tests;
