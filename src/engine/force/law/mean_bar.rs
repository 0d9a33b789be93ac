//! The mean force of a two-node element over a step (Greenspan 1984), from the mean tension T between its lengths.
//!
//! ```text
//! f_a = T d/l,   f_b = -f_a,      d = (d_0 + d_1)/2,   l = (l_0 + l_1)/2,   T = (E_1 - E_0)/(l_1 - l_0)
//! B   = 2 T' d/l n_1^T + T/l (I - d/l n_1^T),      T' = dT/dl_1,   n_1 = d_1/l_1       (the middle moves, d_0 stays)
//! ```
//! d . (d_1 - d_0) = l (l_1 - l_0), so the work is that of T along the length.

use crate::force::law::curve::MeanTension;
use crate::force::{TangentForm, outer};
use nalgebra::{Matrix3, Vector3};

/// A two-node element over a step.
pub(in crate::force) struct MeanBar {
    /// [m] at the start and at the end
    pub lengths: [f64; 2],
    middle: Vector3<f64>,
    /// [m] l, the mean length
    mean_length: f64,
    end: Vector3<f64>,
    tension: MeanTension,
}

impl MeanBar {
    /// From the vectors [m] between its ends at the start, in the middle and at the end of the step, and the law.
    pub(crate) fn new([start, middle, end]: [Vector3<f64>; 3], tension: impl FnOnce([f64; 2]) -> MeanTension) -> Self {
        let lengths = [start, end].map(|d| d.norm());
        MeanBar { lengths, middle, mean_length: 0.5 * (lengths[0] + lengths[1]), end, tension: tension(lengths) }
    }

    /// T/l; 0 for an element without a length.
    fn over_length(&self) -> f64 {
        if self.mean_length > 0.0 { self.tension.force / self.mean_length } else { 0.0 }
    }

    /// Adds f_a and f_b [N] to `f` `[n_nodes]`.
    pub(crate) fn add(&self, [a, b]: [u32; 2], f: &mut [Vector3<f64>]) {
        let force = self.middle * self.over_length();
        f[a as usize] += force;
        f[b as usize] -= force;
    }

    /// [N/m] B; in the symmetric form with the direction of d in place of both d/l and n_1.
    pub(crate) fn block(&self, form: TangentForm) -> Matrix3<f64> {
        let kept = |number: f64| if form.convex { number.max(0.0) } else { number };
        let (across, along) = (kept(self.over_length()), kept(2.0 * self.tension.slope));
        let [left, right] = match form.symmetric {
            true => [self.middle.try_normalize(0.0).unwrap_or_default(); 2],
            false if self.mean_length > 0.0 => {
                [self.middle / self.mean_length, self.end.try_normalize(0.0).unwrap_or_default()]
            }
            false => [Vector3::zeros(); 2],
        };
        Matrix3::from_diagonal_element(across) + outer(left, right) * (along - across)
    }
}
