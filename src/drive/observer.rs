//! What a run tells its observers: both ends of every accepted step, or, of steps that they allow to be made several at
//! once, the account and a few figures.

pub use super::snapshot::{Occasion, Resumable};
pub use crate::model::point::Point;
use crate::model::stride::Passed;

/// The energy account at one time. kinetic + elastic + gravity - external_work + dissipated + numerical
/// keeps its value at t = 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LedgerRow {
    /// [J] kinetic energy
    pub kinetic: f64,
    /// [J] energy of the springs
    pub elastic: f64,
    /// [J] gravity energy, from displacements
    pub gravity: f64,
    /// [J] work of the air and the loads since t = 0
    pub external_work: f64,
    /// [J] taken by dashpots and Rayleigh damping since t = 0
    pub dissipated: f64,
    /// [J] the remainder: above 0 the scheme lost energy, below 0 it made some
    pub numerical: f64,
}

impl LedgerRow {
    /// Whether all that goes into the account is a number.
    pub(super) fn is_finite(&self) -> bool {
        (self.kinetic + self.elastic + self.gravity + self.external_work + self.dissipated).is_finite()
    }
}

/// One accepted step. Its states are in [the engine's numbering](crate::model::state).
#[derive(Clone, Copy, Debug)]
pub struct StepView<'a> {
    /// number of the step, counted from 1
    pub step: u64,
    /// where it started
    pub from: &'a Point,
    /// where it ended
    pub to: &'a Point,
    /// account at `to`
    pub ledger: LedgerRow,
    /// Newton iterations of the step, 0 for explicit schemes
    pub newton_iterations: u32,
    /// [-] final residual over its scale, 0 for explicit schemes
    pub residual: f64,
    /// whether the state at `to` can be right: the scheme has made no more energy than there was, and no node moved
    /// farther than the scene's size; steps made in strides are
    pub credible: bool,
}

/// A step that may be made in a [stride](crate::model::stride).
#[derive(Clone, Copy, Debug, Default)]
pub struct Coming {
    /// its number
    pub step: u64,
    /// [s] its size
    pub h: f64,
    /// [s] time at its end
    pub t: f64,
    /// whether the largest strain is to be told of its end; an observer that wants it sets this
    pub stretch_wanted: bool,
}

/// An accepted step of a stride.
#[derive(Clone, Copy, Debug)]
pub struct Passing<'a> {
    /// number of the step
    pub step: u64,
    /// [s] time at its start
    pub from: f64,
    /// [s] time at its end
    pub t: f64,
    /// account at its end
    pub ledger: LedgerRow,
    /// what is left of its end
    pub passed: &'a Passed,
    /// its end; that of the last step of a stride only
    pub at: Option<&'a Point>,
}

/// Why an observer stops a run.
#[derive(Debug, thiserror::Error)]
pub enum ObserveError {
    /// Results could not be written.
    #[error("{path}: {source}")]
    Write {
        /// the file
        path: String,
        /// the system's reason
        source: std::io::Error,
    },
    /// The writing thread ended before the run did.
    #[error("the thread that writes results has stopped")]
    WriterGone,
}

/// Watches a run. Called in step order, from the thread that integrates.
pub trait Observer {
    /// Before the first step.
    ///
    /// # Errors
    /// When results cannot be written.
    fn started(&mut self, _at: &Point, _ledger: LedgerRow) -> Result<(), ObserveError> {
        Ok(())
    }

    /// Instead of [`Observer::started`], before the first step of a run that goes on from a snapshot.
    ///
    /// # Errors
    /// When results cannot be written.
    fn resumed(&mut self, _at: &Point, _ledger: LedgerRow) -> Result<(), ObserveError> {
        Ok(())
    }

    /// Before every step or [stride](Observer::stride), and once more when the run is interrupted: a moment to keep a
    /// snapshot.
    ///
    /// # Errors
    /// When it cannot be kept.
    fn resumable(&mut self, _run: &Resumable<'_>) -> Result<(), ObserveError> {
        Ok(())
    }

    /// After every accepted step.
    ///
    /// # Errors
    /// When results cannot be written.
    fn accepted(&mut self, step: StepView<'_>) -> Result<(), ObserveError>;

    /// How many of the coming steps, of which the first begins at `from` [s], may be made in one go: the observer then
    /// hears of all of them by [`Observer::passed`], with the state at the end of the last only. Below 2: none, as for
    /// every observer that does not say otherwise.
    fn stride(&self, from: f64, coming: &mut [Coming]) -> usize {
        let _ = (from, coming);
        0
    }

    /// After every step of a stride, in place of [`Observer::accepted`].
    ///
    /// # Errors
    /// When results cannot be written.
    fn passed(&mut self, step: Passing<'_>) -> Result<(), ObserveError> {
        let _ = step;
        Ok(())
    }

    /// Once, when the scheme has made energy worth a warning; the run goes on.
    fn doubted(&mut self, _warning: &str) {}

    /// Before [`Observer::finished`] where the run has failed: states that are not [credible](StepView::credible) right
    /// before the end are not worth showing.
    ///
    /// # Errors
    /// When results cannot be written.
    fn failed(&mut self) -> Result<(), ObserveError> {
        Ok(())
    }

    /// After the last step, however the run ended; `last` is the last accepted point.
    ///
    /// # Errors
    /// When results cannot be written.
    fn finished(&mut self, _last: &Point) -> Result<(), ObserveError> {
        Ok(())
    }
}
