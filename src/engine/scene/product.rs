//! Products of the tangents of a network with a vector, without a matrix.

use super::network::{Network, by_node};
use crate::assembly::TangentSystem;
use crate::force::{TangentForm, TangentSink};
use crate::model::state::StateRef;
use crate::model::system::Weights;
use nalgebra::{Matrix3, Vector3};

impl Network {
    /// y = A p, or A^T p where `TRANSPOSED`, with A = c C + k K at a state; held degrees of freedom included.
    pub(super) fn product<const TRANSPOSED: bool>(&self, at: StateRef<'_>, w: Weights, p: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        self.emit_tangents(at, w, TangentForm::EXACT, &mut Product::<TRANSPOSED>::new(p, y));
        self.add_rank_ones::<TRANSPOSED>(at, w, p, y);
    }

    /// Adds the rank-one parts of the same product.
    pub(super) fn add_rank_ones<const TRANSPOSED: bool>(&self, at: StateRef<'_>, w: Weights, p: &[f64], y: &mut [f64]) {
        let (mut u, mut g) = (Vec::new(), Vec::new());
        for which in 0..self.rank_ones() {
            u.resize(p.len(), 0.0);
            g.resize(p.len(), 0.0);
            self.rank_one(which, at, w, &mut u, &mut g);
            let [onto, along] = if TRANSPOSED { [&g, &u] } else { [&u, &g] };
            let amount: f64 = along.iter().zip(p).map(|(along, p)| along * p).sum();
            y.iter_mut().zip(onto).for_each(|(y, onto)| *y += amount * *onto);
        }
    }
}

/// Multiplies emitted blocks by a vector instead of storing them: y += A p or A^T p.
pub(super) struct Product<'a, const TRANSPOSED: bool> {
    p: &'a [Vector3<f64>],
    y: &'a mut [Vector3<f64>],
}

impl<'a, const TRANSPOSED: bool> Product<'a, TRANSPOSED> {
    pub(super) fn new(p: &'a [f64], y: &'a mut [f64]) -> Self {
        Product { p: by_node(p), y: bytemuck::cast_slice_mut(y) }
    }

    fn times(block: &Matrix3<f64>, p: Vector3<f64>) -> Vector3<f64> {
        if TRANSPOSED { block.tr_mul(&p) } else { block * p }
    }

    /// A block of row node i and column node j.
    fn block(&mut self, [i, j]: [u32; 2], block: &Matrix3<f64>) {
        let [row, column] = if TRANSPOSED { [j, i] } else { [i, j] };
        self.y[row as usize] += Self::times(block, self.p[column as usize]);
    }

    /// An element with any blocks.
    fn element<const N: usize>(&mut self, nodes: [u32; N], blocks: &[[Matrix3<f64>; N]; N]) {
        for (&i, row) in nodes.iter().zip(blocks) {
            for (&j, block) in nodes.iter().zip(row) {
                self.block([i, j], block);
            }
        }
    }
}

impl<const TRANSPOSED: bool> TangentSink for Product<'_, TRANSPOSED> {
    fn pair(&mut self, nodes: [u32; 2], block: Matrix3<f64>) {
        self.block(nodes, &block);
    }

    fn edge(&mut self, [a, b]: [u32; 2], block: Matrix3<f64>) {
        let d = Self::times(&block, self.p[a as usize] - self.p[b as usize]);
        self.y[a as usize] += d;
        self.y[b as usize] -= d;
    }

    fn segment(&mut self, nodes: [u32; 2], blocks: &[[Matrix3<f64>; 2]; 2]) {
        self.element(nodes, blocks);
    }

    fn triangle(&mut self, nodes: [u32; 3], blocks: &[[Matrix3<f64>; 3]; 3]) {
        self.element(nodes, blocks);
    }

    fn none(&mut self, _: &[u32]) {}

    fn few(&mut self, nodes: &[u32], blocks: &[[Matrix3<f64>; 4]; 4]) {
        for (&i, row) in nodes.iter().zip(blocks) {
            for (&j, block) in nodes.iter().zip(row) {
                self.block([i, j], block);
            }
        }
    }
}
