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
pub mod event;
pub mod failure;
pub mod ledger;
pub mod lost_payload;
pub mod max_displacement;
pub mod observer;
mod outcome;
mod run;
mod run_spec;
pub mod snapshot;
mod step_policy;
pub mod watch;

pub use error::RunError;
pub use failure::Failure;
pub use outcome::{Outcome, Status};
pub use run::{Changed, Run, RunState, StepEnd};
pub use run::{resume, run, run_from};
pub use run_spec::{Explain, RunSpec};
pub use snapshot::Snapshot;
