//! Critical steps of the methods on a scene, linearised about a state: prestress, dashpots, Rayleigh damping and the air included.
//!
//! Symmetric and undamped: the largest root lies between a Rayleigh quotient (Lanczos) and a bound that a Cholesky
//! factorisation proves, a fraction of a percent apart; what a scheme does to one oscillator then gives its limit.
//! Euler-Cromer, symmetric and damped: a root z of a step with shape u meets (z - 1)^2 + h c (z - 1) + h^2 k = 0 with the quotients
//! k = u*Ku, c = u*Cu of M, so no root passes -1 while 4 M - 2 h C - h^2 K is positive definite: proved in the same way.
//! Else estimates. A linear step of a Runge-Kutta or multistep scheme is a function of L = [0 I; -M^-1 K, -M^-1 C], so
//! outer eigenvalues of L (Arnoldi) tell; schemes that treat x and v differently are stepped.
//! Motion that grows by itself (buckling, flutter) limits no step: it must grow.

use super::arnoldi::Krylov;
use super::certificate::Certifier;
use super::lanczos::{self, Ritz};
use super::limit::{critical_step, stable};
use super::linearised::{Linearised, dot};
use super::rates::Rates;
use super::step_map::LinearScene;
use crate::integrate::registry::{Family, MethodChoice};
use crate::model::state::StateRef;
use crate::model::system::Weights;
use crate::scene::Scene;

const STIFFNESS: Weights = Weights { m: 0.0, c: 0.0, k: 1.0 };
const DAMPING: Weights = Weights { m: 0.0, c: 1.0, k: 0.0 };
/// Margins in w^2 (or its like) over the Rayleigh quotient that a proof is tried with.
const MARGINS: [f64; 3] = [0.003, 0.02, 0.08];
/// Eigenvalues of L with a larger residual, in units of the fastest rate, are not used.
const CONVERGED: f64 = 1e-3;
/// Products for the eigenvalues of L.
const PRODUCTS: usize = 80;
/// Growth of a step that is none: beyond the limit a step grows by as much as it is beyond.
const GROWTH: f64 = 1e-3;
/// Relative width at which the search for a step that does not grow ends.
const WIDTH: f64 = 0.01;
/// Steps outwards from a guess.
const OUTWARDS: usize = 20;
/// Degrees of freedom above which stepping the map takes many seconds; the roots of L alone then give the estimate.
const MOST_STEPPED: usize = 20_000;
/// Schemes whose linear step is no function of L.
const SPLIT: [&str; 2] = ["euler-cromer", "velocity-verlet"];

/// How far a critical step can be trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Confidence {
    /// proved: steps up to [`CriticalStep::step`] are stable
    Certified {
        /// [s] steps above are unstable
        at_most: f64,
    },
    /// found by iteration on the linearised step, or on a scene too large for a proof
    Estimate,
    /// the method has no limit on any oscillator
    NoLimit,
}

/// The largest stable step of a method on a scene and what sets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalStep {
    /// [s] the safe end; infinite without limit, 0 where the method grows at every step
    pub step: f64,
    /// what it is worth
    pub confidence: Confidence,
    /// degree of freedom that moves most in the motion that sets it
    pub dof: usize,
    /// the rates of that motion
    pub rates: Rates,
}

/// Whether a method has a limit on any oscillator. Kang's filter has none of its own; what acts outside it may set one that
/// is not found here.
pub fn has_limit(method: &MethodChoice) -> bool {
    let some = Rates { frequency: 1.0, ..Rates::default() };
    method.info.family != Family::MatrixFree && critical_step(method, some).is_finite()
}

impl CriticalStep {
    /// Of a method or a scene without limit.
    pub fn none() -> Self {
        CriticalStep { step: f64::INFINITY, confidence: Confidence::NoLimit, dof: 0, rates: Rates::default() }
    }

    /// [-] width of a certified interval over its upper end; none for an estimate.
    pub fn width(&self) -> Option<f64> {
        match self.confidence {
            Confidence::Certified { at_most } if at_most > 0.0 && at_most.is_finite() => {
                Some(1.0 - self.step / at_most)
            }
            _ => None,
        }
    }
}

/// A motion that may set a limit.
#[derive(Clone, Copy, Debug)]
struct Motion {
    frequency: f64,
    damping: f64,
    dof: usize,
    /// whether the motion itself grows; a scheme that grows with it at every step is not wrong
    grows: bool,
}

