//! Outer eigenvalues of a real operator that is not symmetric (Arnoldi 1951), reorthogonalised in full. Estimates: a
//! small residual does not bound the error where eigenvectors are nearly parallel.

use super::linearised::{LEAST_MOTIONS, add, affordable, norm, orthogonalise};
use faer::Mat;

/// A remainder of this share of a product is rounding: the space is invariant.
const NOTHING_LEFT: f64 = 1e-13;

/// An eigenvalue of the operator on the Krylov space.
#[derive(Clone, Copy, Debug)]
pub(super) struct RitzValue {
    pub re: f64,
    pub im: f64,
    /// [-] size of A u - value u for the unit vector u
    pub residual: f64,
    column: usize,
}

/// A Krylov space and what the operator does on it.
pub(super) struct Krylov {
    basis: Vec<Vec<f64>>,
    /// eigenvectors in the basis: real and imaginary parts
    vectors: Vec<Vec<[f64; 2]>>,
    pub values: Vec<RitzValue>,
}

impl Krylov {
    /// At most `most` products; `None` where one is not finite.
    pub fn of(start: Vec<f64>, most: usize, times: impl FnMut(&[f64], &mut [f64])) -> Option<Self> {
        let (basis, h, left) = hessenberg(start, most, times)?;
        let eigen = h.eigen().ok()?;
        let m = basis.len();
        let entry = |i: usize, j: usize| [eigen.U()[(i, j)].re, eigen.U()[(i, j)].im];
        let vectors: Vec<Vec<[f64; 2]>> = (0..m).map(|j| (0..m).map(|i| entry(i, j)).collect()).collect();
        let square = |z: &[f64; 2]| z[0] * z[0] + z[1] * z[1];
        let values = vectors.iter().enumerate().map(|(column, u)| {
            let value = eigen.S().column_vector()[column];
            let size = u.iter().map(square).sum::<f64>();
            let last = u.last().map_or(0.0, square);
            RitzValue { re: value.re, im: value.im, residual: left * (last / size).sqrt(), column }
        });
        let values = values.collect();
        Some(Krylov { basis, vectors, values })
    }

    /// Real and imaginary parts of an eigenvector.
    pub fn vector(&self, of: RitzValue) -> [Vec<f64>; 2] {
        let n = self.basis.first().map_or(0, Vec::len);
        let mut parts = [vec![0.0; n], vec![0.0; n]];
        for (v, u) in self.basis.iter().zip(&self.vectors[of.column]) {
            for (part, factor) in parts.iter_mut().zip(u) {
                add(part, *factor, v);
            }
        }
        parts
    }
}

/// The degree of freedom that moves most in an eigenvector of two halves, in coordinates M^1/2 x; `root` is the diagonal of M^-1/2.
pub(super) fn place([re, im]: &[Vec<f64>; 2], root: &[f64]) -> usize {
    let n = root.len();
    let square = |i: usize| re[i] * re[i] + im[i] * im[i];
    let moves = |i: usize| (square(i) + square(n + i)) * root[i].powi(2);
    (0..n).max_by(|&a, &b| moves(a).total_cmp(&moves(b))).unwrap_or(0)
}

/// Basis, projected operator, size of what is left outside.
type Projection = (Vec<Vec<f64>>, Mat<f64>, f64);

fn hessenberg(start: Vec<f64>, most: usize, mut times: impl FnMut(&[f64], &mut [f64])) -> Option<Projection> {
    let n = start.len();
    let most = affordable(n, [LEAST_MOTIONS, most]);
    let mut h = Mat::<f64>::zeros(most + 1, most);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut q = start;
    let (mut left, mut scale) = (norm(&q), 0.0);
    while basis.len() < most && left > NOTHING_LEFT * scale && left > 0.0 {
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
