//! Critical steps: what one is worth, what to advise where a step is above it, and bounds from one pass over the
//! elements. [`Spectrum`](super::spectrum::Spectrum) finds sharper ones.

pub use super::limit::has_limit;
use super::limit::{critical_step, stable};
use super::operators::{DAMPING, STIFFNESS};
use super::rates::Rates;
use crate::format_number::{figures, two_digits};
use crate::integrate::linear_step::Pencil;
use crate::integrate::registry::{Family, MethodChoice};
use crate::model::at_dof::AtDof;
use crate::model::forces::Role;
use crate::model::state::StateRef;
use crate::model::stop::Stop;
use crate::model::system::BesideStiff;
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

/// Whether a limit is unknown: velocity-dependent forces, follower forces, and elastic ones other than those of linear
/// springs act beside what a matrix-free method solves, or not as it takes them.
pub fn outside_filter(method: &MethodChoice, scene: &dyn Scene) -> bool {
    let elastic = |term: &TermInfo| term.role == Role::Elastic && !term.linear_springs;
    let solved = |term: &TermInfo| term.spring_dashpots && method.info.linear.solves_dashpots;
    let outside = |term: &TermInfo| term.velocity_dependent && !solved(term) || term.follower || elastic(term);
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
            format!("take time.method=velocity-verlet with a step of {step} s or smaller, or {implicit}")
        }
        _ => format!("take {implicit}"),
    }
}

/// An implicit method for a step `h` [s]. Newmark's may gain energy if a step is long for the fastest modes, as it is
/// for those that scaled masses make slower.
pub fn implicit_for(rates: Rates, h: f64) -> &'static str {
    if rates.scaled_masses {
        return "time.method=backward-euler without time.mass_scaling";
    }
    if h * rates.frequency <= JUMPS { "time.method=newmark" } else { "time.method=backward-euler" }
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

/// [-] Long steps, over the limit of a short one, where other elastic forces act on the nodes of stiff springs. From
/// pi/2 on a long step is half a period of the fastest of these, whose motion such forces then raise.
const BEFORE_RESONANCE: f64 = 1.5;

/// [-] Share of a critical step by bounds up to which a step is taken as stable without a search: where every mode of a
/// symmetric scene has a limit of its own, where damping may couple modes in a step, and where forces of the air or
/// others are not symmetric.
const PLAIN: [f64; 3] = [1.0, 0.95, 0.5];

/// A search for the limit takes about as long as this many steps, on a scene too large for a proof.
const SEARCH: f64 = 1000.0;

/// Whether a scene is so large that a search for the limit takes longer than `steps` of it.
pub fn search_outweighs(scene: &dyn Scene, steps: f64) -> bool {
    scene.n_dof() > CostLimits::START.factorise && steps < SEARCH
}

/// The critical step by bounds, if a step is not above it: for runs that a search would outweigh.
pub fn below_bounds(scene: &dyn Scene, at: StateRef<'_>, method: &MethodChoice, step: f64) -> Option<CriticalStep> {
    Some(ElementBounds::of(scene, at).critical_step(method))
        .filter(|found| step <= found.step && found.step.is_finite())
}

/// A critical step where the step of a run is below it beyond doubt, from some passes over the elements
/// ([`ElementBounds`]). `None` if there is doubt.
pub fn plainly_stable(scene: &dyn Scene, at: StateRef<'_>, method: &MethodChoice, step: f64) -> Option<CriticalStep> {
    let bounds = ElementBounds::of(scene, at);
    let found = bounds.critical_step(method);
    let [by_modes, coupled, other] = PLAIN;
    let share = match (bounds.symmetric, bounds.by_modes(method)) {
        (true, true) => by_modes,
        (true, false) => coupled,
        (false, _) => other,
    };
    (step <= share * found.step && found.step.is_finite()).then_some(found)
}

/// [-] Shares of the bound on one rate, with the bound on the other, at which the limit of a method is looked at: more
/// damping may mean a larger limit.
const BETWEEN: [f64; 4] = [0.0, 0.25, 0.5, 0.75];

/// Bounds on the fastest rates of a scene from some passes over its elements: at most 8 each on K and C.
pub struct ElementBounds<'a> {
    scene: &'a dyn Scene,
    at: StateRef<'a>,
    /// bounds, and the degrees of freedom where they are reached
    pub rates: Rates,
    damped: bool,
    symmetric: bool,
}

impl<'a> ElementBounds<'a> {
    /// Computes the bounds at a state.
    pub fn of(scene: &'a dyn Scene, at: StateRef<'a>) -> Self {
        let damped = scene.velocity_dependent();
        let of_damping = || if damped { scene.sharper_rate_bound(at, DAMPING) } else { AtDof::default() };
        let (stiffness, damping) = scene.workers().join(|| scene.sharper_rate_bound(at, STIFFNESS), of_damping);
        let rates = Rates::of_bounds(stiffness, damping, scene.added_mass().is_some());
        ElementBounds { scene, at, rates, damped, symmetric: scene.symmetric() }
    }

