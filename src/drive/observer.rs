//! What a run tells those who watch it: one view an accepted step.

pub use super::snapshot::{Occasion, Resumable};
pub use crate::model::point::Point;

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

/// One accepted step.
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
    fn started(&mut self, at: &Point, ledger: LedgerRow) -> Result<(), ObserveError>;

    /// Instead of [`Observer::started`], before the first step of a run that goes on from a snapshot.
    ///
    /// # Errors
    /// When results cannot be written.
    fn resumed(&mut self, _at: &Point, _ledger: LedgerRow) -> Result<(), ObserveError> {
        Ok(())
    }

    /// Before every step, and once more when the run is interrupted: a moment to keep a snapshot.
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

    /// Once, when the scheme has made energy worth a warning; the run goes on.
    fn doubted(&mut self, _warning: &str) {}

    /// After the last step, however the run ended; `last` is the last good point.
    ///
    /// # Errors
    /// When results cannot be written.
    fn finished(&mut self, last: &Point) -> Result<(), ObserveError>;
}
