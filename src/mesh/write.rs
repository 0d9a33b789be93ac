//! Mesh files out: .vtu and .obj.

use super::group::GroupNumbers;
use super::read::{SEAM, START_DISPLACEMENT};
use super::{Mesh, MeshError};
use crate::vtk::write::{Cells, FixedArrays, VtuError, inline_grid};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

/// Writes a mesh; the format follows from the name's extension. An existing file is replaced only with `replace`.
///
/// # Errors
/// [`MeshError::Target`] for an unknown extension or an existing file, [`MeshError::File`] for errors of the system.
pub fn write_mesh(mesh: &Mesh, path: &Path, replace: bool) -> Result<(), MeshError> {
    let fault = |reason: String| MeshError::File { path: path.to_owned(), reason };
    let refused = |reason: &'static str| MeshError::Target { path: path.to_owned(), reason };
    let text = match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("vtu") => vtu_text(mesh).map_err(|error| fault(error.to_string()))?,
        Some("obj") => obj_text(mesh),
        _ => return Err(refused("cannot be written: name an output that ends in .vtu or .obj")),
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
    file.write_all(text.as_bytes()).map_err(|error| fault(format!("cannot be written: {error}")))
}

/// A mesh as VTK XML: triangles, then line cells, with the cell array `seam` (1 on seams). Groups are the arrays
/// `group` on cells and points, whose numbers the field arrays `group NAME` and `node group NAME` explain; the start
/// displacement is the point array `start_displacement`. The reader uses them all.
///
/// # Errors
/// When a triangle or an edge names a node that does not exist.
pub fn vtu_text(mesh: &Mesh) -> Result<String, VtuError> {
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
    inline_grid(&mesh.nodes, &cells, &arrays)
}

/// A mesh as Wavefront .obj; lines only for edges that are no triangle's; seams, groups and the start displacement are
/// not kept.
pub fn obj_text(mesh: &Mesh) -> String {
    let mut text = String::from("# canopy-fem\n");
    let sides = super::topology::unique_edges(&mesh.triangles);
    // Writing to a String cannot fail; floats print the shortest digits that read back exactly.
    for [x, y, z] in &mesh.nodes {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for &[a, b] in mesh.edges.iter().filter(|&&[a, b]| sides.binary_search(&[a.min(b), a.max(b)]).is_err()) {
        let _ = writeln!(text, "l {} {}", u64::from(a) + 1, u64::from(b) + 1);
    }
    for &[a, b, c] in &mesh.triangles {
        let _ = writeln!(text, "f {} {} {}", u64::from(a) + 1, u64::from(b) + 1, u64::from(c) + 1);
    }
    text
}
