//! Multigrid by smoothed aggregation (Vanek, Mandel & Brezina, Computing 56, 1996) as the preconditioner of conjugate
//! gradients:
//!
//! ```text
//! A_0 = W,    A_l+1 = P_l^T A_l P_l        P_l interpolates from aggregates of nodes (`prolongation`)
//! z = B_l r:  x = (D + L)^-1 r,  x += P_l B_l+1 P_l^T (r - A_l x),  z = x + (D + L^T)^-1 (r - A_l x)
//! ```
//! B of the coarsest level is its inverse, by Cholesky. B of the levels between is applied twice, to r and to what is
//! left of it (a W-cycle): so the number of iterations does not grow with the number of nodes. A single sweep on either
//! side makes B symmetric (`smoother`). Aggregates follow from the pattern; all numbers are made anew with W.

mod block_rows;
mod numbers;
mod prolongation;
mod smoother;
#[cfg(test)]
mod tests;

use super::Cholesky;
use super::bsr::packed;
use super::eisenstat::Curvature;
use super::linear::{Accuracy, Inertia, LinearError, LinearSolver};
use crate::assembly::Pattern;
use crate::mesh::adjacency::Adjacency;
use crate::mesh::random::pseudo_random;
use crate::model::workers::{ALONE, Workers};
use block_rows::{SECTION, sections, sections_mut};
use multiversion::multiversion;
use nalgebra::Vector3;
use numbers::{CoarseNumbers, FineNumbers, Numbers, lower_blocks};
use prolongation::{Prolongation, aggregates};
use smoother::Smoother;
use std::sync::Arc;
use wide::f32x4;

/// Nodes of the coarsest level, at most, unless aggregates no longer reduce their number.
const COARSEST: usize = 400;
/// [-] Least reduction of the number of nodes from level to level.
const REDUCTION: usize = 2;

/// A level with its vectors.
#[derive(Debug)]
struct Level {
    /// A; of the finest level it is W
    matrix: Option<CoarseNumbers>,
    smoother: Smoother,
    up: Prolongation,
    r: Vec<f32x4>,
    /// x, then x - z
    x: Vec<f32x4>,
    z: Vec<f32x4>,
    /// what the first of two cycles found; empty on the finest level, which has one
    first: Vec<f32x4>,
    /// r - A x after the sweep forwards
    left: Vec<f32x4>,
    /// r . z of every section
    sums: Vec<f64>,
}

/// The coarsest level.
#[derive(Debug)]
struct Coarsest {
    matrix: CoarseNumbers,
    solver: Cholesky,
    /// [nonzeros]
    values: Vec<f64>,
    /// right-hand side, then solution
    b: Vec<f64>,
    r: Vec<f32x4>,
    z: Vec<f32x4>,
}

/// W with its levels, and the vectors of conjugate gradients.
#[derive(Debug)]
pub(super) struct Multigrid {
    pattern: Arc<Pattern>,
    /// node of every unknown
    node: Vec<u32>,
    workers: Workers,
    levels: Vec<Level>,
    coarsest: Coarsest,
    /// W is divided by its largest entry
    scale: f64,
    x: Vec<f32x4>,
    p: Vec<f32x4>,
    q: Vec<f32x4>,
    /// p . q of every section
    along: Vec<f64>,
    /// r . z
    square: f64,
    /// p . B^-1 p
    squares: f64,
}

