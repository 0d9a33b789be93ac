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
    /// the operator on the space, upper Hessenberg
    h: Mat<f64>,
    /// norm of the remainder outside the space
    left: f64,
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
    /// From `start` `[n]`, with at most `most` products. `None` if one is not finite, it was stopped, or the eigenvalue
    /// iteration did not converge.
    pub fn of(start: Vec<f64>, most: usize, stop: Stop<'_>, times: impl FnMut(&[f64], &mut [f64])) -> Option<Self> {
        let (basis, h, left) = project(start, most, stop, times)?;
        let values = eigenvalues(&h)?.into_iter().filter(|value| value.im >= 0.0).collect();
        Some(Krylov { basis, h, left, values })
    }

    /// The Ritz vector of an eigenvalue.
    pub fn ritz(&self, value: c64) -> RitzVector {
        let Eigenvector { u, residual } = eigenvector(&self.h, value);
        let last = u.last().map_or(0.0, |u| u.norm());
        RitzVector { shares: u, residual: residual + self.left * last }
    }

    /// Real and imaginary parts of a Ritz vector, each `[n]`.
    pub fn vector(&self, of: &RitzVector) -> [Vec<f64>; 2] {
        let n = self.basis.first().map_or(0, Vec::len);
        let mut parts = [vec![0.0; n], vec![0.0; n]];
        for (v, u) in self.basis.iter().zip(&of.shares) {
            add(&mut parts[0], u.re, v);
            add(&mut parts[1], u.im, v);
        }
        parts
    }
}

/// The degree of freedom that moves most in an eigenvector with position and velocity halves, in coordinates M^1/2 x;
/// `root` is the diagonal of M^-1/2.
pub(super) fn most_moving_dof([re, im]: &[Vec<f64>; 2], root: &[f64]) -> usize {
    let n = root.len();
    let square = |i: usize| re[i] * re[i] + im[i] * im[i];
    let moves = |i: usize| (square(i) + square(n + i)) * root[i].powi(2);
    (0..n).max_by(|&a, &b| moves(a).total_cmp(&moves(b))).unwrap_or(0)
}

/// Basis, projected operator, norm of the remainder.
type Projection = (Vec<Vec<f64>>, Mat<f64>, f64);

fn project(
    start: Vec<f64>,
    most: usize,
    stop: Stop<'_>,
    mut times: impl FnMut(&[f64], &mut [f64]),
) -> Option<Projection> {
    let n = start.len();
    let most = affordable(n, [MIN_ARNOLDI, most]);
    let mut h = Mat::<f64>::zeros(most + 1, most);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut q = start;
    let (mut left, mut scale) = (norm(&q), 0.0);
    while basis.len() < most && left > NOTHING_LEFT * scale && left > 0.0 {
        if stop.asked() {
            return None;
        }
        let j = basis.len();
        q.iter_mut().for_each(|q| *q /= left);
        let mut y = vec![0.0; n];
        times(&q, &mut y);
        scale = norm(&y);
        basis.push(std::mem::replace(&mut q, y));
        left = orthogonalise(&mut q, &basis, |i, part| h[(i, j)] += part);
        h[(j + 1, j)] = left;
        if !(left.is_finite() && scale.is_finite()) {
            return None;
        }
    }
    let m = basis.len();
    let square = Mat::from_fn(m, m, |i, j| h[(i, j)]);
    if m == 0 { None } else { Some((basis, square, if left > NOTHING_LEFT * scale { left } else { 0.0 })) }
}
