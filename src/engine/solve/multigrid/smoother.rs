//! Sweeps of Gauss and Seidel over the 3x3 blocks of a symmetric matrix A = L + D + L^T, in single precision.
//!
//! ```text
//! forwards, from 0:    x = (D + L)^-1 r                          left = r - A x
//! backwards, from x:   z = x + (D + L^T)^-1 (r - A x)            A z = r - L (x - z)
//! ```
//! The first and the second after it are one symmetric sweep. Nodes are divided into sections. A sweep goes through
//! every section by itself, on any thread, and takes what lies between sections from where it began, so that its bits
//! do not depend on the number of threads. Only blocks below the diagonal are stored: a row is read once to take from
//! the nodes before it and to give to them.

use super::super::bsr::{columns, times};
use super::numbers::Numbers;
use crate::mesh::adjacency::Adjacency;
use crate::model::workers::Workers;
use multiversion::multiversion;
use nalgebra::Matrix3;
use rayon::iter::{ParallelBridge, ParallelIterator};
use wide::f32x4;

/// Nodes of a section.
pub(super) const SECTION: usize = 16_384;

/// Does the work on all sections, on the threads of `workers`.
pub(super) fn each_section<T: Send>(
    workers: &Workers,
    sections: impl ExactSizeIterator<Item = T> + Send,
    work: impl Fn(T) + Send + Sync,
) {
    match workers.pool().filter(|_| sections.len() > 1) {
        None => sections.for_each(work),
        Some(pool) => pool.install(|| sections.par_bridge().for_each(work)),
    }
}

/// The sections of a vector of nodes.
pub(super) fn sections<T>(v: &[T]) -> std::slice::Chunks<'_, T> {
    v.chunks(SECTION)
}

/// The same to write.
pub(super) fn sections_mut<T>(v: &mut [T]) -> std::slice::ChunksMut<'_, T> {
    v.chunks_mut(SECTION)
}

/// 3x3 blocks by rows.
#[derive(Clone, Debug)]
pub(super) struct BlockRows {
    start: Vec<u32>,
    column: Vec<u32>,
    /// every block by columns, and one number behind the last, as [`columns`] reads it
    numbers: Vec<f32>,
}

impl BlockRows {
    /// Zeros at pairs (row, column); a row keeps the order of its columns.
    pub(super) fn new(Adjacency { start, items: column }: Adjacency) -> Self {
        BlockRows { numbers: vec![0.0; 9 * column.len() + 1], start, column }
    }

    pub(super) fn rows(&self) -> usize {
        self.start.len() - 1
    }

    pub(super) fn clear(&mut self) {
        self.numbers.fill(0.0);
    }

    pub(super) fn places(&self, row: usize) -> std::ops::Range<usize> {
        self.start[row] as usize..self.start[row + 1] as usize
    }

    pub(super) fn column(&self, place: usize) -> u32 {
        self.column[place]
    }

    /// The place of the block of a row and a column.
    pub(super) fn place(&self, row: u32, column: u32) -> usize {
        let row = self.places(row as usize);
        row.start + self.column[row].iter().position(|&other| other == column).unwrap_or(0)
    }

    pub(super) fn block(&self, place: usize) -> Matrix3<f32> {
        Matrix3::from_column_slice(&self.numbers[9 * place..9 * place + 9])
    }

    pub(super) fn set(&mut self, place: usize, block: &Matrix3<f32>) {
        self.numbers[9 * place..9 * place + 9].copy_from_slice(block.as_slice());
    }

    pub(super) fn add(&mut self, place: usize, block: &Matrix3<f64>) {
        let numbers = &mut self.numbers[9 * place..9 * place + 9];
        numbers.iter_mut().zip(block.as_slice()).for_each(|(sum, entry)| *sum += *entry as f32);
    }

    /// Sets the next block of a row.
    fn push(&mut self, next: &mut u32, block: &Matrix3<f64>) {
        self.set(*next as usize, &block.cast());
        *next += 1;
    }

    /// The blocks of a row, for [`columns`], and their columns.
    #[inline(always)]
    fn row(&self, i: usize) -> impl Iterator<Item = (&[f32], usize)> {
        let row = self.places(i);
        let numbers = &self.numbers[9 * row.start..=9 * row.end];
        numbers.windows(10).step_by(9).zip(self.column[row].iter().map(|&j| j as usize))
    }

    /// Sum of the blocks of a row times v.
    #[inline(always)]
    pub(super) fn sum(&self, i: usize, v: &[f32x4]) -> f32x4 {
        self.row(i).fold(f32x4::ZERO, |sum, (block, j)| sum + times(columns(block), v[j]))
    }

    /// The same of the transposed blocks.
    #[inline(always)]
    fn transposed_sum(&self, i: usize, v: &[f32x4]) -> f32x4 {
        let row = self.places(i);
        self.transposed(row.clone().zip(self.column[row].iter().map(|&j| v[j as usize])))
    }

