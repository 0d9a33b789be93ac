//! A symmetric W by the 3x3 blocks of its nodes, and the preconditioner M that goes with it:
//!
//! ```text
//! W = D + N + N^T                    D the blocks on the diagonal, N strictly below them
//! M = (P + N) P^-1 (P + N^T)         P the blocks of its pivots (`relaxed_ic0`)
//! ```
//! Both are stored in terms of a root of the pivots, P = E E^T:
//!
//! ```text
//! W = E (I + J + L + L^T) E^T,       M = E (I + L) (I + L^T) E^T
//! ```
//! L is stored column by column in single precision: half the memory traffic, and a column of a block fits one
//! register. A node always has three components; those of fixed degrees of freedom have nothing beside their diagonal,
//! so a vector that is zero there stays zero.

use super::twisted_factorization::Subdomain;
use crate::assembly::Pattern;
use crate::mesh::adjacency::Adjacency;
use glam::{Mat3A, Vec3A, Vec4, Vec4Swizzles};
use std::ops::Range;
use std::sync::Arc;

/// Entries of a 3x3 block.
pub(super) const BLOCK: u32 = 9;

/// Loads four numbers of a block at once. If they are loaded one by one, compilers combine them in twice the
/// instructions in some places.
#[inline(always)]
fn four(numbers: &[f32]) -> Vec4 {
    numbers.first_chunk::<4>().map_or(Vec4::ZERO, |four| bytemuck::pod_read_unaligned(bytemuck::bytes_of(four)))
}

/// A 3x3 block by columns, without padding: the product of a large scene is limited by memory.
#[derive(Clone, Copy)]
pub(super) struct Block(pub [f32; 9]);

impl Block {
    #[inline(always)]
    pub fn matrix(&self) -> Mat3A {
        // The last column is loaded from one entry earlier, to stay within the block.
        let columns = [four(&self.0), four(&self.0[3..]), four(&self.0[5..]).yzww()];
        let [x, y, z] = columns.map(Vec3A::from_vec4);
        Mat3A::from_cols(x, y, z)
    }
}

/// A symmetric 3x3 block: the lower triangle by columns.
#[derive(Clone, Copy, Default)]
pub(super) struct SymmetricBlock(pub [f32; 6]);

impl SymmetricBlock {
    /// The lower triangle of a symmetric matrix.
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

    /// Adds the lower triangle of a symmetric matrix.
    pub fn add(&mut self, m: &Mat3A) {
        self.0.iter_mut().zip(SymmetricBlock::of(m).0).for_each(|(entry, other)| *entry += other);
    }

    pub fn diagonal(&self) -> Vec3A {
        let [x, _, _, y, _, z] = self.0;
        Vec3A::new(x, y, z)
    }
}

/// The part of W = E (I + J + L + L^T) E^T in the columns of a subdomain's nodes.
pub(super) struct NodeBlocks {
    pub(super) pattern: Arc<Pattern>,
    pub(super) subdomain: Subdomain,
    /// first block of every node's column of L, and the number of blocks at the end `[n_own + 1]`
    start: Vec<u32>,
    /// row of every block of L, as a local index
    pub(super) row: Vec<u32>,
    pub(super) below: Vec<Block>,
    /// J = E^-1 (D - P) E^-T; I + J is positive definite
    pub(super) surplus: Vec<SymmetricBlock>,
    /// E^-1 of W scaled by its diagonal
    pub(super) inverse_root: Vec<Mat3A>,
    /// index among the entries of L of every stored value in the columns of the subdomain's nodes, then of its
    /// separator's, or [`ELSEWHERE`]
    pub(super) entry: Vec<u32>,
}

/// Not in this L: in a diagonal block or in another subdomain's L.
pub(super) const ELSEWHERE: u32 = u32::MAX;

impl NodeBlocks {
    /// Maximum number of stored entries of W. Each block holds one at least, so that entries of blocks fit 32 bits.
    pub const MOST_ENTRIES: usize = (u32::MAX / BLOCK) as usize;

