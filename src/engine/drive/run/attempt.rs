//! Attempts at the next accepted state: one step of a fixed size, or adaptive ones until one is kept.

use super::super::adaptive::{AdaptiveStep, AttemptContext, DropReason};
use super::super::clock::Tick;
use super::super::observer::Observer;
use super::super::outcome::Status;
use super::super::step_policy::StepPolicy;
use super::accept::{StepEnd, StepPart};
use super::{Run, RunError};
use crate::integrate::stepper::{Attempt, Stepper};
use crate::integrate::{StepError, StepReport};
use crate::interrupt;

/// How an attempt ended.
enum Attempted {
    /// the step is good so far
    Kept(AdaptiveStep),
    /// it is dropped, and a smaller one can be tried
    Dropped,
    /// the run cannot go on
    Failed(Status),
}

impl Run<'_> {
    /// Advances to the next accepted state, which may take several attempts, unless the run must end before. No step is
    /// ever [taken back](StepEnd::TakenBack) at the end.
    ///
    /// # Errors
    /// When a scheme cannot start again at an event, or an observer cannot write.
    pub fn advance(
        &mut self,
        stepper: &mut Stepper<'_>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<StepEnd, RunError> {
        while let Some(tick) = self.next() {
            if self.stop.asked() || interrupt::asked() {
                return Ok(StepEnd::Stopped);
            }
            let attempted = match &mut self.state.policy {
                StepPolicy::Fixed(_) | StepPolicy::Free(_) => {
                    match self.fixed_step(stepper, tick).and_then(|whole| self.end_at_event(stepper, tick, whole)) {
                        Ok(report) => Attempted::Kept(AdaptiveStep::Single(report)),
                        Err(status) => Attempted::Failed(status),
                    }
                }
                StepPolicy::Adaptive(_) => self.adaptive_step(stepper),
            };
            let end = match attempted {
                Attempted::Kept(kept) => self.accept_parts(stepper, kept, observers)?,
                Attempted::Dropped => StepEnd::TakenBack,
                Attempted::Failed(Status::Interrupted) => StepEnd::Stopped,
                Attempted::Failed(status) => StepEnd::Failed(status),
            };
            if end != StepEnd::TakenBack {
                return Ok(end);
            }
        }
        Ok(StepEnd::Stopped)
    }

    /// Accepts an attempted step, or its halves one after the other.
    fn accept_parts(
        &mut self,
        stepper: &mut Stepper<'_>,
        kept: AdaptiveStep,
        observers: &mut [&mut dyn Observer],
    ) -> Result<StepEnd, RunError> {
        match kept {
            AdaptiveStep::Single(report) => self.accept_step(stepper, StepPart::Last, &report, observers),
            AdaptiveStep::Halves([first, second]) => {
                let end = self.accept_step(stepper, StepPart::First, &first, observers)?;
                if end != StepEnd::Accepted {
                    return Ok(end);
                }
                if let StepPolicy::Adaptive(policy) = &mut self.state.policy
                    && let Some(end) = policy.second()
                {
                    std::mem::swap(&mut self.state.to, end);
                }
                // The first half stays where the second is taken back.
                Ok(match self.accept_step(stepper, StepPart::Last, &second, observers)? {
                    StepEnd::TakenBack => StepEnd::Accepted,
                    end => end,
                })
            }
        }
    }

    /// One attempt at a step.
    ///
    /// # Errors
    /// A step that cannot be solved, with its report; [`Status::Interrupted`] without one.
    pub fn fixed_step(&mut self, stepper: &mut Stepper<'_>, tick: Tick) -> Result<StepReport, Status> {
        stepper.set_near_corner(self.state.near_corner(tick));
        let attempt = Attempt { from: &self.state.from, h: tick.h, t_next: tick.t };
        let report = match stepper.attempt(attempt, &mut self.state.to, &mut self.state.counters) {
            Ok(report) => report,
            Err(_) if interrupt::asked() => return Err(Status::Interrupted),
            Err(error) => {
                self.state.failure = Some(self.context(tick).not_converged(&error, worst_of(&error, stepper)));
                return Err(Status::NotConverged);
            }
        };
        if !report.forces_at_end {
            // The ledger and observers need these forces, but the scheme does not, so they are not counted.
            self.scene.evaluate(self.state.to.state.as_ref(), &mut self.state.to.forces);
            self.state.account_passes += 1;
        }
        Ok(report)
    }

    /// One attempt at an adaptive step.
    fn adaptive_step(&mut self, stepper: &mut Stepper<'_>) -> Attempted {
        let StepPolicy::Adaptive(policy) = &mut self.state.policy else { return Attempted::Dropped };
        let mut context =
            AttemptContext { scene: self.scene, stepper: &mut *stepper, counters: &mut self.state.counters };
        policy.begin(&mut context, &self.state.from, &mut self.state.to);
        let Some(planned) = policy.next(self.state.from.state.t) else { return Attempted::Dropped };
        let saved = self.state.events.waits().then(|| policy.state().clone());
        let mut tried = policy.attempt(context, planned, &self.state.from, &mut self.state.to);
        if let Some(saved) = &saved {
            tried = tried.and_then(|kept| self.end_adaptive_at_event(stepper, planned, saved, kept));
        }
        let StepPolicy::Adaptive(policy) = &mut self.state.policy else { return Attempted::Dropped };
        let dropped = match tried {
            Ok(kept) => match policy.stalls(planned.t) {
                None => return Attempted::Kept(kept),
                Some(gone) => {
                    self.state.failure = Some(self.context(Tick { h: planned.h, t: planned.t }).without_progress(gone));
                    return Attempted::Failed(Status::NotConverged);
                }
            },
            Err(_) if interrupt::asked() => return Attempted::Dropped,
            Err(dropped) => dropped,
        };
        let floor = policy.floor(self.state.from.state.t);
        if policy.next(self.state.from.state.t).is_some_and(|next| next.h >= floor) {
            return Attempted::Dropped;
        }
        let context = self.context(Tick { h: planned.h, t: planned.t });
        self.state.failure = Some(match &dropped {
            DropReason::Error(worst) => context.at_the_floor(*worst, floor),
            DropReason::Unsolved(error) => context.not_converged(error, worst_of(error, stepper)),
        });
        Attempted::Failed(Status::NotConverged)
    }
}

/// The degree of freedom with the largest residual of a step that could not be solved; `None` where it was not tried.
fn worst_of(error: &StepError, stepper: &Stepper<'_>) -> Option<usize> {
    match error {
        StepError::Newton(failure) => Some(stepper.dof_of_unknown(failure.worst())),
        StepError::Passed(passage) => Some(passage.dof),
        _ => None,
    }
}
