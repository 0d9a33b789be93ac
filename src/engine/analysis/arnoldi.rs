//! Outer eigenvalues of a real non-symmetric operator (Arnoldi 1951), with full reorthogonalisation. Estimates: a small
//! residual does not bound the error if eigenvectors are nearly parallel.

use super::hessenberg::{Eigenvector, eigenvalues, eigenvector};
use super::vectors::{MIN_ARNOLDI, add, affordable, norm, orthogonalise};
use crate::model::stop::Stop;
use faer::{Mat, c64};

/// A remainder below this share of a product is rounding: the space is invariant.
const NOTHING_LEFT: f64 = 1e-13;

/// A Krylov space and the operator projected on it.
pub(super) struct Krylov {
    basis: Vec<Vec<f64>>,
    /// column j of the operator on the space, upper Hessenberg: its first j + 2 entries
    columns: Vec<Vec<f64>>,
    /// what the last product has outside the space; before the first, the start
    outside: Vec<f64>,
    /// norm of the last product
    scale: f64,
    /// the operator on the space
    h: Mat<f64>,
    /// its eigenvalues; of a conjugate pair the one with the positive imaginary part
    pub values: Vec<c64>,
}

/// An eigenvector on the space.
pub(super) struct RitzVector {
    shares: Vec<c64>,
    /// [-] norm of A u - value u for the unit vector u
    pub residual: f64,
}

impl Krylov {
    /// From `start` `[n]`, with no products yet.
    pub(super) fn from(start: Vec<f64>) -> Self {
        Krylov { basis: vec![], columns: vec![], outside: start, scale: 0.0, h: Mat::zeros(0, 0), values: vec![] }
    }

    /// Extends the space to `most` products, or as many vectors as are affordable. `None` if a product is not finite,
    /// it was stopped, or the eigenvalue iteration did not converge.
    pub(super) fn extend(
        &mut self,
        most: usize,
        stop: Stop<'_>,
        mut times: impl FnMut(&[f64], &mut [f64]),
    ) -> Option<()> {
        let n = self.outside.len();
        let most = affordable(n, [MIN_ARNOLDI, most]);
        while self.basis.len() < most && self.left() > 0.0 {
            if stop.asked() {
                return None;
            }
            let (left, mut column) = (self.left(), vec![0.0; self.basis.len() + 2]);
            self.outside.iter_mut().for_each(|q| *q /= left);
            let mut product = vec![0.0; n];
            times(&self.outside, &mut product);
            self.scale = norm(&product);
            self.basis.push(std::mem::replace(&mut self.outside, product));
            let left = orthogonalise(&mut self.outside, &self.basis, |i, part| column[i] += part);
            if !(left.is_finite() && self.scale.is_finite()) {
                return None;
            }
            column[self.basis.len()] = left;
            self.columns.push(column);
        }
        let m = self.basis.len();
        self.h = Mat::from_fn(m, m, |i, j| self.columns[j].get(i).copied().unwrap_or(0.0));
        self.values = eigenvalues(&self.h)?.into_iter().filter(|value| value.im >= 0.0).collect();
        (m > 0).then_some(())
    }

    /// Norm of what is outside the space; 0 where that is rounding.
    fn left(&self) -> f64 {
        let left = self.columns.last().map_or_else(|| norm(&self.outside), |column| column[column.len() - 1]);
        if left > NOTHING_LEFT * self.scale { left } else { 0.0 }
    }

    /// The Ritz vector of an eigenvalue.
    pub(super) fn ritz(&self, value: c64) -> RitzVector {
        let Eigenvector { u, residual } = eigenvector(&self.h, value);
        let last = u.last().map_or(0.0, |u| u.norm());
        RitzVector { shares: u, residual: residual + self.left() * last }
    }

    /// Real and imaginary parts of a Ritz vector, each `[n]`.
    pub(super) fn vector(&self, of: &RitzVector) -> [Vec<f64>; 2] {
        let n = self.basis.first().map_or(0, Vec::len);
        let mut parts = [vec![0.0; n], vec![0.0; n]];
        for (v, u) in self.basis.iter().zip(&of.shares) {
            add(&mut parts[0], u.re, v);
            add(&mut parts[1], u.im, v);
        }
        parts
    }
}

/// The degree of freedom that moves most in an eigenvector that begins with positions and velocities, in M^1/2 x;
/// `root` is the diagonal of M^-1/2.
pub(super) fn most_moving_dof([re, im]: &[Vec<f64>; 2], root: &[f64]) -> usize {
    let n = root.len();
    let square = |i: usize| re[i] * re[i] + im[i] * im[i];
    let moves = |i: usize| (square(i) + square(n + i)) * root[i].powi(2);
    (0..n).max_by(|&a, &b| moves(a).total_cmp(&moves(b))).unwrap_or(0)
}
