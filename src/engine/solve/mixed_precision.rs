//! A Cholesky factor in single precision, for solves that need not be exact: half the bytes, and twice the numbers in a
//! register. The loops suit the small supernodes of a net, where a library's dense kernels spend most of their time in
//! calls.
//!
//! Columns are grouped into panels. A panel stores the inverse of its triangle and the rows below it in chunks:
//!
//! ```text
//! L y = P b:      y1 = L11^-1 b1,   b2 -= L21 y1            L^T x = y:      x1 = L11^-T (y1 - L21^T x2)
//! ```

use faer::sparse::linalg::cholesky::{SymbolicCholesky, SymbolicCholeskyRaw};
use multiversion::multiversion;
use prefetch_index::prefetch_index;
use std::ops::Range;

/// Range of magnitudes whose products neither overflow nor underflow in single precision.
const F32_RANGE: Range<f64> = 1e-16..1e16;
/// Numbers in a register.
const LANES: usize = 8;
/// Maximum number of columns of a panel.
const COLUMNS: usize = 32;
/// Columns whose sums are computed together: those of a node.
const COLUMNS_AT_ONCE: usize = 3;
/// Prefetch distance of the backward solve in registers: processors prefetch by themselves only in the forward
/// direction.
const PREFETCH_DISTANCE: usize = 384;
/// Registers of a cache line.
const LINE: usize = 64 / size_of::<F32x8>();

/// A register.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
struct F32x8([f32; LANES]);

const ZERO: F32x8 = F32x8([0.0; LANES]);

/// L of W = P^T L L^T P.
#[derive(Debug)]
pub(super) struct SinglePrecisionFactor {
    panels: Vec<Panel>,
    /// rows below the columns of each panel; the last chunk is padded with a row that is always zero
    rows: Vec<[u32; LANES]>,
    /// for each panel L11^-1, then L21, in chunks of rows; a chunk has one register per column
    l: Vec<F32x8>,
    /// elimination order: the unknown of every row `[n]`
    order: Vec<u32>,
    /// right-hand side and solution in elimination order, and a zero `[n + 1]`
    x: Vec<f32>,
    /// entries of the solution in a panel's rows
    gathered: Vec<F32x8>,
    /// [-] L11^-1 in double precision, by columns
    inverse: Vec<f64>,
}

/// Columns with the same rows below them.
#[derive(Clone, Debug)]
struct Panel {
    columns: Range<usize>,
    /// rows below them
    below: usize,
    /// their chunks
    rows: Range<usize>,
    /// its registers
    l: Range<usize>,
    /// index of its first diagonal entry among the values of the library's factor, and the distance to the next
    /// column's entry of the same row
    first: usize,
    tall: usize,
}

impl SinglePrecisionFactor {
    /// For factors of a symbolic analysis; `None` if it is not supernodal.
    pub(super) fn new(symbolic: &SymbolicCholesky<u32>) -> Option<Self> {
        let SymbolicCholeskyRaw::Supernodal(by_supernode) = symbolic.raw() else { return None };
        let n = by_supernode.ncols();
        let (mut panels, mut rows, mut room) = (Vec::new(), Vec::new(), 0);
        let ends = by_supernode.supernode_begin().iter().zip(by_supernode.supernode_end());
        let places = by_supernode.col_ptr_for_row_idx().iter().zip(by_supernode.nnz_per_super());
        for (((&begin, &end), (&first_row, &below)), &value) in ends.zip(places).zip(by_supernode.col_ptr_for_val()) {
            let below = &by_supernode.row_idx()[first_row as usize..][..below as usize];
            let tall = (end - begin) as usize + below.len();
            for first in (begin..end).step_by(COLUMNS) {
                let last = end.min(first + COLUMNS as u32);
                let all: Vec<u32> = (last..end).chain(below.iter().copied()).collect();
                let chunks = rows.len();
                rows.extend(all.chunks(LANES).map(|chunk| {
                    let mut padded = [n as u32; LANES];
                    padded[..chunk.len()].copy_from_slice(chunk);
                    padded
                }));
                let columns = first as usize..last as usize;
                let own = columns.len().div_ceil(LANES);
                let l = room..room + (own + rows.len() - chunks) * columns.len();
                room = l.end;
                let first = value as usize + (first - begin) as usize * (tall + 1);
                panels.push(Panel { columns, below: all.len(), rows: chunks..rows.len(), l, first, tall });
            }
        }
        let order = match symbolic.perm() {
            Some(permutation) => permutation.arrays().0.to_vec(),
            None => (0..n as u32).collect(),
        };
        let longest = panels.iter().map(|panel: &Panel| panel.rows.len()).max().unwrap_or(0);
        let (gathered, inverse) = (vec![ZERO; longest], vec![0.0; COLUMNS * COLUMNS]);
        Some(SinglePrecisionFactor { panels, rows, l: vec![ZERO; room], order, x: vec![0.0; n + 1], gathered, inverse })
    }