    /// Finds the blocks of a subdomain. The symmetric pattern must have all entries of a block between free components,
    /// as others are never written. `node` is the node of every unknown `[n]`.
    pub fn new(pattern: Arc<Pattern>, subdomain: Subdomain, node: &[u32]) -> Self {
        let (own, places) = (subdomain.own.len(), subdomain.n_local());
        let mut found = Vec::new();
        pairs(&pattern, &subdomain, node, |column, row| found.push((column as u32, row as u32)));
        let Adjacency { start, items: mut row } = Adjacency::new(own, found.iter().copied());
        (0..own).for_each(|g| row[start[g] as usize..start[g + 1] as usize].sort_unstable());
        let place = |unknown: u32| subdomain.local_index(node[unknown as usize] as usize);
        let entry_of = |u: u32, r: u32| {
            let (at, other) = (place(u)?, place(r)?);
            let [(column, u), (other, r)] = if at < other { [(at, u), (other, r)] } else { [(other, r), (at, u)] };
            let first = *start.get(column).filter(|_| column < own)? as usize;
            let block = first + row[first..start[column + 1] as usize].binary_search(&(other as u32)).ok()?;
            Some(BLOCK * block as u32 + 3 * (pattern.dof[u as usize] % 3) + pattern.dof[r as usize] % 3)
        };
        let columns =
            unknowns(&pattern, &subdomain.own).chain(unknowns(&pattern, &subdomain.separator)).map(|u| u as u32);
        let entry = columns
            .flat_map(|u| pattern.column(u as usize).iter().map(move |&r| (u, r)))
            .map(|(u, r)| entry_of(u, r).unwrap_or(ELSEWHERE))
            .collect();
        let below = vec![Block([0.0; 9]); row.len()];
        let (surplus, inverse_root) = (vec![SymmetricBlock::default(); places], vec![Mat3A::IDENTITY; places]);
        NodeBlocks { pattern, subdomain, start, row, below, surplus, inverse_root, entry }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.start.len() - 1
    }

    pub(super) fn column(&self, g: usize) -> Range<usize> {
        self.start[g] as usize..self.start[g + 1] as usize
    }

    /// The 3-vector of a node from a function of its unknowns; 0 at fixed components.
    #[inline(always)]
    pub(super) fn node_vector(&self, local: usize, of: impl Fn(usize) -> f32) -> Vec3A {
        let node = self.subdomain.node(local);
        let (first, end) = (self.pattern.node_start[node] as usize, self.pattern.node_start[node + 1] as usize);
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

    /// Unknowns of a node of the subdomain.
    #[inline(always)]
    pub fn unknowns_of(&self, g: usize) -> Range<usize> {
        let node = self.subdomain.node(g);
        self.pattern.node_start[node] as usize..self.pattern.node_start[node + 1] as usize
    }

    /// Unknowns of the subdomain's own nodes and of its separator.
    pub fn unknowns(&self) -> [Range<usize>; 2] {
        [unknowns(&self.pattern, &self.subdomain.own), unknowns(&self.pattern, &self.subdomain.separator)]
    }
}

fn unknowns(pattern: &Pattern, nodes: &Range<usize>) -> Range<usize> {
    pattern.node_start[nodes.start] as usize..pattern.node_start[nodes.end] as usize
}

/// Calls `found(column, row)`, local indices, for every off-diagonal block of a subdomain's L.
fn pairs(pattern: &Pattern, subdomain: &Subdomain, node: &[u32], mut found: impl FnMut(usize, usize)) {
    for g in subdomain.own.clone().chain(subdomain.separator.clone()) {
        // All unknowns of a node have the same neighbours.
        let Some(first) = unknowns(pattern, &(g..g + 1)).next() else { continue };
        for &r in pattern.column(first) {
            let other = node[r as usize] as usize;
            let leads = other != g && r == pattern.node_start[other];
            if let Some((at, other)) = subdomain.local_index(g).zip(subdomain.local_index(other)).filter(|_| leads)
                && at.min(other) < subdomain.own.len()
            {
                found(at.min(other), at.max(other));
            }
        }
    }
}
