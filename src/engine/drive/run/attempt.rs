//! Attempts at the next accepted state: one step of a fixed size, or adaptive ones until one is kept.

use super::super::adaptive::{AdaptiveStep, AttemptContext, DropReason};
use super::super::clock::Tick;
use super::super::observer::Observer;
use super::super::outcome::Status;
use super::super::step_policy::StepPolicy;
use super::accept::{Accepted, StepPart};
use super::{Run, RunError};
use crate::integrate::stepper::{Attempt, Stepper};
use crate::integrate::{StepError, StepReport};
use crate::interrupt;

impl Run<'_> {
    /// Advances to the next accepted state, which may take several attempts, unless the run must end before.
    pub fn advance(
        &mut self,
        stepper: &mut Stepper<'_>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<Result<(), Status>, RunError> {
        while let Some(tick) = self.next() {
            if self.stop.asked() || interrupt::asked() {
                return Ok(Ok(()));
            }
            let kept = match &mut self.state.policy {
                StepPolicy::Fixed(_) | StepPolicy::Free(_) => self.fixed_step(stepper, tick).map(AdaptiveStep::Single),
                StepPolicy::Adaptive(_) => match self.adaptive_step(stepper) {
                    Ok(Some(kept)) => Ok(kept),
                    Ok(None) => continue,
                    Err(stopped) => Err(stopped),
                },
            };
            return match kept {
                // The loop above ends the run, if it is to.
                Err(Status::Interrupted) => Ok(Ok(())),
                Err(stopped) => Ok(Err(stopped)),
                Ok(AdaptiveStep::Single(report)) => {
                    match self.accept_step(stepper, StepPart::Last, &report, observers)? {
                        Ok(Accepted::Back) => continue,
                        Ok(Accepted::Over) => Ok(Ok(())),
                        Err(stopped) => Ok(Err(stopped)),
                    }
                }
                Ok(AdaptiveStep::Halves([first, second])) => {
                    match self.accept_step(stepper, StepPart::First, &first, observers)? {
                        Ok(Accepted::Back) => continue,
                        Ok(Accepted::Over) => {
                            if let StepPolicy::Adaptive(policy) = &mut self.state.policy
                                && let Some(end) = policy.second()
                            {
                                std::mem::swap(&mut self.state.to, end);
                            }
                            Ok(self.accept_step(stepper, StepPart::Last, &second, observers)?.map(|_| ()))
                        }
                        Err(stopped) => Ok(Err(stopped)),
                    }
                }
            };
        }
        Ok(Ok(()))
    }

    /// One attempt at a step.
    ///
    /// # Errors
    /// A step that cannot be solved, with its report; [`Status::Interrupted`] without one.
    pub fn fixed_step(&mut self, stepper: &mut Stepper<'_>, tick: Tick) -> Result<StepReport, Status> {
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

    /// One attempt; `None` if it is dropped and a smaller step can be tried.
    fn adaptive_step(&mut self, stepper: &mut Stepper<'_>) -> Result<Option<AdaptiveStep>, Status> {
        let StepPolicy::Adaptive(policy) = &mut self.state.policy else { return Ok(None) };
        let mut context =
            AttemptContext { scene: self.scene, stepper: &mut *stepper, counters: &mut self.state.counters };
        policy.begin(&mut context, &self.state.from, &mut self.state.to);
        let Some(planned) = policy.next(self.state.from.state.t) else { return Ok(None) };
        let dropped = match policy.attempt(context, planned, &self.state.from, &mut self.state.to) {
            Ok(kept) => match policy.stalls(planned.t) {
                None => return Ok(Some(kept)),
                Some(gone) => {
                    self.state.failure = Some(self.context(Tick { h: planned.h, t: planned.t }).without_progress(gone));
                    return Err(Status::NotConverged);
                }
            },
            Err(_) if interrupt::asked() => return Ok(None),
            Err(dropped) => dropped,
        };
        let floor = policy.floor(self.state.from.state.t);
        if policy.next(self.state.from.state.t).is_some_and(|next| next.h >= floor) {
            return Ok(None);
        }
        let context = self.context(Tick { h: planned.h, t: planned.t });
        self.state.failure = Some(match &dropped {
            DropReason::Error(worst) => context.at_the_floor(*worst, floor),
            DropReason::Unsolved(error) => context.not_converged(error, worst_of(error, stepper)),
        });
        Err(Status::NotConverged)
    }
}

/// The degree of freedom with the largest residual of a step that could not be solved; `None` where it was not tried.
fn worst_of(error: &StepError, stepper: &Stepper<'_>) -> Option<usize> {
    match error {
        StepError::Newton(failure) => Some(stepper.dof_of_unknown(failure.worst())),
        _ => None,
    }
}
