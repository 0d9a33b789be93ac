//! glTF 2.0, .glb and .gltf with its data inside, by `gltf`: triangles and lines of all meshes, moved by their nodes.
//! Nodes, meshes and materials with names are groups. Corners at one place become one node.

use super::cells::{Cells, IGNORED};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use gltf::mesh::Mode;
use nalgebra::{Matrix4, Point3};

/// Nodes in nodes, at most; files have a tenth of it.
const DEEPEST: usize = 100;

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let file = gltf::Gltf::from_slice(bytes).map_err(|error| format!("is not a glTF file: {error}"))?;
    let mut buffers = Vec::new();
    for buffer in file.buffers() {
        let data = match buffer.source() {
            gltf::buffer::Source::Bin => file.blob.clone().ok_or("lacks its binary part")?,
            gltf::buffer::Source::Uri(uri) => match uri.split_once(";base64,") {
                Some((_, text)) => STANDARD.decode(text).map_err(|error| format!("has a damaged buffer: {error}"))?,
                None => return Err(format!("has its data in the file \"{uri}\"; save it as .glb, in one file")),
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
