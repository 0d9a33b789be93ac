//! Deflation of conjugate gradients (Nicolaides, SIAM J. Numer. Anal. 24, 1987; Saad, Yeung, Erhel & Guyomarc'h, SIAM
//! J. Sci. Comput. 21, 2000): translations of aggregates, each some dozens of nodes side by side, are solved for by
//! Cholesky in every iteration, and conjugate gradients do the rest.
//!
//! ```text
//! Z   one column for each translation of each aggregate          C = Z^T W Z   the coarse matrix
//! ```
//! An incomplete factorisation reduces what changes from node to node, but needs as many iterations for a smooth
//! motion as there are nodes across it. The aggregates leave only what is smaller than they are, so that the number of
//! iterations hardly grows with the number of nodes or with the step.
//!
//! In the terms of `bsr`, where A = I + J + L + L^T acts on E^T Y x, Z has the blocks E_g^T Y_g of its aggregate. Rows
//! of Z and of A Z are stored: most nodes meet their own aggregate only.

use super::bsr::{BLOCK, NodeBlocks, columns, packed, times, unpacked};
use super::coarse_matrix::CoarseMatrix;
use super::eisenstat::Curvature;
use super::linear::LinearError;
use super::partitioned_cg::{PartitionedSystem, SubdomainSystem, both};
use super::twisted_factorization::Subdomain;
use crate::assembly::Pattern;
use crate::mesh::adjacency::Adjacency;
use nalgebra::Matrix3;
use std::sync::Arc;
use wide::f32x4;

/// Rows of Z and A Z of a subdomain, and its part of coarse right-hand sides; empty before the first deflation.
#[derive(Default)]
pub(super) struct CoarseRows {
    /// aggregate of every local node `[n_local]`
    aggregate: Vec<u32>,
    /// block of Z of every local node by columns, and one number behind the last `[9 n_local + 1]`
    basis: Vec<f32>,
    /// first block of A Z of every own node, and the number of blocks at the end `[n_own + 1]`
    start: Vec<u32>,
    /// aggregate of every block
    column: Vec<u32>,
    /// transposed blocks of A Z, stored as `basis`
    blocks: Vec<f32>,
    /// the sums of this subdomain, by aggregate
    pub(super) sums: Vec<f32x4>,
}

impl CoarseRows {
    /// Of a subdomain; `rows` are the aggregates that nodes meet.
    fn new(coarse: &CoarseMatrix, rows: &Adjacency, subdomain: &Subdomain) -> Self {
        let local = |place| subdomain.node(place) as u32;
        let own = (0..subdomain.own.len()).map(local);
        let lengths = own.clone().scan(0, |end, g| {
            *end += rows.row(g).len() as u32;
            Some(*end)
        });
        let column: Vec<u32> = own.clone().flat_map(|g| rows.row(g)).copied().collect();
        CoarseRows {
            aggregate: (0..subdomain.n_local()).map(|place| coarse.aggregate[local(place) as usize]).collect(),
            basis: vec![0.0; BLOCK as usize * subdomain.n_local() + 1],
            start: std::iter::once(0).chain(lengths).collect(),
            blocks: vec![0.0; BLOCK as usize * column.len() + 1],
            column,
            sums: vec![f32x4::ZERO; coarse.weight.len()],
        }
    }

    fn basis_of(&self, g: usize) -> Matrix3<f32> {
        Matrix3::from_column_slice(&self.basis[BLOCK as usize * g..][..BLOCK as usize])
    }

    /// Adds a block to row g of A Z.
    fn add(&mut self, g: usize, aggregate: u32, block: &Matrix3<f32>) {
        let row = self.start[g] as usize..self.start[g + 1] as usize;
        if let Some(k) = row.into_iter().find(|&k| self.column[k] == aggregate) {
            let numbers = &mut self.blocks[BLOCK as usize * k..][..BLOCK as usize];
            numbers.iter_mut().zip(block.transpose().as_slice()).for_each(|(sum, entry)| *sum += entry);
        }
    }

