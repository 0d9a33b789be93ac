//! The state between two steps: cubic Hermite interpolation of the end points in x, its time derivative for v.
//!
//! Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), section II.6, eq. (6.7), written in
//! increments from the start, so that a degree of freedom that does not move keeps its exact value.

use crate::model::state::{State, StateRef};

/// Writes the state at `fraction` of the way from `from` to `to` into `out`, which has their size.
pub fn interpolate(from: StateRef<'_>, to: StateRef<'_>, fraction: f64, out: &mut State) {
    let h = to.t - from.t;
    if h <= 0.0 {
        out.copy_from(to);
        return;
    }
    let s = fraction;
    out.t = from.t + s * h;
    let ends = from.x.iter().zip(from.v).zip(to.x.iter().zip(to.v));
    for ((x, v), ((&x0, &v0), (&x1, &v1))) in out.x.iter_mut().zip(&mut out.v).zip(ends) {
        let (d, p0, p1) = (x1 - x0, h * v0, h * v1);
        let square = 3.0 * d - 2.0 * p0 - p1;
        let cube = p0 + p1 - 2.0 * d;
        *x = x0 + s * (p0 + s * (square + s * cube));
        *v = v0 + s * (2.0 * square + 3.0 * s * cube) / h;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hermite interpolation of a cubic is that cubic, in x and in v.
    #[test]
    fn exact_for_cubics() {
        let x = |t: f64| 2.0 - 3.0 * t + 0.5 * t * t - 4.0 * t * t * t;
        let v = |t: f64| -3.0 + t - 12.0 * t * t;
        let at = |t: f64| State { t, x: vec![x(t), 7.25], v: vec![v(t), 0.0] };
        let (from, to) = (at(0.3), at(0.8));
        let mut out = at(0.0);
        for fraction in [0.125, 0.5, 0.9] {
            interpolate(from.as_ref(), to.as_ref(), fraction, &mut out);
            let t = 0.3 + 0.5 * fraction;
            assert!((out.t - t).abs() < 1e-15);
            assert!((out.x[0] - x(t)).abs() < 1e-14 && (out.v[0] - v(t)).abs() < 1e-13, "{out:?}");
            assert_eq!((out.x[1], out.v[1]), (7.25, 0.0), "a resting value keeps its bits");
        }
    }
}
