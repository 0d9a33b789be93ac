//! The critical step during a run: a net that stretches, goes taut or meets faster air can become unstable long after
//! the start. Occasional passes over the elements (about a hundredth of the cost of the run) give a measure that falls
//! with the critical step. Only where this measure comes close to the step is the spectrum computed, and only then can
//! there be a warning; early in the run of a large scene, only where it falls below the step.

use crate::analysis::critical::{CostLimits, CriticalStep, measure_of_limit, plainly_stable, remedy, search_outweighs};
use crate::analysis::spectrum::Spectrum;
use crate::analysis::taut::AllTaut;
use crate::analysis::warnings::worth;
use crate::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, Point, UpcomingStep, Wants};
use crate::format_number::figures;
use crate::integrate::registry::MethodChoice;
use crate::model::state::StateRef;
use crate::model::stop::Stop;
use crate::scene::{BoundBuffer, Scene, place_with_groups};
use crate::warning::{Warning, WarningCode};

/// Cost of a pass over the elements, in force passes.
const PASSES: u32 = 5;
/// The same where forces beside stiff springs have bounds of their own, from several passes.
const REST_PASSES: u32 = 40;
/// One over the share of a run that may be spent.
const SHARE: u32 = 100;
/// Growth of the kinetic energy, over its largest value at an estimate, that leads to a new estimate at once or at the
/// end of the block of steps.
const LIVELIER: f64 = 4.0;
/// The spectrum is computed where, by the measure, the critical step is below this many steps.
const NEAR: f64 = 1.05;
/// It is computed again where the measure has fallen below this share since.
const FALLEN: f64 = 0.97;
/// Largest number of spectra computed in a run.
const MOST_ASKED: u32 = 8;

/// What is monitored.
#[derive(Clone, Copy)]
pub struct Monitored<'a> {
    /// the scene
    pub scene: &'a dyn Scene,
    /// the method of the run
    pub method: &'a MethodChoice,
    /// limit at the start, with all springs taut
    pub start: CriticalStep,
    /// [s] nominal step
    pub step: f64,
    /// called once with a warning, when the critical step falls below the step
    pub tell: &'a dyn Fn(Warning),
    /// ends a search for the critical step
    pub stop: Stop<'a>,
}

/// The smallest critical step of a run.
#[derive(Clone, Copy, Debug)]
pub struct LeastStep {
    /// [s] when
    pub t: f64,
    /// [s] the critical step then
    pub step: f64,
}

/// An observer that warns once when the critical step falls below the step, and records nothing.
pub struct CriticalStepMonitor<'a> {
    monitored: Monitored<'a>,
    every: u64,
    /// step after which the next estimate is made
    next: u64,
    /// [J] largest kinetic energy at an estimate
    kinetic: f64,
    /// [J] a kinetic energy since then that requires another estimate; else 0
    livelier: f64,
    buffer: BoundBuffer,
    /// critical step over measure, when both were last computed
    ratio: Option<f64>,
    /// [s] measure below which the spectrum is computed next
    ask_below: f64,
    asked: u32,
    warned: bool,
    least: Option<LeastStep>,
}

impl<'a> CriticalStepMonitor<'a> {
    /// `None` where there is nothing to monitor: a method without a limit, or one without a stable step.
    pub fn of(monitored: Monitored<'a>, limited: bool) -> Option<Self> {
        let Monitored { scene, method, start, step, .. } = monitored;
        if !limited || start.step == 0.0 {
            return None;
        }
        let damped = scene.velocity_dependent();
        // The cost of an implicit step is more than its force passes.
        let [still, moving] = method.info.evaluations;
        let evaluations = if damped { moving } else { still }.max(1);
        let passes = if method.substeps() > 1.0 { REST_PASSES } else { PASSES };
        let every = u64::from((SHARE * passes * (1 + u32::from(damped))).div_ceil(evaluations));
        let mut buffer = BoundBuffer::default();
        // As the limit at the start.
        let all_taut = AllTaut::of(scene);
        let at_start = measure_of_limit(method, scene, scene.initial_state().as_ref(), &mut buffer);
        drop(all_taut);
        let known = start.step.is_finite() && at_start > 0.0 && at_start.is_finite();
        let ratio = known.then(|| start.step / at_start);
        // The user is warned about the start itself before the run.
        let warned = step > start.step;
        Some(CriticalStepMonitor {
            monitored,
            every,
            next: 1,
            kinetic: 0.0,
            livelier: 0.0,
            buffer,
            ratio,
            ask_below: if known { at_start * FALLEN.max(step / start.step) } else { f64::INFINITY },
            asked: 0,
            warned,
            least: None,
        })
    }