impl Motion {
    fn limit(&self, method: &MethodChoice) -> f64 {
        critical_step(method, self.rates())
    }

    fn rates(&self) -> Rates {
        let Motion { frequency, damping, dof, .. } = *self;
        Rates { frequency, frequency_dof: dof, damping, damping_dof: dof }
    }
}

/// A scene linearised about a state; finds limits of methods, and keeps what several of them need.
pub struct Spectrum<'a> {
    linear: Linearised<'a>,
    symmetric: bool,
    damped: bool,
    /// largest root of the symmetric part of K [1/s^2] and its shape
    stiffest: Ritz,
    /// largest damping rate [1/s] and its shape
    most_damped: Ritz,
    certifier: Option<Certifier>,
    /// [1/s^2] proved to lie above all roots of K
    bound: Option<f64>,
    /// outer motions of a damped or non-symmetric scene, when asked for
    motions: Option<Vec<Motion>>,
    /// [1/s] largest real part among their eigenvalues
    growth: f64,
}

impl<'a> Spectrum<'a> {
    /// Linearises a scene and finds its fastest motion; costs some tens to some hundreds of tangent products and, on symmetric
    /// scenes of up to 200 000 degrees of freedom, one to three factorisations.
    pub fn of(scene: &'a dyn Scene, at: StateRef<'a>) -> Self {
        let linear = Linearised::of(scene, at);
        let stiffest = largest(&linear, STIFFNESS);
        let most_damped = if scene.velocity_dependent() { largest(&linear, DAMPING) } else { Ritz::default() };
        let damped = scene.velocity_dependent() && most_damped.value != 0.0;
        let mut spectrum = Spectrum {
            linear,
            symmetric: scene.symmetric(),
            damped,
            stiffest,
            most_damped,
            certifier: None,
            bound: None,
            motions: None,
            growth: 0.0,
        };
        if spectrum.symmetric {
            spectrum.certifier = Certifier::of(scene);
            spectrum.bound = spectrum.prove(spectrum.stiffest.value);
        }
        spectrum
    }

    /// The fastest rates: the frequency is a lower bound (a Rayleigh quotient) on symmetric scenes, an estimate else.
    pub fn rates(&self) -> Rates {
        Rates {
            frequency: self.stiffest.value.max(0.0).sqrt(),
            frequency_dof: self.place(&self.stiffest.vector),
            damping: self.most_damped.value.max(0.0),
            damping_dof: self.place(&self.most_damped.vector),
        }
    }

    /// [rad/s] what the largest w of a symmetric scene is proved to lie below.
    pub fn frequency_bound(&self) -> Option<f64> {
        self.bound.map(f64::sqrt)
    }

    /// The largest stable step of a method.
    pub fn critical_step(&mut self, method: &MethodChoice) -> CriticalStep {
        if !has_limit(method) {
            return CriticalStep::none();
        }
        if self.symmetric && !self.damped {
            return self.undamped(method);
        }
        if self.symmetric
            && method.info.name == "euler-cromer"
            && let Some(found) = self.euler_cromer()
        {
            return found;
        }
        self.estimate(method).unwrap_or(CriticalStep::none())
    }

    fn undamped(&self, method: &MethodChoice) -> CriticalStep {
        let dof = self.place(&self.stiffest.vector);
        let limit =
            |square: f64| Motion { frequency: square.max(0.0).sqrt(), damping: 0.0, dof, grows: false }.limit(method);
        let at_most = limit(self.stiffest.value);
        let (step, confidence) = match self.bound {
            Some(bound) => (limit(bound), Confidence::Certified { at_most }),
            None => (at_most, Confidence::Estimate),
        };
        CriticalStep { step, confidence, dof, rates: self.rates() }
    }

    /// A bound on the roots of K, a small margin above its largest Rayleigh quotient.
    fn prove(&mut self, quotient: f64) -> Option<f64> {
        let (scene, at) = (self.linear.scene, self.linear.at);
        let certifier = self.certifier.as_mut()?;
        let proved = |bound: &f64| certifier.definite(scene, at, Weights { m: *bound, c: 0.0, k: -1.0 });
        if quotient <= 0.0 {
            return None;
        }
        MARGINS.iter().map(|margin| quotient * (1.0 + margin)).find(proved)
    }

