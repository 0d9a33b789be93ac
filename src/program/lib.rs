//! canopy-fem: parachute canopies and cloth as mass-spring networks, integrated the way a finite-element code would.
//!
//! All is M a = f(t, x, v) with a lumped mass M. `f` is the force on the nodes; its tangents are K = -df/dx and C =
//! -df/dv, so that springs at rest and dashpots have positive ones, and implicit schemes solve with W = cm M + cc C +
//! ck K. Units are SI: m, kg, s, N, Pa, J; every number's doc begins with its own. Specifications, meshes, frames and
//! messages number nodes as the user does; states and forces within a run have [a numbering of the
//! engine](model::state).
//!
//! The program is [`cli`]. A library drives a [`Simulation`](simulation::Simulation), made from a case or in code
//! (`examples/cloth_by_hand.rs`): step by step, with forces, laws, schemes and observers of its own.
//!
//! ```
//! use canopy_fem::{case::Case, simulation::{FollowSpec, follow}};
//! use std::path::PathBuf;
//!
//! let text = r#"{"name": "swing", "system": {"pendulum": {"length": 1, "mass": 2, "damping": 0, "gravity": 9.81, "angle": 0.5}},
//!                "time": {"end": 1, "step": 1e-3, "method": "velocity-verlet"}}"#;
//! let case = Case::from_text(text.to_owned(), "swing.json", PathBuf::new(), &[])?;
//! let mut lowest = f64::INFINITY;
//! let outcome = follow(case.problem(), FollowSpec::default(), |seen| {
//!     lowest = lowest.min(seen.positions[0][2]);
//! })?;
//! assert_eq!(outcome.steps, 1000);
//! assert!(outcome.energy_error < 1e-5 && (lowest + 1.0).abs() < 1e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What a library uses
//! | for | items |
//! |---|---|
//! | cases | [`Case`], [`Problem`], [`CaseError`], [`json_schema`] |
//! | simulations | [`Simulation`] with [a table of its calls](simulation), [`NetworkBuilder`], [`RunSpec`] |
//! | whole runs | [`follow`], [`record`], [`record_static`], [`Outcome`], [`Summary`] |
//! | forces, laws and observers of its own | [`NodalForce`], [`BarLaw`], [`Observer`] |
//! | methods, and schemes of its own | [`registry`], [`Integrator`] |
//! | specifications in code | [`NetworkSpec`], [`build_scene`] |
//! | meshes | [`Mesh`], [`MeshSource`], [`read`], [`write`] |
//! | critical steps, spectra, modes | [`critical`], [`Spectrum`], [`modes`] |
//! | studies and charts | [`study`], [`plot`] |
//!
//! All else is public for the other crates of this program, and changes with them.
//!
//! [`BarLaw`]: simulation::BarLaw
//! [`CaseError`]: case::CaseError
//! [`Case`]: case::Case
//! [`Integrator`]: integrate::Integrator
//! [`MeshSource`]: mesh::MeshSource
//! [`Mesh`]: mesh::Mesh
//! [`NetworkBuilder`]: simulation::NetworkBuilder
//! [`NetworkSpec`]: model::spec::NetworkSpec
//! [`NodalForce`]: simulation::NodalForce
//! [`Observer`]: drive::observer::Observer
//! [`Outcome`]: drive::Outcome
//! [`Problem`]: case::Problem
//! [`RunSpec`]: simulation::RunSpec
//! [`Simulation`]: simulation::Simulation
//! [`Spectrum`]: analysis::spectrum::Spectrum
//! [`Summary`]: output::summary::Summary
//! [`build_scene`]: simulation::build_scene
//! [`critical`]: analysis::critical
//! [`follow`]: simulation::follow()
//! [`json_schema`]: case::json_schema
//! [`modes`]: analysis::modes
//! [`read`]: mesh::read
//! [`record_static`]: simulation::record_static
//! [`record`]: simulation::record()
//! [`registry`]: integrate::registry
//! [`write`]: mesh::write
#![warn(unreachable_pub, clippy::print_stdout, clippy::print_stderr)]
// Units stand in brackets at the beginning of a field's doc, as `[N/m]`; rustdoc would take them for links.
#![allow(rustdoc::broken_intra_doc_links)]

pub mod cli;

pub use canopy_fem_io::sensitivity;
pub use canopy_fem_io::{analysis, assembly, drive, force, integrate, model, preflight, scene, solve, statics};
pub use canopy_fem_io::{case, output, simulation};
pub use canopy_fem_io::{checksum, format_number, input_file, interrupt, mesh, process, startup, vtk, warning};
pub use canopy_fem_study as study;
pub use canopy_fem_study::plot;