    /// [s] The smallest critical step found after the start, if it is clearly below that at the start.
    pub fn least(&self) -> Option<LeastStep> {
        self.least.filter(|least| least.step < FALLEN * self.monitored.start.step)
    }

    /// Called after a step: its end, and its size [s] where the end is known.
    fn stepped(&mut self, step: u64, kinetic: f64, end: Option<(&Point, f64)>) {
        // Chosen by step number, so that a run always does the same work, on any number of threads; at first the
        // number of steps doubles from one to the next, for short runs. A large growth of the kinetic energy may be the
        // beginning of a divergence.
        if kinetic > LIVELIER * self.kinetic {
            self.livelier = self.livelier.max(kinetic);
        }
        if let Some((end, h)) = end.filter(|_| self.livelier > 0.0 || step >= self.next) {
            self.kinetic = self.kinetic.max(kinetic).max(std::mem::take(&mut self.livelier));
            while self.next <= step {
                self.next += self.next.min(self.every);
            }
            self.estimate(end.state.as_ref(), h, step);
        }
    }

    fn estimate(&mut self, at: StateRef<'_>, h: f64, step: u64) {
        let now = measure_of_limit(self.monitored.method, self.monitored.scene, at, &mut self.buffer);
        let estimate = self.ratio.unwrap_or(1.0) * now;
        let Monitored { scene, method, .. } = self.monitored;
        let near = estimate < NEAR * h && !self.warned && now < self.ask_below && self.asked < MOST_ASKED;
        let plain = if near { plainly_stable(scene, at, method, h) } else { None };
        if let Some(bound) = plain {
            // The measure where this bound would come down to the step.
            self.ask_below = now * FALLEN.max(h / bound.step);
        }
        // Where it is only near, a large scene must have made as many steps as the search is worth.
        let due = estimate < h || !search_outweighs(scene, step as f64 / f64::from(1 + self.asked));
        if near && plain.is_none() && due {
            self.asked += 1;
            self.ask_below = FALLEN * now;
            let effort = CostLimits { stop: self.monitored.stop, ..CostLimits::START };
            let mut spectrum = Spectrum::with(scene, at, effort);
            let found = spectrum.critical_step(method);
            if spectrum.stopped() {
                return;
            }
            if found.step.is_finite() && found.step > 0.0 {
                self.ratio = Some(found.step / now);
                self.remember(at.t, found.step);
                if found.step < h {
                    self.warned = true;
                    self.warn(at.t, h, found);
                }
            }
        } else if self.ratio.is_some() {
            self.remember(at.t, estimate);
        }
    }

    fn remember(&mut self, t: f64, step: f64) {
        if self.least.is_none_or(|least| step < least.step) {
            self.least = Some(LeastStep { t, step });
        }
    }

    fn warn(&self, t: f64, h: f64, found: CriticalStep) {
        let Monitored { scene, method, tell, .. } = self.monitored;
        let text = format!(
            "at t = {} s the critical step of {} has fallen to about {} s ({}; set around {}), below the step of {} s; \
             expect it to diverge: {}",
            figures(t, 4),
            method.info.name,
            figures(found.step, 3),
            worth(found),
            place_with_groups(scene, found.dof),
            figures(h, 4),
            remedy(&found, h)
        );
        tell(Warning::new(WarningCode::StepAboveCritical, text));
    }
}

impl Observer for CriticalStepMonitor<'_> {
    fn resumed(&mut self, at: &Point, _ledger: Energies) -> Result<(), ObserveError> {
        self.estimate(at.state.as_ref(), self.monitored.step, 0);
        Ok(())
    }

    /// The state for the next estimate.
    fn wants(&self, step: UpcomingStep) -> Wants {
        Wants::end_if(step.step >= self.next)
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.stepped(step.step, step.ledger.kinetic, step.end.map(|end| (end, step.h())));
        Ok(())
    }
}
