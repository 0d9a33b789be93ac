//! .vtu and .vtp out.

use crate::Mesh;
use crate::group::GroupNumbers;
use crate::read::{SEAM, START_DISPLACEMENT};
use crate::vtk::write::{Cells, FixedArrays, VtuError};
use crate::vtk::write_mesh::{Form, mesh_text};

/// A mesh as an unstructured grid of VTK's XML: triangles, then line cells, with the cell array `seam` (1 on seams).
/// Groups are the arrays `group` on cells and points, whose numbers the field arrays `group NAME` and `node group NAME`
/// explain; the start displacement is the point array `start_displacement`. The reader uses them all.
///
/// # Errors
/// When a triangle or an edge names a node that does not exist.
pub fn vtu_text(mesh: &Mesh) -> Result<String, VtuError> {
    text(mesh, Form::Grid)
}

/// The same as polygons and lines, .vtp.
pub(super) fn vtp_text(mesh: &Mesh) -> Result<String, VtuError> {
    text(mesh, Form::Polygons)
}

fn text(mesh: &Mesh, form: Form) -> Result<String, VtuError> {
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
