//! All that a run needs to go on from a step as if it had never stopped.

use super::adaptive::AdaptiveState;
use super::clock::{FixedSteps, Step};
use super::error::RunError;
use super::failure::Failure;
use super::ledger::Ledger;
use super::observer::LedgerRow;
use super::outcome::RunSpec;
use super::watch::EnergyAccount;
use crate::integrate::stepper::Stepper;
use crate::integrate::{CarriedState, Counters};
use crate::model::point::Point;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// A run between two steps. Forces are not in it: evaluated at the same state they have the same bits.
///
/// The field order is the format of a checkpoint file: with another field goes another
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
    /// what the scheme carries
    pub carried: CarriedState,
    /// work done so far
    pub counters: Counters,
    /// running energy account
    pub ledger: Ledger,
    /// the account at this state
    pub row: LedgerRow,
    /// what the watch remembers
    pub watch: EnergyAccount,
    /// first trouble of a run that was let go on past it
    pub failure: Option<Failure>,
    /// the warning the run has given
    pub doubt: Option<String>,
    /// where adaptive steps stand
    pub adaptive: Option<AdaptiveState>,
}

impl RunSpec<'_> {
    /// Whether a run of this kind of this scene comes past the snapshot. One with another end does, if its steps up to
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
        let Step::Fixed(step_size) = self.step else {
            // The tolerance is shared out over the run, so the case's end is part of what must be the same.
            if snapshot.adaptive.is_none() || t > self.end {
                return Err(RunError::NotOnTheWay { t, step, steps: step, end: self.end });
            }
            return Ok(());
        };
        let clock = FixedSteps::new(step_size, self.end);
        let there = if step == 0 { 0.0 } else { clock.tick(step).t };
        if step > clock.count() || there.to_bits() != t.to_bits() {
            return Err(RunError::NotOnTheWay { t, step, steps: clock.count(), end: self.end });
        }
        Ok(())
    }
}

/// Why a run can be taken up from here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occasion {
    /// before any step but the last
    Step,
    /// before the last step; it may be shortened to meet the end, so a longer run has to go on from here
    LastStep,
    /// the run was stopped from outside and makes no further step
    Interrupted,
}

/// A run between two steps, lent to observers. A snapshot of it costs a copy, so it is made when asked for.
pub struct Resumable<'a> {
    /// why it is shown
    pub occasion: Occasion,
    /// accepted steps
    pub step: u64,
    /// the state
    pub at: &'a Point,
    pub(super) row: LedgerRow,
    /// work done so far
    pub counters: Counters,
    pub(super) ledger: &'a Ledger,
    pub(super) watch: &'a EnergyAccount,
    pub(super) failure: Option<&'a Failure>,
    pub(super) doubt: Option<&'a String>,
    pub(super) stepper: &'a Stepper<'a>,
    /// what adaptive steps carry over
    pub adaptive: Option<&'a AdaptiveState>,
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
            carried: self.stepper.save(),
            counters: self.counters,
            ledger: *self.ledger,
            row: self.row,
            watch: *self.watch,
            failure: self.failure.cloned(),
            doubt: self.doubt.cloned(),
            adaptive: self.adaptive.cloned(),
        }
    }
}
