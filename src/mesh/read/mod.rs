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
            let reason = match extension.as_str() {
                "" => "the name has no extension that says its format".to_owned(),
                other => format!("files \".{other}\" are not read"),
            };
            let reason = format!("{reason}; use .vtu, .vtp, .vtk, .msh, .obj or .stl{}", converter(path, &extension));
            Err(MeshError::File { path: path.to_owned(), reason })
        }
    }
}

/// The program that writes a file of this extension as one that is read, and its command.
fn converter(path: &Path, extension: &str) -> String {
    let to = |ending: &str| path.with_extension(ending).display().to_string();
    let from = path.display();
    match extension {
        // Readers of meshio 5.
        "inp" | "avs" | "bdf" | "nas" | "fem" | "med" | "e" | "exo" | "ex2" | "xdmf" | "xmf" | "ply" | "off"
        | "mesh" | "meshb" | "dat" | "tec" | "su2" | "vol" | "xml" | "node" | "ele" | "f3grid" | "post" | "ugrid"
        | "mdpa" | "h5m" | "wkt" | "cgns" => format!(": `meshio convert {from} {}` writes one", to("vtu")),
        "geo" | "step" | "stp" | "iges" | "igs" | "brep" => {
            format!(": `gmsh -2 {from} -o {}` makes a mesh of its surfaces", to("msh"))
        }
        "unv" | "p3d" => format!(": `gmsh -save {from} -o {}` writes one", to("msh")),
        "gltf" | "glb" | "fbx" | "dae" | "3ds" | "blend" | "x3d" | "wrl" => {
            ": open it in Blender, and export it as .obj or .stl".to_owned()
        }
        "dxf" | "dwg" | "sldprt" | "fcstd" | "3dm" => {
            ": open it in a CAD program such as FreeCAD, and export it as .obj or .stl".to_owned()
        }
        "k" | "key" | "dyn" => ": open it in LS-PrePost, and export it as .stl".to_owned(),
        _ => String::new(),
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
