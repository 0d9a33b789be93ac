//! Meshes: nodes, edges (which carry the springs) and triangles (which carry the air and pressure).
//!
//! Everything here is in the *user's* numbering: node 7 of a case, a file or a message is `nodes[7]`. The engine has a
//! numbering of its own (`scene::numbering`).
//!
//! `README.md` beside this file says why it is built as it is.

#![cfg_attr(not(test), warn(unreachable_pub, clippy::print_stdout, clippy::print_stderr))]
// Units stand in brackets at the beginning of a field's doc, as `[N/m]`; rustdoc would take them for links.
#![allow(rustdoc::broken_intra_doc_links)]

pub mod adjacency;
pub mod annulus;
pub mod box_tree;
pub mod canopy;
pub mod chain;
mod check;
mod coarse;
pub mod components;
pub mod crossing;
mod delaunay;
mod distmesh;
mod error;
pub(crate) mod explicit;
pub mod file;
mod flips;
pub mod format_number;
#[cfg(feature = "vtk")]
pub mod frames;
pub mod group;
pub mod hanging;
mod hilbert;
pub mod input_file;
pub mod interrupt;
mod layout;
pub mod least_distance;
pub mod look;
mod loops;
mod named_parts;
mod orient;
mod over_plane;
pub mod parachute;
mod polish;
pub mod process;
pub(crate) mod quality;
pub mod random;
pub mod read;
pub mod rectangle;
pub(crate) mod sdf;
pub mod sew;
mod sides;
pub mod source;
pub mod startup;
pub(crate) mod topology;
pub mod tuples;
pub mod unit_vector;
#[cfg(feature = "vtk")]
pub mod vtk;
pub mod warning;
pub mod write;

use std::collections::BTreeMap;

pub use crossing::{Crossing, CrossingFinder};
pub use error::MeshError;
pub use file::MeshFile;
pub use group::{Group, Groups};
pub use loops::BoundaryLoop;
pub use named_parts::{NamedParts, with_groups};
pub use quality::Quality;
pub use source::MeshSource;
pub use topology::{EdgeKind, Topology};

/// [-] How many tapes or lines an edge stands for, by the group's name and the edge's number, where it is not one.
pub type Strands = BTreeMap<String, BTreeMap<u32, f64>>;

/// A surface or line mesh in three dimensions.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Mesh {
    /// [m] positions of the nodes.
    pub nodes: Vec<[f64; 3]>,
    /// Pairs of nodes, each listed once; every edge can carry a spring.
    pub edges: Vec<[u32; 2]>,
    /// Triples of nodes; pressure acts along the right-hand normal.
    pub triangles: Vec<[u32; 3]>,
    /// Indices into `edges` of the radial seam lines; empty unless requested.
    pub seams: Vec<u32>,
    /// Named parts of the mesh.
    #[serde(skip_serializing_if = "Groups::is_empty")]
    pub groups: Groups,
    /// [m] Displacement of every node at the start, `[n_nodes][3]`; empty = none. Masses and rest lengths follow from
    /// `nodes`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub displacement: Vec<[f64; 3]>,
    /// Rows of cloth of a generated canopy of gores, from its vent or apex to its skirt: the nodes of each,
    /// right-handed about the outer normal; an apex is a row of one node. Those of one canopy after those of another.
    /// Empty if they are not known, as in files.
    #[serde(skip)]
    pub rows: Vec<Vec<u32>>,
    /// [-] Tapes and lines that stand side by side, as in coarsened gores; empty if they are not known, as in files.
    #[serde(skip)]
    pub strands: Strands,
    /// What triangles and edges of sewn pieces are as they are cut; masses and rest lengths follow from these, and not
    /// from `nodes`. `None` for others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cut: Option<sew::Cut>,
}
