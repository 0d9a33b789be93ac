//! Critical steps of the methods on a scene that is linearised about a state, including prestress, dashpots, Rayleigh
//! damping and air.
//!
//! Symmetric and undamped: the largest eigenvalue lies between a Rayleigh quotient (Lanczos) and a bound proved by one
//! pass over the elements or a Cholesky factorisation. The behaviour of a scheme on one oscillator then gives its
//! limit.
//!
//! Euler-Cromer, symmetric and damped: an eigenvalue z of a step with mode u satisfies (z - 1)^2 + h c (z - 1) + h^2 k
//! z = 0 with the quotients k = u*Ku, c = u*Cu over u*Mu. So no eigenvalue passes -1 while 4 M - 2 h C - h^2 K is
//! positive definite, which is proved in the same way ([`Pencil`], which a method may provide).
//!
//! All other limits are estimates. A linear step of a Runge-Kutta or multistep scheme is a function of L = [0 I; -M^-1
//! K, -M^-1 C], so the outer eigenvalues of L (Arnoldi) determine the limit; explicit partitioned schemes are stepped.
//! Motion that grows by itself (buckling, flutter) limits no step. A stepped scheme is stable if every growing mode of
//! its step map also grows in the scene.

use super::certificate::Certifier;
use super::critical::{Confidence, CostLimits, CriticalStep, has_limit};
use super::lanczos::{self, Ritz};
use super::modes::{Mode, ModeLimit, Modes};
use super::operators::{DAMPING, Linearised, STIFFNESS};
use super::rates::Rates;
use super::step_map::{LinearScene, Search};
use crate::integrate::linear_step::Pencil;
use crate::integrate::registry::{Family, MethodChoice};
use crate::model::at_dof::AtDof;
use crate::model::state::StateRef;
use crate::model::system::Weights;
use crate::scene::{BoundBuffer, Scene};

/// Margins over the Rayleigh quotient that a proof is tried with.
const MARGINS: [f64; 3] = [0.003, 0.02, 0.08];
/// An element bound this close to the quotient needs no factorisation.
const CLOSE: f64 = 1.003;
/// Without a factorisation an element bound this close is still used.
const USEFUL: f64 = 1.15;
/// Share by which rounding may raise an element bound.
const ROUNDING: f64 = 1e-10;

/// A scene linearised about a state. Finds the limits of methods and stores what several of them need.
pub struct Spectrum<'a> {
    linear: Linearised<'a>,
    effort: CostLimits<'a>,
    damped: bool,
    /// largest eigenvalue of the symmetric part of K [1/s^2] and its mode
    stiffest: Ritz,
    /// largest damping rate [1/s] and its mode
    most_damped: Ritz,
    certifier: Option<Certifier>,
    buffer: BoundBuffer,
    /// [1/s^2] proved upper bound on the eigenvalues of K
    bound: Option<f64>,
    /// outer modes of a damped or non-symmetric scene, computed at the first use
    modes: Option<Modes>,
}

impl<'a> Spectrum<'a> {
    /// Linearises a scene and finds its fastest mode. Takes some tens to hundreds of tangent products and, on symmetric
    /// scenes of up to 200 000 degrees of freedom, up to three factorisations.
    pub fn of(scene: &'a dyn Scene, at: StateRef<'a>) -> Self {
        Self::with(scene, at, CostLimits::FULL)
    }

    /// The same within limits of cost; what cannot be proved within them is an estimate.
    pub fn with(scene: &'a dyn Scene, at: StateRef<'a>, effort: CostLimits<'a>) -> Self {
        let linear = Linearised::of(scene, at, effort.stop);
        let stiffest = largest(&linear, STIFFNESS);
        let most_damped = if scene.velocity_dependent() { largest(&linear, DAMPING) } else { Ritz::default() };
        let damped = scene.velocity_dependent() && most_damped.value != 0.0;
        let (certifier, buffer, bound, modes) = (None, BoundBuffer::default(), None, None);
        let mut spectrum = Spectrum { linear, effort, damped, stiffest, most_damped, certifier, buffer, bound, modes };
        if spectrum.symmetric() {
            spectrum.bound = spectrum.prove(spectrum.stiffest.value);
        }
        spectrum
    }

    /// Whether the search was stopped.
    pub fn stopped(&self) -> bool {
        self.effort.stop.asked()
    }

    fn symmetric(&self) -> bool {
        self.linear.scene.symmetric()
    }

