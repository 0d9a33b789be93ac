//! Steps that are attempted first, and then accepted or dropped: for implicit coupling.

use super::{Pending, Simulation, SimulationError, StepInfo};
use crate::drive::{RunError, StepEnd};
use crate::model::stop::Stop;

impl Simulation {
    /// Computes the next step without accepting it: [`Simulation::attempted`] shows its end. For implicit coupling,
    /// where the forces of a step depend on its end.
    ///
    /// # Errors
    /// As [`Simulation::step`], and when an attempted step still waits.
    pub fn attempt(&mut self) -> Result<(), SimulationError> {
        self.attempt_next(None)
    }

    /// The same with a step of `h` [s], which ends earlier where an event of the scene lies within it: for a coupling
    /// whose steps are not those of the case. The end of the run does not limit it.
    ///
    /// # Errors
    /// As [`Simulation::attempt`]; also settings without `free_steps`, and a size that is not above 0, not finite or
    /// lost in the rounding of the time.
    pub fn attempt_with_step(&mut self, h: f64) -> Result<(), SimulationError> {
        if !self.spec.free_steps {
            return Err(SimulationError::NotFree);
        }
        if !(h > 0.0 && h.is_finite() && self.time() + h > self.time()) {
            let needed = "a finite number above 0 that time can hold";
            return Err(RunError::OutOfRange { what: "step [s]", value: h, needed }.into());
        }
        self.attempt_next(Some(h))
    }

    fn attempt_next(&mut self, h: Option<f64>) -> Result<(), SimulationError> {
        self.idle()?;
        if self.tangent.is_some() {
            return Err(SimulationError::Derivatives { why: "steps that may be dropped have none".to_owned() });
        }
        let made = self.at_work(Stop::NEVER, |run, stepper| {
            let Some(tick) = run.next_of(h) else { return Ok(None) };
            if !run.spec.keep_going {
                run.state.failure = None;
            }
            if run.spec.free_steps || run.spec.step.fixed().is_some() {
                return Ok(Some(run.fixed_step(stepper, tick).ok().map(Pending::Fixed)));
            }
            let before = Box::new(run.state.snapshot(stepper));
            Ok(Some(match run.advance(stepper, &mut [])? {
                StepEnd::Failed(_) => None,
                _ => Some(Pending::Adaptive(before)),
            }))
        })?;
        // Without a next step the run has ended; without an attempt the step has failed.
        let attempted = made.ok_or_else(|| SimulationError::Ended { t: self.time() })?;
        self.pending = Some(attempted.ok_or_else(|| self.failed())?);
        Ok(())
    }

    /// Accepts the attempted step.
    ///
    /// # Errors
    /// When there is none, or when its end cannot be right; then it is dropped.
    pub fn accept(&mut self) -> Result<StepInfo, SimulationError> {
        let from = match self.pending.take() {
            None => return Err(SimulationError::Attempt { pending: false }),
            Some(Pending::Adaptive(before)) => before.t,
            Some(Pending::Fixed(report)) => {
                let from = self.time();
                let end = self.at_work(Stop::NEVER, |run, stepper| run.accept_fixed(stepper, &report))?;
                if end != StepEnd::Accepted {
                    return Err(self.failed());
                }
                from
            }
        };
        self.measure_step(from);
        Ok(self.info())
    }

    /// Drops the attempted step: the state is the one before it again.
    ///
    /// # Errors
    /// When there is none.
    pub fn drop_attempt(&mut self) -> Result<(), SimulationError> {
        match self.pending.take() {
            None => Err(SimulationError::Attempt { pending: false }),
            Some(Pending::Fixed(_)) => Ok(()),
            Some(Pending::Adaptive(before)) => self.take_up(*before),
        }
    }

    /// No attempted step waits.
    pub(super) fn idle(&self) -> Result<(), SimulationError> {
        match self.pending {
            None => Ok(()),
            Some(_) => Err(SimulationError::Attempt { pending: true }),
        }
    }
}
