//! What goes into the engine of canopy-fem and comes out of it: cases, results, and the simulation that a program
//! drives.
//!
//! `README.md` beside this file says why it is built as it is.
#![cfg_attr(not(test), warn(unreachable_pub, clippy::print_stdout, clippy::print_stderr))]
// Units stand in brackets at the beginning of a field's doc, as `[N/m]`; rustdoc would take them for links.
#![allow(rustdoc::broken_intra_doc_links)]

pub mod case;
pub mod checksum;
pub mod output;
pub mod simulation;

pub use canopy_fem_engine::sensitivity;
pub use canopy_fem_engine::{
    analysis, assembly, contact, drive, force, integrate, model, preflight, scene, solve, statics,
};
pub use canopy_fem_engine::{format_number, input_file, interrupt, mesh, process, startup, vtk, warning};
