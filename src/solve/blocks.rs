//! A symmetric W by the 3x3 blocks of its nodes, scaled so that the blocks on the diagonal are the identity:
//!
//! ```text
//! W = E (I + L + L^T) E^T,      E E^T the blocks on the diagonal, L strictly below them
//! ```
//! Only L is stored, column by column, in single precision: its entries are at most 1, half the bytes come from memory, and a column of a
//! block is one register. A node with fixed degrees of freedom keeps three places: the idle ones have the identity and nothing beside it, so that a
//! vector which is zero there stays so.

use crate::assembly::Pattern;
use glam::{DMat3, DVec3, Mat3A, Vec3A, Vec4, Vec4Swizzles};
use std::ops::Range;
use std::sync::Arc;

/// Entries of a 3x3 block.
const BLOCK: u32 = 9;
/// A positive definite I + L + L^T has entries below 1; a larger one than this is more than rounding.
const LARGEST: f32 = 1.0 + 1e-5;

/// A block column by column, without the gaps of registers: a large scene's product waits for memory.
#[derive(Clone, Copy)]
struct Block([f32; 9]);

impl Block {
    #[inline(always)]
    fn matrix(&self) -> Mat3A {
        let four = |first: usize| Vec4::from_array(self.0[first..].first_chunk().copied().unwrap_or_default());
        // The last column from one number earlier, so that nothing beyond the block is read.
        Mat3A::from_cols(Vec3A::from_vec4(four(0)), Vec3A::from_vec4(four(3)), Vec3A::from_vec4(four(5).yzww()))
    }
}

/// W = E (I + L + L^T) E^T.
pub(super) struct NodeBlocks {
    pattern: Arc<Pattern>,
    /// first block of every node's column of L, and their number at the end
    start: Vec<u32>,
    /// row of every block of L
    row: Vec<u32>,
    below: Vec<Block>,
    /// 1/sqrt(W_uu) of every unknown: what is scaled by it can be told in single precision
    scale: Vec<f64>,
    /// E^-1 of W scaled so
    inverse_root: Vec<Mat3A>,
    /// where every stored value of W that is beside the diagonal's blocks goes, among the entries of L
    entry: Vec<u32>,
}

impl NodeBlocks {
    /// Stored entries of W beyond which entries of blocks, of which each holds one at least, could not be numbered.
    pub const MOST_ENTRIES: usize = (u32::MAX / BLOCK) as usize;

    /// Finds the blocks of a symmetric pattern.
    pub fn new(pattern: Arc<Pattern>) -> Self {
        let nodes = pattern.node_start.len() - 1;
        let mut node = vec![0; pattern.n()];
        for (g, unknowns) in (0..).zip(pattern.node_start.windows(2)) {
            node[unknowns[0] as usize..unknowns[1] as usize].fill(g);
        }
        let (mut start, mut row, mut entry) = (vec![0], Vec::new(), vec![0; pattern.nonzeros()]);
        for (g, columns) in (0..).zip(pattern.node_start.windows(2)) {
            let first = row.len();
            let all = (columns[0]..columns[1]).flat_map(|u| pattern.column(u as usize)).map(|&r| node[r as usize]);
            row.extend(all.filter(|&r| r != g));
            row[first..].sort_unstable();
            let kept = first + dedup(&mut row[first..]);
            row.truncate(kept);
            for u in columns[0] as usize..columns[1] as usize {
                let slots = pattern.col_ptr[u] as usize..pattern.col_ptr[u + 1] as usize;
                for (entry, &r) in entry[slots].iter_mut().zip(pattern.column(u)) {
                    if let Ok(at) = row[first..].binary_search(&node[r as usize]) {
                        *entry = BLOCK * (first + at) as u32 + 3 * (pattern.dof[u] % 3) + pattern.dof[r as usize] % 3;
                    }
                }
            }
            start.push(row.len() as u32);
        }
        row.shrink_to_fit();
        let (below, scale) = (vec![Block([0.0; 9]); row.len()], vec![0.0; pattern.n()]);
        NodeBlocks { pattern, start, row, below, scale, inverse_root: vec![Mat3A::IDENTITY; nodes], entry }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.inverse_root.len()
    }

    /// Takes the values of W; whether the blocks on its diagonal are positive definite, and those beside them no larger than that allows.
    pub fn fill(&mut self, values: &[f64]) -> bool {
        let pattern = Arc::clone(&self.pattern);
        for (scale, &first) in self.scale.iter_mut().zip(&pattern.col_ptr) {
            // Rows ascend from the diagonal.
            *scale = values[first as usize].sqrt().recip();
        }
        let mut small = true;
        for (g, unknowns) in pattern.node_start.windows(2).enumerate() {
            let mut diagonal = DMat3::IDENTITY;
            for u in unknowns[0] as usize..unknowns[1] as usize {
                let slots = pattern.col_ptr[u] as usize..pattern.col_ptr[u + 1] as usize;
                for ((&r, value), &entry) in
                    pattern.column(u).iter().zip(&values[slots.clone()]).zip(&self.entry[slots])
                {
                    let scaled = value * self.scale[u] * self.scale[r as usize];
                    if r < unknowns[1] {
                        diagonal.col_mut((pattern.dof[u] % 3) as usize)[(pattern.dof[r as usize] % 3) as usize] =
                            scaled;
                    } else {
                        small &= scaled.abs() <= f64::from(LARGEST);
                        let (block, within) = ((entry / BLOCK) as usize, (entry % BLOCK) as usize);
                        self.below[block].0[within] = scaled as f32;
                    }
                }
            }
            let Some(inverse) = inverse_root(&diagonal) else { return false };
            self.inverse_root[g] = inverse;
        }
        small && self.scale_blocks()
    }

