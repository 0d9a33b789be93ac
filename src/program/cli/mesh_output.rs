//! What the commands of `canopy-fem mesh` share: where a mesh goes, what is doubtful in it, and why they fail.

use crate::mesh::canopy::Canopy;
use crate::mesh::file::repairs;
use crate::mesh::{Mesh, MeshError, Topology};
use clap::Args;
use std::path::PathBuf;

/// The output of a generated mesh.
#[derive(Clone, Debug, Args)]
pub struct OutputArgs {
    /// File to write, .vtu, .vtp, .msh, .obj, .ply, .stl, .inp, .bdf, .mdpa or .glb; without it, the command only
    /// describes the mesh
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Replace the file if it exists
    #[arg(long)]
    pub force: bool,
}

/// Why `canopy-fem mesh` failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshCliError {
    /// The mesh cannot be made or read.
    #[error(transparent)]
    Input(MeshError),
    /// The mesh cannot be written.
    #[error(transparent)]
    Output(MeshError),
    /// An end of a chain is missing.
    #[error("a chain needs both --from X Y Z and --to X Y Z")]
    ChainEnds,
}

impl MeshCliError {
    /// Exit status of the program: 2 for bad input or a bad name for the output, 1 if writing failed.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Input(_) | Self::ChainEnds | Self::Output(MeshError::Target { .. }) => 2,
            Self::Output(_) => 1,
        }
    }
}

/// What the reader changed, and what is wrong with the mesh for a simulation.
pub(super) fn doubts(mesh: &Mesh, topology: &Topology, notes: &[String]) -> Vec<String> {
    let sheet = topology.check_manifold().err();
    let canopies = Canopy::of_groups(mesh);
    let mut canopy: Vec<String> =
        canopies.values().filter_map(|found| Some(found.as_ref().err()?.to_string())).collect();
    canopy.dedup();
    let sheet = sheet.into_iter().map(|error| error.to_string());
    notes.iter().cloned().chain(sheet).chain(canopy).chain(repairs(mesh, topology)).collect()
}
