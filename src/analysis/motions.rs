//! The outer motions of a damped or non-symmetric scene: converged eigenvalues of L = [0 I; -M^-1 K, -M^-1 C] by
//! Arnoldi's iteration, as oscillators whose limits a method can be asked for.

use super::arnoldi::{Krylov, place};
use super::critical::{DAMPING, STIFFNESS};
use super::lanczos::Ritz;
use super::limit::{critical_step, stable};
use super::linearised::Linearised;
use super::rates::Rates;
use crate::integrate::registry::MethodChoice;

/// [-] Eigenvalues of L with a larger residual, over the fastest rate, are not used.
const CONVERGED: f64 = 1e-3;
/// [products] with L for its eigenvalues.
pub(super) const PRODUCTS: usize = 80;

/// A motion that may set a limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    /// [rad/s] undamped frequency
    pub frequency: f64,
    /// [1/s] damping rate: twice that at which its amplitude decays, where it swings
    pub damping: f64,
    /// degree of freedom that moves most
    pub dof: usize,
    /// whether the motion itself grows; a scheme that grows with it at every step is not wrong
    pub grows: bool,
}

impl Motion {
    /// [s] the largest stable step of a method on this motion
    pub fn limit(&self, method: &MethodChoice) -> f64 {
        critical_step(method, self.rates())
    }

    pub fn rates(&self) -> Rates {
        let Motion { frequency, damping, dof, .. } = *self;
        Rates { frequency, frequency_dof: dof, damping, damping_dof: dof }
    }
}

/// What was found of a scene.
pub(super) struct Motions {
    list: Vec<Motion>,
}

impl Motions {
    /// Adds to the stiffest and the most damped shape by their own quotients. `unit` [1/s] is a rate to measure others
    /// by.
    pub fn find(linear: &Linearised<'_>, shapes: [&Ritz; 2], unit: f64) -> Self {
        let mut list = Vec::new();
        for shape in shapes.map(|ritz| &ritz.vector).into_iter().filter(|shape| !shape.is_empty()) {
            if let Some(Rates { frequency, damping, .. }) = linear.quotients(shape) {
                list.push(Motion { frequency, damping, dof: linear.place(shape), grows: false });
            }
        }
        let mut motions = Motions { list };
        if let Some(krylov) = krylov(linear, unit) {
            motions.take(&krylov, &linear.root, unit);
        }
        motions
    }

    fn take(&mut self, krylov: &Krylov, root: &[f64], unit: f64) {
        for value in &krylov.values {
            let ritz = krylov.ritz(*value);
            if ritz.residual > CONVERGED * unit {
                continue;
            }
            let dof = place(&krylov.vector(&ritz), root);
            if value.im > 0.0 {
                let (frequency, damping) = (value.re.hypot(value.im), (-2.0 * value.re).max(0.0));
                self.list.push(Motion { frequency, damping, dof, grows: value.re > 0.0 });
            } else if value.re < 0.0 {
                self.list.push(Motion { frequency: 0.0, damping: -value.re, dof, grows: false });
            }
        }
    }

    /// Rates of all motions that do not grow by themselves.
    pub fn rates(&self) -> Vec<Rates> {
        self.list.iter().filter(|motion| !motion.grows).map(Motion::rates).collect()
    }

    /// The least limit of a method and the motion that sets it.
    pub fn limit(&self, method: &MethodChoice) -> Option<(f64, Motion)> {
        let mut found: Option<(f64, Motion)> = None;
        for motion in &self.list {
            // A motion that is stable at the least limit so far sets none; asking that is forty times cheaper than its
            // limit.
            let matters = |(least, _): (f64, Motion)| least > 0.0 && !stable(method, motion.rates(), least);
            if found.is_none_or(matters) {
                let step = motion.limit(method);
                if !(motion.grows && step == 0.0) && found.is_none_or(|(least, _)| step < least) {
                    found = Some((step, *motion));
                }
            }
        }
        found
    }
}

/// On (unit q, q'), so that both halves have one size.
fn krylov(linear: &Linearised<'_>, unit: f64) -> Option<Krylov> {
    let n = linear.root.len();
    let (mut p, mut stiff) = (vec![0.0; n], vec![0.0; n]);
    let start = [linear.start(), linear.start().into_iter().rev().collect()].concat();
    let held = linear.root.iter().cycle().map(|root| f64::from(u8::from(*root > 0.0)));
    let start: Vec<f64> = start.iter().zip(held).map(|(start, free)| start * free).collect();
    Krylov::of(start, PRODUCTS, linear.stop, |from, to| {
        let (q, rate) = from.split_at(n);
        let (to_q, to_rate) = to.split_at_mut(n);
        linear.times(STIFFNESS, q, &mut p, &mut stiff);
        linear.times(DAMPING, rate, &mut p, to_rate);
        for ((to, to_rate), (rate, stiff)) in to_q.iter_mut().zip(to_rate).zip(rate.iter().zip(&stiff)) {
            *to = unit * rate;
            *to_rate = -*to_rate - stiff / unit;
        }
    })
}
