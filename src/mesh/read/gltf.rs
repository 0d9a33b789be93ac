//! glTF 2.0, .glb and .gltf with its data inside or in files beside it, by `gltf`: triangles and lines of all meshes,
//! moved by their nodes. Nodes, meshes and materials with names are groups. Corners at one place become one node.

use super::cells::{Cells, IGNORED};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use gltf::mesh::Mode;
use nalgebra::{Matrix4, Point3};
use std::path::{Component, Path, PathBuf};

/// Nodes in nodes, at most; files have a tenth of it.
const DEEPEST: usize = 100;

/// `folder` is that of the file, if it may have others beside it.
pub(super) fn read(bytes: &[u8], folder: Option<&Path>) -> Result<Cells, String> {
    let file = gltf::Gltf::from_slice(bytes).map_err(|error| format!("is not a glTF file: {error}"))?;
    let mut buffers = Vec::new();
    for buffer in file.buffers() {
        let data = match buffer.source() {
            gltf::buffer::Source::Bin => file.blob.clone().ok_or("lacks its binary part")?,
            gltf::buffer::Source::Uri(uri) => match uri.split_once(";base64,") {
                Some((_, text)) => STANDARD.decode(text).map_err(|error| format!("has a damaged buffer: {error}"))?,
                None => beside(uri, folder)?,
            },
        };
        if data.len() < buffer.length() {
            return Err(format!("is cut off: a buffer has {} of {} bytes", data.len(), buffer.length()));
        }
        buffers.push(data);
    }
    let mut reader = Reader { cells: Cells::of_corners(), buffers };
    for scene in file.scenes() {
        for node in scene.nodes() {
            reader.node(&node, Matrix4::identity(), 0)?;
        }
    }
    Ok(reader.cells)
}

/// The bytes of a file that is named relative to the folder, and lies in it or below.
fn beside(uri: &str, folder: Option<&Path>) -> Result<Vec<u8>, String> {
    let one_file = "save it as .glb, in one file";
    let name = unescaped(uri);
    let below = name.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    let folder = folder.filter(|_| below && !uri.contains(':'));
    let path = folder.ok_or_else(|| format!("has its data in the file \"{uri}\"; {one_file}"))?.join(name);
    let shown = path.display();
    crate::input_file::read(&path)
        .map_err(|error| format!("has its data in the file \"{shown}\", which cannot be read: {error}; {one_file}"))
}

/// A relative address as a path: %20 is a blank.
fn unescaped(uri: &str) -> PathBuf {
    let (mut bytes, mut rest) = (Vec::new(), uri.as_bytes());
    while let [first, after @ ..] = rest {
        let digits = after.get(..2).filter(|_| *first == b'%').and_then(|two| std::str::from_utf8(two).ok());
        let sign = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        bytes.push(sign.unwrap_or(*first));
        rest = if sign.is_some() { &after[2..] } else { after };
    }
    PathBuf::from(String::from_utf8_lossy(&bytes).into_owned())
}

struct Reader {
    cells: Cells,
    buffers: Vec<Vec<u8>>,
}

impl Reader {
    fn node(&mut self, node: &gltf::Node<'_>, outer: Matrix4<f64>, depth: usize) -> Result<(), String> {
        if depth > DEEPEST {
            return Err(format!("has nodes more than {DEEPEST} deep"));
        }
        let own = Matrix4::from_fn(|row, column| f64::from(node.transform().matrix()[column][row]));
        let placed = outer * own;
        if let Some(mesh) = node.mesh() {
            for primitive in mesh.primitives() {
                let names = [node.name(), mesh.name(), primitive.material().name()];
                let mut names: Vec<String> = names.into_iter().flatten().map(str::to_owned).collect();
                names.sort_unstable();
                names.dedup();
                self.primitive(&primitive, &placed)?;
                self.cells.name_cells(&names);
            }
        }
        node.children().try_for_each(|child| self.node(&child, placed, depth + 1))
    }

    fn primitive(&mut self, primitive: &gltf::Primitive<'_>, placed: &Matrix4<f64>) -> Result<(), String> {
        let reader = primitive.reader(|buffer| self.buffers.get(buffer.index()).map(Vec::as_slice));
        let first = self.cells.points.len() as u64;
        let places: Vec<[f32; 3]> = reader.read_positions().ok_or("has a mesh without positions")?.collect();
        let indices: Vec<u64> = match reader.read_indices() {
            Some(list) => list.into_u32().map(|n| first + u64::from(n)).collect(),
            None => (first..first + places.len() as u64).collect(),
        };
        let moved = |p: [f32; 3]| -> [f64; 3] { placed.transform_point(&Point3::from(p.map(f64::from))).coords.into() };
        self.cells.points.extend(places.into_iter().map(moved));
        match primitive.mode() {
            Mode::Triangles => indices.as_chunks::<3>().0.iter().for_each(|t| self.cells.add_face(t)),
            Mode::TriangleStrip => self.cells.add_strip(&indices),
            Mode::TriangleFan => {
                let (hub, rim) = indices.split_first().ok_or("has a fan without triangles")?;
                rim.windows(2).for_each(|pair| self.cells.add_face(&[*hub, pair[0], pair[1]]));
            }
            Mode::Lines => indices.as_chunks::<2>().0.iter().for_each(|pair| self.cells.add_line(pair, false)),
            Mode::LineStrip => self.cells.add_line(&indices, false),
            Mode::LineLoop => {
                self.cells.add_line(&indices, false);
                if let [first, .., last] = indices[..] {
                    self.cells.add_line(&[last, first], false);
                }
            }
            Mode::Points => self.cells.remark(IGNORED),
        }
        Ok(())
    }
}
