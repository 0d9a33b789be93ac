//! Sweeps of Gauss and Seidel over the 3x3 blocks of a symmetric matrix A = L + D + L^T, in single precision.
//!
//! ```text
//! forwards, from 0:    x = (D + L)^-1 r                          left = r - A x
//! backwards, from x:   z = x + (D + L^T)^-1 (r - A x)            A z = r - L (x - z)
//! ```
//! The first and the second after it are one symmetric sweep. Nodes are divided into sections. A sweep goes through
//! every section by itself, on any thread, and takes what lies between sections from where it began, so that its bits
//! do not depend on the number of threads. Every block is stored once, with its transpose: in a section a row is read
//! once to take from the nodes before it and to give to them.

use super::super::bsr::{columns, times};
use super::block_rows::{BlockRows, Columns, SECTION, sections, sections_mut};
use super::numbers::Numbers;
use crate::mesh::adjacency::Adjacency;
use crate::model::workers::Workers;
use multiversion::multiversion;
use nalgebra::Matrix3;
use std::sync::atomic::{AtomicBool, Ordering};
use wide::f32x4;

/// A symmetric matrix.
#[derive(Debug)]
pub(super) struct Smoother {
    /// transposed blocks below the diagonal in a section; columns count from the first node of the section
    below: BlockRows,
    /// blocks of every node with those of later sections
    behind: BlockRows,
    /// columns of `behind`: blocks of every node with those of earlier sections
    before: Columns,
    /// D^-1, as the numbers of [`BlockRows`]; 0 at fixed components
    inverse: Vec<f32>,
}

impl Smoother {
    /// Zeros, of the blocks of a lower triangle.
    pub(super) fn new(lower: &Adjacency) -> Self {
        let n = lower.rows();
        let one_section = |(g, h): &(u32, u32)| *g as usize / SECTION == *h as usize / SECTION;
        let pairs = (0..n as u32).flat_map(|g| lower.row(g).iter().map(move |&h| (g, h))).filter(|(g, h)| g != h);
        let inside = pairs.clone().filter(one_section).map(|(g, h)| (h, g % SECTION as u32));
        let between = pairs.filter(move |pair| !one_section(pair));
        let behind = Adjacency::new(n, between);
        Smoother {
            below: BlockRows::new(Adjacency::new(n, inside)),
            before: Columns::new(&behind, n),
            behind: BlockRows::new(behind),
            inverse: vec![0.0; 9 * n + 1],
        }
    }

    /// Sets the numbers. Returns whether all blocks on the diagonal are positive definite.
    pub(super) fn set(&mut self, workers: &Workers, matrix: &(impl Numbers + Sync)) -> bool {
        let Smoother { below, behind, inverse, .. } = self;
        let well = AtomicBool::new(true);
        let (inverse, _) = inverse.as_chunks_mut::<9>();
        let rows = below.sections_mut().zip(behind.sections_mut()).zip(sections_mut(inverse)).enumerate();
        workers.each_section(rows, |(section, ((mut below, mut behind), inverse))| {
            let first = section * SECTION;
            for (g, inverse) in (first..).zip(inverse) {
                matrix.column(g as u32, |h, block| {
                    let (row, across) = (h as usize, || block.transpose().cast());
                    if row == g {
                        match inverse_of(block) {
                            Some(found) => inverse.copy_from_slice(found.as_slice()),
                            None => well.store(false, Ordering::Relaxed),
                        }
                    } else if row / SECTION == section {
                        below.set(row, (g - first) as u32, &across());
                    } else {
                        behind.set(g, h, &across());
                    }
                });
            }
        });
        well.into_inner()
    }

    /// Calls `found(i, j, A_ij)` for all blocks beside the diagonal of the rows i of a section.
    pub(super) fn each_block(&self, section: usize, mut found: impl FnMut(usize, usize, &Matrix3<f32>)) {
        let first = section * SECTION;
        for i in first..self.nodes().min(first + SECTION) {
            for (column, block) in self.below.blocks(i) {
                let j = first + column as usize;
                found(i, j, &block.transpose());
                found(j, i, &block);
            }
            self.behind.blocks(i).for_each(|(j, block)| found(i, j as usize, &block));
            self.before.places(i).for_each(|(j, place)| found(i, j, &self.behind.block(place).transpose()));
        }
    }

    /// Sum over the blocks of a node with other sections.
    #[inline(always)]
    fn beyond(&self, i: usize, v: &[f32x4]) -> f32x4 {
        self.behind.sum(i, v) + self.before.transposed_sum(&self.behind, i, v)
    }