    /// Sum of transposed blocks, by their places, times vectors.
    #[inline(always)]
    pub(super) fn transposed(&self, of: impl Iterator<Item = (usize, f32x4)>) -> f32x4 {
        let [mut x, mut y, mut z] = [f32x4::ZERO; 3];
        for (place, v) in of {
            let [a, b, c] = columns(&self.numbers[9 * place..=9 * place + 9]);
            x += a * v;
            y += b * v;
            z += c * v;
        }
        let [x, y, z, _] = f32x4::transpose([x, y, z, z]);
        x + y + z
    }
}

/// A symmetric matrix.
#[derive(Debug)]
pub(super) struct Smoother {
    /// transposed blocks below the diagonal in a section; columns count from the first node of the section
    below: BlockRows,
    /// blocks between sections
    between: BlockRows,
    /// D^-1, as the numbers of [`BlockRows`]; 0 at fixed components
    inverse: Vec<f32>,
    /// the next block of every row of both
    next: [Vec<u32>; 2],
}

impl Smoother {
    /// Zeros, of the blocks of a lower triangle.
    pub(super) fn new(lower: &Adjacency) -> Self {
        let n = lower.rows();
        let one_section = |(g, h): &(u32, u32)| *g as usize / SECTION == *h as usize / SECTION;
        let pairs = (0..n as u32).flat_map(|g| lower.row(g).iter().map(move |&h| (g, h))).filter(|(g, h)| g != h);
        let inside = pairs.clone().filter(one_section).map(|(g, h)| (h, g % SECTION as u32));
        let between = pairs.filter(move |pair| !one_section(pair));
        Smoother {
            below: BlockRows::new(Adjacency::new(n, inside)),
            // Of a row those before it come first, in the order in which they are set.
            between: BlockRows::new(Adjacency::new(n, between.clone().map(|(g, h)| (h, g)).chain(between))),
            inverse: vec![0.0; 9 * n + 1],
            next: [vec![0; n], vec![0; n]],
        }
    }

    /// Sets the numbers. Returns whether all blocks on the diagonal are positive definite.
    pub(super) fn set(&mut self, matrix: &impl Numbers) -> bool {
        let Smoother { below, between, inverse, next: [inside, beyond] } = self;
        let n = inside.len();
        inside.copy_from_slice(&below.start[..n]);
        beyond.copy_from_slice(&between.start[..n]);
        let mut well = true;
        for g in 0..n {
            matrix.column(g as u32, |h, block| {
                let h = h as usize;
                if h == g {
                    match inverse_of(block) {
                        Some(found) => inverse[9 * g..9 * g + 9].copy_from_slice(found.as_slice()),
                        None => well = false,
                    }
                } else if g / SECTION == h / SECTION {
                    below.push(&mut inside[h], &block.transpose());
                } else {
                    between.push(&mut beyond[h], block);
                    between.push(&mut beyond[g], &block.transpose());
                }
            });
        }
        well
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
        each_section(workers, vectors, |(section, ((r, x), left))| forward(self, section * SECTION, [x, left], r));
        self.between(workers, x, |sum, given| *sum -= given, left);
    }

    /// Sweeps backwards: x becomes x - z. Returns r . z.
    pub(super) fn backward(&self, workers: &Workers, r: &[f32x4], [x, z]: [&mut [f32x4]; 2], sums: &mut [f64]) -> f64 {
        z.fill(f32x4::ZERO);
        self.between(workers, x, |sum, given| *sum = given, z);
        let vectors = sections(r).zip(sections_mut(x)).zip(sections_mut(z)).zip(sums.iter_mut()).enumerate();
        each_section(workers, vectors, |(section, (((r, x), z), sum))| {
            *sum = backward(self, section * SECTION, [x, z], r)
        });
        sums.iter().sum()
    }

    /// A z of a node after [`Smoother::backward`]; `moved` is x - z.
    #[inline(always)]
    pub(super) fn product(&self, i: usize, r: f32x4, moved: &[f32x4]) -> f32x4 {
        r - self.below.transposed_sum(i, &moved[i - i % SECTION..]) - self.between.sum(i, moved)
    }

    /// Takes the sums over blocks between sections into `out`.
    fn between(
        &self,
        workers: &Workers,
        x: &[f32x4],
        take: impl Fn(&mut f32x4, f32x4) + Sync + Send,
        out: &mut [f32x4],
    ) {
        if self.between.column.is_empty() {
            return;
        }
        each_section(workers, sections_mut(out).enumerate(), |(section, out)| {
            for (out, i) in out.iter_mut().zip(section * SECTION..) {
                if self.between.start[i] < self.between.start[i + 1] {
                    take(out, self.between.sum(i, x));
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
