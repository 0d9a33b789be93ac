//! The three ways to attempt a step and estimate its error.

use super::estimate::{Deviation, Pair, doubled, embedded};
use super::{Adaptive, EstimateInfo, PlannedStep};
use crate::integrate::stepper::{Attempt, Stepper};
use crate::integrate::{CarriedState, Counters, PairInfo, StepError, StepReport};
use crate::model::point::Point;
use crate::scene::Scene;

/// Largest growth of a step: with an error estimate from the steps before it, and from two half steps.
const GROWTH: [f64; 2] = [2.0, 5.0];

/// A step that was accepted.
#[derive(Clone, Copy, Debug)]
pub enum AdaptiveStep {
    /// one step, to the caller's point; what the scheme carries is pending
    Single(StepReport),
    /// two halves: the first to the caller's point, accepted; the second to [`Adaptive::second`], pending
    Halves([StepReport; 2]),
}

/// Why an attempt was dropped.
#[derive(Clone, Debug)]
pub enum DropReason {
    /// the error is too large, or not a number
    Error(Deviation),
    /// a step could not be solved
    Unsolved(StepError),
}

/// What attempts are made with.
pub struct AttemptContext<'a, 's> {
    /// the scene
    pub scene: &'a dyn Scene,
    /// the scheme bound to it
    pub stepper: &'a mut Stepper<'s>,
    /// counts the work
    pub counters: &'a mut Counters,
}

impl AttemptContext<'_, '_> {
    /// One attempt with the forces at its end, which the estimate needs even if the scheme does not.
    fn step(&mut self, from: &Point, t_next: f64, to: &mut Point) -> Result<StepReport, DropReason> {
        let attempt = Attempt { from, h: t_next - from.state.t, t_next };
        let report = self.stepper.attempt(attempt, to, self.counters).map_err(DropReason::Unsolved)?;
        if !report.forces_at_end {
            self.counters.evaluate(self.scene, to.state.as_ref(), &mut to.forces);
        }
        Ok(StepReport { forces_at_end: true, ..report })
    }

    /// Second half of a step, with what the scheme carries before it in `carried`. If `judge` refuses the step, the
    /// first half is taken back too.
    fn second_half(
        &mut self,
        carried: &mut CarriedState,
        middle: &Point,
        t_next: f64,
        end: &mut Point,
        judge: impl FnOnce(&Point, &Point) -> Result<(), DropReason>,
    ) -> Result<StepReport, DropReason> {
        self.stepper.save_into(carried);
        self.stepper.accept();
        match self.step(middle, t_next, end).and_then(|report| judge(middle, end).map(|()| report)) {
            Ok(report) => Ok(report),
            Err(dropped) => {
                self.stepper.restore(carried).map_err(DropReason::Unsolved)?;
                Err(dropped)
            }
        }
    }
}

impl Adaptive {
    /// One step, its error by the parabola through three accelerations.
    pub(super) fn single(
        &mut self,
        context: &mut AttemptContext<'_, '_>,
        planned: PlannedStep,
        from: &Point,
        to: &mut Point,
    ) -> Result<AdaptiveStep, DropReason> {
        let report = context.step(from, planned.t, to)?;
        self.check_branches(context, planned, [from, to])?;
        let inverse_mass = context.scene.inverse_mass();
        let derivatives = self.state.before.estimate(planned.h, [from, to], inverse_mass, &mut self.error);
        for error in [&mut self.error.x, &mut self.error.v] {
            context.stepper.filter_error(error, context.counters).map_err(DropReason::Unsolved)?;
        }
        self.judge(planned, EstimateInfo { derivatives, most_growth: GROWTH[0], pair: None }, to)?;
        self.state.memory.refresh(context.scene, to.state.as_ref(), &self.error.v, &mut self.product);
        self.state.before.remember(planned.h, from, inverse_mass);
        Ok(AdaptiveStep::Single(report))
    }

    /// One step, its error by the scheme's own pair.
    pub(super) fn by_pair(
        &mut self,
        context: &mut AttemptContext<'_, '_>,
        planned: PlannedStep,
        pair: PairInfo,
        from: &Point,
        to: &mut Point,
    ) -> Result<AdaptiveStep, DropReason> {
        let report = context.step(from, planned.t, to)?;
        self.check_branches(context, planned, [from, to])?;
        let attempt = Attempt { from, h: planned.h, t_next: planned.t };
        let derivatives = embedded(context.stepper, attempt, to, &mut self.error);
        self.judge(planned, EstimateInfo { derivatives, most_growth: GROWTH[1], pair: Some(pair) }, to)?;
        self.state.memory.refresh(context.scene, to.state.as_ref(), &self.error.v, &mut self.product);
        Ok(AdaptiveStep::Single(report))
    }

    /// A step and two halves of it, whose difference estimates the error.
    pub(super) fn halves(
        &mut self,
        context: &mut AttemptContext<'_, '_>,
        planned: PlannedStep,
        from: &Point,
        to: &mut Point,
    ) -> Result<AdaptiveStep, DropReason> {
        // Moved out and back, because `judge` needs the rest of `self`.
        let mut pair = self.pair.take().unwrap_or_else(|| Box::new([from.clone(), from.clone()]));
        let mut carried = std::mem::take(&mut self.carried);
        let [whole, second] = &mut *pair;
        let middle = from.state.t + 0.5 * planned.h;
        let whole_step =
            context.step(from, planned.t, whole).and_then(|_| self.check_branches(context, planned, [from, whole]));
        let tried = whole_step.and_then(|()| context.step(from, middle, to)).and_then(|first| {
            let inverse_mass = context.scene.inverse_mass();
            let judge = |middle: &Point, end: &Point| {
                let pair = Pair { h: planned.h, from, middle, halves: end, whole };
                let derivatives = doubled(self.spec.order, &pair, inverse_mass, &mut self.error);
                self.judge(planned, EstimateInfo { derivatives, most_growth: GROWTH[1], pair: None }, end)
            };
            let last = context.second_half(&mut carried, to, planned.t, second, judge)?;
            self.state.memory.refresh(context.scene, second.state.as_ref(), &self.error.v, &mut self.product);
            Ok(AdaptiveStep::Halves([first, last]))
        });
        (self.pair, self.carried) = (Some(pair), carried);
        if tried.is_ok() {
            self.state.before.remember(planned.t - middle, to, context.scene.inverse_mass());
        }
        tried
    }
}