    /// Copies the values of a factor. Returns whether they fit single precision.
    pub(super) fn set_values(&mut self, values: &[f64]) -> bool {
        let SinglePrecisionFactor { panels, l, inverse, .. } = self;
        panels.iter().all(|panel| {
            let (wide, values) = (panel.columns.len(), &values[panel.first..]);
            if !invert(values, panel, inverse) {
                return false;
            }
            let (own, below) = l[panel.l.clone()].split_at_mut(wide.div_ceil(LANES) * wide);
            fill(own, wide, |row, k| if row < wide { inverse[k * wide + row] } else { 0.0 });
            fill(below, wide, |row, k| if row < panel.below { values[k * panel.tall + wide + row] } else { 0.0 });
            true
        })
    }

    /// Replaces b `[n]` by an approximation of W^-1 b.
    pub(super) fn solve(&mut self, b: &mut [f64]) {
        let size = b.iter().fold(0.0_f64, |size, b| size.max(b.abs()));
        let scale = if size > 0.0 { size.recip() } else { 0.0 };
        for (x, &from) in self.x.iter_mut().zip(&self.order) {
            *x = (b[from as usize] * scale) as f32;
        }
        eliminate(self);
        substitute(self);
        for (x, &to) in self.x.iter().zip(&self.order) {
            b[to as usize] = f64::from(*x) * size;
        }
    }
}

/// L11^-1 by columns. Returns whether its numbers fit single precision.
fn invert(l: &[f64], panel: &Panel, inverse: &mut [f64]) -> bool {
    let (wide, tall) = (panel.columns.len(), panel.tall);
    for j in 0..wide {
        let column = &mut inverse[j * wide..(j + 1) * wide];
        column.fill(0.0);
        for i in j..wide {
            let sum: f64 = (j..i).map(|k| l[k * tall + i] * column[k]).sum();
            column[i] = (if i == j { 1.0 } else { -sum }) / l[i * tall + i];
        }
        if !F32_RANGE.contains(&column[j]) || column.iter().any(|v| v.abs() >= F32_RANGE.end) {
            return false;
        }
    }
    true
}

/// Fills chunks of rows; a chunk has one register per column.
fn fill(registers: &mut [F32x8], columns: usize, value: impl Fn(usize, usize) -> f64) {
    for (chunk, registers) in registers.chunks_mut(columns).enumerate() {
        for (k, register) in registers.iter_mut().enumerate() {
            for (i, entry) in register.0.iter_mut().enumerate() {
                *entry = value(LANES * chunk + i, k) as f32;
            }
        }
    }
}

/// L y = b
#[multiversion(targets("x86_64+avx+avx2"))]
fn eliminate(factor: &mut SinglePrecisionFactor) {
    let SinglePrecisionFactor { panels, rows, l, x, .. } = factor;
    for panel in panels.iter() {
        let wide = panel.columns.len();
        let (own, below) = l[panel.l.clone()].split_at(wide.div_ceil(LANES) * wide);
        let mut y = [0.0; COLUMNS];
        for (y, block) in y.as_chunks_mut::<LANES>().0.iter_mut().zip(own.chunks_exact(wide)) {
            *y = combined(block, &x[panel.columns.clone()]).0;
        }
        x[panel.columns.clone()].copy_from_slice(&y[..wide]);
        for (block, rows) in below.chunks_exact(wide).zip(&rows[panel.rows.clone()]) {
            let sums = combined(block, &y[..wide]);
            for (&row, sum) in rows.iter().zip(sums.0) {
                x[row as usize] -= sum;
            }
        }
    }
}

