//! All that a run needs to continue from a step as if it had never stopped.

use super::adaptive::AdaptiveState;
use super::clock::{EventSteps, FixedSteps, JoinedAt, Step};
use super::error::RunError;
use super::event::{EventWatch, Fired};
use super::failure::Failure;
use super::ledger::Ledger;
use super::observer::Energies;
use super::run_spec::RunSpec;
use super::watch::EnergyAccount;
use crate::integrate::stepper::Stepper;
use crate::integrate::{CarriedState, Counters};
use crate::model::forces::Forces;
use crate::model::point::Point;
use crate::scene::{Scene, event_times};
use serde::{Deserialize, Serialize};

/// A run between two steps. Forces are in it only where a scheme evaluates them at other velocities than the state's:
/// evaluated at the same state they have the same bits.
///
/// The field order is the format of a checkpoint file: a change needs a new
/// [`FORMAT`](crate::output::checkpoint::FORMAT).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// accepted steps
    pub step: u64,
    /// [s] time
    pub t: f64,
    /// [m] (or [rad]) positions of all degrees of freedom, in the scene's numbering
    pub x: Vec<f64>,
    /// [m/s] (or [rad/s]) their velocities
    pub v: Vec<f64>,
    /// forces of the last step, for schemes whose forces lag behind ([`Stepper::lags`])
    pub forces: Option<Forces>,
    /// what the scheme carries
    pub carried: CarriedState,
    /// work done so far
    pub counters: Counters,
    /// energy account of the run
    pub ledger: Ledger,
    /// the account at this state
    pub row: Energies,
    /// both before a program changed values at this state
    pub before_change: Option<(Ledger, Energies)>,
    /// the energy account of the watch
    pub watch: EnergyAccount,
    /// first divergence of a run that continued after it
    pub failure: Option<Failure>,
    /// the warning the run has given
    pub doubt: Option<String>,
    /// state of the adaptive steps
    pub adaptive: Option<AdaptiveState>,
    /// events that have happened
    pub fired: Vec<Fired>,
}

impl RunSpec {
    /// Checks that a run of this scene passes through the snapshot. A run with another end does, if its steps up to
    /// there are the same.
    ///
    /// # Errors
    /// [`RunError::OtherScene`] or [`RunError::NotOnTheWay`].
    pub fn passes(&self, scene: &dyn Scene, snapshot: &Snapshot) -> Result<(), RunError> {
        let &Snapshot { step, t, ref x, ref v, .. } = snapshot;
        let needed = scene.n_dof();
        if let Some(found) = [x.len(), v.len()].into_iter().find(|n| *n != needed) {
            return Err(RunError::OtherScene { found, needed });
        }
        if self.free_steps {
            return Ok(());
        }
        let Step::Fixed(step_size) = self.step else {
            // The tolerance is divided over the run, so the end must be the same too.
            if snapshot.adaptive.is_none() || t > self.end {
                return Err(RunError::NotOnTheWay { t, step, steps: step, end: self.end });
            }
            return Ok(());
        };
        let mut clock = EventSteps::new(FixedSteps::new(step_size, self.end), event_times(scene));
        let known = EventWatch::known(scene, &snapshot.fired);
        known.into_iter().for_each(|t| clock.divide(t));
        // A program may have put the run between two ends of steps.
        let JoinedAt { step: last, t: there } = clock.join(t);
        if step != last || there.to_bits() != t.to_bits() || t > self.end {
            return Err(RunError::NotOnTheWay { t, step, steps: clock.count(), end: self.end });
        }
        Ok(())
    }

    /// Where a run of this scene stands that a program puts at time `t` [s], after `steps` of its own. Fixed steps
    /// count from t = 0, so their number follows from the time.
    ///
    /// # Errors
    /// [`RunError::OutOfRange`]: a time that is not finite, before 0, or beyond the end.
    pub fn join(&self, scene: &dyn Scene, steps: u64, t: f64) -> Result<JoinedAt, RunError> {
        let end = if self.free_steps { f64::INFINITY } else { self.end };
        if !(t.is_finite() && t >= 0.0 && t <= end) {
            return Err(RunError::OutOfRange { what: "time [s]", value: t, needed: "a time between 0 and the end" });
        }
        Ok(match self.step {
            Step::Fixed(step) if !self.free_steps => {
                EventSteps::new(FixedSteps::new(step, self.end), event_times(scene)).join(t)
            }
            _ => JoinedAt { step: steps, t },
        })
    }
}

/// Why a run can be resumed from here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occasion {
    /// before any step but the last
    Step,
    /// before the last step; it may be shortened to meet the end, so a run with a later end must continue from here
    LastStep,
    /// the run was stopped from outside and makes no further step
    Interrupted,
}

/// A run between two steps, shown to observers. A snapshot of it costs a copy, so it is made only on request.
pub struct Resumable<'a> {
    /// why it is shown
    pub occasion: Occasion,
    /// accepted steps
    pub step: u64,
    /// the state
    pub at: &'a Point,
    pub(super) row: Energies,
    /// work done so far
    pub counters: Counters,
    pub(super) ledger: &'a Ledger,
    pub(super) before_change: Option<(Ledger, Energies)>,
    pub(super) watch: &'a EnergyAccount,
    pub(super) failure: Option<&'a Failure>,
    pub(super) doubt: Option<&'a String>,
    pub(super) stepper: &'a Stepper<'a>,
    /// what adaptive steps keep
    pub adaptive: Option<&'a AdaptiveState>,
    /// events that have happened
    pub fired: &'a [Fired],
}

impl Resumable<'_> {
    /// A copy of everything.
    pub fn snapshot(&self) -> Snapshot {
        let state = &self.at.state;
        Snapshot {
            step: self.step,
            t: state.t,
            x: state.x.clone(),
            v: state.v.clone(),
            forces: self.stepper.lags().then(|| self.at.forces.clone()),
            carried: self.stepper.save(),
            counters: self.counters,
            ledger: *self.ledger,
            row: self.row,
            before_change: self.before_change,
            watch: *self.watch,
            failure: self.failure.cloned(),
            doubt: self.doubt.cloned(),
            adaptive: self.adaptive.cloned(),
            fired: self.fired.to_vec(),
        }
    }
}
