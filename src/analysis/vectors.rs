//! Vector operations of the Krylov iterations, and how many vectors they may store.

/// a.b in eight lanes. The order of the sum differs from `solve::norms`, and the bits of limits depend on it.
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

/// Removes the components along an orthonormal basis from q. Calls `part_was(i, component)` and returns the norm of the
/// rest. A second pass follows if the first removed most of q and so left rounding (Daniel, Gragg, Kaufman & Stewart
/// 1976).
pub(super) fn orthogonalise(q: &mut [f64], basis: &[Vec<f64>], mut part_was: impl FnMut(usize, f64)) -> f64 {
    let mut before = norm(q);
    loop {
        for (i, v) in basis.iter().enumerate() {
            let part = dot(v, q);
            part_was(i, part);
            add(q, -part, v);
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
