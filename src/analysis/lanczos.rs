//! The largest eigenvalue of a symmetric operator (Lanczos 1950), reorthogonalised in full, restarted with its best vector.

use super::linearised::{add, affordable, dot, norm};
use faer::{Mat, Side};

/// Residual over value at which no restart is made; the value is then wrong by about its square over the gap.
const GOOD: f64 = 1e-3;
const RESTARTS: usize = 4;
/// A remainder of this share of the operator's size is rounding: the space is complete.
const NOTHING_LEFT: f64 = 1e-12;

/// The largest Ritz value: a Rayleigh quotient, so never above the largest eigenvalue; an eigenvalue lies within `residual` of it.
#[derive(Clone, Debug, Default)]
pub(super) struct Ritz {
    pub value: f64,
    /// unit vector
    pub vector: Vec<f64>,
}

/// `None` where a product is not finite or there is nothing to iterate on.
pub(super) fn largest(mut start: Vec<f64>, mut times: impl FnMut(&[f64], &mut [f64])) -> Option<Ritz> {
    let mut best = None;
    for _ in 0..RESTARTS {
        let (ritz, residual) = cycle(start, &mut times)?;
        let done = residual <= GOOD * ritz.value.abs();
        start = ritz.vector.clone();
        best = Some(ritz);
        if done {
            break;
        }
    }
    best
}

fn cycle(start: Vec<f64>, times: &mut impl FnMut(&[f64], &mut [f64])) -> Option<(Ritz, f64)> {
    let n = start.len();
    let most = affordable(n, [12, 60]);
    let (mut alpha, mut beta) = (Vec::new(), Vec::new());
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let (mut q, mut size, mut scale) = (start, 0.0, 0.0_f64);
    let mut remainder = norm(&q);
    while basis.len() < most && remainder > NOTHING_LEFT * scale && remainder > 0.0 {
        if !basis.is_empty() {
            beta.push(size);
        }
        q.iter_mut().for_each(|q| *q /= remainder);
        let mut y = vec![0.0; n];
        times(&q, &mut y);
        alpha.push(dot(&q, &y));
        scale = scale.max(norm(&y));
        basis.push(std::mem::replace(&mut q, y));
        // Twice is enough (Kahan, in Parlett 1980).
        for _ in 0..2 {
            for v in &basis {
                let part = dot(v, &q);
                add(&mut q, -part, v);
            }
        }
        remainder = norm(&q);
        size = remainder;
        if !(remainder.is_finite() && scale.is_finite()) {
            return None;
        }
    }
    let m = alpha.len();
    let top = m.checked_sub(1)?;
    let t = Mat::from_fn(m, m, |i, j| match i.abs_diff(j) {
        0 => alpha[i],
        1 => beta[i.min(j)],
        _ => 0.0,
    });
    let eigen = t.self_adjoint_eigen(Side::Lower).ok()?;
    let value = eigen.S().column_vector()[top];
    let mut vector = vec![0.0; n];
    for (i, v) in basis.iter().enumerate() {
        add(&mut vector, eigen.U()[(i, top)], v);
    }
    Some((Ritz { value, vector }, (size * eigen.U()[(top, top)]).abs()))
}
