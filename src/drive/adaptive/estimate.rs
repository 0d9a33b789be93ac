//! The local error of a step, for any scheme.
//!
//! [`Quadrature`], for orders 1 and 2: the true accelerations a = M^-1 f at the step's ends and at the end of the step before
//! define a parabola; what integrating it gives is right to h^4 in v and h^5 in x, so the scheme's difference from it is the leading
//! term of its own local error, whatever the scheme (the idea of Milne's device: Hairer, Norsett & Wanner 1993, III.1). With
//! g the step before, and d2 the second divided difference of a:
//! ```text
//! e_x = x_{n+1} - x_n - h v_n - h^2/6 (2 a_n + a_{n+1}) + h^4/12 d2
//! e_v = v_{n+1} - v_n - h/2 (a_n + a_{n+1})             + h^3/6  d2
//! d2  = [(a_{n+1} - a_n)/h - (a_n - a_{n-1})/g] / (h + g)
//! ```
//! It costs no force pass. For Newmark's displacement it is the estimate h^2 (beta - 1/6) (a_{n+1} - a_n) of Zienkiewicz & Xie
//! (1991, Earthquake Eng. Struct. Dyn. 20, 871-887) to leading order, and unlike that sees the velocity's error too, which is as large, and does not vanish for beta = 1/6.
//!
//! [`doubled`], for higher orders and for steps without a step before: one step against two halves, divided by
//! 2^p - 1 (Hairer, Norsett & Wanner 1993, section II.4).

use serde::{Deserialize, Serialize};

use crate::drive::clock::Tolerance;
use crate::model::point::Point;
use crate::model::state::StateRef;

/// Local errors of a step, by degree of freedom.
#[derive(Clone, Debug, Default)]
pub struct LocalError {
    /// [m] of the positions
    pub x: Vec<f64>,
    /// [m/s] of the velocities
    pub v: Vec<f64>,
}

impl LocalError {
    /// Room for `n` degrees of freedom.
    pub fn new(n: usize) -> Self {
        LocalError { x: vec![0.0; n], v: vec![0.0; n] }
    }
}

/// What the motion has come to so far: errors are compared with it. Part of a checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// [m] largest displacement of any degree of freedom from where it was at t = 0
    x: f64,
    /// [m/s] largest speed of any degree of freedom
    v: f64,
}

/// The largest error of a step over what a whole run may make, and where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Largest {
    /// [-] error over tolerance; infinite where the error is not a number
    pub ratio: f64,
    /// degree of freedom
    pub dof: usize,
}

impl Motion {
    /// With the state `at`, of a run that began at positions `start`.
    #[must_use]
    pub fn with(self, start: &[f64], at: StateRef<'_>) -> Self {
        let x = at.x.iter().zip(start).fold(self.x, |m, (x, x0)| m.max((x - x0).abs()));
        let v = at.v.iter().fold(self.v, |m, v| m.max(v.abs()));
        Motion { x, v }
    }

    /// The largest error over the tolerance. An error of velocity counts as the error of position it grows to within the time
    /// `largest displacement / largest speed` of this motion, 1/w for an oscillation.
    pub fn largest(self, error: &LocalError, tolerance: Tolerance) -> Largest {
        let Motion { x, v } = self;
        let allowed_x = tolerance.absolute + tolerance.relative * x;
        let per_x = 1.0 / allowed_x;
        let per_v = if v > 0.0 { x / (v * allowed_x) } else { 0.0 };
        let mut found = Largest::default();
        for (dof, (ex, ev)) in error.x.iter().zip(&error.v).enumerate() {
            let ratio = (ex.abs() * per_x).max(ev.abs() * per_v);
            let broken = !(ex.is_finite() && ev.is_finite());
            if broken || ratio > found.ratio {
                found = Largest { ratio: if broken { f64::INFINITY } else { ratio }, dof };
            }
            if broken {
                break;
            }
        }
        found
    }
}

/// Accelerations at the end of the step before the last; part of a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quadrature {
    /// [s] size of the last step; 0 when there is none to look back on
    gap: f64,
    /// [m/s^2] accelerations at its start
    a: Vec<f64>,
}

impl Quadrature {
    /// Whether there is a step to look back on.
    pub fn is_ready(&self) -> bool {
        self.gap > 0.0
    }

    /// Forgets the step before: forces are not smooth across the present time.
    pub fn forget(&mut self) {
        self.gap = 0.0;
    }

    /// After an accepted step of `h` [s] that began at `from`.
    pub fn remember(&mut self, h: f64, from: &Point, inverse_mass: &[f64]) {
        self.gap = h;
        self.a.resize(inverse_mass.len(), 0.0);
        for ((a, f), m) in self.a.iter_mut().zip(&from.forces.total).zip(inverse_mass) {
            *a = m * f;
        }
    }

    /// The local error of a step of `h` [s]; the forces of both points are those at their states.
    pub fn estimate(&self, h: f64, [from, to]: [&Point; 2], inverse_mass: &[f64], error: &mut LocalError) {
        let (n, n1, g) = (&from.state, &to.state, self.gap);
        for (i, m) in inverse_mass.iter().enumerate() {
            let (before, a, after) = (self.a[i], m * from.forces.total[i], m * to.forces.total[i]);
            let second = ((after - a) / h - (a - before) / g) / (h + g);
            error.x[i] = (n1.x[i] - n.x[i] - h * n.v[i]) - h * h / 6.0 * (2.0 * a + after) + h.powi(4) / 12.0 * second;
            error.v[i] = (n1.v[i] - n.v[i]) - 0.5 * h * (a + after) + h.powi(3) / 6.0 * second;
        }
    }
}

/// The error of two half steps, from their difference to the whole one by a scheme of order `order`.
pub fn doubled(order: u32, whole: &Point, halves: &Point, error: &mut LocalError) {
    let part = 1.0 / (2f64.powi(order.min(60) as i32) - 1.0);
    let difference = |e: &mut [f64], whole: &[f64], halves: &[f64]| {
        for ((e, whole), halves) in e.iter_mut().zip(whole).zip(halves) {
            *e = part * (halves - whole);
        }
    };
    difference(&mut error.x, &whole.state.x, &halves.state.x);
    difference(&mut error.v, &whole.state.v, &halves.state.v);
}
