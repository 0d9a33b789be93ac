//! A case over values of its keys: what the gauges say of every run.
//!
//! ```text
//! case + --vary --plan--> list of runs --run--> one file a run --table--> columns --report--> csv json svg html
//! ```
//! The files, shards and merges are those of a tradeoff study ([`super::store`]), with the plan of a sweep. Runs are
//! made on several threads, one run a thread; a run itself is that of `canopy-fem solve`, without its files. Where the
//! values are drawn from distributions ([`sample`]), the report is of their scatter.

mod figure;
mod plan;
mod report;
mod result;
mod run;
pub mod sample;
mod table;
mod vary;
mod words;

pub use plan::{SweepJob, SweepPlan, SweepPlanner};
pub use report::{FILES, SweepReport, clear, planned};
pub use result::SweepResult;
pub use run::{SweepRow, SweepRunner, rows_of};
pub use vary::Vary;
pub use words::unit_of;
