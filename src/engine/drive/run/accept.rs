//! What follows after a step was made: it is added to the account, checked by the watch, and shown.

use super::super::clock::Tick;
use super::super::failure::{DivergedState, FailureContext};
use super::super::ledger::LedgerStep;
use super::super::observer::{AcceptedStep, Energies, Observer};
use super::super::outcome::Status;
use super::super::run_spec::RunSpec;
use super::super::step_policy::StepPolicy;
use super::super::watch::{DivergenceKind, WatchReport, WatchedStep, power_of};
use super::{BLOW_UP, Run, RunError};
use crate::integrate::StepReport;
use crate::integrate::stepper::Stepper;

/// Which part of a step is accepted: the whole step or its second half, which the scheme must still accept; or its
/// first half, which the scheme has accepted already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StepPart {
    First,
    Last,
}

/// How a step ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum StepEnd {
    /// the state is the one at its end
    Accepted,
    /// it is not credible, or its error too large: the state is the one before it, and a smaller step can be tried
    TakenBack,
    /// the run was asked to stop in it: the state is the one before it
    Stopped,
    /// the run cannot go on: the state is the one before it
    Failed(Status),
}

impl Run<'_> {
    /// Accepts the step that ended in `to`: adds it to the account, shows it, and swaps the two points.
    pub(super) fn accept_step(
        &mut self,
        stepper: &mut Stepper<'_>,
        part: StepPart,
        report: &StepReport,
        observers: &mut [&mut dyn Observer],
    ) -> Result<StepEnd, RunError> {
        let tick = Tick { h: self.state.to.state.t - self.state.from.state.t, t: self.state.to.state.t };
        let before = (self.state.ledger, self.state.watch);
        let entered = self.state.ledger.step(self.scene, &self.state.from, &self.state.to, report, &self.state.row);
        let row = entered.row;
        let finite = row.is_finite() && self.scene.workers().all_finite(&self.state.to.forces.total);
        let left = !finite || self.has_left(self.scene.extent(self.state.to.state.as_ref()));
        match self.examine(tick, &entered, if left { Some(finite) } else { None }) {
            WatchReport::Calm => {}
            WatchReport::Doubt(gain) => {
                self.state.new_doubt = Some(self.context(tick).doubt(gain));
            }
            WatchReport::Diverged(trouble) => {
                let adaptive = matches!(self.state.policy, StepPolicy::Adaptive(_));
                if let StepPolicy::Adaptive(policy) = &mut self.state.policy
                    && tick.h > 10.0 * policy.floor(self.state.from.state.t)
                {
                    (self.state.ledger, self.state.watch) = before;
                    policy.take_back(tick.h, (part == StepPart::First).then_some(stepper))?;
                    return Ok(StepEnd::TakenBack);
                }
                self.diverged(tick, trouble, row, left);
                if !finite || !self.spec.keep_going || adaptive {
                    (self.state.ledger, self.state.watch) = before;
                    return Ok(StepEnd::Failed(Status::Diverged));
                }
            }
        }
        let credible = self.state.watch.credible(&self.state.to, &row, self.state.steps + 1)
            && self.state.scene_limits.holds(&self.state.from.state, &self.state.to.state, row.kinetic);
        if part == StepPart::Last {
            stepper.accept();
        }
        std::mem::swap(&mut self.state.from, &mut self.state.to);
        self.state.row = row;
        self.state.before_change = None;
        self.state.steps += 1;
        let view = AcceptedStep {
            step: self.state.steps,
            from: self.state.to.state.t,
            t: self.state.from.state.t,
            ledger: row,
            start: Some(&self.state.to),
            end: Some(&self.state.from),
            summary: None,
            newton_iterations: report.newton_iterations,
            residual: report.residual,
            credible,
        };
        let doubt = self.state.new_doubt.take();
        for o in observers.iter_mut() {
            o.accepted(view)?;
            if let Some(doubt) = &doubt {
                o.warned(doubt);
            }
        }
        self.state.doubt = doubt.or(self.state.doubt.take());
        if part == StepPart::Last {
            self.pass_events(stepper, observers)?;
        }
        Ok(StepEnd::Accepted)
    }

    /// Accepts an attempted step of fixed size.
    ///
    /// # Errors
    /// When the scheme cannot start again at an event.
    pub fn accept_fixed(&mut self, stepper: &mut Stepper<'_>, report: &StepReport) -> Result<StepEnd, RunError> {
        self.accept_watched(stepper, report, &mut [])
    }

    /// The same with observers.
    ///
    /// # Errors
    /// As [`Run::accept_fixed`], and when an observer cannot write.
    pub fn accept_watched(
        &mut self,
        stepper: &mut Stepper<'_>,
        report: &StepReport,
        observers: &mut [&mut dyn Observer],
    ) -> Result<StepEnd, RunError> {
        self.accept_step(stepper, StepPart::Last, report, observers)
    }

    /// The watch's report on a step; for a state that has left the scene, `left` says whether it is finite.
    fn examine(&mut self, tick: Tick, entered: &LedgerStep, left: Option<bool>) -> WatchReport {
        let &LedgerStep { row: ref after, by_stages } = entered;
        if left == Some(false) {
            return WatchReport::Diverged(DivergenceKind::NotFinite);
        }
        let (scene, from, to, before) = (self.scene, &self.state.from, &self.state.to, &self.state.row);
        let times = [from.state.t, to.state.t];
        let (step, power) = (self.state.steps + 1, [from, to].map(|at| power_of(scene, times, &at.forces.tallies)));
        let seen =
            self.state.watch.step(WatchedStep { scene, from, to, before, after, by_stages, power, step, h: tick.h });
        match (seen, left) {
            (WatchReport::Calm | WatchReport::Doubt(_), Some(_)) => {
                let share = self.state.watch.gain_share(to, after, step);
                WatchReport::Diverged(DivergenceKind::Spread {
                    times: BLOW_UP,
                    share,
                    error: self.state.ledger.energy_error(step),
                })
            }
            _ => seen,
        }
    }

    fn diverged(&mut self, tick: Tick, trouble: DivergenceKind, after: Energies, left: bool) {
        if self.state.failure.is_none() {
            let diverged = DivergedState {
                trouble,
                to: &self.state.to,
                before: self.state.row,
                after,
                gain: self.state.watch.gain(),
            };
            self.state.failure = Some(self.context(tick).diverged(&diverged));
        }
        if let Some(failure) = self.state.failure.as_mut().filter(|_| left) {
            failure.blow_up_time.get_or_insert(tick.t);
        }
    }

    pub(super) fn context(&self, Tick { h, t }: Tick) -> FailureContext<'_> {
        let &Run { scene, spec: &RunSpec { ref method, end, explain, .. }, stop, interrupt, .. } = self;
        let (from, step, stop) = (&self.state.from, self.state.steps + 1, stop.or(interrupt));
        let gain = self.state.watch.gain();
        FailureContext { scene, method, from, step, h, t, end, gain, explain, stop }
    }
}