    /// The fastest rates. The frequency is a lower bound (a Rayleigh quotient) on symmetric scenes, else an estimate.
    pub fn rates(&self) -> Rates {
        Rates {
            frequency: self.stiffest.value.max(0.0).sqrt(),
            frequency_dof: self.linear.most_moving_dof(&self.stiffest.vector),
            damping: self.most_damped.value.max(0.0),
            damping_dof: self.linear.most_moving_dof(&self.most_damped.vector),
            scaled_masses: self.linear.scene.added_mass().is_some(),
        }
    }

    /// [rad/s] Proved upper bound on the largest w of a symmetric scene.
    pub fn frequency_bound(&self) -> Option<f64> {
        self.bound.map(f64::sqrt)
    }

    /// The largest stable step of a method.
    pub fn critical_step(&mut self, method: &MethodChoice) -> CriticalStep {
        let (scene, at) = (self.linear.scene, self.linear.at);
        self.of_all_forces(method).with_rest(scene, at, method)
    }

    /// The same of a method that takes all forces in steps of one size.
    fn of_all_forces(&mut self, method: &MethodChoice) -> CriticalStep {
        if !has_limit(method) {
            return CriticalStep::none();
        }
        if self.symmetric() && !self.damped {
            return self.undamped(method);
        }
        let pencil = method.pencil().filter(|_| self.symmetric());
        let proved = pencil.and_then(|pencil| self.definite_below(pencil));
        let mut found = proved.or_else(|| self.estimate(method)).unwrap_or(CriticalStep::none());
        found.rates.scaled_masses = self.linear.scene.added_mass().is_some();
        found
    }

    fn undamped(&self, method: &MethodChoice) -> CriticalStep {
        let rates = self.rates();
        let dof = rates.frequency_dof;
        let limit =
            |square: f64| Mode { frequency: square.max(0.0).sqrt(), damping: 0.0, dof, grows: false }.limit(method);
        let at_most = limit(self.stiffest.value);
        let (step, confidence) = match self.bound {
            Some(bound) => (limit(bound), Confidence::Certified { at_most }),
            None => (at_most, Confidence::Estimate),
        };
        CriticalStep { step, confidence, dof, rates }
    }

    /// A proved bound on the eigenvalues of K, a small margin above the largest Rayleigh quotient.
    fn prove(&mut self, quotient: f64) -> Option<f64> {
        if quotient <= 0.0 {
            return None;
        }
        let bound = self.linear.scene.rate_bound(self.linear.at, STIFFNESS, &mut self.buffer).value;
        let bound = bound * (1.0 + ROUNDING);
        if bound <= CLOSE * quotient {
            return Some(bound);
        }
        let mut candidates = MARGINS.iter().map(|margin| quotient * (1.0 + margin));
        let proved = candidates.find(|&bound| self.definite(Weights { m: bound, c: 0.0, k: -1.0 }));
        proved.or((bound <= USEFUL * quotient).then_some(bound))
    }

    /// Whether m M + c C + k K is proved positive definite within the effort.
    fn definite(&mut self, w: Weights) -> bool {
        let (scene, at) = (self.linear.scene, self.linear.at);
        if self.stopped() {
            return false;
        }
        if self.certifier.is_none() && scene.n_dof() <= self.effort.factorise {
            self.certifier = Certifier::of(scene);
        }
        self.certifier.as_mut().is_some_and(|certifier| certifier.definite(scene, at, w))
    }

    /// The limit of a pencil. Quotients of any vector give an upper bound, so the iteration descends to the limit.
    fn definite_below(&mut self, pencil: Pencil) -> Option<CriticalStep> {
        let (h, shape) = self.definite_at_most(pencil)?;
        let dof = self.linear.most_moving_dof(&shape);
        let rates = Rates { damping_dof: dof, frequency_dof: dof, ..self.linear.quotients(&shape)? };
        let step = MARGINS.iter().map(|margin| h * (1.0 - 0.5 * margin)).find(|&h| {
            let bound = self.linear.scene.rate_bound(self.linear.at, taken(pencil, h), &mut self.buffer).value;
            bound * (1.0 + ROUNDING) < pencil.m || self.definite(pencil.at(h))
        })?;
        Some(CriticalStep { step, confidence: Confidence::Certified { at_most: h }, dof, rates })
    }

