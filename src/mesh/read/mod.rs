//! Mesh files in, one file a format. A frame of a run is a mesh too: its nodes have their positions at that time.
//!
//! Line cells become edges first, in file order; the triangles' edges that are not among them follow, sorted by their
//! nodes. Quads are cut along their first diagonal, or the second where the first is not inside. Nodes that no line or
//! triangle uses (such as Gmsh's arc centres) are dropped, and the rest keep their order: a node without mass could not
//! move.
//!
//! Named parts of the file become groups; a line on the side of a triangle names that edge.

// Readers whose features are off leave some of what they share unused.
#![cfg_attr(not(all(feature = "gltf", feature = "ply", feature = "vtk")), allow(dead_code))]

mod assemble;
mod bdf;
mod cells;
mod divide;
mod dxf;
mod fill;
#[cfg(feature = "gltf")]
mod gltf;
mod inp;
mod keyword;
mod labels;
mod marks;
mod mdpa;
mod merge;
mod msh;
mod obj;
mod off;
mod offset;
mod once;
mod piece;
mod pieces;
#[cfg(feature = "ply")]
mod ply;
mod polygon;
mod statements;
mod stl;
mod text;
mod unit;
#[cfg(feature = "vtk")]
mod vtk;

use super::file::{Axes, y_up};
use super::sew::sew;
use super::{Mesh, MeshError, MeshFile};
pub(super) use assemble::extent;
use cells::Cells;
pub(super) use merge::joined;
use std::path::Path;

/// Name of the cell array of a .vtu file that marks seams.
pub(super) const SEAM: &str = "seam";
/// Name of the point array of a .vtu file with the displacement at the start.
pub(super) const START_DISPLACEMENT: &str = "start_displacement";
/// Whole numbers of a .ply file that mark no part.
pub(super) const PLY_NO_MARKS: [&str; 7] = ["red", "green", "blue", "alpha", "flags", "quality", "intensity"];

/// A mesh read from a file, and what the reader changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// the mesh; it has passed [`Mesh::check`]
    pub mesh: Mesh,
    /// one sentence for every change or omission
    pub notes: Vec<String>,
    /// one sentence for every repair that was asked for
    pub repairs: Vec<String>,
}

/// Reads a mesh file and takes the mesh as it is; the format follows from the name's extension.
///
/// # Errors
/// [`MeshError::File`] with the file's name and the reason.
pub fn read_mesh(path: &Path) -> Result<Imported, MeshError> {
    read_file(&MeshFile::plain(""), &[path])
}

/// The same for the bytes of a file that are already in memory; `path` gives the format, and the name in messages. No
/// other file is opened.
///
/// # Errors
/// As [`read_mesh`], except for reading the file.
pub fn mesh_from_bytes(path: &Path, bytes: &[u8]) -> Result<Imported, MeshError> {
    file_from_bytes(&MeshFile::plain(""), path, bytes)
}

/// The same, placed and repaired as `wanted`, whose file names are not used.
///
/// # Errors
/// As [`mesh_from_bytes`].
pub fn file_from_bytes(wanted: &MeshFile, path: &Path, bytes: &[u8]) -> Result<Imported, MeshError> {
    finish(cells_of(wanted, path, bytes, None)?, wanted, path)
}

/// Reads files as one mesh, placed and repaired as `wanted`; messages name the first of them.
pub(super) fn read_file(wanted: &MeshFile, paths: &[&Path]) -> Result<Imported, MeshError> {
    let mut all = Cells::default();
    for (number, path) in paths.iter().enumerate() {
        // A format that is not read is told before the file is opened.
        reader(path)?;
        let fault = |error: std::io::Error| MeshError::File {
            path: path.to_path_buf(),
            reason: format!("cannot be read: {error}"),
        };
        let cells = cells_of(wanted, path, &crate::input_file::read(path).map_err(fault)?, path.parent())?;
        if number == 0 { all = cells } else { all.append(cells) }
    }
    finish(all, wanted, paths.first().copied().unwrap_or(Path::new("")))
}

