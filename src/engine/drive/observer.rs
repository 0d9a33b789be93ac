//! What a run shows its observers: the energy account of every accepted step, and the states they ask for.

use super::event::Fired;
pub use super::snapshot::{Occasion, Resumable};
use crate::model::observables::Observables;
pub use crate::model::point::Point;
use crate::model::step_block::StepSummary;

/// The energy account at one time. kinetic + elastic + gravity - external_work + dissipated + numerical
/// keeps its value at t = 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Energies {
    /// [J] kinetic energy
    pub kinetic: f64,
    /// [J] energy of springs and bars
    pub elastic: f64,
    /// [J] gravity energy, from displacements
    pub gravity: f64,
    /// [J] work of the air and the loads since t = 0
    pub external_work: f64,
    /// [J] taken by dashpots and Rayleigh damping, and lost with springs that are cut, since t = 0
    pub dissipated: f64,
    /// [J] the remainder: energy that the scheme lost (above 0) or made (below 0)
    pub numerical: f64,
}

impl Energies {
    /// Whether all energies of the account are finite.
    pub(super) fn is_finite(&self) -> bool {
        (self.kinetic + self.elastic + self.gravity + self.external_work + self.dissipated).is_finite()
    }
}

/// A step that will be made next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UpcomingStep {
    /// number of the step, counted from 1
    pub step: u64,
    /// [s] time at its start
    pub from: f64,
    /// [s] time at its end
    pub t: f64,
}

impl UpcomingStep {
    /// [s] its size
    pub fn h(&self) -> f64 {
        self.t - self.from
    }
}

/// The states of a step that an observer wants to see.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum States {
    /// none: only the account of the step
    None,
    /// the state at its end
    End,
    /// the states at both ends
    #[default]
    BothEnds,
}

/// What an observer wants to know of a step. A run makes several steps in a block where no observer wants their states.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wants {
    /// states
    pub states: States,
    /// whether [`AcceptedStep::max_strain`] is wanted without a state
    pub strain: bool,
}

impl Wants {
    /// The account alone.
    pub const ACCOUNT: Self = Wants { states: States::None, strain: false };

    /// The state at the end if `wanted`, else the account alone.
    pub fn end_if(wanted: bool) -> Self {
        Wants { states: if wanted { States::End } else { States::None }, strain: false }
    }
}

/// An accepted step. Its states are in [the engine's numbering](crate::model::state).
#[derive(Clone, Copy, Debug, Default)]
pub struct AcceptedStep<'a> {
    /// number of the step, counted from 1
    pub step: u64,
    /// [s] time at its start
    pub from: f64,
    /// [s] time at its end
    pub t: f64,
    /// account at its end
    pub ledger: Energies,
    /// state at its start, if an observer wants both ends
    pub start: Option<&'a Point>,
    /// state at its end, if an observer wants it
    pub end: Option<&'a Point>,
    /// summary of the state at its end, if that state is not kept
    pub summary: Option<&'a StepSummary>,
    /// Newton iterations of the step, 0 for explicit schemes
    pub newton_iterations: u32,
    /// [-] final residual over its scale, 0 for explicit schemes
    pub residual: f64,
    /// whether its end is credible: the scheme made no more energy than was present or supplied, and no node moved
    /// farther than the scene's size
    pub credible: bool,
}

impl<'a> AcceptedStep<'a> {
    /// [s] its size
    pub fn h(&self) -> f64 {
        self.t - self.from
    }

    /// The states at both ends, if they are known.
    pub fn ends(&self) -> Option<[&'a Point; 2]> {
        Some([self.start?, self.end?])
    }

    /// [m/s] largest speed at its end
    pub fn max_speed(&self, picture: &dyn Observables) -> f64 {
        match (self.summary, self.end) {
            (Some(summary), _) => summary.max_speed(),
            (None, Some(end)) => picture.max_speed(end.state.as_ref()),
            (None, None) => f64::NAN,
        }
    }

    /// [-] largest strain at its end, where [`Wants::strain`] or the state was asked for
    pub fn max_strain(&self, picture: &dyn Observables) -> f64 {
        match (self.summary, self.end) {
            (Some(summary), _) => summary.max_strain(),
            (None, Some(end)) => picture.max_strain(end.state.as_ref()),
            (None, None) => f64::NAN,
        }
    }
}

/// Why an observer stops a run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ObserveError {
    /// Results could not be written.
    #[error("{path}: {source}")]
    Write {
        /// the file
        path: String,
        /// the system's reason
        source: std::io::Error,
    },
    /// The writing thread ended before the run.
    #[error("the thread that writes results has stopped")]
    WriterGone,
}

/// Watches a run. Called in step order, from the thread that integrates.
pub trait Observer {
    /// Before the first step.
    ///
    /// # Errors
    /// When results cannot be written.
    fn started(&mut self, _at: &Point, _ledger: Energies) -> Result<(), ObserveError> {
        Ok(())
    }

    /// Called instead of [`Observer::started`], before the first step of a run that continues from a snapshot.
    ///
    /// # Errors
    /// When results cannot be written.
    fn resumed(&mut self, _at: &Point, _ledger: Energies) -> Result<(), ObserveError> {
        Ok(())
    }

    /// Called at states from which a run can be resumed: at the start, after every step whose state an observer wanted,
    /// and when the run is interrupted.
    ///
    /// # Errors
    /// When the snapshot cannot be written.
    fn resumable(&mut self, _run: &Resumable<'_>) -> Result<(), ObserveError> {
        Ok(())
    }

    /// After [`Observer::started`], [`Observer::resumed`] or [`Observer::accepted`], for every event that has happened
    /// since, at the state that was shown; of a run that continues, for all that have happened before.
    ///
    /// # Errors
    /// When results cannot be written.
    fn event(&mut self, _event: &Fired) -> Result<(), ObserveError> {
        Ok(())
    }

    /// What the observer wants to know of a step that will be made next. Called for the next steps in order, up to the
    /// first whose state is wanted.
    fn wants(&self, step: UpcomingStep) -> Wants {
        let _ = step;
        Wants::default()
    }

    /// After every accepted step.
    ///
    /// # Errors
    /// When results cannot be written.
    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError>;

    /// Whether the run is to end after the last step that was shown, as complete. Asked after every step or block of
    /// steps.
    fn ends_run(&self) -> bool {
        false
    }

    /// Called once, when the scheme has made enough energy for a warning; the run continues.
    fn warned(&mut self, _warning: &str) {}

    /// Called before [`Observer::finished`] if the run has failed. States right before the end that are not
    /// [credible](AcceptedStep::credible) need not be shown.
    ///
    /// # Errors
    /// When results cannot be written.
    fn failed(&mut self) -> Result<(), ObserveError> {
        Ok(())
    }

    /// Called after the last step, however the run ended; `last` is the last accepted point.
    ///
    /// # Errors
    /// When results cannot be written.
    fn finished(&mut self, _last: &Point) -> Result<(), ObserveError> {
        Ok(())
    }
}