    /// 4 M - 2 h C - h^2 K; any quotients (k, c) give a step that is too large, so the iteration comes down to the limit.
    fn euler_cromer(&mut self) -> Option<CriticalStep> {
        let (mut h, mut shape) = (f64::INFINITY, Vec::new());
        for vector in [&self.stiffest.vector, &self.most_damped.vector] {
            let at_most = self.first_step_to_minus_one(vector)?;
            if at_most < h {
                (h, shape) = (at_most, vector.clone());
            }
        }
        if !(h > 0.0 && h.is_finite()) {
            return None;
        }
        for _ in 0..4 {
            let ritz = largest(&self.linear, Weights { m: 0.0, c: 2.0 * h, k: h * h });
            let next = self.first_step_to_minus_one(&ritz.vector)?;
            if next >= h {
                break;
            }
            let settled = next > h * (1.0 - 1e-4);
            (h, shape) = (next, ritz.vector);
            if settled {
                break;
            }
        }
        let (scene, at) = (self.linear.scene, self.linear.at);
        let dof = self.place(&shape);
        let rates = Rates { damping_dof: dof, frequency_dof: dof, ..self.quotients(&shape)? };
        let certifier = self.certifier.as_mut()?;
        let proved = |h: &f64| certifier.definite(scene, at, Weights { m: 4.0, c: -2.0 * h, k: -h * h });
        let step = MARGINS.iter().map(|margin| h * (1.0 - 0.5 * margin)).find(proved)?;
        Some(CriticalStep { step, confidence: Confidence::Certified { at_most: h }, dof, rates })
    }

    /// [s] h with h^2 k + 2 h c = 4 for the Rayleigh quotients of a shape.
    fn first_step_to_minus_one(&self, shape: &[f64]) -> Option<f64> {
        let Rates { frequency, damping, .. } = self.quotients(shape)?;
        Some(4.0 / (damping + (damping * damping + 4.0 * frequency * frequency).sqrt()))
    }

    /// Rayleigh quotients of a shape.
    fn quotients(&self, shape: &[f64]) -> Option<Rates> {
        let (mut p, mut y) = (vec![0.0; shape.len()], vec![0.0; shape.len()]);
        let mut quotient = |w: Weights| {
            self.linear.times(w, shape, &mut p, &mut y);
            dot(shape, &y) / dot(shape, shape)
        };
        let (k, c) = (quotient(STIFFNESS), quotient(DAMPING));
        let rates = Rates { frequency: k.max(0.0).sqrt(), damping: c.max(0.0), ..Rates::default() };
        (k.is_finite() && c.is_finite()).then_some(rates)
    }

    fn estimate(&mut self, method: &MethodChoice) -> Option<CriticalStep> {
        if self.motions.is_none() {
            self.motions = Some(self.find_motions());
        }
        let motions = self.motions.as_deref().unwrap_or_default();
        let mut found: Option<(f64, Motion)> = None;
        for motion in motions {
            // A motion that is stable at the least limit so far sets none; asking that is forty times cheaper than its limit.
            let matters = |(least, _): (f64, Motion)| least > 0.0 && !stable(method, motion.rates(), least);
            if found.is_none_or(matters) {
                let step = motion.limit(method);
                if motion.grows && step == 0.0 {
                    continue;
                }
                if found.is_none_or(|(least, _)| step < least) {
                    found = Some((step, *motion));
                }
            }
        }
        let (mut step, motion) = found?;
        let mut dof = motion.dof;
        if SPLIT.contains(&method.info.name) && self.damped && step.is_finite() && step > 0.0 {
            (step, dof) = self.stepped_limit(method, step).unwrap_or((step, dof));
        }
        Some(CriticalStep { step, confidence: Confidence::Estimate, dof, rates: motion.rates() })
    }