impl Multigrid {
    /// Finds the aggregates of a symmetric pattern.
    ///
    /// # Errors
    /// When the analysis of the coarsest matrix fails.
    pub(super) fn new(pattern: &Arc<Pattern>, workers: &Workers) -> Result<Self, LinearError> {
        let node = pattern.node_of_unknown();
        let mut lower = lower_blocks(pattern, &node);
        let mut position = pattern.position.clone();
        let (mut levels, mut matrix) = (Vec::new(), None);
        let coarsest = loop {
            let n = lower.rows();
            let pairs = (0..n as u32).flat_map(|g| lower.row(g).iter().map(move |&h| (g, h)));
            let around = Adjacency::new(n, pairs.clone().map(|(g, h)| (h, g)).chain(pairs.filter(|(g, h)| g != h)));
            let grouped = || {
                let up = Prolongation::new(&around, aggregates(&around), workers);
                let coarse = up.coarse(&around);
                (up, coarse)
            };
            let ((up, coarse), smoother) = workers.join(grouped, || Smoother::new(&lower));
            position = up.middles(&position);
            levels.push(Level::new(matrix.take(), smoother, up));
            let count = coarse.rows();
            if count <= COARSEST || REDUCTION * count > n {
                break Coarsest::new(CoarseNumbers::new(coarse), position)?;
            }
            lower = coarse.clone();
            matrix = Some(CoarseNumbers::new(coarse));
        };
        let n = pattern.position.len();
        let zeros = || vec![f32x4::ZERO; n];
        Ok(Multigrid {
            pattern: Arc::clone(pattern),
            node,
            workers: workers.clone(),
            levels,
            coarsest,
            scale: 1.0,
            x: zeros(),
            p: zeros(),
            q: zeros(),
            along: vec![0.0; n.div_ceil(SECTION)],
            square: 0.0,
            squares: 0.0,
        })
    }

    /// Sets the matrices of all levels; `values` [nonzeros]. Returns `false` if W is found not to be positive definite.
    ///
    /// # Errors
    /// Sums that are not finite.
    pub(super) fn set_values(&mut self, values: &[f64]) -> Result<bool, LinearError> {
        let Multigrid { pattern, node, workers, levels, coarsest, scale, .. } = self;
        let diagonal = pattern.col_ptr[..pattern.n()].iter().map(|&first| values[first as usize]);
        *scale = diagonal.fold(0.0, f64::max).recip();
        let fine = FineNumbers { pattern, node, values, scale: *scale };
        let mut rest = levels.as_mut_slice();
        while let [level, coarser @ ..] = rest {
            let Level { matrix, smoother, up, .. } = level;
            let coarse = match coarser {
                [Level { matrix: Some(coarse), .. }, ..] => coarse,
                _ => &mut coarsest.matrix,
            };
            let well = match matrix {
                None => set_level(workers, &fine, smoother, up, coarse),
                Some(matrix) => set_level(workers, matrix, smoother, up, coarse),
            };
            if !well {
                return Ok(false);
            }
            rest = coarser;
        }
        coarsest.set()
    }

    /// r <- b / s, where s is the largest entry of b `[n]`. Returns s and r . z.
    ///
    /// # Errors
    /// A b that is not finite.
    pub(super) fn set_right_hand_side(&mut self, b: &[f64]) -> Result<[f64; 2], LinearError> {
        let most = |range: std::ops::Range<usize>| b[range].iter().fold(0.0_f64, |most, b| most.max(b.abs()));
        let size = self.workers.fold(b.len(), 0.0, most, f64::max);
        let inverse = if size >= f64::MIN_POSITIVE { size.recip() } else { 0.0 };
        Ok([size, self.set_residual(|u| (b[u] * inverse) as f32)?])
    }

    /// Sets r to a fixed pseudo-random vector. Returns r . z.
    ///
    /// # Errors
    /// None with a W that was set.
    pub(super) fn set_trial_right_hand_side(&mut self) -> Result<f64, LinearError> {
        self.set_residual(|u| pseudo_random(u) as f32)
    }

    fn set_residual(&mut self, b: impl Fn(usize) -> f32 + Send + Sync) -> Result<f64, LinearError> {
        let Multigrid { pattern, workers, levels, .. } = self;
        workers.each_section(sections_mut(&mut levels[0].r).enumerate(), |(section, r)| {
            for (r, unknowns) in r.iter_mut().zip(pattern.node_start[section * SECTION..].windows(2)) {
                let mut v = Vector3::zeros();
                (unknowns[0]..unknowns[1]).for_each(|u| v[(pattern.dof[u as usize] % 3) as usize] = b(u as usize));
                *r = packed(v);
            }
        });
        self.precondition()
    }

    /// z <- B r; returns r . z.
    fn precondition(&mut self) -> Result<f64, LinearError> {
        let Multigrid { levels, coarsest, workers, square, .. } = self;
        *square = cycle(levels, coarsest, workers)?;
        Ok(*square)
    }

    /// x <- 0, p <- 0
    pub(super) fn begin(&mut self) {
        for v in [&mut self.x, &mut self.p, &mut self.q] {
            self.workers.each_section(sections_mut(v), |v| v.fill(f32x4::ZERO));
        }
        self.squares = 0.0;
    }

