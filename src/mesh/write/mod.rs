//! Mesh files out: .vtu, .vtp, .msh, .obj, .ply, .stl, .inp, .bdf, .mdpa and .glb.

mod decks;
mod formats;
#[cfg(feature = "gltf")]
mod glb;
mod members;
mod msh;
mod names;
#[cfg(feature = "vtk")]
mod vtk;

pub use formats::obj_text;
#[cfg(feature = "vtk")]
pub use vtk::vtu_text;

use super::{Mesh, MeshError};
use names::{NameRule, Names};
use std::io::Write as _;
use std::path::Path;

/// Writes a mesh; the format follows from the name's extension. An existing file is replaced only with `replace`.
/// Returns sentences for what the format does not hold, and for names of groups that it holds in another form.
///
/// # Errors
/// [`MeshError::Target`] for an unknown extension or an existing file, [`MeshError::File`] for errors of the system.
pub fn write_mesh(mesh: &Mesh, path: &Path, replace: bool) -> Result<Vec<String>, MeshError> {
    let fault = |reason: String| MeshError::File { path: path.to_owned(), reason };
    let refused = |reason: &'static str| MeshError::Target { path: path.to_owned(), reason };
    let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).unwrap_or_default();
    let mut notes = lost(mesh, &ending);
    let mut named = |rule: &NameRule| {
        let Names { written, changed } = Names::new(mesh, rule);
        notes.extend(changed);
        written
    };
    let bytes = match ending.as_str() {
        #[cfg(feature = "vtk")]
        "vtu" => vtu_text(mesh).map_err(|error| fault(error.to_string()))?.into_bytes(),
        #[cfg(feature = "vtk")]
        "vtp" => vtk::vtp_text(mesh).map_err(|error| fault(error.to_string()))?.into_bytes(),
        #[cfg(not(feature = "vtk"))]
        "vtu" | "vtp" => return Err(refused("needs the feature \"vtk\" of this library's build")),
        "msh" => msh::msh_text(mesh, &named(&msh::MSH)).into_bytes(),
        "obj" => formats::obj_named(mesh, &named(&formats::OBJ)).into_bytes(),
        "ply" => formats::ply_text(mesh, &named(&formats::PLY)).into_bytes(),
        "stl" => formats::stl(mesh),
        "inp" => decks::inp_text(mesh, &named(&decks::INP)).into_bytes(),
        "mdpa" => decks::mdpa_text(mesh, &named(&decks::MDPA)).into_bytes(),
        "bdf" => {
            let (text, told) = decks::bdf_text(mesh);
            notes.extend(told);
            text.into_bytes()
        }
        #[cfg(feature = "gltf")]
        "glb" => glb::glb(mesh).map_err(fault)?,
        #[cfg(not(feature = "gltf"))]
        "glb" => return Err(refused("needs the feature \"gltf\" of this library's build")),
        _ => {
            return Err(refused(
                "cannot be written: name an output that ends in .vtu, .vtp, .msh, .obj, .ply, .stl, .inp, .bdf, .mdpa or .glb",
            ));
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
    Ok(notes)
}

/// What a format does not hold.
fn lost(mesh: &Mesh, ending: &str) -> Vec<String> {
    let mut parts: Vec<(usize, &str, &str)> = Vec::new();
    if !["vtu", "vtp"].contains(&ending) {
        parts.push((mesh.seams.len(), "edge", " on seams"));
        parts.push((mesh.displacement.len(), "displacement", " at the start"));
    }
    parts.push((mesh.cut.as_ref().map_or(0, |cut| cut.triangles.len()), "triangle", " as cut flat, of sewn pieces"));
    match ending {
        "stl" => parts.extend([(members::lines(mesh).len(), "line", ""), (mesh.groups.len(), "group", "")]),
        #[cfg(feature = "gltf")]
        "glb" => {
            let of_nodes = mesh.groups.values().filter(|group| !group.nodes.is_empty()).count();
            parts.extend([
                (of_nodes, "group", " of nodes"),
                (glb::unnamed(mesh), "group", " of one part, beyond three"),
            ]);
        }
        _ => {}
    }
    if ["stl", "glb"].contains(&ending) {
        let rounded = mesh.nodes.iter().flatten().filter(|x| f64::from(**x as f32) != **x).count();
        parts.push((rounded, "coordinate", " in double precision"));
    }
    let words = |(count, one, rest)| format!("{count} {one}{}{rest}", if count == 1 { "" } else { "s" });
    let parts: Vec<String> = parts.into_iter().filter(|(count, ..)| *count > 0).map(words).collect();
    if parts.is_empty() { Vec::new() } else { vec![format!(".{ending} does not hold {}", parts.join(", "))] }
}