/// Sum of y_k times register k.
#[inline(always)]
fn combined(registers: &[F32x8], y: &[f32]) -> F32x8 {
    let mut sums = ZERO;
    for (l, y) in registers.iter().zip(y) {
        for i in 0..LANES {
            sums.0[i] += l.0[i] * y;
        }
    }
    sums
}

/// L^T x = y
#[multiversion(targets("x86_64+avx+avx2"))]
fn substitute(factor: &mut SinglePrecisionFactor) {
    let SinglePrecisionFactor { panels, rows, l, x, gathered, .. } = factor;
    let (mut sums, mut left) = ([ZERO; COLUMNS], [ZERO; COLUMNS / LANES]);
    for panel in panels.iter().rev() {
        let wide = panel.columns.len();
        let (own, below) = l[panel.l.clone()].split_at(wide.div_ceil(LANES) * wide);
        let rows = &rows[panel.rows.clone()];
        let gathered = &mut gathered[..rows.len()];
        for (gathered, rows) in gathered.iter_mut().zip(rows) {
            for (entry, &row) in gathered.0.iter_mut().zip(rows) {
                *entry = x[row as usize];
            }
        }
        let (x, sums) = (&mut x[panel.columns.clone()], &mut sums[..wide]);
        products(below, gathered, sums);
        subtract_totals(sums, x);
        left.fill(ZERO);
        for (left, x) in left.iter_mut().zip(x.chunks(LANES)) {
            left.0[..x.len()].copy_from_slice(x);
        }
        products(own, &left, sums);
        x.fill(0.0);
        subtract_totals(sums, x);
        x.iter_mut().for_each(|x| *x = -*x);
    }
}

/// Register k of every chunk times x, summed over the chunks.
#[inline(always)]
fn products(l: &[F32x8], x: &[F32x8], sums: &mut [F32x8]) {
    let wide = sums.len();
    let mut k = 0;
    while k + COLUMNS_AT_ONCE <= wide {
        sums[k..k + COLUMNS_AT_ONCE].copy_from_slice(&sums_of::<COLUMNS_AT_ONCE>(l, wide, k, x));
        k += COLUMNS_AT_ONCE;
    }
    while k < wide {
        sums[k..=k].copy_from_slice(&sums_of::<1>(l, wide, k, x));
        k += 1;
    }
}

/// The sums of N columns at once: they stay in registers and do not wait for each other.
#[inline(always)]
fn sums_of<const N: usize>(l: &[F32x8], wide: usize, k: usize, x: &[F32x8]) -> [F32x8; N] {
    let mut sums = [ZERO; N];
    for (chunk, x) in l.chunks_exact(wide).zip(x) {
        // Panels are visited from last to first, so the preceding one is prefetched.
        (k..k + N).step_by(LINE).for_each(|k| prefetch_index(chunk, k.wrapping_sub(PREFETCH_DISTANCE)));
        for (sum, l) in sums.iter_mut().zip(&chunk[k..k + N]) {
            for i in 0..LANES {
                sum.0[i] += l.0[i] * x.0[i];
            }
        }
    }
    sums
}

/// Subtracts the sum of every register. Not inlined, as its order of summation would otherwise determine the lanes of
/// the loops before it (see `Lanes::total`).
#[inline(never)]
fn subtract_totals(sums: &[F32x8], from: &mut [f32]) {
    for (from, F32x8(l)) in from.iter_mut().zip(sums) {
        *from -= ((l[0] + l[4]) + (l[2] + l[6])) + ((l[1] + l[5]) + (l[3] + l[7]));
    }
}
