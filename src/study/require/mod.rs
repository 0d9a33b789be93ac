//! What a scene requires: what each part of a model does to the quantities of interest, and what it costs.
//!
//! ```text
//! case --variants--> changes --plan--> list of runs --run--> one file a run --compare--> differences
//!   --combine--> the leanest case within the accuracy --report--> csv json html
//! ```
//! The case is taken as the user wrote it. A variant is simpler or finer by one thing ([`change`], [`variants`]). The
//! files, shards and merges are those of other studies ([`super::store`]). Combinations depend on what the variants
//! have shown: they are made after them, and never assumed to add up (`combine`).

pub mod change;
mod combine;
mod compare;
mod figure;
mod lines;
mod plan;
mod report;
mod run;
pub mod variants;

pub use change::ErrorOf;
pub use combine::{Combiner, Lean};
pub use compare::{Comparison, Number};
pub use plan::{RequireJob, RequirePlan, RequirePlanner};
pub use report::{FILES, RequireReport, clear, planned};
pub use run::{RequireResult, RequireRow, RequireRunner, rows_of};
pub use variants::Variants;
