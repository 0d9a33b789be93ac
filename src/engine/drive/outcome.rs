//! The outcome of a run.

use super::event::Fired;
use super::failure::Failure;
use super::observer::Energies;
use super::watch::DOUBTFUL;
use crate::format_number::figures;
use crate::integrate::Counters;
use crate::solve::LinearStats;

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
    /// whether an observer or an event has ended it before its time
    pub ended_early: bool,
    /// the events that have happened
    pub fired: Vec<Fired>,
    /// names of events that have not
    pub unmet: Vec<String>,
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
    pub ledger: Energies,
    /// what went wrong, if anything did
    pub failure: Option<Failure>,
    /// the linear solver's account, for implicit methods
    pub linear: Option<LinearStats>,
}

impl Outcome {
    /// Whether the run has ended with a landing.
    pub fn landed(&self) -> bool {
        self.fired.iter().any(|fired| fired.landing.is_some())
    }

    /// Text about a run whose scheme has made energy itself (Kuhl & Crisfield 1999 show it for Newmark).
    pub fn energy_doubt(&self) -> Option<String> {
        (self.energy_made > DOUBTFUL).then(|| {
            let share = figures(100.0 * self.energy_made, 2);
            format!("the scheme itself has made energy, up to {share} % of all that was present or supplied")
        })
    }
}