    /// Outer motions: converged eigenvalues of L, and the stiffest and the most damped shape by their own quotients.
    fn find_motions(&mut self) -> Vec<Motion> {
        let mut motions = Vec::new();
        for shape in [&self.stiffest.vector, &self.most_damped.vector] {
            if let Some(Rates { frequency, damping, .. }) = self.quotients(shape).filter(|_| !shape.is_empty()) {
                motions.push(Motion { frequency, damping, dof: self.place(shape), grows: false });
            }
        }
        let unit = self.unit();
        let n = self.linear.root.len();
        let (mut p, mut stiff) = (vec![0.0; n], vec![0.0; n]);
        let start: Vec<f64> = [self.linear.start(), self.linear.start().into_iter().rev().collect()].concat();
        let start: Vec<f64> =
            start.iter().zip(self.linear.root.iter().cycle()).map(|(s, r)| if *r > 0.0 { *s } else { 0.0 }).collect();
        // On (unit q, q') so that both halves have one size.
        let krylov = Krylov::of(start, PRODUCTS, |from, to| {
            let (q, rate) = from.split_at(n);
            let (to_q, to_rate) = to.split_at_mut(n);
            self.linear.times(STIFFNESS, q, &mut p, &mut stiff);
            self.linear.times(DAMPING, rate, &mut p, to_rate);
            for ((to, to_rate), (rate, stiff)) in to_q.iter_mut().zip(to_rate).zip(rate.iter().zip(&stiff)) {
                *to = unit * rate;
                *to_rate = -*to_rate - stiff / unit;
            }
        });
        let Some(krylov) = krylov else { return motions };
        for value in krylov.values.iter().filter(|v| v.residual <= CONVERGED * unit && v.im >= 0.0) {
            self.growth = self.growth.max(value.re);
            let parts = krylov.parts(*value);
            let moves = |i: usize| (parts[i] + parts[n + i]) * self.linear.root[i].powi(2);
            let dof = (0..n).max_by(|&a, &b| moves(a).total_cmp(&moves(b))).unwrap_or(0);
            if value.im > 0.0 {
                motions.push(Motion {
                    frequency: value.re.hypot(value.im),
                    damping: (-2.0 * value.re).max(0.0),
                    dof,
                    grows: value.re > 0.0,
                });
            } else if value.re < 0.0 {
                motions.push(Motion { frequency: 0.0, damping: -value.re, dof, grows: false });
            }
        }
        motions
    }

    /// The largest step whose map does not grow, searched about `guess`.
    fn stepped_limit(&self, method: &MethodChoice, guess: f64) -> Option<(f64, usize)> {
        if self.linear.root.len() > MOST_STEPPED {
            return None;
        }
        let growth = self.natural_growth();
        let unit = self.unit();
        let stepped = LinearScene::of(&self.linear)?;
        let grows = |h: f64| {
            let (radius, dof) = stepped.radius(method, h, unit)?;
            Some((radius > (1.0 + GROWTH) * (h * growth).exp(), dof))
        };
        let (mut stable, mut unstable) = (0.0, guess);
        let (mut up, mut dof) = grows(unstable)?;
        // Outwards from the guess until it lies between a stable and a growing step.
        let mut factor = 0.97;
        for _ in 0..OUTWARDS {
            if up {
                let below = factor * unstable;
                let (yes, at) = grows(below)?;
                if !yes {
                    stable = below;
                    break;
                }
                (unstable, dof) = (below, at);
            } else {
                (stable, unstable) = (unstable, unstable / factor);
                (up, dof) = grows(unstable)?;
                if up {
                    break;
                }
            }
            factor *= 0.9;
            if unstable * growth > 1.0 {
                // The motion grows by itself before a step could show.
                return None;
            }
        }
        if !up || stable == 0.0 {
            return None;
        }
        while unstable - stable > WIDTH * unstable {
            let middle = 0.5 * (stable + unstable);
            let (yes, at) = grows(middle)?;
            if yes { (unstable, dof) = (middle, at) } else { stable = middle }
        }
        Some((stable, dof))
    }

    /// [1/s] how fast the scene itself grows: where compression makes K indefinite, or in the wind.
    fn natural_growth(&self) -> f64 {
        if !self.symmetric {
            return self.growth;
        }
        let softest = largest(&self.linear, Weights { k: -1.0, ..STIFFNESS });
        self.growth.max(softest.value.max(0.0).sqrt())
    }

    /// [1/s] a rate to measure others by.
    fn unit(&self) -> f64 {
        let Rates { frequency, damping, .. } = self.rates();
        let unit = frequency.max(damping);
        if unit > 0.0 { unit } else { 1.0 }
    }

    /// The degree of freedom that moves most.
    fn place(&self, shape: &[f64]) -> usize {
        let moves = |i: usize| (shape[i] * self.linear.root[i]).abs();
        (0..shape.len()).max_by(|&a, &b| moves(a).total_cmp(&moves(b))).unwrap_or(0)
    }
}

fn largest(linear: &Linearised<'_>, w: Weights) -> Ritz {
    let mut p = vec![0.0; linear.root.len()];
    let times = |q: &[f64], y: &mut [f64]| linear.times(w, q, &mut p, y);
    lanczos::largest(linear.start(), times).unwrap_or_default()
}
