//! Mesh files out: .vtu, .vtp, .msh, .obj, .ply and .stl.

mod formats;
mod members;
mod msh;
#[cfg(feature = "vtk")]
mod vtk;

pub use formats::obj_text;
#[cfg(feature = "vtk")]
pub use vtk::vtu_text;

use super::{Mesh, MeshError};
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
        #[cfg(feature = "vtk")]
        "vtu" => vtu_text(mesh).map_err(|error| fault(error.to_string()))?.into_bytes(),
        #[cfg(feature = "vtk")]
        "vtp" => vtk::vtp_text(mesh).map_err(|error| fault(error.to_string()))?.into_bytes(),
        #[cfg(not(feature = "vtk"))]
        "vtu" | "vtp" => return Err(refused("needs the feature \"vtk\" of this library's build")),
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
