//! Vector operations of the Krylov iterations, and how many vectors they may store.

use crate::model::quad::{self, Pass, Quad, VectorUnit};

/// a.b in eight lanes. The order of the sum differs from `solve::vectors`, and the bits of limits depend on it.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, a_rest) = a.as_chunks::<8>();
    let (b, b_rest) = b.as_chunks::<8>();
    let mut lanes = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for (lane, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            *lane += a * b;
        }
    }
    lanes.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f64>()
}

pub(super) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// y += f x
pub(super) fn add(y: &mut [f64], f: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += f * x;
    }
}

/// Removes the components along `N` orthonormal vectors from q, and returns them.
struct Remove<'a, const N: usize> {
    q: &'a mut [f64],
    along: [&'a [f64]; N],
}

impl<const N: usize> Pass for Remove<'_, N> {
    type Output = [f64; N];

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) -> [f64; N] {
        let (q, q_rest) = self.q.as_chunks_mut::<4>();
        let split = self.along.map(|v| v.as_chunks::<4>());
        let along = split.map(|(v, _)| &v[..q.len()]);
        let mut sums = [unit.splat(0.0); N];
        for (i, q) in q.iter().enumerate() {
            let q = unit.quad(*q);
            for (sum, v) in sums.iter_mut().zip(along) {
                *sum = *sum + unit.quad(v[i]) * q;
            }
        }
        let mut parts = sums.map(|sum| sum.numbers().iter().sum::<f64>());
        for (part, (_, rest)) in parts.iter_mut().zip(split) {
            *part += q_rest.iter().zip(rest).map(|(q, v)| q * v).sum::<f64>();
        }
        let factors = parts.map(|part| unit.splat(part));
        for (i, q) in q.iter_mut().enumerate() {
            let mut left = unit.quad(*q);
            for (factor, v) in factors.iter().zip(along) {
                left = left - *factor * unit.quad(v[i]);
            }
            *q = left.numbers();
        }
        for (part, (_, rest)) in parts.iter().zip(split) {
            add(q_rest, -part, rest);
        }
        parts
    }
}

/// Removes the components along an orthonormal basis from q. Calls `part_was(i, component)` and returns the norm of the
/// rest. A second pass follows if the first removed most of q and so left rounding (Daniel, Gragg, Kaufman & Stewart
/// 1976).
pub(super) fn orthogonalise(q: &mut [f64], basis: &[Vec<f64>], mut part_was: impl FnMut(usize, f64)) -> f64 {
    let mut before = norm(q);
    loop {
        // Four at a time read and write q a quarter as often.
        let (fours, others) = basis.as_chunks::<4>();
        let parts = fours.iter().flat_map(|four| quad::run(Remove { q, along: four.each_ref().map(Vec::as_slice) }));
        parts.enumerate().for_each(|(i, part)| part_was(i, part));
        for (i, v) in others.iter().enumerate() {
            let [part] = quad::run(Remove { q, along: [v] });
            part_was(4 * fours.len() + i, part);
        }
        let left = norm(q);
        if left > 0.5 * before || before == 0.0 || !left.is_finite() || left < f64::EPSILON * before {
            return left;
        }
        // The second pass is accurate relative to its own size.
        before = left;
    }
}

/// Minimum and maximum number of vectors of a Lanczos search, and minimum of an Arnoldi search.
pub(super) const SHAPES: [usize; 2] = [12, 60];
pub(super) const MIN_ARNOLDI: usize = 20;
/// Number of vectors of length `n` that fit into the memory of an analysis, within [`least`, `most`].
pub(super) fn affordable(n: usize, [least, most]: [usize; 2]) -> usize {
    const NUMBERS: usize = 12_000_000;
    (NUMBERS / n.max(1)).clamp(least, most).min(n)
}