    /// p <- z + beta p, q <- A p
    pub(super) fn product(&mut self, beta: f32) -> Curvature {
        let Multigrid { levels, workers, p, q, along, square, squares, .. } = self;
        let (level, b) = (&levels[0], f64::from(beta));
        let vectors = sections_mut(p).zip(sections_mut(q)).zip(along.iter_mut()).enumerate();
        workers.each_section(vectors, |(section, ((p, q), along))| {
            *along = direction(level, section * SECTION, [p, q], beta)
        });
        // p and z are conjugate in B^-1.
        *squares = *square + b * b * *squares;
        Curvature { along: along.iter().sum(), squares: *squares }
    }

    /// x += alpha p, r -= alpha q, z <- B r; returns r . z.
    ///
    /// # Errors
    /// An r that is not finite.
    pub(super) fn advance(&mut self, alpha: f32) -> Result<f64, LinearError> {
        let Multigrid { levels, workers, x, p, q, .. } = self;
        let vectors = sections_mut(x).zip(sections_mut(&mut levels[0].r)).zip(sections(p).zip(sections(q)));
        workers.each_section(vectors, |((x, r), (p, q))| {
            for ((x, r), (p, q)) in x.iter_mut().zip(r).zip(p.iter().zip(q)) {
                *x += *p * alpha;
                *r -= *q * alpha;
            }
        });
        self.precondition()
    }

    /// b <- s x
    pub(super) fn finish(&self, s: f64, b: &mut [f64]) {
        let Multigrid { pattern, node, workers, x, scale, .. } = self;
        workers.set(b, |unknowns, b| {
            for (b, u) in b.iter_mut().zip(unknowns) {
                let x = x[node[u] as usize].to_array();
                *b = f64::from(x[(pattern.dof[u] % 3) as usize]) * s * scale;
            }
        });
    }
}

impl Level {
    fn new(matrix: Option<CoarseNumbers>, smoother: Smoother, up: Prolongation) -> Self {
        let n = smoother.nodes();
        let first = vec![f32x4::ZERO; if matrix.is_some() { n } else { 0 }];
        let zeros = || vec![f32x4::ZERO; n];
        let sums = vec![0.0; n.div_ceil(SECTION)];
        Level { matrix, smoother, up, r: zeros(), x: zeros(), z: zeros(), first, left: zeros(), sums }
    }

    /// first <- z, r <- r - A z
    fn leave(&mut self, workers: &Workers) {
        let Level { smoother, r, x, z, first, .. } = self;
        let vectors = sections_mut(r).zip(sections_mut(first)).zip(sections(z)).enumerate();
        workers.each_section(vectors, |(section, ((r, first), z))| {
            first.copy_from_slice(z);
            r.iter_mut().zip(section * SECTION..).for_each(|(r, i)| *r -= smoother.product(i, *r, x));
        });
    }

    /// z <- z + first
    fn join(&mut self, workers: &Workers) {
        let vectors = sections_mut(&mut self.z).zip(sections(&self.first));
        workers.each_section(vectors, |(z, first)| z.iter_mut().zip(first).for_each(|(z, first)| *z += *first));
    }
}

/// Sets a level from its matrix, and the matrix of the next one. Returns whether blocks on the diagonal are positive
/// definite.
fn set_level(
    workers: &Workers,
    matrix: &(impl Numbers + Sync),
    smoother: &mut Smoother,
    up: &mut Prolongation,
    coarse: &mut CoarseNumbers,
) -> bool {
    let well = smoother.set(workers, matrix);
    if well {
        up.set(workers, smoother);
        up.restrict_matrix(workers, matrix, coarse);
    }
    well
}

/// z <- B r of the first of these levels; returns r . z.
fn cycle(levels: &mut [Level], coarsest: &mut Coarsest, workers: &Workers) -> Result<f64, LinearError> {
    let [level, coarser @ ..] = levels else { return Ok(0.0) };
    let Level { smoother, up, r, x, left, .. } = level;
    smoother.forward(workers, r, x, left);
    match coarser {
        [] => {
            up.restrict(workers, left, &mut coarsest.r);
            coarsest.solve()?;
            up.correct(workers, &coarsest.z, x);
        }
        [next, ..] => {
            up.restrict(workers, left, &mut next.r);
            cycle(coarser, coarsest, workers)?;
            coarser[0].leave(workers);
            cycle(coarser, coarsest, workers)?;
            coarser[0].join(workers);
            up.correct(workers, &coarser[0].z, x);
        }
    }
    let Level { smoother, r, x, z, sums, .. } = level;
    Ok(smoother.backward(workers, r, [x, z], sums))
}

