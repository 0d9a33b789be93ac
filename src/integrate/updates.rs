//! The vector updates that explicit schemes are made of.

use super::StageWork;
use crate::model::forces::{Forces, Role};
use crate::model::system::System;

/// out = a + h b
pub(super) fn add_scaled(out: &mut [f64], a: &[f64], h: f64, b: &[f64]) {
    for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
        *out = a + h * b;
    }
}

/// out += h b
pub(super) fn accumulate(out: &mut [f64], h: f64, b: &[f64]) {
    for (out, b) in out.iter_mut().zip(b) {
        *out += h * b;
    }
}

/// out = v + h M^-1 f
pub(super) fn kick<S: System + ?Sized>(system: &S, out: &mut [f64], v: &[f64], h: f64, f: &[f64]) {
    for (((out, v), f), inverse_mass) in out.iter_mut().zip(v).zip(f).zip(system.inverse_mass()) {
        *out = v + h * (inverse_mass * f);
    }
}

/// out = M^-1 f
pub(super) fn acceleration<S: System + ?Sized>(system: &S, out: &mut [f64], f: &[f64]) {
    for ((out, f), inverse_mass) in out.iter_mut().zip(f).zip(system.inverse_mass()) {
        *out = inverse_mass * f;
    }
}

/// out += h M^-1 f
pub(super) fn accumulate_kick<S: System + ?Sized>(system: &S, out: &mut [f64], h: f64, f: &[f64]) {
    for ((out, f), inverse_mass) in out.iter_mut().zip(f).zip(system.inverse_mass()) {
        *out += h * (inverse_mass * f);
    }
}

/// [W] external and dissipated power of a force pass.
pub(super) fn power<S: System + ?Sized>(system: &S, forces: &Forces) -> StageWork {
    let mut sum = StageWork::default();
    for (term, tally) in system.terms().iter().zip(&forces.tallies) {
        match term.role {
            Role::External => sum.external += tally.power,
            Role::Dissipative => sum.dissipated -= tally.power,
            Role::Elastic | Role::Gravity => {}
        }
    }
    sum
}

/// sum of weight * power over stages
pub(super) fn weigh<const N: usize>(stages: [(f64, StageWork); N]) -> StageWork {
    let mut sum = StageWork::default();
    for (w, p) in stages {
        sum.add(w, p);
    }
    sum
}

impl StageWork {
    /// += weight * power
    pub(super) fn add(&mut self, weight: f64, power: StageWork) {
        self.external += weight * power.external;
        self.dissipated += weight * power.dissipated;
    }
}
