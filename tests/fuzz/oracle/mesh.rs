//! What must hold of any bytes as a mesh file: refused with a sentence, or a mesh that can be used and written.

use canopy_fem::mesh::read::{Imported, file_from_bytes, formats, mesh_from_bytes};
use canopy_fem::mesh::write::{obj_text, vtu_text};
use canopy_fem::mesh::{EdgeKind, Mesh, MeshFile, Quality, Topology};
use std::path::Path;

/// Gives the bytes to every reader.
///
/// # Errors
/// What does not hold.
pub fn judge(bytes: &[u8]) -> Result<(), String> {
    // Outlines of a drawing are filled.
    let wanted = MeshFile { edge: Some(0.3), ..MeshFile::plain("") };
    for ending in formats().filter_map(|endings| endings.first()) {
        let name = &*format!("fuzz.{ending}");
        match file_from_bytes(&wanted, Path::new(name), bytes) {
            Ok(Imported { mesh, notes, .. }) => {
                if notes.iter().any(|note| note.split_whitespace().count() < 3) {
                    return Err(format!("{name}: notes without a sentence: {notes:?}"));
                }
                usable(&mesh).map_err(|why| format!("{name}: {why}"))?;
                comes_back(&mesh).map_err(|why| format!("{name}: {why}"))?;
            }
            Err(error) => {
                let words = error.to_string();
                if !words.starts_with(name) || words.split_whitespace().count() < 4 {
                    return Err(format!("{name}: refused with \"{words}\""));
                }
            }
        }
    }
    Ok(())
}

fn usable(mesh: &Mesh) -> Result<(), String> {
    mesh.check().map_err(|error| format!("read, but {error}"))?;
    let topology = Topology::new(mesh).map_err(|error| format!("checked, but {error}"))?;
    let kinds = (0..mesh.edges.len()).map(|e| topology.edge_kind(e));
    let lines = kinds.filter(|kind| *kind == EdgeKind::Line).count();
    let interior = 2 * mesh.edges.len() - 2 * lines;
    if mesh.triangles.is_empty() != (interior == 0) {
        return Err(format!("{} triangles, but {lines} of {} edges are lines", mesh.triangles.len(), mesh.edges.len()));
    }
    // Either answer is right; both must come.
    let _ = (topology.check_manifold(), topology.check_orientation(mesh));
    let quality = Quality::with_topology(mesh, &topology);
    let angles = [quality.min_angle, quality.mean_min_angle, quality.max_angle];
    if !mesh.triangles.is_empty() && !angles.iter().all(|a| (0.0..=180.0).contains(a)) {
        return Err(format!("angles {angles:?}"));
    }
    let ordered = quality.min_edge >= 0.0 && quality.min_edge <= quality.max_edge;
    if !(mesh.edges.is_empty() || ordered) {
        return Err(format!("edges of {} m to {} m", quality.min_edge, quality.max_edge));
    }
    Ok(())
}

fn comes_back(mesh: &Mesh) -> Result<(), String> {
    let back = |name: &str, text: String| {
        let imported = mesh_from_bytes(Path::new(name), text.as_bytes());
        imported.map(|i| i.mesh).map_err(|error| format!("written, but {error}"))
    };
    let text = vtu_text(mesh).map_err(|error| format!("read, but not written: {error}"))?;
    if back("back.vtu", text)? != *mesh {
        return Err("another mesh comes back from .vtu".to_owned());
    }
    let other = back("back.obj", obj_text(mesh))?;
    if (&other.nodes, &other.triangles, sorted(&other)) != (&mesh.nodes, &mesh.triangles, sorted(mesh)) {
        return Err("another mesh comes back from .obj".to_owned());
    }
    Ok(())
}

fn sorted(mesh: &Mesh) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = mesh.edges.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    edges
}