    /// Sets the rows from a factorised subdomain, without what a separator gets from its halves.
    fn set(&mut self, blocks: &NodeBlocks, scale: &[f64], weight: &[f64]) {
        for g in 0..self.aggregate.len() {
            let weight = weight[self.aggregate[g] as usize];
            let translation = blocks.node_vector(g, |u| (weight / scale[u]) as f32);
            let root = blocks.inverse_root[g].cast::<f64>().try_inverse().unwrap_or_default().transpose();
            let basis = root.cast::<f32>() * Matrix3::from_diagonal(&translation);
            self.basis[BLOCK as usize * g..][..BLOCK as usize].copy_from_slice(basis.as_slice());
        }
        self.blocks.fill(0.0);
        let own = blocks.nodes();
        for g in 0..own {
            let (aggregate, basis) = (self.aggregate[g], self.basis_of(g));
            self.add(g, aggregate, &(basis + blocks.surplus[g].matrix() * basis));
            for k in blocks.column(g) {
                let (row, block) = (blocks.row[k] as usize, blocks.block(k));
                let (other, beside) = (self.aggregate[row], self.basis_of(row));
                self.add(g, other, &block.tr_mul(&beside));
                if row < own {
                    self.add(row, aggregate, &(block * basis));
                }
            }
        }
    }

    /// Adds to this separator's rows what they get from a half.
    fn add_half(&mut self, half: &CoarseRows, blocks: &NodeBlocks) {
        for g in 0..blocks.nodes() {
            for k in blocks.column(g) {
                if let Some(row) = (blocks.row[k] as usize).checked_sub(blocks.nodes()) {
                    self.add(row, half.aggregate[g], &(blocks.block(k) * half.basis_of(g)));
                }
            }
        }
    }

    /// sums <- 0
    fn clear(&mut self) {
        self.sums.fill(f32x4::ZERO);
    }

    /// sums += (row g of A Z)^T u
    #[inline(always)]
    pub(super) fn restrict(&mut self, g: usize, u: f32x4) {
        let row = self.start[g] as usize..self.start[g + 1] as usize;
        let numbers = &self.blocks[BLOCK as usize * row.start..=BLOCK as usize * row.end];
        let blocks = numbers.windows(BLOCK as usize + 1).step_by(BLOCK as usize);
        for (block, &aggregate) in blocks.zip(&self.column[row]) {
            self.sums[aggregate as usize] += times(columns(block), u);
        }
    }

    /// sums <- Z^T v for the own nodes' v
    pub(super) fn project(&mut self, v: &[f32x4]) {
        self.clear();
        for (g, v) in v.iter().enumerate() {
            let sum = self.basis_of(g).tr_mul(&unpacked(*v));
            self.sums[self.aggregate[g] as usize] += packed(sum);
        }
    }

    /// t <- u + beta t - Z translation
    pub(super) fn combine(&self, translation: &[f32x4], u: &[f32x4], beta: f32, t: &mut [f32x4]) {
        let bases = self.basis.windows(BLOCK as usize + 1).step_by(BLOCK as usize);
        for (((t, u), &a), basis) in t.iter_mut().zip(u).zip(&self.aggregate).zip(bases) {
            *t = *u + *t * beta - times(columns(basis), translation[a as usize]);
        }
    }
}

impl SubdomainSystem {
    /// u <- (I + L^T)^-1 r, and its sums
    fn back_residual(&mut self) {
        self.coarse.clear();
        self.blocks.back_residual(&self.r, &mut self.u, &mut self.coarse);
    }

    /// t <- u + beta t - Z translation, q <- (I + L)^-1 A t
    fn deflated_product(&mut self, translation: &[f32x4], beta: f32, halves: Option<&[SubdomainSystem; 2]>) {
        self.coarse.combine(translation, &self.u, beta, &mut self.t);
        self.q.fill(f32x4::ZERO);
        halves.into_iter().for_each(|halves| self.add_halves(halves));
        self.reductions.curvature = self.blocks.product(&self.t, &mut self.q);
    }
}

