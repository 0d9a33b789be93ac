//! The largest eigenvalues of a symmetric positive definite operator with their vectors: a block Lanczos iteration with
//! full orthogonalisation and restarts that keep the best vectors (Grimes, Lewis & Simon 1994; Wu & Simon 2000).
//!
//! A block finds at most as many vectors of one eigenvalue as it has itself, and it may find a whole invariant space
//! that is not all. So new vectors join it until the operator says that no eigenvalue is missing.

use super::low_mode::ModesError;
use super::vectors::{add, dot, norm, orthogonalise};
use crate::mesh::random::pseudo_random;
use crate::model::stop::Stop;
use crate::solve::LinearError;
use faer::{Mat, Side};

/// Vectors that are multiplied at a time at first, and at most.
const BLOCK: usize = 4;
const LARGEST_BLOCK: usize = 16;
/// [-] Residual of an eigenvalue over the eigenvalue: its error is about the square of it.
const GOOD: f64 = 1e-8;
/// Products after which the iteration gives up, for each vector.
const PRODUCTS: usize = 200;
/// [-] A vector that orthogonalisation leaves shorter than this share is rounding.
const NOTHING_LEFT: f64 = 1e-10;

/// A symmetric positive definite operator.
pub(super) trait Operator {
    /// Its product with a vector.
    fn times(&mut self, q: &[f64]) -> Result<Vec<f64>, LinearError>;

    /// Whether no eigenvalue is missing among its largest ones, descending.
    fn complete(&mut self, largest: &[f64]) -> Result<bool, LinearError>;
}

/// An orthonormal basis with its images.
pub(super) struct Krylov {
    basis: Vec<Vec<f64>>,
    images: Vec<Vec<f64>>,
    /// the operator in the basis, lower triangle by rows
    projected: Vec<Vec<f64>>,
    count: usize,
    /// random vectors taken so far
    seeds: usize,
}

impl Krylov {
    /// Unit eigenvectors `[n]` of the `count` largest eigenvalues, descending.
    pub(super) fn largest(
        of: &mut impl Operator,
        n: usize,
        count: usize,
        stop: Stop<'_>,
    ) -> Result<Vec<Vec<f64>>, ModesError> {
        let (basis, images, projected) = (Vec::new(), Vec::new(), Vec::new());
        let mut krylov = Krylov { basis, images, projected, count, seeds: 0 };
        let most = (3 * count + 2 * LARGEST_BLOCK).min(n);
        let mut block: Vec<Vec<f64>> = Vec::new();
        krylov.join(n, &mut block);
        let (mut products, mut found, mut look) = (0, 0, count);
        while products < PRODUCTS * (count + BLOCK) {
            if stop.asked() {
                return Err(ModesError::Stopped);
            }
            products += block.len().max(1);
            krylov.expand(of, &mut block)?;
            let full = krylov.basis.len() + block.len() > most;
            if krylov.basis.len() < look && !full && !block.is_empty() {
                continue;
            }
            look = krylov.basis.len() + BLOCK.max(count / 4);
            let ritz = krylov.ritz()?;
            found = ritz.iter().take(count).filter(|one| one.residual <= GOOD * one.value.abs()).count();
            let whole = krylov.basis.len() == n;
            let values: Vec<f64> = ritz.iter().take(count).map(|one| one.value).collect();
            if whole || found == count && of.complete(&values)? {
                return Ok(ritz.into_iter().take(count).map(Ritz::smoothed).collect());
            }
            if full && krylov.basis.len() > count + BLOCK {
                krylov.restart(ritz);
                look = 0;
            }
            if found == count || block.is_empty() {
                krylov.join(n, &mut block);
                look = krylov.basis.len() + 4 * block.len();
            }
        }
        Err(ModesError::NotConverged { found, asked: count, solves: products })
    }

    /// Adds a block to the basis, and makes the next one of its images.
    fn expand(&mut self, of: &mut impl Operator, block: &mut Vec<Vec<f64>>) -> Result<(), LinearError> {
        let added = block.len();
        for q in block.drain(..) {
            self.images.push(of.times(&q)?);
            self.basis.push(q);
        }
        for i in self.basis.len() - added..self.basis.len() {
            self.projected.push((0..=i).map(|j| dot(&self.basis[i], &self.images[j])).collect());
        }
        let mut next = Vec::new();
        for image in &self.images[self.images.len() - added..] {
            self.take(image.clone(), &mut next);
        }
        *block = next;
        Ok(())
    }

    /// Adds new vectors to a block.
    fn join(&mut self, n: usize, block: &mut Vec<Vec<f64>>) {
        for _ in 0..BLOCK.min(LARGEST_BLOCK.saturating_sub(block.len())) {
            let seed = (0..n).map(|i| pseudo_random(i + self.seeds * n)).collect();
            self.seeds += 1;
            self.take(seed, block);
        }
    }

    fn restart(&mut self, best: Vec<Ritz>) {
        (self.basis, self.images, self.projected) = Default::default();
        for (i, one) in best.into_iter().enumerate() {
            self.basis.push(one.vector);
            self.images.push(one.image);
            self.projected.push((0..=i).map(|j| if i == j { one.value } else { 0.0 }).collect());
        }
    }

    /// Appends a vector to a block, made orthogonal to the basis and to the block, if something is left of it.
    fn take(&self, mut q: Vec<f64>, block: &mut Vec<Vec<f64>>) {
        let whole = norm(&q);
        let mut left = whole;
        // A second time, because each set disturbs what the other has made.
        for _ in 0..2 {
            orthogonalise(&mut q, &self.basis, |_, _| {});
            left = orthogonalise(&mut q, block, |_, _| {});
        }
        if left > NOTHING_LEFT * whole && left.is_finite() {
            q.iter_mut().for_each(|q| *q /= left);
            block.push(q);
        }
    }

    /// The Ritz pairs that a restart keeps, the largest first.
    fn ritz(&self) -> Result<Vec<Ritz>, LinearError> {
        let m = self.basis.len();
        let projected = Mat::from_fn(m, m, |i, j| self.projected[i.max(j)][i.min(j)]);
        let eigen = projected.self_adjoint_eigen(Side::Lower).map_err(|_| LinearError::Singular { unknown: None })?;
        let pick = |k: usize| {
            let value = eigen.S().column_vector()[k];
            let n = self.basis.first().map_or(0, Vec::len);
            let (mut vector, mut image) = (vec![0.0; n], vec![0.0; n]);
            for (i, (q, of_q)) in self.basis.iter().zip(&self.images).enumerate() {
                add(&mut vector, eigen.U()[(i, k)], q);
                add(&mut image, eigen.U()[(i, k)], of_q);
            }
            let left: f64 = image.iter().zip(&vector).map(|(y, q)| (y - value * q).powi(2)).sum();
            Ritz { value, vector, image, residual: left.sqrt() }
        };
        Ok((0..m).rev().take(self.count + BLOCK).map(pick).collect())
    }
}

/// An approximate eigenpair.
struct Ritz {
    value: f64,
    vector: Vec<f64>,
    /// the operator times the vector
    image: Vec<f64>,
    /// norm of image - value vector
    residual: f64,
}

impl Ritz {
    /// The image, of unit length: the operator has damped what other eigenvectors, of small eigenvalues, have in the
    /// vector.
    fn smoothed(mut self) -> Vec<f64> {
        let size = norm(&self.image);
        self.image.iter_mut().for_each(|y| *y /= size);
        self.image
    }
}
