//! Triangular solves with L over the nodes, forward and backward, and Eisenstat's product made of them.

use super::bsr::{BLOCK, NodeBlocks, columns, packed, times, unpacked};
use nalgebra::Vector3;
use prefetch_index::prefetch_index;
use std::ops::Range;
use wide::f32x4;

/// Prefetch distance in blocks of L, about as many as are processed until memory answers. Hardware prefetching was seen
/// to fail at this access pattern. In cache it costs nothing.
const AHEAD: usize = 192;

impl NodeBlocks {
    /// v = E^-1 b; `b` by unknown, `v` `[n_own]`.
    pub(super) fn gather(&self, b: impl Fn(usize) -> f32, v: &mut [f32x4]) {
        for (g, (v, inverse_root)) in v.iter_mut().zip(&self.inverse_root).take(self.nodes()).enumerate() {
            *v = packed(*inverse_root * self.node_vector(g, &b));
        }
    }

    /// b = s Y^-1 E^-T v. `scale` is Y^-1 of every unknown `[n]`, `b` has the unknowns of the subdomain.
    pub(super) fn scatter(&self, v: &[f32x4], s: f64, scale: &[f64], b: &mut [f64]) {
        let first = self.unknowns()[0].start;
        for (g, (v, inverse_root)) in v.iter().zip(&self.inverse_root).take(self.nodes()).enumerate() {
            let own = inverse_root.tr_mul(&unpacked(*v));
            let unknowns = self.unknowns_of(g);
            for (i, u) in unknowns.clone().enumerate() {
                let direction = if unknowns.len() == 3 { i } else { self.direction(u) };
                b[u - first] = f64::from(own[direction]) * scale[u] * s;
            }
        }
    }

    /// v <- (I + L)^-1 v
    pub(super) fn forward(&self, v: &mut [f32x4]) {
        for g in 0..self.nodes() {
            let column = self.column(g);
            self.fetch(column.start.wrapping_add(AHEAD));
            self.take_below(column, v[g], v);
        }
    }

    /// v <- (I + L^T)^-1 v
    pub(super) fn backward(&self, v: &mut [f32x4]) {
        for g in (0..self.nodes()).rev() {
            let column = self.column(g);
            self.fetch(column.start.wrapping_sub(AHEAD));
            v[g] -= self.above(column, v);
        }
    }

    /// Prefetches two cache lines, the size of most columns of L. Indices out of range are ignored.
    #[inline(always)]
    fn fetch(&self, block: usize) {
        let first = block.wrapping_mul(BLOCK as usize);
        prefetch_index(&self.below, first);
        prefetch_index(&self.below, first.wrapping_add(2 * BLOCK as usize));
    }

    /// The blocks of a column of L, for [`columns`], and their rows.
    #[inline(always)]
    fn blocks(&self, column: Range<usize>) -> impl Iterator<Item = (&[f32], usize)> {
        let numbers = &self.below[BLOCK as usize * column.start..=BLOCK as usize * column.end];
        let blocks = numbers.windows(BLOCK as usize + 1).step_by(BLOCK as usize);
        blocks.zip(self.row[column].iter().map(|&row| row as usize))
    }

    /// v <- v - (column of L) y
    #[inline(always)]
    fn take_below(&self, column: Range<usize>, y: f32x4, v: &mut [f32x4]) {
        for (block, row) in self.blocks(column) {
            v[row] -= times(columns(block), y);
        }
    }

    /// Row of L^T v, of the node whose column of L this is.
    #[inline(always)]
    fn above(&self, column: Range<usize>, v: &[f32x4]) -> f32x4 {
        let [mut x, mut y, mut z] = [f32x4::ZERO; 3];
        for (block, row) in self.blocks(column) {
            let [a, b, c] = columns(block);
            x += a * v[row];
            y += b * v[row];
            z += c * v[row];
        }
        let [x, y, z, _] = f32x4::transpose([x, y, z, z]);
        x + y + z
    }

    /// The first half of the product of Eisenstat (SIAM J. Sci. Stat. Comput. 2, 1981), for the price of one with W
    /// itself: with A = I + J + L + L^T and p <- z + beta p,
    ///
    /// ```text
    /// q = (I + L)^-1 A (I + L^T)^-1 p = t + (I + L)^-1 (L^T t + J t),      t = (I + L^T)^-1 p,      L^T t = p - t
    /// ```
    /// The backward sweep computes t, and L^T t + J t in q.
    pub(super) fn back(&self, z: &[f32x4], beta: f32, sweep: Sweep<'_>) {
        let Sweep { p, t, q } = sweep;
        for g in (0..self.nodes()).rev() {
            let column = self.column(g);
            self.fetch(column.start.wrapping_sub(AHEAD));
            let above = self.above(column, t);
            p[g] = z[g] + p[g] * beta;
            t[g] = p[g] - above;
            q[g] = above + times(self.surplus[g].columns(), t[g]);
        }
    }

    /// The forward sweep of the product.
    pub(super) fn forth(&self, sweep: Sweep<'_>) -> Curvature {
        let Sweep { p, t, q } = sweep;
        let (mut along, mut squares) = (Vector3::zeros(), Vector3::zeros());
        for g in 0..self.nodes() {
            let (column, y) = (self.column(g), q[g]);
            self.fetch(column.start.wrapping_add(AHEAD));
            self.take_below(column, y, q);
            q[g] = y + t[g];
            along += unpacked(p[g] * q[g]).cast::<f64>();
            squares += unpacked(p[g] * p[g]).cast::<f64>();
        }
        Curvature { along: along.sum(), squares: squares.sum() }
    }
}

/// Inner products of a direction p.
#[derive(Clone, Copy, Default)]
pub(super) struct Curvature {
    /// p . q
    pub along: f64,
    /// p . p
    pub squares: f64,
}

/// Vectors of a product: p `[n_own]`; t and q also hold the separators beside it `[n_local]`.
pub(super) struct Sweep<'a> {
    /// direction
    pub p: &'a mut [f32x4],
    /// (I + L^T)^-1 p
    pub t: &'a mut [f32x4],
    /// the product
    pub q: &'a mut [f32x4],
}