/// p <- z + beta p, q <- A z + beta q of a section; returns p . q.
#[multiversion(targets("x86_64+avx+avx2"))]
fn direction(level: &Level, first: usize, [p, q]: [&mut [f32x4]; 2], beta: f32) -> f64 {
    let Level { smoother, r, x, z, .. } = level;
    let mut along = [0.0; 3];
    for (i, (p, q)) in (first..).zip(p.iter_mut().zip(q)) {
        *p = z[i] + *p * beta;
        *q = smoother.product(i, r[i], x) + *q * beta;
        along.iter_mut().zip((*p * *q).to_array()).for_each(|(sum, part)| *sum += f64::from(part));
    }
    along.iter().sum()
}

impl Coarsest {
    fn new(matrix: CoarseNumbers, position: Vec<[f64; 3]>) -> Result<Self, LinearError> {
        let count = position.len();
        let pattern = Arc::new(coarsest_pattern(&matrix.rows, position));
        let values = vec![0.0; pattern.nonzeros()];
        let mut solver = Cholesky::new(pattern, &ALONE)?;
        solver.set_accuracy(Accuracy::of_reused());
        let zeros = || vec![f32x4::ZERO; count];
        Ok(Coarsest { matrix, solver, values, b: vec![0.0; 3 * count], r: zeros(), z: zeros() })
    }

    /// Factorises the matrix. Returns whether it is positive definite.
    fn set(&mut self) -> Result<bool, LinearError> {
        let mut values = self.values.iter_mut();
        for a in 0..self.matrix.rows.rows() {
            for j in 0..3 {
                for (k, block) in self.matrix.blocks_of(a).iter().enumerate() {
                    let from = if k == 0 { j } else { 0 };
                    for (i, value) in (from..3).zip(&mut values) {
                        // No node of the aggregate is free along a direction of a zero.
                        *value = if k == 0 && i == j && block[(i, i)] == 0.0 { 1.0 } else { block[(i, j)] };
                    }
                }
            }
        }
        Ok(self.solver.prepare(&self.values).map_err(of_all)? == Inertia::Definite)
    }

    /// z <- A^-1 r
    fn solve(&mut self) -> Result<(), LinearError> {
        for (b, r) in self.b.chunks_exact_mut(3).zip(&self.r) {
            b.iter_mut().zip(r.to_array()).for_each(|(b, r)| *b = f64::from(r));
        }
        self.solver.solve(&self.values, &mut self.b).map_err(of_all)?;
        for (z, b) in self.z.iter_mut().zip(self.b.chunks_exact(3)) {
            *z = f32x4::new([b[0] as f32, b[1] as f32, b[2] as f32, 0.0]);
        }
        Ok(())
    }
}

/// The same error without an unknown, as that of the coarsest matrix is none of W.
fn of_all(error: LinearError) -> LinearError {
    match error {
        LinearError::NotFinite { .. } | LinearError::Singular { .. } => LinearError::Singular { unknown: None },
        other => other,
    }
}

/// The pattern of the coarsest matrix: three unknowns for each aggregate.
fn coarsest_pattern(lower: &Adjacency, position: Vec<[f64; 3]>) -> Pattern {
    let count = position.len() as u32;
    let (mut col_ptr, mut row_idx) = (vec![0], Vec::new());
    for a in 0..count {
        for u in 3 * a..3 * a + 3 {
            row_idx.extend(u..3 * a + 3);
            lower.row(a)[1..].iter().for_each(|b| row_idx.extend(3 * b..3 * b + 3));
            col_ptr.push(row_idx.len() as u32);
        }
    }
    let (dof, node_start) = ((0..3 * count).collect(), (0..=count).map(|a| 3 * a).collect());
    Pattern { col_ptr, row_idx, symmetric: true, dof, node_start, position }
}
