//! The largest eigenvalue of a symmetric operator (Lanczos 1950), restarted with its best vector, reorthogonalised in
//! full where that is cheap.

use super::vectors::{SHAPES, add, affordable, dot, norm, orthogonalise};
use crate::model::stop::Stop;
use faer::{Mat, Side};

/// Relative residual at which no restart is made; the error of the value is about its square over the gap.
const GOOD: f64 = 1e-3;
const RESTARTS: usize = 4;
/// Products between two checks of convergence.
const LOOK: usize = 8;
/// Relative gain between two checks at which the value has converged, although modes close to each other may still mix.
const SETTLED: f64 = 2e-4;
/// A remainder below this share of the operator's norm is rounding: the space is complete.
const NOTHING_LEFT: f64 = 1e-12;
/// Length of vectors above which only the last two are orthogonalised against: orthogonality to the others is lost as
/// fast as a value converges (Paige 1971), and no value here converges beyond [`GOOD`].
const LONG: usize = 20_000;

/// The largest Ritz value: a Rayleigh quotient, so never above the largest eigenvalue.
#[derive(Clone, Debug, Default)]
pub(super) struct Ritz {
    pub value: f64,
    /// unit vector
    pub vector: Vec<f64>,
}

/// Finds the largest Ritz value from `start` `[n]`. `None` if a product is not finite, the start is zero, or it was
/// stopped.
pub(super) fn largest(mut start: Vec<f64>, stop: Stop<'_>, mut times: impl FnMut(&[f64], &mut [f64])) -> Option<Ritz> {
    let mut best = None;
    for _ in 0..RESTARTS {
        let (ritz, done) = cycle(start, stop, &mut times)?;
        start = ritz.vector.clone();
        best = Some(ritz);
        if done {
            break;
        }
    }
    best
}

fn cycle(start: Vec<f64>, stop: Stop<'_>, times: &mut impl FnMut(&[f64], &mut [f64])) -> Option<(Ritz, bool)> {
    let n = start.len();
    let most = affordable(n, SHAPES);
    let mut t = Tridiagonal::default();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let (mut q, mut scale) = (start, 0.0_f64);
    let mut remainder = norm(&q);
    let (mut top, mut before, mut done) = (None, f64::NEG_INFINITY, false);
    while basis.len() < most && remainder > NOTHING_LEFT * scale && remainder > 0.0 {
        if stop.asked() {
            return None;
        }
        if !basis.is_empty() {
            t.beta.push(remainder);
        }
        q.iter_mut().for_each(|q| *q /= remainder);
        let mut y = vec![0.0; n];
        times(&q, &mut y);
        t.alpha.push(dot(&q, &y));
        scale = scale.max(norm(&y));
        basis.push(std::mem::replace(&mut q, y));
        let known = if n > LONG { basis.len().saturating_sub(2) } else { 0 };
        remainder = orthogonalise(&mut q, &basis[known..], |_, _| {});
        if !(remainder.is_finite() && scale.is_finite()) {
            return None;
        }
        top = None;
        if basis.len().is_multiple_of(LOOK) {
            let found = t.top()?;
            let close = found.residual(remainder) <= GOOD * found.value.abs();
            done = close || found.value - before <= SETTLED * found.value.abs();
            before = found.value;
            top = Some(found);
            if done {
                break;
            }
        }
    }
    let top = top.or_else(|| t.top())?;
    let mut vector = vec![0.0; n];
    for (v, share) in basis.iter().zip(&top.shares) {
        add(&mut vector, *share, v);
    }
    done |= top.residual(remainder) <= GOOD * top.value.abs();
    Some((Ritz { value: top.value, vector }, done))
}

/// The operator projected on its Krylov space.
#[derive(Default)]
struct Tridiagonal {
    alpha: Vec<f64>,
    beta: Vec<f64>,
}

/// Its largest eigenvalue and unit eigenvector.
struct Top {
    value: f64,
    shares: Vec<f64>,
}

impl Tridiagonal {
    fn top(&self) -> Option<Top> {
        let m = self.alpha.len();
        let top = m.checked_sub(1)?;
        let t = Mat::from_fn(m, m, |i, j| match i.abs_diff(j) {
            0 => self.alpha[i],
            1 => self.beta[i.min(j)],
            _ => 0.0,
        });
        // The library bounds its QR iteration and reports if the bound is reached.
        let eigen = t.self_adjoint_eigen(Side::Lower).ok()?;
        let shares = (0..m).map(|i| eigen.U()[(i, top)]).collect();
        Some(Top { value: eigen.S().column_vector()[top], shares })
    }
}

impl Top {
    /// Norm of A u - value u, from the norm of the remainder.
    fn residual(&self, remainder: f64) -> f64 {
        remainder * self.shares.last().map_or(0.0, |share| share.abs())
    }
}
