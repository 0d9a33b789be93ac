//! Studies of many runs on one scene: what accuracy costs.
//!
//! ```text
//! case + wishes --plan--> references, list of runs --run--> one file a run --rows--> front, answers --report--> csv json svg html
//! ```
//! A study is a list of independent runs ([`plan`]), so that machines can share it: each run has its own file
//! ([`store`]), finished ones are never made again, and a stopped one goes on where it was. Errors are distances from a
//! reference that knows its own error ([`reference`]). Everything that decides numbers is counted; seconds are only
//! measured.

pub mod answers;
pub mod bench;
pub mod difference;
mod error;
pub mod experiment;
pub mod frames;
pub mod front;
pub mod ladder;
mod measure;
pub mod plan;
pub mod reference;
pub mod report;
pub mod row;
mod runner;
pub mod stability;
pub mod store;
pub mod trial;
pub mod wishes;

pub use error::StudyError;
pub use measure::{Ended, Meter};
pub use runner::{Runner, Shard, Study, rows_of};