    /// [s] A step slightly above the first at which an eigenvalue passes -1, and its mode.
    fn definite_at_most(&self, pencil: Pencil) -> Option<(f64, Vec<f64>)> {
        let (mut h, mut shape) = (f64::INFINITY, Vec::new());
        for vector in [&self.stiffest.vector, &self.most_damped.vector] {
            let at_most = self.singular_at(pencil, vector)?;
            if at_most < h {
                (h, shape) = (at_most, vector.clone());
            }
        }
        if !(h > 0.0 && h.is_finite()) {
            return None;
        }
        for _ in 0..4 {
            let ritz = largest(&self.linear, taken(pencil, h));
            let next = self.singular_at(pencil, &ritz.vector)?;
            if next >= h {
                break;
            }
            let settled = next > h * (1.0 - 1e-4);
            (h, shape) = (next, ritz.vector);
            if settled {
                break;
            }
        }
        Some((h, shape))
    }

    /// [s] The step at which the pencil vanishes for the Rayleigh quotients of a vector.
    fn singular_at(&self, pencil: Pencil, shape: &[f64]) -> Option<f64> {
        let Rates { frequency, damping, .. } = self.linear.quotients(shape)?;
        Some(pencil.singular_at(frequency * frequency, damping))
    }

    /// Rates of the scene's outer modes, which set limits: the stiffest, the most damped, and outer eigenvalues of L.
    pub fn outer_modes(&mut self) -> Vec<Rates> {
        let unit = self.unit();
        let shapes = [&self.stiffest, &self.most_damped];
        self.modes.get_or_insert_with(|| Modes::find(&self.linear, shapes, unit)).rates()
    }

    fn estimate(&mut self, method: &MethodChoice) -> Option<CriticalStep> {
        let unit = self.unit();
        let shapes = [&self.stiffest, &self.most_damped];
        let modes = self.modes.get_or_insert_with(|| Modes::find(&self.linear, shapes, unit));
        let ModeLimit { step, mode } = modes.limit(method)?;
        let mut found = AtDof { value: step, dof: mode.dof };
        let steppable = self.damped && self.linear.scene.n_dof() <= self.effort.step;
        // An implicit scheme would need what it carries at every state.
        let explicit = method.info.family == Family::Explicit;
        // The linearised scene does not know its stiff springs.
        let stepped_alone = method.partitioned() && explicit && method.substeps() == 1.0;
        if stepped_alone && steppable && step < self.effort.sharpen_below && step > 0.0 {
            let most = self.fixed_velocity(method);
            let search = Search { guess: step.min(most.value), unit, stop: self.effort.stop };
            let stepped = LinearScene::of(&self.linear).and_then(|linear| linear.limit(method, search));
            found = stepped.unwrap_or(found);
            if most.value < found.value {
                found = most;
            }
        }
        let AtDof { value: step, dof } = found;
        Some(CriticalStep { step, confidence: Confidence::Estimate, dof, rates: mode.rates() })
    }

    /// [s] Step at which the method keeps a velocity unchanged whatever K is ([`LinearStep::fixed_velocity`]). Beyond
    /// it the velocity grows monotonically, which is hard to tell from motion that grows by itself. Infinite for other
    /// methods.
    ///
    /// [`LinearStep::fixed_velocity`]: crate::integrate::linear_step::LinearStep::fixed_velocity
    fn fixed_velocity(&self, method: &MethodChoice) -> AtDof {
        let damping = self.most_damped.value;
        let fixed = method.info.linear.fixed_velocity.filter(|_| damping > 0.0);
        let step = fixed.map_or(f64::INFINITY, |hc| hc / damping);
        AtDof { value: step, dof: self.linear.most_moving_dof(&self.most_damped.vector) }
    }

    /// [1/s] The scale of rates.
    fn unit(&self) -> f64 {
        let unit = self.stiffest.value.max(0.0).sqrt().max(self.most_damped.value);
        if unit > 0.0 { unit } else { 1.0 }
    }
}

/// The weights that a pencil subtracts from its part in M.
fn taken(pencil: Pencil, h: f64) -> Weights {
    let Weights { c, k, .. } = pencil.at(h);
    Weights { m: 0.0, c: -c, k: -k }
}

fn largest(linear: &Linearised<'_>, w: Weights) -> Ritz {
    let mut p = vec![0.0; linear.root.len()];
    let times = |q: &[f64], y: &mut [f64]| linear.times(w, q, &mut p, y);
    lanczos::largest(linear.start(), linear.stop, times).unwrap_or_default()
}
