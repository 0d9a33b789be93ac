//! The engine of canopy-fem: networks of masses and springs, integrated the way a finite-element code would.
//!
//! All is M a = f(t, x, v) with a lumped mass M. `f` is the force on the nodes; its tangents are K = -df/dx and C =
//! -df/dv, so that springs at rest and dashpots have positive ones, and implicit schemes solve with W = cm M + cc C +
//! ck K. Units are SI: m, kg, s, N, Pa, J; every number's doc begins with its own. Specifications, meshes, frames and
//! messages number nodes as the user does; states and forces within a run have [a numbering of the
//! engine](model::state).
//!
//! `README.md` beside this file says why it is built as it is.
#![cfg_attr(not(test), warn(unreachable_pub, clippy::print_stdout, clippy::print_stderr))]
// Units stand in brackets at the beginning of a field's doc, as `[N/m]`; rustdoc would take them for links.
#![allow(rustdoc::broken_intra_doc_links)]

pub mod analysis;
pub mod assembly;
pub mod contact;
pub mod drive;
pub mod force;
pub mod integrate;
pub mod model;
pub mod preflight;
pub mod scene;
pub mod sensitivity;
pub mod solve;
pub mod statics;

pub use canopy_fem_mesh as mesh;
#[cfg(feature = "vtk")]
pub use canopy_fem_mesh::vtk;
pub use canopy_fem_mesh::{format_number, input_file, interrupt, process, startup, warning};
