//! The state between two steps: cubic Hermite interpolation of the end points in x, its time derivative for v.
//!
//! Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), section II.6, eq. (6.7), written in
//! increments from the start, so that a degree of freedom that does not move keeps its exact value.
//!
//! With the mean speed d/h of the step, and s from 0 to 1 along it, the derivative is
//! ```text
//! v(s) = (1 - s) v0 + s v1 + 6 s (1 - s) [d/h - (v0 + v1)/2]
//! ```
//! The bracket is -h^2 v''/12 in a smooth motion and of order h^2 in every scheme of order 2. The Euler schemes move
//! nodes with the velocity at one end only, d = h v0 or d = h v1. There it is h a/2 or -h a/2, which would change v in
//! each step by 3/4 of the increment of the step. It is left out then: the error of the linear v is h^2 v''/8 only.

use crate::model::state::{State, StateRef};

/// Writes the state at `fraction` of the step from `from` to `to` into `out`, which has their size.
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
        let rounding = 4.0 * f64::EPSILON * (x0.abs().max(x1.abs()) + to.t.abs() * v0.abs().max(v1.abs()));
        let by_one_end = (d - p0).abs().min((d - p1).abs()) <= rounding;
        *v = if by_one_end { v0 + s * (v1 - v0) } else { v0 + s * (2.0 * square + 3.0 * s * cube) / h };
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

    /// An oscillator x'' = -x under explicit Euler (d = h v0) and Euler-Cromer (d = h v1), far from the origin and
    /// late: between its steps the velocity is that of the chord, up to rounding. The bracket would add 0.03 at the
    /// turning points.
    #[test]
    fn euler_steps_do_not_bend_the_velocity() {
        let h = 0.02;
        for explicit in [true, false] {
            let mut from = State { t: 40.0, x: vec![1e3 + 2.0], v: vec![0.0] };
            let mut out = from.clone();
            for step in 1..=400_u32 {
                let v1 = from.v[0] - h * (from.x[0] - 1e3);
                let x1 = from.x[0] + h * if explicit { from.v[0] } else { v1 };
                let to = State { t: 40.0 + f64::from(step) * h, x: vec![x1], v: vec![v1] };
                interpolate(from.as_ref(), to.as_ref(), 0.5, &mut out);
                let chord = f64::midpoint(from.v[0], v1);
                assert!((out.v[0] - chord).abs() < 1e-14, "step {step}: {} {chord}", out.v[0]);
                from = to;
            }
        }
    }
}
