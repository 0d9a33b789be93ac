//! Inner products and norms of vectors `[n]`, summed in fixed lanes.

use crate::model::lanes::{LANES, Lanes};
use multiversion::multiversion;

/// |v|
pub(crate) fn norm(v: &[f64]) -> f64 {
    dot(v, v).sqrt()
}

/// v.w
#[multiversion(targets("x86_64+avx+avx2"))]
pub(crate) fn dot(v: &[f64], w: &[f64]) -> f64 {
    let mut lanes = Lanes::default();
    let ((v, rest), (w, other)) = (v.as_chunks::<LANES>(), w.as_chunks::<LANES>());
    for (v, w) in v.iter().zip(w) {
        let mut products = [0.0; LANES];
        for j in 0..LANES {
            products[j] = v[j] * w[j];
        }
        lanes.add(&products);
    }
    lanes.total() + rest.iter().zip(other).map(|(v, w)| v * w).sum::<f64>()
}

/// Norm of the entries of `r` above their rounding floors; both `[n]`. So a stiff corner of a scene, whose residual
/// cannot be small, hides nothing of a soft one.
#[multiversion(targets("x86_64+avx+avx2"))]
pub(crate) fn excess(r: &[f64], floor: &[f64]) -> f64 {
    let mut lanes = Lanes::default();
    let ((r, rest), (floor, other)) = (r.as_chunks::<LANES>(), floor.as_chunks::<LANES>());
    for (r, floor) in r.iter().zip(floor) {
        let mut squares = [0.0; LANES];
        for j in 0..LANES {
            squares[j] = beyond(r[j], floor[j]).powi(2);
        }
        lanes.add(&squares);
    }
    (lanes.total() + rest.iter().zip(other).map(|(r, floor)| beyond(*r, *floor).powi(2)).sum::<f64>()).sqrt()
}

#[inline(always)]
fn beyond(r: f64, floor: f64) -> f64 {
    let excess = r.abs() - floor;
    // Not `max`, so that NaN stays NaN.
    if excess <= 0.0 { 0.0 } else { excess }
}
