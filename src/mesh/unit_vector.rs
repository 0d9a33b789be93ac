//! A vector over its length, with one division instead of one per component.

use nalgebra::SVector;

/// v / |v|; `None` if the length is 0, not finite, or overflows.
#[inline]
pub fn unit_vector<const D: usize>(v: SVector<f64, D>) -> Option<SVector<f64, D>> {
    let inverse = v.norm().recip();
    (inverse.is_finite() && inverse > 0.0).then(|| v * inverse)
}
