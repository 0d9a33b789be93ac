//! Studies of many runs on one scene: what accuracy costs.
//!
//! ```text
//! case + options --plan--> references, list of runs --run--> one file a run --rows--> Pareto front, recommendations --report--> csv json svg html
//! ```
//! A study is a list of independent runs ([`plan`]), so that machines can share it: each run has its own file
//! ([`store`]), finished ones are never made again, and a stopped one goes on where it was. Errors are distances from a
//! reference that knows its own error ([`reference`]). Everything that decides numbers is counted; seconds are only
//! measured.
//!
//! `README.md` beside this file says why it is built as it is.

#![cfg_attr(not(test), warn(unreachable_pub, clippy::print_stdout, clippy::print_stderr))]
// Units stand in brackets at the beginning of a field's doc, as `[N/m]`; rustdoc would take them for links.
#![allow(rustdoc::broken_intra_doc_links)]

pub mod accuracy;
pub mod beside;
mod compared_model;
mod costs;
pub mod difference;
mod error;
pub mod experiment;
pub mod export;
pub mod fit;
pub mod forecast;
pub mod frames;
pub mod gradient;
mod keeper;
mod measure;
mod method_look;
pub mod models;
pub mod options;
pub mod pareto;
pub mod plan;
pub mod planned_runs;
pub mod plot;
pub mod prepared_case;
pub mod ranking;
pub mod recommendations;
pub mod reference;
mod reference_quantities;
pub mod report;
pub mod require;
pub mod row;
mod runner;
mod saved_run;
pub mod stability;
mod step_grid;
pub mod store;
pub mod sweep;
pub mod template;
pub mod verify;
pub mod view;
pub mod whole_run;
pub mod worth;

use canopy_fem_io::{analysis, assembly, drive, force, integrate, model, scene, sensitivity, solve};
use canopy_fem_io::{case, checksum, format_number, input_file, mesh, output, process, simulation, vtk};
pub use error::StudyError;
pub use method_look::{method_color, method_mark};
pub use runner::{Runner, Shard, Study, rows_of};