impl PartitionedSystem {
    /// Factorises W with deflation by aggregates of at most `largest` nodes; `values` [nonzeros]. Returns `false` if W
    /// is found not to be positive definite.
    ///
    /// # Errors
    /// When the analysis of the coarse matrix fails, or its entries are not finite.
    pub(super) fn deflate(&mut self, values: &[f64], largest: usize) -> Result<bool, LinearError> {
        let pattern = Arc::clone(&self.separator.blocks.pattern);
        let mut coarse = match self.coarse.take() {
            Some(coarse) => coarse,
            None => self.coarsen(&pattern, largest)?,
        };
        // Fill in the pivots would only make up for smooth modes.
        let found = match self.set_values(values, 0.0) {
            true => coarse.set_values(&pattern, values, &self.scale),
            false => Ok(false),
        };
        if found == Ok(true) {
            let PartitionedSystem { halves, separator, scale, workers, .. } = self;
            both(workers, halves, |half| half.coarse.set(&half.blocks, scale, &coarse.weight));
            separator.coarse.set(&separator.blocks, scale, &coarse.weight);
            halves.iter().for_each(|half| separator.coarse.add_half(&half.coarse, &half.blocks));
        }
        (self.coarse, self.deflated) = (Some(coarse), found == Ok(true));
        found
    }

    fn coarsen(&mut self, pattern: &Pattern, largest: usize) -> Result<CoarseMatrix, LinearError> {
        let (coarse, rows) = CoarseMatrix::new(pattern, largest)?;
        for part in self.halves.iter_mut().chain([&mut self.separator]) {
            part.coarse = CoarseRows::new(&coarse, &rows, &part.blocks.subdomain);
            part.u = vec![f32x4::ZERO; part.t.len()];
        }
        Ok(coarse)
    }

    /// x^ <- (I + L^T) Z C^-1 Z^T E^-1 b, which solves for the translations of aggregates, and r; returns r . r.
    ///
    /// # Errors
    /// A b that is not finite.
    pub(super) fn begin_deflated(&mut self) -> Result<f64, LinearError> {
        for part in self.halves.iter_mut().chain([&mut self.separator]) {
            part.u.fill(f32x4::ZERO);
            part.t.fill(f32x4::ZERO);
        }
        self.solve_coarse(-1.0)?;
        self.apply(0.0);
        Ok(self.advance(1.0))
    }

    /// p <- r + beta p - (I + L^T) Z C^-1 (A Z)^T (I + L^T)^-1 r, q <- (I + L)^-1 A (I + L^T)^-1 p
    ///
    /// # Errors
    /// An r that is not finite.
    pub(super) fn deflated_product(&mut self, beta: f32) -> Result<Curvature, LinearError> {
        let PartitionedSystem { halves, separator, workers, .. } = self;
        separator.back_residual();
        both(workers, halves, |half| {
            half.u[half.blocks.nodes()..].copy_from_slice(&separator.u);
            half.back_residual();
        });
        self.solve_coarse(1.0)?;
        Ok(self.apply(beta))
    }

    fn solve_coarse(&mut self, share: f32) -> Result<(), LinearError> {
        let PartitionedSystem { halves, separator, coarse, .. } = self;
        let parts = halves.iter().chain([&*separator]).map(|part| &*part.coarse.sums);
        coarse.as_mut().map_or(Ok(()), |coarse| coarse.solve(parts, share))
    }

    fn apply(&mut self, beta: f32) -> Curvature {
        let PartitionedSystem { halves, separator, coarse, workers, .. } = self;
        let translation = coarse.as_ref().map_or(&[][..], |coarse| &coarse.translation);
        both(workers, halves, |half| half.deflated_product(translation, beta, None));
        separator.deflated_product(translation, beta, Some(halves));
        self.curvature()
    }
}
