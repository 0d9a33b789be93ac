//! The run: steps are attempted, accepted or dropped, added to the energy account and shown to observers.
//!
//! [`run`] owns the two points of a step. A step that is not finite or has diverged is never shown to an observer as
//! credible.

pub mod adaptive;
pub mod at_rest;
mod cause;
pub mod clock;
pub mod cloth_strain;
pub mod critical_step_monitor;
mod error;
pub mod failure;
pub mod ledger;
pub mod max_displacement;
pub mod observer;
mod outcome;
mod run;
pub mod snapshot;
mod step_policy;
pub mod watch;

pub use error::RunError;
pub use failure::Failure;
pub use outcome::{Explain, Outcome, RunSpec, Status};
pub use run::{Changed, Run, RunState};
pub use run::{resume, run, run_from};
pub use snapshot::Snapshot;
