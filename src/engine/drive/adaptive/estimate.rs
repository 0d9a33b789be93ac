//! The local error of a step, for any scheme.
//!
//! [`Quadrature`], for orders 1 and 2: the true accelerations a = M^-1 f at the step's ends and at the end of the step
//! before define a parabola. Its integrals have errors of h^4 in v and h^5 in x. So their difference from the scheme's
//! result is the leading term of the local error (the idea of Milne's device: Hairer, Norsett & Wanner 1993, III.1).
//! With g the step before, and d2 the second divided difference of a:
//! ```text
//! e_x = x_{n+1} - x_n - h v_n - h^2/6 (2 a_n + a_{n+1}) + h^4/12 d2
//! e_v = v_{n+1} - v_n - h/2 (a_n + a_{n+1})             + h^3/6  d2
//! d2  = [(a_{n+1} - a_n)/h - (a_n - a_{n-1})/g] / (h + g)
//! ```
//! It costs no force pass. For Newmark's displacement it is the estimate h^2 (beta - 1/6) (a_{n+1} - a_n) of
//! Zienkiewicz & Xie (1991, Earthquake Eng. Struct. Dyn. 20, 871-887) to leading order, but it includes the error of
//! the velocity too, which is as large, and it does not vanish for beta = 1/6.
//!
//! [`embedded`], for schemes with an embedded pair ([`crate::integrate::PairInfo`]); it needs no earlier step. The run
//! continues with the more accurate of the two solutions (local extrapolation). Its error is about C w h times the
//! estimate, with a constant C of the pair and the frequency w of the motion. So the error at the end is proportional
//! to the estimate per step, not per unit of time: error per step with extrapolation (XEPS: Shampine 1977, Math. Comp.
//! 31, 517-536; Hairer, Norsett & Wanner 1993, section II.4).
//!
//! [`doubled`], for higher orders, for forces that lag behind the state, and for first steps: the difference between
//! one step and two half steps, divided by 2^p - 1 (Hairer, Norsett & Wanner 1993, section II.4).

use serde::{Deserialize, Serialize};

use crate::drive::clock::Tolerance;
use crate::integrate::ErrorEstimate;
use crate::integrate::stepper::{Attempt, Stepper};
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
    /// Buffers for `n` degrees of freedom.
    pub fn new(n: usize) -> Self {
        LocalError { x: vec![0.0; n], v: vec![0.0; n] }
    }
}

/// Size of the motion so far, with which errors are compared. Norms are Euclidean, over all degrees of freedom. Part of
/// a checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MotionScale {
    /// [m] largest displacement from the state at t = 0
    x: f64,
    /// [m/s] largest velocity
    v: f64,
    /// [m^2/s^6] squares of the accelerations' first derivative, summed with the largest weights for the newest steps
    slow: f64,
    /// [m^2/s^8] squares of their second derivative, summed in the same way
    fast: f64,
}

/// Rounding errors of a coordinate in an estimate, which is a difference of a few coordinates.
const ROUNDINGS: f64 = 4.0;

/// Factor on the earlier terms of a sum over the last steps, in each step.
const KEPT: f64 = 0.9;

/// Error of a step, and the degree of freedom where it is largest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// [-] error over the allowed error of a whole run; infinite where the error is not a number
    pub ratio: f64,
    /// degree of freedom with the largest error
    pub dof: usize,
}

/// Squares of the first and second derivative of the accelerations in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AccelerationDerivatives {
    slow: f64,
    fast: f64,
}

impl AccelerationDerivatives {
    fn add(&mut self, first: f64, second: f64) {
        self.slow += first * first;
        self.fast += second * second;
    }
}

impl MotionScale {
    /// With the derivatives of one more step.
    #[must_use]
    pub fn with_derivatives(self, derivatives: AccelerationDerivatives) -> Self {
        MotionScale { slow: KEPT * self.slow + derivatives.slow, fast: KEPT * self.fast + derivatives.fast, ..self }
    }

