//! Operations on vectors `[n]` on all threads. Sums are made in fixed lanes and chunks, so their bits do not depend on
//! the number of threads.

use crate::model::lanes::{LANES, Lanes};
use crate::model::workers::Workers;
use multiversion::multiversion;

impl Workers {
    /// |v|
    pub(crate) fn norm(&self, v: &[f64]) -> f64 {
        self.dot(v, v).sqrt()
    }

    /// v.w
    pub(crate) fn dot(&self, v: &[f64], w: &[f64]) -> f64 {
        self.sum(v.len(), |range| dot(&v[range.clone()], &w[range]))
    }

    /// Norm of the entries of `r` above their rounding floors. So a stiff corner of a scene, whose residual cannot be
    /// small, hides nothing of a soft one.
    pub(crate) fn excess(&self, r: &[f64], floor: &[f64]) -> f64 {
        self.sum(r.len(), |range| excess(&r[range.clone()], &floor[range])).sqrt()
    }

    /// v <- v + a w
    pub(crate) fn add(&self, v: &mut [f64], a: f64, w: &[f64]) {
        self.set(v, |range, v| v.iter_mut().zip(&w[range]).for_each(|(v, w)| *v += a * w));
    }

    /// v <- -w
    pub(crate) fn copy_negative(&self, v: &mut [f64], w: &[f64]) {
        self.set(v, |range, v| v.iter_mut().zip(&w[range]).for_each(|(v, w)| *v = -w));
    }

    /// v <- -v
    pub(crate) fn negate(&self, v: &mut [f64]) {
        self.set(v, |_, v| v.iter_mut().for_each(|v| *v = -*v));
    }

    /// v <- w
    pub(crate) fn copy(&self, v: &mut [f64], w: &[f64]) {
        self.set(v, |range, v| v.copy_from_slice(&w[range]));
    }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn dot(v: &[f64], w: &[f64]) -> f64 {
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

/// The square of the norm.
#[multiversion(targets("x86_64+avx+avx2"))]
fn excess(r: &[f64], floor: &[f64]) -> f64 {
    let mut lanes = Lanes::default();
    let ((r, rest), (floor, other)) = (r.as_chunks::<LANES>(), floor.as_chunks::<LANES>());
    for (r, floor) in r.iter().zip(floor) {
        let mut squares = [0.0; LANES];
        for j in 0..LANES {
            squares[j] = beyond(r[j], floor[j]).powi(2);
        }
        lanes.add(&squares);
    }
    lanes.total() + rest.iter().zip(other).map(|(r, floor)| beyond(*r, *floor).powi(2)).sum::<f64>()
}

#[inline(always)]
fn beyond(r: f64, floor: f64) -> f64 {
    let excess = r.abs() - floor;
    // Not `max`, so that NaN stays NaN.
    if excess <= 0.0 { 0.0 } else { excess }
}
