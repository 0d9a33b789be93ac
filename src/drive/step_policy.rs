//! The choice of the next step of a run: of fixed size, or of the size that a tolerance allows.

use super::adaptive::{Adaptive, AdaptiveSpec, AdaptiveState, PlannedStep};
use super::clock::{FixedSteps, Step, Tick};
use super::outcome::RunSpec;
use crate::integrate::registry::Family;
use crate::integrate::stepper::Stepper;
use crate::scene::Scene;

/// Steps of one size, or of the size a tolerance allows.
pub(super) enum StepPolicy {
    Fixed(FixedSteps),
    Adaptive(Box<Adaptive>),
}

impl StepPolicy {
    /// Starts at t = 0, or continues from the adaptive steps of an earlier run.
    pub fn of(scene: &dyn Scene, stepper: &Stepper<'_>, spec: RunSpec<'_>, state: Option<AdaptiveState>) -> Self {
        match spec.step {
            Step::Fixed(step) => StepPolicy::Fixed(FixedSteps::new(step, spec.end)),
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
    pub fn next(&self, steps: u64, t: f64) -> Option<Tick> {
        match self {
            StepPolicy::Fixed(clock) => (steps < clock.count()).then(|| clock.tick(steps + 1)),
            StepPolicy::Adaptive(policy) => policy.next(t).map(|PlannedStep { h, t, .. }| Tick { h, t }),
        }
    }

    /// What adaptive steps keep.
    pub fn state(&self) -> Option<&AdaptiveState> {
        match self {
            StepPolicy::Fixed(_) => None,
            StepPolicy::Adaptive(policy) => Some(policy.state()),
        }
    }
}