    /// With the state `at` of a run that began at positions `start` `[n_dof]`. For accepted steps only: a diverging
    /// step must not be compared with its own size.
    #[must_use]
    pub fn with_state(self, start: &[f64], at: StateRef<'_>) -> Self {
        let x = at.x.iter().zip(start).map(|(x, x0)| (x - x0).powi(2)).sum::<f64>().sqrt();
        let v = at.v.iter().map(|v| v * v).sum::<f64>().sqrt();
        MotionScale { x: self.x.max(x), v: self.v.max(v), ..self }
    }

    /// [-] w h of the motion to which the error of a step of `h` [s] belongs, at most 1: above 1 an estimate is not
    /// small compared with the motion.
    pub fn phase_increment(&self, h: f64) -> f64 {
        let period = self.period(h);
        if period > 0.0 { h / period } else { 1.0 }
    }

    /// [s] Time in which an error of velocity becomes an error of position: 1/w for an oscillation. For a net it is the
    /// w of its fastest motion, because the error of a step belongs to it. It is at least the step of `h` [s], because
    /// the next step turns a velocity error into h times a position error, also in a scene that has not moved yet.
    fn period(&self, h: f64) -> f64 {
        let whole = if self.v > 0.0 { self.x / self.v } else { 0.0 };
        let bend = (self.slow / self.fast).sqrt();
        if bend.is_finite() { bend.min(whole).max(h) } else { whole.max(h) }
    }

    /// [m] Euclidean norm of the allowed error of a run; `free` is the number of free degrees of freedom.
    pub fn allowed(&self, tolerance: Tolerance, free: f64) -> f64 {
        tolerance.absolute * free.sqrt() + tolerance.relative * self.x
    }

    /// [s] Time in which the whole motion turns an error of velocity into one of position; at least `h` [s].
    pub fn whole_period(&self, h: f64) -> f64 {
        if self.v > 0.0 { (self.x / self.v).max(h) } else { h }
    }

    /// The error of a step of `h` [s] to the state `end` over the tolerance; `free` is the number of free degrees of
    /// freedom. The rounding error of that state is subtracted from the estimate as long as it is below the tolerance.
    /// It does not fall with the step, and per unit of time it would keep short steps short for ever.
    pub fn deviation(
        &self,
        h: f64,
        error: &LocalError,
        end: StateRef<'_>,
        tolerance: Tolerance,
        free: f64,
    ) -> Deviation {
        let (period, allowed) = (self.period(h), self.allowed(tolerance, free));
        let rounding = ROUNDINGS * f64::EPSILON;
        let in_positions = rounding * end.x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let rounding = if in_positions < allowed { rounding } else { 0.0 };
        let (mut sum, mut largest, mut dof) = (0.0, 0.0, 0);
        for (i, ((ex, ev), (x, v))) in error.x.iter().zip(&error.v).zip(end.x.iter().zip(end.v)).enumerate() {
            let (ex, ev) = (above_rounding(*ex, rounding * x.abs()), above_rounding(*ev, rounding * v.abs()));
            let square = ex * ex + (period * ev).powi(2);
            sum += square;
            if square > largest {
                (largest, dof) = (square, i);
            }
        }
        let broken = || error.x.iter().zip(&error.v).position(|(x, v)| !(x.is_finite() && v.is_finite()));
        if !f64::is_finite(sum) {
            return Deviation { ratio: f64::INFINITY, dof: broken().unwrap_or(dof) };
        }
        Deviation { ratio: sum.sqrt() / allowed, dof }
    }
}

/// The part of an estimate that exceeds the rounding error of the estimated number; NaN for NaN.
fn above_rounding(estimate: f64, rounding: f64) -> f64 {
    if estimate.abs() <= rounding { 0.0 } else { estimate.abs() - rounding }
}

/// Accelerations at the end of the step before the last; part of a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quadrature {
    /// [s] size of the last step; 0 when there is none
    gap: f64,
    /// [m/s^2] accelerations at its start; less those at its end if `relative`
    a: Vec<f64>,
    /// whether a program has changed values since. The difference of the accelerations is kept: the parabola is then
    /// that of the motion within the steps, without the jump between them
    relative: bool,
}

impl Quadrature {
    /// Whether a last step is known.
    pub fn is_ready(&self) -> bool {
        self.gap > 0.0
    }

    /// Clears the last step, because forces are not smooth across the present time.
    pub fn forget(&mut self) {
        self.gap = 0.0;
    }

