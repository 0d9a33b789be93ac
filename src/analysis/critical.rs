//! Critical steps: what one is worth, what to advise where a step is above it, and bounds from one pass over the
//! elements. [`Spectrum`](super::spectrum::Spectrum) finds sharper ones.

use super::limit::critical_step;
use super::operators::{DAMPING, STIFFNESS};
use super::rates::Rates;
use crate::figures::{figures, two_digits};
use crate::integrate::linear_step::Pencil;
use crate::integrate::registry::{Family, MethodChoice};
use crate::model::state::StateRef;
use crate::model::stop::Stop;
use crate::model::system::TermInfo;
use crate::scene::{BoundRoom, Scene};

/// Share of a critical step that is advised: scenes stiffen, and close to its limit a scheme is stable but wrong
/// (velocity Verlet makes the energy of the fastest oscillation swell by 1/(1 - (wh/2)^2), fivefold at 0.9, by a third
/// at 0.5).
const ADVISED: f64 = 0.5;
/// [rad] w h up to which a step is advised for an implicit method that damps nothing
const JUMPS: f64 = 3.0;

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

/// Whether a method has a limit on any oscillator. Kang's filter has none of its own; what acts outside it may set one
/// that is not found here.
pub fn has_limit(method: &MethodChoice) -> bool {
    let some = Rates { frequency: 1.0, ..Rates::default() };
    method.info.family != Family::MatrixFree && critical_step(method, some).is_finite()
}

/// Whether a limit is not known: forces that follow velocities, and loads that turn with the cloth, act outside Kang's
/// filter.
pub fn outside_filter(method: &MethodChoice, scene: &dyn Scene) -> bool {
    let outside = |term: &TermInfo| term.velocity_dependent || term.follower;
    method.info.family == Family::MatrixFree && scene.terms().iter().any(outside)
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

    /// [s] A step to take below a limit that is above 0, two digits: an estimate may lie a few percent above the true
    /// limit, what is proved does not.
    pub fn safe(&self) -> f64 {
        let share = match self.confidence {
            Confidence::Certified { .. } => 0.98,
            Confidence::Estimate | Confidence::NoLimit => 0.9,
        };
        if self.step.is_finite() { two_digits(share * self.step) } else { self.step }
    }
}

/// What to take in place of a step `h` [s] that is above a critical step, or of a method that has no stable step.
/// Whoever finds this fault, before a run, in it or after it, gives this advice.
pub fn remedy(limit: &CriticalStep, h: f64) -> String {
    let implicit = implicit_for(limit.rates, h);
    if limit.step > 0.0 {
        return format!("take a step of {} s or smaller, or {implicit}", figures(ADVISED * limit.step, 2));
    }
    match MethodChoice::with_defaults("velocity-verlet").map(|verlet| critical_step(&verlet, limit.rates)) {
        Ok(verlet) if verlet.is_finite() => {
            let step = figures(ADVISED * verlet, 2);
            format!("take --method velocity-verlet with a step of {step} s or smaller, or {implicit}")
        }
        _ => format!("take {implicit}"),
    }
}

/// A method for which a step `h` [s] is not too long: Newmark's may make energy where a step jumps over motions.
pub fn implicit_for(rates: Rates, h: f64) -> &'static str {
    if h * rates.frequency <= JUMPS { "--method newmark" } else { "--method backward-euler" }
}

/// What an analysis may cost.
#[derive(Clone, Copy, Debug)]
pub struct Effort<'a> {
    /// degrees of freedom up to which a proof may take factorisations
    pub factorise: usize,
    /// degrees of freedom up to which a step is made again and again
    pub step: usize,
    /// [s] estimates above are not made sharper by stepping: of no matter to a run with a step far below
    pub sharpen_below: f64,
    /// looked at between two pieces of work; once it is asked for, what is found is not worth reading
    /// ([`Spectrum::stopped`])
    pub stop: Stop<'a>,
}

impl Effort<'static> {
    /// Fit for a question of its own: seconds on the largest scenes.
    pub const FULL: Self = Effort { factorise: 200_000, step: 20_000, sharpen_below: f64::INFINITY, stop: Stop::NEVER };
    /// Fit for the start of a run: a small part of it.
    pub const START: Self = Effort { factorise: 20_000, step: 6_000, sharpen_below: f64::INFINITY, stop: Stop::NEVER };
}

/// Degrees of freedom below which the spectrum is cheap enough to be asked always.
const LARGE: usize = 20_000;

/// A safe end for a large scene whose step is far below it, from one or two passes over its elements: nothing more is
/// then asked. Proved on symmetric undamped scenes; else the least limit of oscillators with the bounds on both rates.
pub fn plainly_stable(scene: &dyn Scene, at: StateRef<'_>, method: &MethodChoice, step: f64) -> Option<CriticalStep> {
    if scene.n_dof() <= LARGE {
        return None;
    }
    let found = ElementBounds::of(scene, at).critical_step(method);
    (2.0 * step <= found.step && found.step.is_finite()).then_some(found)
}

/// Bounds on the fastest rates of a scene from one or two passes over its elements: what is known of a scene for which
/// more is not affordable.
pub struct ElementBounds {
    /// bounds, and the degrees of freedom they are reached at
    pub rates: Rates,
    /// whether they prove a limit: on symmetric undamped scenes
    proved: bool,
}

impl ElementBounds {
    /// At a state.
    pub fn of(scene: &dyn Scene, at: StateRef<'_>) -> Self {
        let mut room = BoundRoom::default();
        let (square, frequency_dof) = scene.rate_bound(at, STIFFNESS, &mut room);
        let damped = scene.velocity_dependent();
        let (damping, damping_dof) = if damped { scene.rate_bound(at, DAMPING, &mut room) } else { (0.0, 0) };
        let rates = Rates { frequency: square.sqrt(), frequency_dof, damping, damping_dof };
        ElementBounds { rates, proved: !damped && scene.symmetric() }
    }

    /// A safe end: the least limit of oscillators with the bounds on both rates.
    pub fn critical_step(&self, method: &MethodChoice) -> CriticalStep {
        if !has_limit(method) {
            return CriticalStep::none();
        }
        let both = self.rates;
        let alone = [Rates { damping: 0.0, ..both }, Rates { frequency: 0.0, ..both }];
        let least =
            [both, alone[0], alone[1]].map(|rates| critical_step(method, rates)).into_iter().fold(f64::NAN, f64::min);
        let confidence = match self.proved {
            true => Confidence::Certified { at_most: f64::INFINITY },
            false => Confidence::Estimate,
        };
        CriticalStep { step: least, confidence, dof: both.frequency_dof, rates: both }
    }
}

/// [s] The limit of Euler-Cromer were the element bounds on the rates reached: for other methods a measure that falls
/// as their limit does.
pub(crate) fn step_by_bounds(scene: &dyn Scene, at: StateRef<'_>, room: &mut BoundRoom) -> f64 {
    let (k, _) = scene.rate_bound(at, STIFFNESS, room);
    let c = match scene.velocity_dependent() {
        true => scene.rate_bound(at, DAMPING, room).0,
        false => 0.0,
    };
    Pencil::EULER_CROMER.singular_at(k, c)
}