/// Points and cells of a file; the cells name its own points only. `folder` is where files beside it lie.
fn cells_of(wanted: &MeshFile, path: &Path, bytes: &[u8], folder: Option<&Path>) -> Result<Cells, MeshError> {
    let reader = reader(path)?;
    let read = || match reader {
        Reader::Alone(read) => read(bytes),
        Reader::WithOthers(read) => read(bytes, folder),
        Reader::ByEdge(read) => read(bytes, wanted),
    };
    // A panic of a parsing library on a damaged file must not end the program.
    let cells = std::panic::catch_unwind(read)
        .unwrap_or_else(|_| Err("is damaged; the parser gave up on it. Write it anew".to_owned()));
    let cells = cells.and_then(|mut cells| {
        cells.check_points()?;
        let named = unit::of_comments(bytes).filter(|_| cells.unit.is_none());
        cells.follow_header(wanted);
        if let Some((name, length)) = named.filter(|(_, length)| *length != 1.0 && wanted.scale.is_none()) {
            cells
                .notes
                .push(format!("a comment gives its lengths in {name}: --scale {length}, or \"scale\" in a case"));
        }
        Ok(cells)
    });
    cells.map_err(|reason| MeshError::File { path: path.to_owned(), reason })
}

fn finish(mut cells: Cells, wanted: &MeshFile, path: &Path) -> Result<Imported, MeshError> {
    let fault = |reason: String| MeshError::File { path: path.to_owned(), reason };
    wanted.place(&mut cells.points, &mut cells.displacement);
    let sewing = if wanted.sew.is_empty() { None } else { Some(cells.lay_out(wanted)?) };
    let mut imported = cells.into_mesh(wanted).map_err(fault)?;
    if let Some(sewing) = sewing {
        imported.repairs.extend(sew(&mut imported.mesh, &wanted.sew, &sewing)?);
        wanted.translate(&mut imported.mesh.nodes);
        imported.mesh.check().map_err(|error| fault(error.to_string()))?;
    }
    Ok(imported)
}

impl Cells {
    /// Follows what the file itself says of its unit and its axes, unless the user says otherwise.
    fn follow_header(&mut self, wanted: &MeshFile) {
        if let Some((name, length)) = self.unit.take() {
            match wanted.scale {
                None if length != 1.0 => {
                    self.points.as_flattened_mut().iter_mut().for_each(|x| *x *= length);
                    self.notes.push(format!("its header gives lengths in {name}, so they were scaled by {length}"));
                }
                Some(scale) if (scale / length - 1.0).abs() > 1e-3 => self.notes.push(format!(
                    "its header gives lengths in {name} ({length} m), but the scale that is asked for is {scale}"
                )),
                _ => {}
            }
        }
        if std::mem::take(&mut self.y_is_up) && wanted.axes == Axes::Auto {
            self.points.iter_mut().for_each(|p| *p = y_up(p[0], p[1], p[2]));
            self.notes.push("its y axis, which is up in glTF, was turned up; \"z-up\" leaves it".to_owned());
        }
    }
}

/// What makes points and cells of the bytes of a file.
#[derive(Clone, Copy)]
enum Reader {
    Alone(fn(&[u8]) -> Result<Cells, String>),
    /// also of files in the folder that is given
    WithOthers(fn(&[u8], Option<&Path>) -> Result<Cells, String>),
    /// curves by the length of edges that is wanted
    ByEdge(fn(&[u8], &MeshFile) -> Result<Cells, String>),
}

/// The reader of a file's format.
fn reader(path: &Path) -> Result<Reader, MeshError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let known = FORMATS.iter().find(|(endings, _)| endings.contains(&extension.as_str()));
    #[cfg(feature = "vtk")]
    if LISTS.contains(&extension.as_str()) {
        return Ok(Reader::Alone(vtk::read_list));
    }
    known.map(|(_, reader)| *reader).ok_or_else(|| {
        let reason = match extension.as_str() {
            "" => "the name has no extension that says its format".to_owned(),
            other => match feature(other) {
                Some(feature) => format!("files \".{other}\" need the feature \"{feature}\", which this build lacks"),
                None => format!("files \".{other}\" are not read"),
            },
        };
        let reason = format!("{reason}; read are {}{}", endings(), converter(path, &extension));
        MeshError::File { path: path.to_owned(), reason }
    })
}

