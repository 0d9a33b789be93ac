//! A symmetric W by the 3x3 blocks of its nodes, scaled so that the blocks on the diagonal are the identity:
//!
//! ```text
//! W = E (I + L + L^T) E^T,      E E^T the blocks on the diagonal, L strictly below them
//! ```
//! Only L is stored, column by column. A node with fixed degrees of freedom keeps three places: the idle ones have the identity and nothing
//! beside it, so that a vector which is zero there stays so.

use crate::assembly::Pattern;
use glam::{DMat3, DVec3};
use std::ops::Range;

/// Entries of a 3x3 block.
const BLOCK: u32 = 9;

/// W = E (I + L + L^T) E^T.
pub(super) struct NodeBlocks {
    /// first block of every node's column of L, and their number at the end
    start: Vec<u32>,
    /// row node of every block of L
    row: Vec<u32>,
    below: Vec<DMat3>,
    /// E^-1
    inverse_root: Vec<DMat3>,
    /// where every stored value of W goes: among the entries of the blocks on the diagonal, then those of L
    entry: Vec<u32>,
    /// place of every unknown in a vector by nodes
    place: Vec<u32>,
}

impl NodeBlocks {
    /// Stored entries of W beyond which entries of blocks, of which each holds one at least, could not be numbered.
    pub const MOST_ENTRIES: usize = (u32::MAX / BLOCK) as usize;

    /// Finds the blocks of a symmetric pattern.
    pub fn new(pattern: &Pattern) -> Self {
        let nodes = pattern.node_start.len() - 1;
        let mut place = vec![0; pattern.n()];
        let (mut start, mut row, mut entry) = (vec![0], Vec::new(), vec![0; pattern.nonzeros()]);
        for (g, unknowns) in pattern.node_start.windows(2).enumerate() {
            for u in unknowns[0]..unknowns[1] {
                place[u as usize] = 3 * g as u32 + pattern.dof[u as usize] % 3;
            }
        }
        let diagonal = BLOCK * nodes as u32;
        for g in 0..nodes as u32 {
            let first = row.len();
            let columns = pattern.node_start[g as usize]..pattern.node_start[g as usize + 1];
            let all = columns.clone().flat_map(|u| pattern.column(u as usize)).map(|&r| place[r as usize] / 3);
            row.extend(all.filter(|&r| r != g));
            row[first..].sort_unstable();
            let kept = first + dedup(&mut row[first..]);
            row.truncate(kept);
            for u in columns {
                let slots = pattern.col_ptr[u as usize] as usize..pattern.col_ptr[u as usize + 1] as usize;
                for (entry, &r) in entry[slots].iter_mut().zip(pattern.column(u as usize)) {
                    let (other, within) = (place[r as usize] / 3, 3 * (place[u as usize] % 3) + place[r as usize] % 3);
                    *entry = within
                        + match row[first..].binary_search(&other) {
                            Ok(at) => diagonal + BLOCK * (first + at) as u32,
                            Err(_) => BLOCK * g,
                        };
                }
            }
            start.push(row.len() as u32);
        }
        row.shrink_to_fit();
        let below = vec![DMat3::ZERO; row.len()];
        NodeBlocks { start, row, below, inverse_root: vec![DMat3::IDENTITY; nodes], entry, place }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.inverse_root.len()
    }

    /// Takes the values of W; whether the blocks on its diagonal are positive definite.
    pub fn fill(&mut self, values: &[f64]) -> bool {
        self.inverse_root.fill(DMat3::IDENTITY);
        let on_diagonal = BLOCK as usize * self.nodes();
        let diagonal: &mut [f64] = bytemuck::cast_slice_mut(&mut self.inverse_root);
        let below: &mut [f64] = bytemuck::cast_slice_mut(&mut self.below);
        for (&entry, &value) in self.entry.iter().zip(values) {
            let entry = entry as usize;
            match entry.checked_sub(on_diagonal) {
                None => diagonal[entry] = value,
                Some(entry) => below[entry] = value,
            }
        }
        for block in &mut self.inverse_root {
            let Some(inverse) = inverse_root(block) else { return false };
            *block = inverse;
        }
        for (g, right) in self.inverse_root.iter().enumerate() {
            let right = right.transpose();
            for k in self.column(g) {
                self.below[k] = self.inverse_root[self.row[k] as usize] * self.below[k] * right;
            }
        }
        true
    }

    fn column(&self, g: usize) -> Range<usize> {
        self.start[g] as usize..self.start[g + 1] as usize
    }

