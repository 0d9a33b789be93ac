//! Triangular solves with L over the nodes, forward and backward, and Eisenstat's product made of them.

use super::bsr::NodeBlocks;
use glam::{DVec3, Mat3A, Vec3A};
use prefetch_index::prefetch_index;

/// Prefetch distance in blocks of L, about as many as are processed until memory answers. Hardware prefetching was seen
/// to fail at this access pattern. In cache it costs nothing.
const AHEAD: usize = 192;

impl NodeBlocks {
    /// v = E^-1 b; `b` by unknown, `v` `[n_own]`.
    pub fn gather(&self, b: impl Fn(usize) -> f32, v: &mut [Vec3A]) {
        for (g, (v, inverse_root)) in v.iter_mut().zip(&self.inverse_root).take(self.nodes()).enumerate() {
            *v = *inverse_root * self.node_vector(g, &b);
        }
    }

    /// b = s Y^-1 E^-T v. `scale` is Y^-1 of every unknown `[n]`, `b` has the unknowns of the subdomain.
    pub fn scatter(&self, v: &[Vec3A], (s, scale): (f64, &[f64]), b: &mut [f64]) {
        let first = self.unknowns()[0].start;
        for (g, (v, inverse_root)) in v.iter().zip(&self.inverse_root).take(self.nodes()).enumerate() {
            let own = inverse_root.transpose() * *v;
            let unknowns = self.unknowns_of(g);
            for (i, u) in unknowns.clone().enumerate() {
                let direction = if unknowns.len() == 3 { i } else { self.direction(u) };
                b[u - first] = f64::from(own[direction]) * scale[u] * s;
            }
        }
    }

    /// v <- (I + L)^-1 v
    pub fn forward(&self, v: &mut [Vec3A]) {
        for g in 0..self.nodes() {
            self.take_below(g, v);
        }
    }

    /// v <- (I + L^T)^-1 v
    pub fn backward(&self, v: &mut [Vec3A]) {
        for g in (0..self.nodes()).rev() {
            v[g] -= self.above(g, v);
        }
    }

    /// Prefetches two cache lines, the size of most columns of L. Indices out of range are ignored.
    #[inline(always)]
    fn fetch(&self, block: usize) {
        prefetch_index(&self.below, block);
        prefetch_index(&self.below, block.wrapping_add(2));
    }

    /// v <- v - (column g of L) v_g, in the forward sweep; returns v_g.
    #[inline(always)]
    fn take_below(&self, g: usize, v: &mut [Vec3A]) -> Vec3A {
        let (y, column) = (v[g], self.column(g));
        self.fetch(column.start.wrapping_add(AHEAD));
        for (block, &row) in self.below[column.clone()].iter().zip(&self.row[column]) {
            v[row as usize] -= block.matrix() * y;
        }
        y
    }

    /// Row g of L^T v, in the backward sweep.
    #[inline(always)]
    fn above(&self, g: usize, v: &[Vec3A]) -> Vec3A {
        let column = self.column(g);
        self.fetch(column.start.wrapping_sub(AHEAD));
        let mut sums = Mat3A::ZERO;
        for (block, &row) in self.below[column.clone()].iter().zip(&self.row[column]) {
            let (block, v) = (block.matrix(), v[row as usize]);
            sums.x_axis += block.x_axis * v;
            sums.y_axis += block.y_axis * v;
            sums.z_axis += block.z_axis * v;
        }
        let sums = sums.transpose();
        sums.x_axis + sums.y_axis + sums.z_axis
    }

    /// The first half of the product of Eisenstat (SIAM J. Sci. Stat. Comput. 2, 1981), for the price of one with W
    /// itself: with A = I + J + L + L^T and p <- z + beta p,
    ///
    /// ```text
    /// q = (I + L)^-1 A (I + L^T)^-1 p = t + (I + L)^-1 (L^T t + J t),      t = (I + L^T)^-1 p,      L^T t = p - t
    /// ```
    /// The backward sweep computes t, and L^T t + J t in q.
    pub fn back(&self, z: &[Vec3A], beta: f32, sweep: Sweep<'_>) {
        let Sweep { p, t, q } = sweep;
        for g in (0..self.nodes()).rev() {
            let above = self.above(g, t);
            p[g] = z[g] + beta * p[g];
            t[g] = p[g] - above;
            q[g] = above + self.surplus[g].matrix() * t[g];
        }
    }

    /// The forward sweep of the product.
    pub fn forth(&self, sweep: Sweep<'_>) -> Curvature {
        let Sweep { p, t, q } = sweep;
        let (mut along, mut squares) = (DVec3::ZERO, DVec3::ZERO);
        for g in 0..self.nodes() {
            q[g] = self.take_below(g, q) + t[g];
            along += (p[g] * q[g]).as_dvec3();
            squares += (p[g] * p[g]).as_dvec3();
        }
        Curvature { along: along.element_sum(), squares: squares.element_sum() }
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

/// Vectors of a product: p `[n_own]`; t and q also hold the separator `[n_local]`.
pub(super) struct Sweep<'a> {
    /// direction
    pub p: &'a mut [Vec3A],
    /// (I + L^T)^-1 p
    pub t: &'a mut [Vec3A],
    /// the product
    pub q: &'a mut [Vec3A],
}