    /// Number of nodes.
    pub(super) fn nodes(&self) -> usize {
        self.below.rows()
    }

    /// D^-1 of a node.
    pub(super) fn inverse(&self, i: usize) -> Matrix3<f32> {
        Matrix3::from_column_slice(&self.inverse[9 * i..9 * i + 9])
    }

    #[inline(always)]
    fn solved(&self, i: usize, v: f32x4) -> f32x4 {
        times(columns(&self.inverse[9 * i..=9 * i + 9]), v)
    }

    /// Sweeps forwards: overwrites x and left.
    pub(super) fn forward(&self, workers: &Workers, r: &[f32x4], x: &mut [f32x4], left: &mut [f32x4]) {
        let vectors = sections(r).zip(sections_mut(x)).zip(sections_mut(left)).enumerate();
        workers.each_section(vectors, |(section, ((r, x), left))| forward(self, section * SECTION, [x, left], r));
        self.between(workers, x, |sum, given| *sum -= given, left);
    }

    /// Sweeps backwards: x becomes x - z. Returns r . z.
    pub(super) fn backward(&self, workers: &Workers, r: &[f32x4], [x, z]: [&mut [f32x4]; 2], sums: &mut [f64]) -> f64 {
        workers.each_section(sections_mut(z), |z| z.fill(f32x4::ZERO));
        self.between(workers, x, |sum, given| *sum = given, z);
        let vectors = sections(r).zip(sections_mut(x)).zip(sections_mut(z)).zip(sums.iter_mut()).enumerate();
        workers
            .each_section(vectors, |(section, (((r, x), z), sum))| *sum = backward(self, section * SECTION, [x, z], r));
        sums.iter().sum()
    }

    /// A z of a node after [`Smoother::backward`]; `moved` is x - z.
    #[inline(always)]
    pub(super) fn product(&self, i: usize, r: f32x4, moved: &[f32x4]) -> f32x4 {
        r - self.below.transposed_sum(i, &moved[i - i % SECTION..]) - self.beyond(i, moved)
    }

    /// Takes the sums over blocks between sections into `out`.
    fn between(
        &self,
        workers: &Workers,
        x: &[f32x4],
        take: impl Fn(&mut f32x4, f32x4) + Sync + Send,
        out: &mut [f32x4],
    ) {
        if self.behind.is_empty() {
            return;
        }
        workers.each_section(sections_mut(out).enumerate(), |(section, out)| {
            for (out, i) in out.iter_mut().zip(section * SECTION..) {
                if !(self.behind.columns(i).is_empty() && self.before.rows(i).is_empty()) {
                    take(out, self.beyond(i, x));
                }
            }
        });
    }
}

/// The inverse of a block on the diagonal, 0 at fixed components; none if it is not positive definite.
fn inverse_of(block: &Matrix3<f64>) -> Option<Matrix3<f32>> {
    let fixed = (0..3).filter(|&j| block[(j, j)] == 0.0);
    let mut diagonal = *block;
    fixed.clone().for_each(|j| diagonal[(j, j)] = 1.0);
    let mut inverse = diagonal.cholesky()?.inverse();
    fixed.for_each(|j| inverse[(j, j)] = 0.0);
    Some(inverse.cast())
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn forward(smoother: &Smoother, first: usize, [x, left]: [&mut [f32x4]; 2], r: &[f32x4]) {
    for i in 0..r.len() {
        let g = first + i;
        let own = smoother.solved(g, r[i] - smoother.below.transposed_sum(g, x));
        x[i] = own;
        left[i] = f32x4::ZERO;
        for (block, j) in smoother.below.row(g) {
            left[j] -= times(columns(block), own);
        }
    }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn backward(smoother: &Smoother, first: usize, [x, z]: [&mut [f32x4]; 2], r: &[f32x4]) -> f64 {
    let mut along = [0.0; 3];
    for i in (0..r.len()).rev() {
        let g = first + i;
        // z holds what the nodes behind this one give.
        let own = smoother.solved(g, r[i] - z[i] - smoother.below.transposed_sum(g, x));
        z[i] = own;
        x[i] -= own;
        for (block, j) in smoother.below.row(g) {
            z[j] += times(columns(block), own);
        }
        let parts = (r[i] * own).to_array();
        along.iter_mut().zip(parts).for_each(|(sum, part)| *sum += f64::from(part));
    }
    along.iter().sum()
}
