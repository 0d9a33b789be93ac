//! The specification of a run, and its outcome.

use super::clock::{Step, Tolerance};
use super::error::RunError;
use super::failure::Failure;
use super::observer::LedgerRow;
use super::watch::DOUBTFUL;
use crate::format_number::figures;
use crate::integrate::Counters;
use crate::integrate::registry::MethodChoice;
use crate::model::stop::Stop;
use crate::solve::LinearStats;

/// For which events a run searches the cause. The search is an analysis of the scene that takes as long as some hundred
/// steps of a small scene. Without it a report still says what happened and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Explain {
    /// nothing
    Nothing,
    /// a run that fails
    Failures,
    /// a run that fails, and energy that the scheme makes
    All,
}

/// What to run.
#[derive(Clone, Copy, Debug)]
pub struct RunSpec<'a> {
    /// [s] end of the run
    pub end: f64,
    /// its steps
    pub step: Step,
    /// whether a program gives the size of each step, whatever `step` is
    pub free_steps: bool,
    /// [s] interval of the frames; `None` where only ends of steps are shown. Adaptive steps of a scheme with an
    /// embedded pair end at its multiples, because cubic interpolation would be less accurate than such a step; other
    /// steps do not
    pub frames_every: Option<f64>,
    /// continue after a divergence until a value is not finite
    pub keep_going: bool,
    /// events for which the cause is searched; none where the cost of a run is measured
    pub explain: Explain,
    /// ends the search for a cause, besides the flag that ends the run
    pub interrupt: Stop<'a>,
    /// the method of the stepper
    pub method: &'a MethodChoice,
}

impl RunSpec<'_> {
    /// [s] The step, where all steps have this size.
    pub fn steps_of_one_size(&self) -> Option<f64> {
        self.step.fixed().filter(|_| !self.free_steps)
    }

    /// Checks the numbers of the specification.
    ///
    /// # Errors
    /// [`RunError::OutOfRange`]: an end, step, interval of frames or absolute tolerance that is not finite and above 0,
    /// or a relative tolerance outside (0, 1).
    pub fn check(&self) -> Result<(), RunError> {
        let above = |what: &'static str, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(RunError::OutOfRange { what, value, needed: "a finite number above 0" }),
        };
        above("end [s]", self.end)?;
        self.frames_every.map_or(Ok(()), |every| above("time between frames [s]", every))?;
        match self.step {
            Step::Fixed(step) => above("step [s]", step),
            Step::Adaptive(Tolerance { relative, absolute }) => {
                above("absolute tolerance", absolute)?;
                let (what, needed) = ("relative tolerance", "a number between 0 and 1");
                match relative > 0.0 && relative < 1.0 {
                    true => Ok(()),
                    false => Err(RunError::OutOfRange { what, value: relative, needed }),
                }
            }
        }
    }
}

/// How a run ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// reached its end
    #[default]
    Completed,
    /// a state was not finite or left the scene
    Diverged,
    /// an implicit step could not be solved
    NotConverged,
    /// stopped from outside
    Interrupted,
}

/// The result of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// how it ended
    pub status: Status,
    /// accepted steps
    pub steps: u64,
    /// attempts of adaptive steps that were dropped
    pub rejected_steps: u64,
    /// [s] time of the last good state
    pub t_end: f64,
    /// whether an observer has ended it before its time
    pub ended_early: bool,
    /// work done
    pub counters: Counters,
    /// additional force passes for the account and the observers, where a scheme evaluates none at the end of its step;
    /// counted since the last start or resume
    pub account_passes: u64,
    /// [-] largest numerical energy over the largest energy exchanged; where rounding explains it, over the energies
    /// that were rounded
    pub energy_error: f64,
    /// [-] largest energy made by the scheme over all energy that was present or supplied
    pub energy_made: f64,
    /// warning that the run gave
    pub doubt: Option<String>,
    /// the account at the last good state
    pub ledger: LedgerRow,
    /// what went wrong, if anything did
    pub failure: Option<Failure>,
    /// the linear solver's account, for implicit methods
    pub linear: Option<LinearStats>,
}

impl Outcome {
    /// Text about a run whose scheme has made energy itself (Kuhl & Crisfield 1999 show it for Newmark).
    pub fn energy_doubt(&self) -> Option<String> {
        (self.energy_made > DOUBTFUL).then(|| {
            let share = figures(100.0 * self.energy_made, 2);
            format!("the scheme itself has made energy, up to {share} % of all that was present or supplied")
        })
    }
}