    /// Values have changed: the forces of `at` are still those before. `inverse_mass` `[n_dof]`.
    pub fn keep_over_change(&mut self, at: &Point, inverse_mass: &[f64]) {
        if self.is_ready() && !self.relative {
            for ((a, f), m) in self.a.iter_mut().zip(&at.forces.total).zip(inverse_mass) {
                *a -= m * f;
            }
            self.relative = true;
        }
    }

    /// Stores an accepted step of `h` [s] that began at `from`; `inverse_mass` `[n_dof]`.
    pub fn remember(&mut self, h: f64, from: &Point, inverse_mass: &[f64]) {
        (self.gap, self.relative) = (h, false);
        self.a.resize(inverse_mass.len(), 0.0);
        for ((a, f), m) in self.a.iter_mut().zip(&from.forces.total).zip(inverse_mass) {
            *a = m * f;
        }
    }

    /// The local error of a step of `h` [s]; the forces of both points are those at their states.
    pub fn estimate(
        &self,
        h: f64,
        [from, to]: [&Point; 2],
        inverse_mass: &[f64],
        error: &mut LocalError,
    ) -> AccelerationDerivatives {
        let (n, n1, g) = (&from.state, &to.state, self.gap);
        let mut derivatives = AccelerationDerivatives::default();
        for (i, m) in inverse_mass.iter().enumerate() {
            let (a, after) = (m * from.forces.total[i], m * to.forces.total[i]);
            let before = if self.relative { a + self.a[i] } else { self.a[i] };
            let slope = (after - a) / h;
            let second = (slope - (a - before) / g) / (h + g);
            error.x[i] = (n1.x[i] - n.x[i] - h * n.v[i]) - h * h / 6.0 * (2.0 * a + after) + h.powi(4) / 12.0 * second;
            error.v[i] = (n1.v[i] - n.v[i]) - 0.5 * h * (a + after) + h.powi(3) / 6.0 * second;
            derivatives.add(slope, 2.0 * second);
        }
        derivatives
    }
}

/// The estimate of the scheme's embedded pair for the last attempt, from `attempt.from` to `to`. Its parts in x and v
/// belong to the same oscillations, so they give the time scale, as two derivatives of the acceleration do.
pub fn embedded(
    stepper: &mut Stepper<'_>,
    attempt: Attempt<'_>,
    to: &Point,
    error: &mut LocalError,
) -> AccelerationDerivatives {
    stepper.embedded_error(attempt, to, ErrorEstimate { x: &mut error.x, v: &mut error.v });
    let mut derivatives = AccelerationDerivatives::default();
    for (x, v) in error.x.iter().zip(&error.v) {
        derivatives.add(*x, *v);
    }
    derivatives
}

/// A whole step and its two halves.
pub struct Pair<'a> {
    /// [s] size of the whole step
    pub h: f64,
    /// where it began
    pub from: &'a Point,
    /// end of the first half
    pub middle: &'a Point,
    /// end of the second half
    pub halves: &'a Point,
    /// end of the whole step
    pub whole: &'a Point,
}

/// The error of two half steps by a scheme of order `order`; `inverse_mass` `[n_dof]`.
pub fn doubled(order: u32, pair: &Pair<'_>, inverse_mass: &[f64], error: &mut LocalError) -> AccelerationDerivatives {
    let &Pair { h, from, middle, halves, whole } = pair;
    let part = 1.0 / (2f64.powi(order.min(60) as i32) - 1.0);
    let difference = |e: &mut [f64], whole: &[f64], halves: &[f64]| {
        for ((e, whole), halves) in e.iter_mut().zip(whole).zip(halves) {
            *e = part * (halves - whole);
        }
    };
    difference(&mut error.x, &whole.state.x, &halves.state.x);
    difference(&mut error.v, &whole.state.v, &halves.state.v);
    let mut derivatives = AccelerationDerivatives::default();
    let forces = from.forces.total.iter().zip(&middle.forces.total).zip(&halves.forces.total);
    for (m, ((f0, f1), f2)) in inverse_mass.iter().zip(forces) {
        derivatives.add(m * (f2 - f0) / h, 4.0 * m * (f2 - 2.0 * f1 + f0) / (h * h));
    }
    derivatives
}
