//! What a step of a method is on linear scenes M a = -K x - C v, as far as others ask: [`crate::analysis`] for limits,
//! diagnoses for advice.

use crate::model::system::Weights;

/// What is known of a method's step on linear scenes; `analysis/limit` measures all of it on oscillators.
#[derive(Debug)]
pub struct LinearStep {
    /// whether the method is a partitioned one with these parameters: it advances positions and velocities by different
    /// formulas. Else its step is a function of h L, L = [0 I; -M^-1 K, -M^-1 C], and an eigenvalue of L alone tells
    /// what becomes of its motion
    pub partitioned: fn(&[f64]) -> bool,
    /// whether, with default parameters, every step takes energy from an undamped oscillation, up to w h = 2 at least:
    /// what the step is coarse for dies out without swinging
    pub always_dissipates: bool,
    /// [-] h c at which a step with the damping rate c [1/s] keeps a velocity as it is, whatever K does, for a method
    /// that has such a step
    pub fixed_velocity: Option<f64>,
    /// the matrix that is positive definite in stable steps alone, for a method that has such a one on symmetric scenes
    pub pencil: Option<Pencil>,
}

/// The matrix m M - c h C - k h^2 K. No eigenvalue of the step passes -1 while it is positive definite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pencil {
    /// [-] weight of M
    pub m: f64,
    /// [-] weight of -h C
    pub c: f64,
    /// [-] weight of -h^2 K
    pub k: f64,
}

impl LinearStep {
    /// A method that is a function of h L with all its parameters and may leave an oscillation its energy, or add some.
    pub const PLAIN: LinearStep =
        LinearStep { partitioned: |_| false, always_dissipates: false, fixed_velocity: None, pencil: None };
    /// The same of a partitioned method.
    pub const PARTITIONED: LinearStep = LinearStep { partitioned: |_| true, ..LinearStep::PLAIN };
    /// The same of a method that takes energy in every step.
    pub const DISSIPATIVE: LinearStep = LinearStep { always_dissipates: true, ..LinearStep::PLAIN };
}

impl Pencil {
    /// 4 M - 2 h C - h^2 K.
    pub const EULER_CROMER: Pencil = Pencil { m: 4.0, c: 2.0, k: 1.0 };

    /// Its weights at a step [s].
    pub fn at(self, h: f64) -> Weights {
        Weights { m: self.m, c: -self.c * h, k: -self.k * h * h }
    }

    /// [s] The step at which it is 0 for quotients of K, `k` [1/s^2], and of C, `c` [1/s].
    pub fn singular_at(self, k: f64, c: f64) -> f64 {
        let c = self.c * c;
        2.0 * self.m / (c + (c * c + 4.0 * self.m * self.k * k).sqrt())
    }
}
