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

use super::sections::Subdomain;
use crate::assembly::Pattern;
use crate::mesh::adjacency::Adjacency;
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;
use std::sync::Arc;
use wide::f32x4;

/// Entries of a 3x3 block.
pub(super) const BLOCK: u32 = 9;

/// A vector of a node in one register; its fourth number has no meaning.
#[inline(always)]
pub(super) fn packed(v: Vector3<f32>) -> f32x4 {
    f32x4::new([v.x, v.y, v.z, 0.0])
}

/// The vector of a node.
#[inline(always)]
pub(super) fn unpacked(v: f32x4) -> Vector3<f32> {
    let [x, y, z, _] = v.to_array();
    Vector3::new(x, y, z)
}

/// The columns of a 3x3 block, of its nine numbers and one more: each is read with the number behind it.
#[inline(always)]
pub(super) fn columns(block: &[f32]) -> [f32x4; 3] {
    let column = |numbers: &[f32]| numbers.first_chunk().map_or(f32x4::ZERO, |four| f32x4::new(*four));
    [column(block), column(&block[3..]), column(&block[6..])]
}

/// A matrix by columns times a vector.
#[inline(always)]
pub(super) fn times([x, y, z]: [f32x4; 3], v: f32x4) -> f32x4 {
    let [a, b, c, _] = v.to_array();
    x * a + y * b + z * c
}

/// A symmetric 3x3 block: the lower triangle by columns.
#[derive(Clone, Copy, Default)]
pub(super) struct SymmetricBlock(pub [f32; 6]);

impl SymmetricBlock {
    /// The lower triangle of a symmetric matrix.
    pub(super) fn of(m: &Matrix3<f32>) -> Self {
        SymmetricBlock([m.m11, m.m21, m.m31, m.m22, m.m32, m.m33])
    }

    #[inline(always)]
    pub(super) fn matrix(&self) -> Matrix3<f32> {
        let [xx, yx, zx, yy, zy, zz] = self.0;
        Matrix3::new(xx, yx, zx, yx, yy, zy, zx, zy, zz)
    }

    #[inline(always)]
    pub(super) fn columns(&self) -> [f32x4; 3] {
        let [xx, yx, zx, yy, zy, zz] = self.0;
        [[xx, yx, zx, 0.0], [yx, yy, zy, 0.0], [zx, zy, zz, 0.0]].map(f32x4::new)
    }

    /// Adds the lower triangle of a symmetric matrix.
    pub(super) fn add(&mut self, m: &Matrix3<f32>) {
        self.0.iter_mut().zip(SymmetricBlock::of(m).0).for_each(|(entry, other)| *entry += other);
    }

    pub(super) fn diagonal(&self) -> Vector3<f32> {
        let [x, _, _, y, _, z] = self.0;
        Vector3::new(x, y, z)
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
    /// every block of L by columns, and one number behind the last, as [`columns`] reads it `[9 n_blocks + 1]`
    pub(super) below: Vec<f32>,
    /// J = E^-1 (D - P) E^-T; I + J is positive definite
    pub(super) surplus: Vec<SymmetricBlock>,
    /// E^-1 of W scaled by its diagonal
    pub(super) inverse_root: Vec<Matrix3<f32>>,
    /// index among the entries of L of every stored value in the columns of the subdomain's nodes, then of its
    /// separators', or [`ELSEWHERE`]
    pub(super) entry: Vec<u32>,
}

/// Not in this L: in a diagonal block or in another subdomain's L.
pub(super) const ELSEWHERE: u32 = u32::MAX;

impl NodeBlocks {
    /// Maximum number of stored entries of W. Each block holds one at least, so that entries of blocks fit 32 bits.
    pub(super) const MOST_ENTRIES: usize = (u32::MAX / BLOCK) as usize;

    /// Finds the blocks of a subdomain. The symmetric pattern must have all entries of a block between free components,
    /// as others are never written. `node` is the node of every unknown `[n]`.
    pub(super) fn new(pattern: Arc<Pattern>, subdomain: Subdomain, node: &[u32]) -> Self {
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
        let entry = all_unknowns(&pattern, &subdomain)
            .into_iter()
            .flatten()
            .flat_map(|u| pattern.column(u).iter().map(move |&r| (u as u32, r)))
            .map(|(u, r)| entry_of(u, r).unwrap_or(ELSEWHERE))
            .collect();
        let below = vec![0.0; BLOCK as usize * row.len() + 1];
        let (surplus, inverse_root) = (vec![SymmetricBlock::default(); places], vec![Matrix3::identity(); places]);
        NodeBlocks { pattern, subdomain, start, row, below, surplus, inverse_root, entry }
    }

    /// Number of nodes.
    pub(super) fn nodes(&self) -> usize {
        self.start.len() - 1
    }

    /// A block of L.
    pub(super) fn block(&self, k: usize) -> Matrix3<f32> {
        Matrix3::from_column_slice(&self.below[BLOCK as usize * k..][..BLOCK as usize])
    }

    pub(super) fn set_block(&mut self, k: usize, block: &Matrix3<f32>) {
        self.below[BLOCK as usize * k..][..BLOCK as usize].copy_from_slice(block.as_slice());
    }

    pub(super) fn column(&self, g: usize) -> Range<usize> {
        self.start[g] as usize..self.start[g + 1] as usize
    }

    /// The 3-vector of a node from a function of its unknowns; 0 at fixed components.
    #[inline(always)]
    pub(super) fn node_vector(&self, local: usize, of: impl Fn(usize) -> f32) -> Vector3<f32> {
        let node = self.subdomain.node(local);
        let (first, end) = (self.pattern.node_start[node] as usize, self.pattern.node_start[node + 1] as usize);
        if end - first == 3 {
            return Vector3::new(of(first), of(first + 1), of(first + 2));
        }
        let mut places = Vector3::zeros();
        (first..end).for_each(|u| places[self.direction(u)] = of(u));
        places
    }

    /// 0, 1, 2 for an unknown along x, y, z
    pub(super) fn direction(&self, u: usize) -> usize {
        (self.pattern.dof[u] % 3) as usize
    }

    /// Unknowns of a node of the subdomain.
    #[inline(always)]
    pub(super) fn unknowns_of(&self, g: usize) -> Range<usize> {
        let node = self.subdomain.node(g);
        self.pattern.node_start[node] as usize..self.pattern.node_start[node + 1] as usize
    }

    /// Unknowns of the subdomain's own nodes and of its separators.
    pub(super) fn unknowns(&self) -> [Range<usize>; 3] {
        all_unknowns(&self.pattern, &self.subdomain)
    }
}

fn all_unknowns(pattern: &Pattern, Subdomain { own, beside: [before, behind], .. }: &Subdomain) -> [Range<usize>; 3] {
    [own, before, behind].map(|nodes| unknowns(pattern, nodes))
}

fn unknowns(pattern: &Pattern, nodes: &Range<usize>) -> Range<usize> {
    pattern.node_start[nodes.start] as usize..pattern.node_start[nodes.end] as usize
}

/// Calls `found(column, row)`, local indices, for every off-diagonal block of a subdomain's L.
fn pairs(pattern: &Pattern, subdomain: &Subdomain, node: &[u32], mut found: impl FnMut(usize, usize)) {
    let [before, behind] = subdomain.beside.clone();
    for g in subdomain.own.clone().chain(before).chain(behind) {
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
