//! A symmetric W by the 3x3 blocks of its nodes, and the preconditioner M that goes with it:
//!
//! ```text
//! W = D + N + N^T                    D the blocks on the diagonal, N strictly below them
//! M = (P + N) P^-1 (P + N^T)         P the blocks of its pivots (`pivots`)
//! ```
//! Both are kept in terms of a root of the pivots, P = E E^T:
//!
//! ```text
//! W = E (I + J + L + L^T) E^T,       M = E (I + L) (I + L^T) E^T
//! ```
//! L is stored column by column, in single precision: half the bytes come from memory, and a column of a block is one register. A node with fixed
//! degrees of freedom keeps three places: the idle ones have nothing beside their diagonal, so that a vector which is zero there stays so.

use crate::assembly::Pattern;
use glam::{Mat3A, Vec3A, Vec4, Vec4Swizzles};
use std::ops::Range;
use std::sync::Arc;

/// Entries of a 3x3 block.
pub(super) const BLOCK: u32 = 9;

/// Four numbers of a block.
#[inline(always)]
fn four(numbers: &[f32]) -> Vec4 {
    Vec4::from_array(numbers.first_chunk().copied().unwrap_or_default())
}

/// A block column by column, without the gaps of registers: a large scene's product waits for memory.
#[derive(Clone, Copy)]
pub(super) struct Block(pub [f32; 9]);

impl Block {
    #[inline(always)]
    pub fn matrix(&self) -> Mat3A {
        // The last column from one number earlier, so that nothing beyond the block is read.
        let columns = [four(&self.0), four(&self.0[3..]), four(&self.0[5..]).yzww()];
        let [x, y, z] = columns.map(Vec3A::from_vec4);
        Mat3A::from_cols(x, y, z)
    }
}

/// A symmetric block by its columns' entries from the diagonal on.
#[derive(Clone, Copy, Default)]
pub(super) struct SymmetricBlock(pub [f32; 6]);

impl SymmetricBlock {
    /// Its lower half.
    pub fn of(m: &Mat3A) -> Self {
        let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis];
        SymmetricBlock([x.x, x.y, x.z, y.y, y.z, z.z])
    }

    #[inline(always)]
    pub fn matrix(&self) -> Mat3A {
        let columns = [four(&self.0), four(&self.0[1..]).xzww(), four(&self.0[2..]).xzww()];
        let [x, y, z] = columns.map(Vec3A::from_vec4);
        Mat3A::from_cols(x, y, z)
    }

    /// Adds the lower half of a symmetric one.
    pub fn add(&mut self, m: &Mat3A) {
        self.0.iter_mut().zip(SymmetricBlock::of(m).0).for_each(|(entry, other)| *entry += other);
    }

    pub fn diagonal(&self) -> Vec3A {
        let [x, _, _, y, _, z] = self.0;
        Vec3A::new(x, y, z)
    }
}

/// W = E (I + J + L + L^T) E^T.
pub(super) struct NodeBlocks {
    pub(super) pattern: Arc<Pattern>,
    /// first block of every node's column of L, and their number at the end
    start: Vec<u32>,
    /// row of every block of L
    pub(super) row: Vec<u32>,
    pub(super) below: Vec<Block>,
    /// J: what D has more than P, E^-1 (D - P) E^-T; I + J is positive definite
    pub(super) surplus: Vec<SymmetricBlock>,
    /// 1/sqrt(W_uu) of every unknown: what is scaled by it can be told in single precision
    pub(super) scale: Vec<f64>,
    /// E^-1 of W scaled so
    pub(super) inverse_root: Vec<Mat3A>,
    /// where every stored value of W that is beside the diagonal's blocks goes, among the entries of L
    pub(super) entry: Vec<u32>,
}

impl NodeBlocks {
    /// Stored entries of W beyond which entries of blocks, of which each holds one at least, could not be numbered.
    pub const MOST_ENTRIES: usize = (u32::MAX / BLOCK) as usize;

    /// Finds the blocks of a symmetric pattern, which must have all entries of a block over its free places: what is not stored is never written again.
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
        let (surplus, inverse_root) = (vec![SymmetricBlock::default(); nodes], vec![Mat3A::IDENTITY; nodes]);
        NodeBlocks { pattern, start, row, below, surplus, scale, inverse_root, entry }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.inverse_root.len()
    }

    pub(super) fn column(&self, g: usize) -> Range<usize> {
        self.start[g] as usize..self.start[g + 1] as usize
    }

    /// A number of each of a node's unknowns in its three places, 0 in the idle ones.
    #[inline(always)]
    pub(super) fn places(&self, g: usize, of: impl Fn(usize) -> f32) -> Vec3A {
        let (first, end) = (self.pattern.node_start[g] as usize, self.pattern.node_start[g + 1] as usize);
        if end - first == 3 {
            return Vec3A::new(of(first), of(first + 1), of(first + 2));
        }
        let mut places = Vec3A::ZERO;
        (first..end).for_each(|u| places[self.direction(u)] = of(u));
        places
    }

    /// 0, 1, 2 for an unknown along x, y, z
    pub(super) fn direction(&self, u: usize) -> usize {
        (self.pattern.dof[u] % 3) as usize
    }
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