/// The feature that reads a format whose libraries a program can do without.
fn feature(extension: &str) -> Option<&'static str> {
    match extension {
        "vtu" | "vtp" | "vtk" => Some("vtk"),
        "ply" => Some("ply"),
        "gltf" | "glb" => Some("gltf"),
        _ => None,
    }
}

/// The formats by the endings of their names.
const FORMATS: &[(&[&str], Reader)] = &[
    #[cfg(feature = "vtk")]
    (&["vtu", "vtp", "vtk"], Reader::Alone(vtk::read)),
    (&["msh"], Reader::Alone(msh::read)),
    (&["obj"], Reader::Alone(obj::read)),
    (&["stl"], Reader::Alone(stl::read)),
    #[cfg(feature = "ply")]
    (&["ply"], Reader::Alone(ply::read)),
    (&["off"], Reader::Alone(off::read)),
    (&["inp"], Reader::Alone(inp::read)),
    (&["k", "key", "dyn"], Reader::Alone(keyword::read)),
    (&["bdf", "nas", "fem", "dat"], Reader::Alone(bdf::read)),
    (&["mdpa"], Reader::Alone(mdpa::read)),
    (&["dxf"], Reader::ByEdge(dxf::read)),
    #[cfg(feature = "gltf")]
    (&["gltf", "glb"], Reader::WithOthers(gltf::read)),
];

/// Endings of files that list others, which are refused with the names of those.
#[cfg(feature = "vtk")]
const LISTS: &[&str] = &["pvd", "pvtu", "pvtp", "vtm", "vtmb"];

/// Most nodes and elements that statements of a file may make of others.
const MOST_MADE: u64 = 300_000;
/// Most members that all groups of a file may have, beyond four for each cell.
const MOST_MEMBERS: u64 = 3_000_000;

/// The formats that are read, each by the endings of its names.
pub fn formats() -> impl Iterator<Item = &'static [&'static str]> {
    FORMATS.iter().map(|(endings, _)| *endings)
}

/// The endings of the formats that are read: ".vtu, .vtp, ...".
pub fn endings() -> String {
    formats().flatten().map(|ending| format!(".{ending}")).collect::<Vec<_>>().join(", ")
}

/// The program that writes a file of this extension as one that is read, and its command.
fn converter(path: &Path, extension: &str) -> String {
    let to = |ending: &str| path.with_extension(ending).display().to_string();
    let from = path.display();
    match extension {
        // Readers of meshio 5.
        "avs" | "med" | "e" | "exo" | "ex2" | "xdmf" | "xmf" | "mesh" | "meshb" | "tec" | "su2" | "vol" | "xml"
        | "node" | "ele" | "f3grid" | "post" | "ugrid" | "h5m" | "wkt" | "cgns" => {
            format!(": `meshio convert {from} {}` writes one", to("vtu"))
        }
        "geo" | "step" | "stp" | "iges" | "igs" | "brep" => {
            format!(": `gmsh -2 {from} -o {}` makes a mesh of its surfaces", to("msh"))
        }
        "unv" | "p3d" => format!(": `gmsh -save {from} -o {}` writes one", to("msh")),
        "fbx" | "dae" | "3ds" | "x3d" | "wrl" | "3mf" => format!(": `assimp export {from} {}` writes one", to("glb")),
        "blend" => ": open it in Blender, and export it as .glb or .obj".to_owned(),
        "dwg" | "sldprt" | "fcstd" | "3dm" => {
            ": open it in a CAD program such as FreeCAD, and export it as .dxf, .obj or .stl".to_owned()
        }
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::{FORMATS, feature, mesh_from_bytes};
    use std::path::Path;

    /// A format is read or names the feature that this build lacks.
    #[test]
    fn formats_without_their_feature_are_refused_by_its_name() {
        for ending in ["vtu", "vtp", "vtk", "ply", "gltf", "glb"] {
            let name = feature(ending).expect("a feature");
            let error = mesh_from_bytes(Path::new(&format!("net.{ending}")), b"").expect_err("no mesh").to_string();
            let on = FORMATS.iter().any(|(endings, _)| endings.contains(&ending));
            assert_eq!(error.contains(&format!("need the feature \"{name}\"")), !on, "{error}");
        }
    }
}
