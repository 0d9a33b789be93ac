//! The critical step while a run goes on: a net that stretches, goes taut or meets faster air can lose its
//! stability long after the start. One pass over the elements now and then (about a hundredth of the run) gives a
//! measure that falls as the critical step does; only where that comes close to the step is the spectrum itself asked,
//! and only then is anything said.

use crate::analysis::critical::step_by_bounds;
use crate::analysis::critical::{CostLimits, CriticalStep, remedy};
use crate::analysis::spectrum::Spectrum;
use crate::analysis::warnings::worth;
use crate::drive::observer::{AcceptedStep, LedgerRow, ObserveError, Observer, Point, UpcomingStep, Wants};
use crate::format_number::figures;
use crate::integrate::registry::MethodChoice;
use crate::model::state::StateRef;
use crate::model::stop::Stop;
use crate::scene::{BoundBuffer, Scene, place_of};
use crate::warning::WarningCode;

/// Force passes that a pass over the elements is worth.
const PASSES: u32 = 5;
/// Share of a run, one over this, that is spent.
const SHARE: u32 = 100;
/// At first a look follows the last after one part in so many of the steps made.
const EARLY: u64 = 4;
/// Growth of the kinetic energy since the liveliest look at which is looked at once, or at the end of the block in
/// which it grows so.
const LIVELIER: f64 = 4.0;
/// The spectrum is asked where the measure says that the critical step is below so many steps.
const NEAR: f64 = 1.05;
/// It is asked again where the measure has fallen below this share since.
const FALLEN: f64 = 0.97;
/// Most questions to the spectrum in a run.
const MOST_ASKED: u32 = 8;

/// What is monitored.
#[derive(Clone, Copy)]
pub struct Monitored<'a> {
    /// the scene
    pub scene: &'a dyn Scene,
    /// the method of the run
    pub method: &'a MethodChoice,
    /// limit at the start
    pub start: CriticalStep,
    /// [s] nominal step
    pub step: f64,
    /// reported once, when the critical step falls below the step
    pub tell: &'a dyn Fn(&str),
    /// ends a search for the critical step
    pub stop: Stop<'a>,
}

/// The least critical step a run has met.
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
    /// step after which is looked next
    next: u64,
    /// [J] largest kinetic energy at a look
    kinetic: f64,
    /// [J] one since that asks for another; else 0
    livelier: f64,
    room: BoundBuffer,
    /// critical step over measure, where both were last known
    ratio: Option<f64>,
    /// [s] measure at which the spectrum is asked next
    ask_below: f64,
    asked: u32,
    warned: bool,
    least: Option<LeastStep>,
}

impl<'a> CriticalStepMonitor<'a> {
    /// `None` where there is nothing to follow: a method without limit, or one that grows at every step anyway.
    pub fn of(monitored: Monitored<'a>, limited: bool) -> Option<Self> {
        let Monitored { scene, method, start, step, .. } = monitored;
        if !limited || start.step == 0.0 {
            return None;
        }
        let damped = scene.velocity_dependent();
        // An implicit step is dearer than any number of force passes that are expected of it.
        let [still, moving] = method.info.evaluations;
        let evaluations = if damped { moving } else { still }.max(1);
        let every = u64::from((SHARE * PASSES * (1 + u32::from(damped))).div_ceil(evaluations));
        let mut room = BoundBuffer::default();
        let at_start = step_by_bounds(scene, scene.initial_state().as_ref(), &mut room);
        let known = start.step.is_finite() && at_start > 0.0 && at_start.is_finite();
        let ratio = known.then(|| start.step / at_start);
        // The start itself is spoken of before the run.
        let warned = step > start.step;
        Some(CriticalStepMonitor {
            monitored,
            every,
            next: 1,
            kinetic: 0.0,
            livelier: 0.0,
            room,
            ratio,
            ask_below: f64::INFINITY,
            asked: 0,
            warned,
            least: None,
        })
    }

    /// [s] the least critical step seen after the start, where it is clearly below that at the start.
    pub fn least(&self) -> Option<LeastStep> {
        self.least.filter(|least| least.step < FALLEN * self.monitored.start.step)
    }

    /// After a step, with its end and its size [s] where the end can be seen.
    fn stepped(&mut self, step: u64, kinetic: f64, end: Option<(&Point, f64)>) {
        // By number, so that a run does the same work each time, on any number of threads; closer together early on,
        // for short runs. A motion that has become much livelier may be one that has begun to diverge.
        if kinetic > LIVELIER * self.kinetic {
            self.livelier = self.livelier.max(kinetic);
        }
        if let Some((end, h)) = end.filter(|_| self.livelier > 0.0 || step >= self.next) {
            self.kinetic = self.kinetic.max(kinetic).max(std::mem::take(&mut self.livelier));
            while self.next <= step {
                self.next += (self.next / EARLY).clamp(1, self.every);
            }
            self.estimate(end.state.as_ref(), h);
        }
    }

    fn estimate(&mut self, at: StateRef<'_>, h: f64) {
        let now = step_by_bounds(self.monitored.scene, at, &mut self.room);
        let estimate = self.ratio.unwrap_or(1.0) * now;
        if estimate < NEAR * h && !self.warned && now < self.ask_below && self.asked < MOST_ASKED {
            self.asked += 1;
            self.ask_below = FALLEN * now;
            let effort = CostLimits { stop: self.monitored.stop, ..CostLimits::START };
            let mut spectrum = Spectrum::with(self.monitored.scene, at, effort);
            let found = spectrum.critical_step(self.monitored.method);
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
        tell(&format!(
            "at t = {} s the critical step of {} has fallen to about {} s ({}; set around {}), below the step of {} s; \
             expect it to diverge: {} [{}]",
            figures(t, 4),
            method.info.name,
            figures(found.step, 3),
            worth(found),
            place_of(scene, found.dof),
            figures(h, 4),
            remedy(&found, h),
            WarningCode::StepAboveCritical
        ));
    }
}

impl Observer for CriticalStepMonitor<'_> {
    fn resumed(&mut self, at: &Point, _ledger: LedgerRow) -> Result<(), ObserveError> {
        self.estimate(at.state.as_ref(), self.monitored.step);
        Ok(())
    }

    /// The state of the next look.
    fn wants(&self, step: UpcomingStep) -> Wants {
        Wants::end_if(step.step >= self.next)
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.stepped(step.step, step.ledger.kinetic, step.end.map(|end| (end, step.h())));
        Ok(())
    }
}
