//! Mesh files out: .vtu and .obj.

use super::{Mesh, MeshError};
use base64::Engine as _;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

/// Writes a mesh; the format follows from the name's extension. A file of that name is replaced only with `replace`.
///
/// # Errors
/// [`MeshError::Target`] for a name of no known kind or a file that is there, [`MeshError::File`] where the system
/// refuses.
pub fn write_mesh(mesh: &Mesh, path: &Path, replace: bool) -> Result<(), MeshError> {
    let fault = |reason: String| MeshError::File { path: path.to_owned(), reason };
    let refused = |reason: &'static str| MeshError::Target { path: path.to_owned(), reason };
    let text = match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("vtu") => vtu_text(mesh),
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

/// A mesh as VTK XML: triangles, then line cells, with the cell array `seam` (1 on seams) that the reader honours.
///
/// Data is inline base64: as exact as raw data, and readable by every VTK and by [`super::read`].
pub fn vtu_text(mesh: &Mesh) -> String {
    let cells = mesh.triangles.len() + mesh.edges.len();
    let nodes = mesh.triangles.iter().flatten().chain(mesh.edges.iter().flatten());
    let triangle_ends = (1..=mesh.triangles.len()).map(|i| 3 * i);
    let line_ends = (1..=mesh.edges.len()).map(|i| 3 * mesh.triangles.len() + 2 * i);
    let kinds = mesh.triangles.iter().map(|_| 5).chain(mesh.edges.iter().map(|_| 3));
    let mut seam = vec![0_u8; cells];
    for &edge in &mesh.seams {
        if let Some(cell) = seam.get_mut(mesh.triangles.len() + edge as usize) {
            *cell = 1;
        }
    }
    let points = array("Float64", "points", 3, bytes(mesh.nodes.iter().flatten(), |c| c.to_le_bytes()));
    let connectivity = array("Int64", "connectivity", 1, bytes(nodes, |&n| i64::from(n).to_le_bytes()));
    let offsets = array("Int64", "offsets", 1, bytes(triangle_ends.chain(line_ends), |n| (n as i64).to_le_bytes()));
    let types = array("UInt8", "types", 1, kinds.collect());
    let seam = array("UInt8", "seam", 1, seam);
    format!(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{cells}\">\n\
         <Points>\n{points}</Points>\n<Cells>\n{connectivity}{offsets}{types}</Cells>\n\
         <CellData>\n{seam}</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n",
        mesh.nodes.len()
    )
}

fn bytes<T, const N: usize>(values: impl Iterator<Item = T>, encode: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    values.flat_map(encode).collect()
}

/// A data array: its length in bytes as one 64-bit word, then the data, together in base64.
fn array(kind: &str, name: &str, components: usize, data: Vec<u8>) -> String {
    let mut all = (data.len() as u64).to_le_bytes().to_vec();
    all.extend(data);
    let encoded = base64::engine::general_purpose::STANDARD.encode(all);
    format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">{encoded}</DataArray>\n"
    )
}

/// A mesh as Wavefront .obj; lines only for edges that are no triangle's, seams are not kept.
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
