//! Critical steps: what one is worth, what to advise where a step is above it, and bounds from one pass over the
//! elements. [`Spectrum`](super::spectrum::Spectrum) finds sharper ones.

use super::limit::critical_step;
use super::operators::{DAMPING, STIFFNESS};
use super::rates::Rates;
use crate::format_number::{figures, two_digits};
use crate::integrate::linear_step::Pencil;
use crate::integrate::registry::{Family, MethodChoice};
use crate::model::forces::Role;
use crate::model::state::StateRef;
use crate::model::stop::Stop;
use crate::model::system::TermInfo;
use crate::scene::{BoundBuffer, Scene};

/// [-] Share of a critical step that is advised. Scenes stiffen, and close to its limit a scheme is stable but
/// inaccurate: velocity Verlet inflates the energy of the fastest oscillation by 1/(1 - (wh/2)^2), fivefold at 0.9, by
/// a third at 0.5.
const ADVISED: f64 = 0.5;
/// [rad] Largest w h that is advised for an implicit method without numerical damping.
const JUMPS: f64 = 3.0;

/// How far a critical step can be trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Confidence {
    /// proved: steps up to [`CriticalStep::step`] are stable
    Certified {
        /// [s] steps above are unstable
        at_most: f64,
    },
    /// estimated: by iteration on the linearised step, or on a scene too large for a proof
    Estimate,
    /// the method has no limit on any oscillator
    NoLimit,
}

/// The largest stable step of a method on a scene and what sets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalStep {
    /// [s] lower end of the interval; infinite without limit, 0 if the method is unstable at every step
    pub step: f64,
    /// how far it can be trusted
    pub confidence: Confidence,
    /// degree of freedom that moves most in the mode that sets it
    pub dof: usize,
    /// the rates of that mode
    pub rates: Rates,
}

/// Whether a method has a stability limit on an oscillator. Kang's filter has none; forces outside it may set one that
/// is not found here.
pub fn has_limit(method: &MethodChoice) -> bool {
    let some = Rates { frequency: 1.0, ..Rates::default() };
    method.info.family != Family::MatrixFree && critical_step(method, some).is_finite()
}

/// Whether a limit is unknown: velocity-dependent forces, follower forces, and elastic ones other than those of linear
/// springs act outside Kang's filter, or not as it takes them.
pub fn outside_filter(method: &MethodChoice, scene: &dyn Scene) -> bool {
    let elastic = |term: &TermInfo| term.role == Role::Elastic && !term.linear_springs;
    let outside = |term: &TermInfo| term.velocity_dependent || term.follower || elastic(term);
    method.info.family == Family::MatrixFree && scene.terms().iter().any(outside)
}

impl CriticalStep {
    /// A method or scene without limit.
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

    /// [s] A safe step below a positive limit, two digits. An estimate may lie a few percent above the true limit; a
    /// proved limit does not.
    pub fn safe(&self) -> f64 {
        let share = match self.confidence {
            Confidence::Certified { .. } => 0.98,
            Confidence::Estimate | Confidence::NoLimit => 0.9,
        };
        if self.step.is_finite() { two_digits(share * self.step) } else { self.step }
    }
}

/// The advice for a step `h` [s] above a critical step, or for a method without a stable step. All checks give the same
/// advice, before, during and after a run.
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

/// An implicit method for a step `h` [s]. Newmark's may gain energy if a step is long for the fastest modes.
pub fn implicit_for(rates: Rates, h: f64) -> &'static str {
    if h * rates.frequency <= JUMPS { "--method newmark" } else { "--method backward-euler" }
}

/// Limits on the cost of an analysis.
#[derive(Clone, Copy, Debug)]
pub struct CostLimits<'a> {
    /// degrees of freedom up to which a proof may factorise
    pub factorise: usize,
    /// degrees of freedom up to which the step map is iterated
    pub step: usize,
    /// [s] estimates above this are not refined by stepping: a run with a far smaller step does not need it
    pub sharpen_below: f64,
    /// checked between pieces of work; results after a stop are not valid
    /// ([`Spectrum::stopped`](super::spectrum::Spectrum::stopped))
    pub stop: Stop<'a>,
}

impl CostLimits<'static> {
    /// For a command of its own: seconds on the largest scenes.
    pub const FULL: Self =
        CostLimits { factorise: 200_000, step: 20_000, sharpen_below: f64::INFINITY, stop: Stop::NEVER };
    /// For the start of a run: a small part of its time.
    pub const START: Self =
        CostLimits { factorise: 20_000, step: 6_000, sharpen_below: f64::INFINITY, stop: Stop::NEVER };
}

/// [-] Share of a critical step by bounds up to which a step is taken as stable without a search: on symmetric scenes,
/// and where forces of the air or others are not symmetric.
const PLAIN: [f64; 2] = [0.9, 0.5];

/// A critical step where the step of a run is clearly below it, from one or two passes over the elements: at most as
/// large as the true one on symmetric undamped scenes, which it proves, else the smallest limit of oscillators with the
/// bounds on both rates. `None` if the step is not clearly below.
pub fn plainly_stable(scene: &dyn Scene, at: StateRef<'_>, method: &MethodChoice, step: f64) -> Option<CriticalStep> {
    let found = ElementBounds::of(scene, at).critical_step(method);
    let [symmetric, other] = PLAIN;
    let share = if scene.symmetric() { symmetric } else { other };
    (step <= share * found.step && found.step.is_finite()).then_some(found)
}

/// Bounds on the fastest rates of a scene from one or two passes over its elements, for scenes too large for more.
pub struct ElementBounds {
    /// bounds, and the degrees of freedom where they are reached
    pub rates: Rates,
    /// whether they prove a limit (symmetric undamped scenes)
    proved: bool,
}

impl ElementBounds {
    /// Computes the bounds at a state.
    pub fn of(scene: &dyn Scene, at: StateRef<'_>) -> Self {
        let mut buffer = BoundBuffer::default();
        let (square, frequency_dof) = scene.rate_bound(at, STIFFNESS, &mut buffer);
        let damped = scene.velocity_dependent();
        let (damping, damping_dof) = if damped { scene.rate_bound(at, DAMPING, &mut buffer) } else { (0.0, 0) };
        let rates = Rates { frequency: square.sqrt(), frequency_dof, damping, damping_dof };
        ElementBounds { rates, proved: !damped && scene.symmetric() }
    }

    /// The smallest limit of oscillators with the bounds on both rates.
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

/// [s] The limit of Euler-Cromer if the element bounds on the rates were reached. The limits of other methods scale
/// with it.
pub(crate) fn step_by_bounds(scene: &dyn Scene, at: StateRef<'_>, buffer: &mut BoundBuffer) -> f64 {
    let (k, _) = scene.rate_bound(at, STIFFNESS, buffer);
    let c = match scene.velocity_dependent() {
        true => scene.rate_bound(at, DAMPING, buffer).0,
        false => 0.0,
    };
    Pencil::EULER_CROMER.singular_at(k, c)
}