    /// Whether every mode has the limit of an oscillator with its own quotients of K and C, if the scene is symmetric:
    /// the step is a function of h L, or has a pencil ([`super::spectrum`]).
    fn by_modes(&self, method: &MethodChoice) -> bool {
        !self.damped || !method.partitioned() || method.info.linear.pencil.is_some()
    }

    /// The smallest limit of oscillators with rates up to the bounds. On a symmetric scene it is at most as large as
    /// the true one where every mode has a limit of its own; without damping that is proved. Velocity Verlet's damped
    /// modes have no limits of their own. But no step below this limit was unstable for 3,000 pairs of random matrices
    /// K and C.
    pub fn critical_step(&self, method: &MethodChoice) -> CriticalStep {
        if !has_limit(method) {
            return CriticalStep::none();
        }
        let both = self.rates;
        let lower = |share: f64| {
            [Rates { damping: share * both.damping, ..both }, Rates { frequency: share * both.frequency, ..both }]
        };
        let shares = if self.symmetric { &BETWEEN[..] } else { &BETWEEN[..1] };
        let mut least = critical_step(method, both);
        for rates in shares.iter().flat_map(|share| lower(*share)) {
            // Much cheaper than the limit.
            if !stable(method, rates, least) {
                least = least.min(critical_step(method, rates));
            }
        }
        let confidence = match self.symmetric && !self.damped {
            true => Confidence::Certified { at_most: f64::INFINITY },
            false => Confidence::Estimate,
        };
        let found = CriticalStep { step: least, confidence, dof: both.frequency_dof, rates: both };
        found.with_rest(self.scene, self.at, method)
    }
}

impl CriticalStep {
    /// The same for a method that makes short steps of stiff springs: at most the step that all other forces allow, by
    /// the bounds of their elements, and short of resonance where these act on the same nodes. An estimate.
    pub(super) fn with_rest(self, scene: &dyn Scene, at: StateRef<'_>, method: &MethodChoice) -> Self {
        let substeps = method.substeps();
        if substeps == 1.0 {
            return self;
        }
        let of_short_step = self.step / substeps;
        let beside = scene.stiff().and_then(|stiff| stiff.beside_stiff(substeps, at));
        let Some(BesideStiff { stiffness, damping, on_short_nodes }) = beside else {
            return CriticalStep { step: of_short_step, confidence: Confidence::Estimate, ..self };
        };
        let most = if on_short_nodes { self.step.min(BEFORE_RESONANCE * of_short_step) } else { self.step };
        let capped = CriticalStep { step: most, confidence: Confidence::Estimate, ..self };
        let rates = Rates::of_bounds(stiffness, damping, self.rates.scaled_masses);
        match rest_step([stiffness.value, damping.value]) {
            step if step > most => capped,
            step if step > 0.0 => CriticalStep { step, dof: stiffness.dof, rates, ..capped },
            // Numbers overflow, or a bound is none.
            _ => CriticalStep { step: of_short_step, ..capped },
        }
    }
}

/// [s] The limit of central differences with the bounds on K [1/s^2] and C [1/s] of forces beside stiff springs.
fn rest_step([k, c]: [f64; 2]) -> f64 {
    Pencil::EULER_CROMER.singular_at(k, c)
}

/// [s] A measure of the limit of a method: what grows and falls with it as the scene changes.
pub(crate) fn measure_of_limit(
    method: &MethodChoice,
    scene: &dyn Scene,
    at: StateRef<'_>,
    buffer: &mut BoundBuffer,
) -> f64 {
    let (all, substeps) = (step_by_bounds(scene, at, buffer), method.substeps());
    let rest = scene.stiff().filter(|_| substeps > 1.0).and_then(|stiff| stiff.beside_stiff(substeps, at));
    rest.map_or(all, |rest| (substeps * all).min(rest_step([rest.stiffness.value, rest.damping.value])))
}

/// [s] The limit of Euler-Cromer if the element bounds on the rates were reached. The limits of other methods scale
/// with it.
pub fn step_by_bounds(scene: &dyn Scene, at: StateRef<'_>, buffer: &mut BoundBuffer) -> f64 {
    let k = scene.rate_bound(at, STIFFNESS, buffer).value;
    let c = match scene.velocity_dependent() {
        true => scene.rate_bound(at, DAMPING, buffer).value,
        false => 0.0,
    };
    Pencil::EULER_CROMER.singular_at(k, c)
}
