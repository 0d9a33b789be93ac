//! canopy-fem: parachute canopies and cloth as mass-spring networks, integrated the way a finite-element code would.
#![warn(missing_docs)]
// Units stand in brackets at the beginning of a field's doc, as `[N/m]`; rustdoc would take them for links.
#![allow(rustdoc::broken_intra_doc_links)]

pub mod analysis;
pub mod assembly;
pub mod case;
pub mod cli;
pub mod drive;
pub mod figures;
pub mod force;
pub mod integrate;
pub mod mesh;
pub mod model;
pub mod output;
pub mod plot;
pub mod scene;
pub mod simulation;

pub mod solve;
pub mod startup;
pub mod study;
