//! Operations on vectors that the Krylov iterations share, and how many vectors they may keep.

/// a.b in eight lanes, which a processor can add side by side. Adds them in another order than `solve::norms`: the bits
/// of limits hang on it.
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

/// Takes the parts along an orthonormal basis out of q, and says how large they were and what is left. A second pass is
/// made where the first took most of q away and so left rounding (Daniel, Gragg, Kaufman & Stewart 1976).
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
        // What is left of the second pass is as good as its own size.
        before = left;
    }
}

/// Least and most shapes that a search for the largest eigenvalue keeps, and least of one for eigenvalues of L.
pub(super) const SHAPES: [usize; 2] = [12, 60];
pub(super) const MIN_ARNOLDI: usize = 20;
/// Vectors of length `n` that fit into the memory an analysis may take, at least `least`, at most `most`.
pub(super) fn affordable(n: usize, [least, most]: [usize; 2]) -> usize {
    const NUMBERS: usize = 12_000_000;
    (NUMBERS / n.max(1)).clamp(least, most).min(n)
}