    fn scale_blocks(&mut self) -> bool {
        let mut largest = Vec3A::ZERO;
        for g in 0..self.nodes() {
            let right = self.inverse_root[g].transpose();
            for k in self.column(g) {
                let block = self.inverse_root[self.row[k] as usize] * self.below[k].matrix() * right;
                largest = largest.max(block.x_axis.abs()).max(block.y_axis.abs()).max(block.z_axis.abs());
                self.below[k] = Block(block.to_cols_array());
            }
        }
        largest.max_element() <= LARGEST
    }

    fn column(&self, g: usize) -> Range<usize> {
        self.start[g] as usize..self.start[g + 1] as usize
    }

    /// v = E^-1 b / s, with s of the size of E^-1 b, which is returned.
    pub fn gather(&self, b: &[f64], v: &mut [Vec3A]) -> f64 {
        let size = b.iter().zip(&self.scale).fold(0.0_f64, |size, (b, scale)| size.max((b * scale).abs()));
        let inverse = if size > 0.0 { size.recip() } else { 0.0 };
        let single = |u: usize| (b[u] * self.scale[u] * inverse) as f32;
        for (g, unknowns) in self.pattern.node_start.windows(2).enumerate() {
            let (first, end) = (unknowns[0] as usize, unknowns[1] as usize);
            let own = if end - first == 3 {
                Vec3A::new(single(first), single(first + 1), single(first + 2))
            } else {
                let mut own = Vec3A::ZERO;
                (first..end).for_each(|u| own[self.direction(u)] = single(u));
                own
            };
            v[g] = self.inverse_root[g] * own;
        }
        size
    }

    /// b = s E^-T v
    pub fn scatter(&self, v: &[Vec3A], s: f64, b: &mut [f64]) {
        for (g, unknowns) in self.pattern.node_start.windows(2).enumerate() {
            let own = self.inverse_root[g].transpose() * v[g];
            let (first, end) = (unknowns[0] as usize, unknowns[1] as usize);
            for (i, b) in b[first..end].iter_mut().enumerate() {
                let direction = if end - first == 3 { i } else { self.direction(first + i) };
                *b = f64::from(own[direction]) * self.scale[first + i] * s;
            }
        }
    }

    /// 0, 1, 2 for an unknown along x, y, z
    fn direction(&self, u: usize) -> usize {
        (self.pattern.dof[u] % 3) as usize
    }

    /// v <- (I + L)^-1 v
    pub fn forward(&self, v: &mut [Vec3A]) {
        for g in 0..self.nodes() {
            let y = v[g];
            let column = self.column(g);
            for (block, &row) in self.below[column.clone()].iter().zip(&self.row[column]) {
                v[row as usize] -= block.matrix() * y;
            }
        }
    }

    /// v <- (I + L^T)^-1 v
    pub fn backward(&self, v: &mut [Vec3A]) {
        for g in (0..self.nodes()).rev() {
            v[g] -= self.above(g, v);
        }
    }

    /// Row g of L^T v
    #[inline(always)]
    fn above(&self, g: usize, v: &[Vec3A]) -> Vec3A {
        let column = self.column(g);
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

    /// The product of Eisenstat (1981), for the price of one with W itself: with A = I + L + L^T and p <- z + beta p,
    ///
    /// ```text
    /// q = (I + L)^-1 A (I + L^T)^-1 p = t + (I + L)^-1 (p - t),      t = (I + L^T)^-1 p,      p - t = L^T t
    /// ```
    pub fn times(&self, z: &[Vec3A], beta: f32, sweep: Sweep<'_>) -> Curvature {
        let Sweep { p, t, q } = sweep;
        for g in (0..self.nodes()).rev() {
            let above = self.above(g, t);
            p[g] = z[g] + beta * p[g];
            t[g] = p[g] - above;
            q[g] = above;
        }
        let (mut along, mut squares) = (DVec3::ZERO, DVec3::ZERO);
        for g in 0..self.nodes() {
            let y = q[g];
            let column = self.column(g);
            for (block, &row) in self.below[column.clone()].iter().zip(&self.row[column]) {
                q[row as usize] -= block.matrix() * y;
            }
            q[g] = y + t[g];
            along += (p[g] * q[g]).as_dvec3();
            squares += (p[g] * p[g]).as_dvec3();
        }
        Curvature { along: along.element_sum(), squares: squares.element_sum() }
    }
}

/// What a product tells of its direction p.
pub(super) struct Curvature {
    /// p . q
    pub along: f64,
    /// p . p
    pub squares: f64,
}

/// Vectors of a product.
pub(super) struct Sweep<'a> {
    /// direction
    pub p: &'a mut [Vec3A],
    /// room
    pub t: &'a mut [Vec3A],
    /// the product
    pub q: &'a mut [Vec3A],
}

/// E^-1 of a block E E^T of which the lower triangle is given.
fn inverse_root(block: &DMat3) -> Option<Mat3A> {
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
    let columns = [DVec3::new(ia, below, corner), DVec3::new(0.0, id, -e * id * i_f), DVec3::new(0.0, 0.0, i_f)];
    let [x, y, z] = columns.map(|column| column.as_vec3a());
    Some(Mat3A::from_cols(x, y, z))
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
