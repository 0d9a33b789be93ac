//! Properties of a method's step on linear scenes M a = -K x - C v, used by [`crate::analysis`] for limits and by
//! diagnoses for advice.

use crate::model::system::Weights;

/// Properties of a method's step on linear scenes; tests in `analysis/limit` measure all of them on oscillators.
#[derive(Debug)]
pub struct LinearStep {
    /// whether the method is partitioned with these parameters: it advances positions and velocities by different
    /// formulas. Otherwise its step is a function of h L, L = [0 I; -M^-1 K, -M^-1 C], and each eigenvalue of L alone
    /// determines its mode
    pub partitioned: fn(&[f64]) -> bool,
    /// whether, with default parameters, every step removes energy from an undamped oscillation, up to w h = 2 at least
    pub always_dissipates: bool,
    /// [-] h c at which a step with the damping rate c [1/s] keeps a velocity unchanged whatever K is, for a method
    /// with such a step
    pub fixed_velocity: Option<f64>,
    /// the matrix that is positive definite only in stable steps of symmetric scenes, for a method with such a matrix;
    /// with substeps, that of a short step
    pub pencil: Option<Pencil>,
    /// [-] short steps of stiff springs in a step: the limit that these set is so many times longer. 1 for a method
    /// that makes one step of everything
    pub substeps: fn(&[f64]) -> f64,
    /// whether steps without a limit are so on linear scenes only: on others the method may make energy
    pub linear_only: bool,
    /// sweeps over all springs or nodes in a step, for a method that solves each of them; else 0
    pub sweeps: fn(&[f64]) -> f64,
    /// whether a matrix-free method solves the dashpots of springs as it does these
    pub solves_dashpots: bool,
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
    /// A method that is a function of h L for all its parameters and may keep or raise the energy of an oscillation.
    pub const PLAIN: LinearStep = LinearStep {
        partitioned: |_| false,
        always_dissipates: false,
        fixed_velocity: None,
        pencil: None,
        substeps: |_| 1.0,
        linear_only: false,
        sweeps: |_| 0.0,
        solves_dashpots: false,
    };
    /// The same for a partitioned method.
    pub const PARTITIONED: LinearStep = LinearStep { partitioned: |_| true, ..LinearStep::PLAIN };
    /// The same for a method that removes energy in every step.
    pub const DISSIPATIVE: LinearStep = LinearStep { always_dissipates: true, ..LinearStep::PLAIN };
}

impl Pencil {
    /// 4 M - 2 h C - h^2 K.
    pub const EULER_CROMER: Pencil = Pencil { m: 4.0, c: 2.0, k: 1.0 };

    /// The same for steps that are made of so many.
    pub(super) fn in_steps(self, substeps: f64) -> Self {
        Pencil { c: self.c / substeps, k: self.k / (substeps * substeps), ..self }
    }

    /// Its weights for a step `h` [s].
    pub fn at(self, h: f64) -> Weights {
        Weights { m: self.m, c: -self.c * h, k: -self.k * h * h }
    }

    /// [s] The step at which it vanishes for the quotients of K, `k` [1/s^2], and of C, `c` [1/s].
    pub fn singular_at(self, k: f64, c: f64) -> f64 {
        let c = self.c * c;
        2.0 * self.m / (c + (c * c + 4.0 * self.m * self.k * k).sqrt())
    }
}