    /// v = E^-1 b
    pub fn gather(&self, b: &[f64], v: &mut [DVec3]) {
        v.fill(DVec3::ZERO);
        let places: &mut [f64] = bytemuck::cast_slice_mut(v);
        for (&place, b) in self.place.iter().zip(b) {
            places[place as usize] = *b;
        }
        for (v, inverse) in v.iter_mut().zip(&self.inverse_root) {
            *v = *inverse * *v;
        }
    }

    /// b = E^-T v, in place of v
    pub fn scatter(&self, v: &mut [DVec3], b: &mut [f64]) {
        for (v, inverse) in v.iter_mut().zip(&self.inverse_root) {
            *v = transposed_times(inverse, *v);
        }
        let places: &[f64] = bytemuck::cast_slice(v);
        for (&place, b) in self.place.iter().zip(b) {
            *b = places[place as usize];
        }
    }

    /// v <- (I + L)^-1 v
    pub fn forward(&self, v: &mut [DVec3]) {
        for g in 0..self.nodes() {
            let y = v[g];
            let column = self.column(g);
            for (block, &row) in self.below[column.clone()].iter().zip(&self.row[column]) {
                v[row as usize] -= *block * y;
            }
        }
    }

    /// v <- (I + L^T)^-1 v
    pub fn backward(&self, v: &mut [DVec3]) {
        for g in (0..self.nodes()).rev() {
            v[g] -= self.above(g, v);
        }
    }

    /// Row g of L^T v
    #[inline]
    fn above(&self, g: usize, v: &[DVec3]) -> DVec3 {
        let column = self.column(g);
        let blocks = self.below[column.clone()].iter().zip(&self.row[column]);
        blocks.fold(DVec3::ZERO, |sum, (block, &row)| sum + transposed_times(block, v[row as usize]))
    }

    /// The product of Eisenstat (1981), for the price of one with W itself: with A = I + L + L^T and p <- z + beta p,
    ///
    /// ```text
    /// q = (I + L)^-1 A (I + L^T)^-1 p = t + (I + L)^-1 (p - t),      t = (I + L^T)^-1 p,      p - t = L^T t
    /// ```
    /// Returns p . q.
    pub fn times(&self, z: &[DVec3], beta: f64, sweep: Sweep<'_>) -> f64 {
        let Sweep { p, t, q } = sweep;
        for g in (0..self.nodes()).rev() {
            let above = self.above(g, t);
            p[g] = z[g] + beta * p[g];
            t[g] = p[g] - above;
            q[g] = above;
        }
        let mut sum = DVec3::ZERO;
        for g in 0..self.nodes() {
            let y = q[g];
            let column = self.column(g);
            for (block, &row) in self.below[column.clone()].iter().zip(&self.row[column]) {
                q[row as usize] -= *block * y;
            }
            q[g] = y + t[g];
            sum += p[g] * q[g];
        }
        sum.element_sum()
    }
}

/// Vectors of a product.
pub(super) struct Sweep<'a> {
    /// direction
    pub p: &'a mut [DVec3],
    /// room
    pub t: &'a mut [DVec3],
    /// the product
    pub q: &'a mut [DVec3],
}

#[inline]
fn transposed_times(block: &DMat3, v: DVec3) -> DVec3 {
    DVec3::new(block.x_axis.dot(v), block.y_axis.dot(v), block.z_axis.dot(v))
}

/// E^-1 of a block E E^T of which the lower triangle is given.
fn inverse_root(block: &DMat3) -> Option<DMat3> {
    let [x, y, z] = [block.x_axis, block.y_axis, block.z_axis];
    let root = |pivot: f64| (pivot > 0.0).then(|| pivot.sqrt());
    let a = root(x.x)?;
    let (b, c) = (x.y / a, x.z / a);
    let d = root(y.y - b * b)?;
    let e = (y.z - c * b) / d;
    let f = root(z.z - c * c - e * e)?;
    let (ia, id, i_f) = (1.0 / a, 1.0 / d, 1.0 / f);
    let below = -b * ia * id;
    let corner = -(c * ia + e * below) * i_f;
    Some(DMat3::from_cols(DVec3::new(ia, below, corner), DVec3::new(0.0, id, -e * id * i_f), DVec3::new(0.0, 0.0, i_f)))
}

/// Drops repeated values of a sorted list and returns how many are left at its start.
fn dedup(sorted: &mut [u32]) -> usize {
    let mut kept = 0;
    for i in 0..sorted.len() {
        if i == 0 || sorted[i] != sorted[kept - 1] {
            sorted[kept] = sorted[i];
            kept += 1;
        }
    }
    kept
}
