//! Mesh files out: .vtu, .vtp, .msh, .obj, .ply and .stl.

mod formats;
mod members;
mod msh;

pub use formats::obj_text;

use super::group::GroupNumbers;
use super::read::{SEAM, START_DISPLACEMENT};
use super::{Mesh, MeshError};
use crate::vtk::write::{Cells, FixedArrays, VtuError};
use crate::vtk::write_mesh::{Form, mesh_text};
use std::io::Write as _;
use std::path::Path;

/// Writes a mesh; the format follows from the name's extension. An existing file is replaced only with `replace`.
/// Returns a sentence for what the format does not hold.
///
/// # Errors
/// [`MeshError::Target`] for an unknown extension or an existing file, [`MeshError::File`] for errors of the system.
pub fn write_mesh(mesh: &Mesh, path: &Path, replace: bool) -> Result<Vec<String>, MeshError> {
    let fault = |reason: String| MeshError::File { path: path.to_owned(), reason };
    let refused = |reason: &'static str| MeshError::Target { path: path.to_owned(), reason };
    let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).unwrap_or_default();
    let bytes = match ending.as_str() {
        "vtu" => vtk_text(mesh, Form::Grid).map_err(|error| fault(error.to_string()))?.into_bytes(),
        "vtp" => vtk_text(mesh, Form::Polygons).map_err(|error| fault(error.to_string()))?.into_bytes(),
        "msh" => msh::msh_text(mesh).into_bytes(),
        "obj" => obj_text(mesh).into_bytes(),
        "ply" => formats::ply_text(mesh).into_bytes(),
        "stl" => formats::stl(mesh),
        _ => {
            return Err(refused("cannot be written: name an output that ends in .vtu, .vtp, .msh, .obj, .ply or .stl"));
        }
    };
    let mut options = std::fs::OpenOptions::new();
    options.write(true);
    if replace {
        options.create(true).truncate(true)
    } else {
        options.create_new(true)
    };
    let mut file = options.open(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::AlreadyExists => refused("exists already; name another file or add --force"),
        _ => fault(format!("cannot be written: {error}")),
    })?;
    file.write_all(&bytes).map_err(|error| fault(format!("cannot be written: {error}")))?;
    Ok(lost(mesh, &ending))
}

/// What a format does not hold.
fn lost(mesh: &Mesh, ending: &str) -> Vec<String> {
    let lines = members::lines(mesh).len();
    let vtk = ["vtu", "vtp"].contains(&ending);
    let parts = [
        (!vtk, mesh.seams.len(), "edges on seams"),
        (!vtk, mesh.displacement.len(), "displacements at the start"),
        (ending == "stl", lines, "lines"),
        (ending == "stl", mesh.groups.len(), "groups"),
    ];
    let parts = parts.into_iter().filter(|(gone, count, _)| *gone && *count > 0);
    let parts: Vec<String> = parts.map(|(_, count, what)| format!("{count} {what}")).collect();
    if parts.is_empty() { Vec::new() } else { vec![format!(".{ending} does not hold {}", parts.join(", "))] }
}

/// A mesh as an unstructured grid of VTK's XML: triangles, then line cells, with the cell array `seam` (1 on seams).
/// Groups are the arrays `group` on cells and points, whose numbers the field arrays `group NAME` and `node group NAME`
/// explain; the start displacement is the point array `start_displacement`. The reader uses them all.
///
/// # Errors
/// When a triangle or an edge names a node that does not exist.
pub fn vtu_text(mesh: &Mesh) -> Result<String, VtuError> {
    vtk_text(mesh, Form::Grid)
}

fn vtk_text(mesh: &Mesh, form: Form) -> Result<String, VtuError> {
    let cells = Cells { points: mesh.nodes.len(), triangles: &mesh.triangles, edges: &mesh.edges };
    let mut seam = vec![0; mesh.triangles.len() + mesh.edges.len()];
    for &edge in &mesh.seams {
        if let Some(cell) = seam.get_mut(mesh.triangles.len() + edge as usize) {
            *cell = 1;
        }
    }
    let groups = GroupNumbers::new(&mesh.groups, [mesh.nodes.len(), mesh.triangles.len(), mesh.edges.len()]);
    let arrays = FixedArrays {
        cell_numbers: groups.cell_array(),
        cell_flags: &[(SEAM, &seam)],
        point_numbers: groups.point_array(),
        point_vectors: (!mesh.displacement.is_empty()).then_some((START_DISPLACEMENT, &mesh.displacement)),
        field: &groups.field_arrays(),
    };
    mesh_text(form, &mesh.nodes, &cells, &arrays)
}
