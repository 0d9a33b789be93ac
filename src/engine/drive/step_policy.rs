//! The choice of the next step of a run: of fixed size, or of the size that a tolerance allows.

use super::adaptive::{Adaptive, AdaptiveSpec, AdaptiveState, PlannedStep};
use super::clock::{EventSteps, FixedSteps, FreeSteps, Step, Tick};
use super::run_spec::RunSpec;
use crate::integrate::registry::Family;
use crate::integrate::stepper::Stepper;
use crate::model::spec::ascending;
use crate::scene::{Scene, event_times, pass_events};

/// Steps of one size, of the size a tolerance allows, or of the sizes a program gives.
pub(super) enum StepPolicy {
    Fixed(EventSteps),
    Adaptive(Box<Adaptive>),
    Free(FreeSteps),
}

impl StepPolicy {
    /// The policy of a run at time `t` [s], and how many events it has passed; the scene is then at that time.
    pub(super) fn at(
        scene: &dyn Scene,
        stepper: &Stepper<'_>,
        spec: &RunSpec,
        state: Option<AdaptiveState>,
        t: f64,
    ) -> (Self, usize) {
        pass_events(scene, 0);
        let mut policy = Self::of(scene, stepper, spec, state);
        let passed = policy.passed(scene, t);
        pass_events(scene, passed);
        if let StepPolicy::Adaptive(adaptive) = &mut policy {
            adaptive.recount(scene);
        }
        (policy, passed)
    }

    /// Starts at t = 0, or continues from the adaptive steps of an earlier run.
    fn of(scene: &dyn Scene, stepper: &Stepper<'_>, spec: &RunSpec, state: Option<AdaptiveState>) -> Self {
        match spec.step {
            step if spec.free_steps => StepPolicy::Free(FreeSteps {
                step: step.fixed().unwrap_or(spec.end),
                end: spec.end,
                events: event_times(scene).to_vec(),
            }),
            Step::Fixed(step) => {
                StepPolicy::Fixed(EventSteps::new(FixedSteps::new(step, spec.end), event_times(scene)))
            }
            Step::Adaptive(tolerance) => {
                // Kang's filter also damps slow motion.
                let coherent = spec.method.info.family == Family::MatrixFree;
                let frames_every = spec.frames_every.filter(|_| stepper.pair().is_some());
                let order = spec.method.order();
                let made = AdaptiveSpec { end: spec.end, frames_every, tolerance, order, coherent };
                StepPolicy::Adaptive(Box::new(match state {
                    Some(state) => Adaptive::restore(scene, made, state),
                    None => Adaptive::new(scene, made),
                }))
            }
        }
    }

    /// The step after `steps` accepted ones, or the next to attempt from `t` [s]; `None` at the end.
    pub(super) fn next(&self, steps: u64, t: f64) -> Option<Tick> {
        match self {
            StepPolicy::Fixed(clock) => (steps < clock.count()).then(|| clock.tick_from(steps + 1, t)),
            StepPolicy::Adaptive(policy) => policy.next(t).map(|PlannedStep { h, t, .. }| Tick { h, t }),
            StepPolicy::Free(steps) => steps.next(t),
        }
    }

    /// [-] How many of a scene's events a run has passed that is at time `t` [s].
    pub(super) fn passed(&self, scene: &dyn Scene, t: f64) -> usize {
        let events = match self {
            StepPolicy::Fixed(clock) => clock.events(),
            StepPolicy::Adaptive(_) | StepPolicy::Free(_) => event_times(scene),
        };
        events.partition_point(|event| event - t <= 4.0 * f64::EPSILON * event)
    }

    /// Ends steps at times [s] of events too, which may be past, and at what began with an event.
    pub(super) fn end_at(&mut self, scene: &dyn Scene, times: impl Iterator<Item = f64>) {
        match self {
            StepPolicy::Fixed(clock) => times.for_each(|t| clock.divide(t)),
            StepPolicy::Adaptive(adaptive) => {
                adaptive.end_at(scene, times);
                adaptive.recount(scene);
            }
            StepPolicy::Free(steps) => {
                steps.events = ascending(times.chain(event_times(scene).iter().copied()).collect());
            }
        }
    }

    /// [s] Differences of times at `t` [s] that count as rounding.
    pub(super) fn slack(&self, t: f64) -> f64 {
        match self {
            StepPolicy::Fixed(clock) => clock.slack(t),
            StepPolicy::Adaptive(_) | StepPolicy::Free(_) => 4.0 * f64::EPSILON * t,
        }
    }

    /// What adaptive steps keep.
    pub(super) fn state(&self) -> Option<&AdaptiveState> {
        match self {
            StepPolicy::Fixed(_) | StepPolicy::Free(_) => None,
            StepPolicy::Adaptive(policy) => Some(policy.state()),
        }
    }
}
