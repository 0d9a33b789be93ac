//! Mesh files in: .vtu, .vtp, .vtk, .msh (2.2 text; 4.1 text and binary), .obj, .stl. A frame of a run is a mesh too:
//! its nodes have their positions at that time.
//!
//! Line cells become edges first, in file order; the triangles' edges that are not among them follow, sorted by their
//! nodes. Quads are cut along their first diagonal. Nodes that no line or triangle uses (such as Gmsh's arc centres)
//! are dropped, and the rest keep their order: a node without mass could not move.
//!
//! Named parts of the file become groups; a line on the side of a triangle names that edge.

mod cells;
mod msh;
mod obj;
mod stl;
mod vtk;

use super::{Mesh, MeshError};
use cells::Cells;
use std::path::Path;

/// Name of the cell array of a .vtu file that marks seams.
pub(super) const SEAM: &str = "seam";
/// Name of the point array of a .vtu file with the displacement at the start.
pub(super) const START_DISPLACEMENT: &str = "start_displacement";

/// A mesh read from a file, and what the reader changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// the mesh; it has passed [`Mesh::check`]
    pub mesh: Mesh,
    /// one sentence for every change or omission
    pub notes: Vec<String>,
}

/// Reads a mesh file; the format follows from the name's extension.
///
/// # Errors
/// [`MeshError::File`] with the file's name and the reason.
pub fn read_mesh(path: &Path) -> Result<Imported, MeshError> {
    let reader = reader(path)?;
    let fault =
        |error: std::io::Error| MeshError::File { path: path.to_owned(), reason: format!("cannot be read: {error}") };
    read_with(reader, path, &crate::input_file::read(path).map_err(fault)?)
}

/// The same for the bytes of a file that are already in memory; `path` gives the format, and the name in messages.
///
/// # Errors
/// As [`read_mesh`], except for reading the file.
pub fn mesh_from_bytes(path: &Path, bytes: &[u8]) -> Result<Imported, MeshError> {
    read_with(reader(path)?, path, bytes)
}

type Reader = fn(&[u8]) -> Result<Cells, String>;

/// The reader of a file's format.
fn reader(path: &Path) -> Result<Reader, MeshError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match extension.as_str() {
        "vtu" | "vtp" | "vtk" => Ok(vtk::read),
        "msh" => Ok(msh::read),
        "obj" => Ok(obj::read),
        "stl" => Ok(stl::read),
        _ => {
            let reason =
                format!("the extension \"{extension}\" is not a mesh format; use .vtu, .vtp, .vtk, .msh, .obj or .stl");
            Err(MeshError::File { path: path.to_owned(), reason })
        }
    }
}

fn read_with(reader: Reader, path: &Path, bytes: &[u8]) -> Result<Imported, MeshError> {
    let fault = |reason: String| MeshError::File { path: path.to_owned(), reason };
    // A panic of a parsing library on a damaged file must not end the program.
    let cells = std::panic::catch_unwind(|| reader(bytes))
        .unwrap_or_else(|_| Err("is damaged; the parser gave up on it. Write it anew".to_owned()));
    let imported = cells.and_then(Cells::into_mesh).map_err(fault)?;
    imported.mesh.check().map_err(|error| fault(error.to_string()))?;
    Ok(imported)
}
