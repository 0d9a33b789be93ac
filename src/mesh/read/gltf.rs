//! glTF 2.0, .glb and .gltf with its data inside or in files beside it, by `gltf`: triangles and lines of all meshes,
//! moved by their nodes. Nodes, meshes and materials with names are groups. Corners at one place become one node.
//!
//! Source: Khronos, "glTF 2.0 Specification", and the list of its extensions.

use super::cells::{Cells, IGNORED};
use super::statements::Meaning::{Nothing, Refused};
use super::statements::{LeftOut, Meaning, Statements};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use gltf::mesh::Mode;
use nalgebra::{Matrix4, Point3};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::{Component, Path, PathBuf};

/// Nodes in nodes, at most; files have a tenth of it.
const DEEPEST: usize = 100;

/// What is done with extensions.
const EXTENSIONS: Statements = Statements {
    mark: "",
    list: &[
        (Refused(DRACO), &["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"]),
        (Refused("its positions are whole numbers; export it without quantization"), &["KHR_mesh_quantization"]),
        (Refused("it repeats a mesh; export the instances as meshes"), &["EXT_mesh_gpu_instancing"]),
        (
            Refused("it makes or hides parts of the mesh; export it without"),
            &[
                "MSFT_lod",
                "KHR_node_visibility",
                "KHR_mesh_primitive_restart",
                "MPEG_*",
                "KHR_gaussian*",
                "VRM*",
                "CESIUM_primitive_outline",
            ],
        ),
        (
            Nothing,
            &[
                "KHR_materials_*",
                "KHR_texture_*",
                "KHR_lights_*",
                "KHR_xmp*",
                "EXT_texture_*",
                "EXT_lights_*",
                "KHR_animation_*",
                "KHR_techniques_webgl",
                "EXT_materials_*",
                "KHR_audio*",
                "KHR_physics_*",
                "KHR_node_selectability",
                "KHR_node_hoverability",
                "MSFT_texture_*",
                "MSFT_packing*",
                "ADOBE_materials_*",
                "AGI_*",
                "FB_*",
                "GODOT_*",
                "GRIFFEL_*",
                "KHR_accessor_float64",
                "EXT_mesh_features",
                "EXT_mesh_manifold",
                "EXT_structural_metadata",
                "EXT_instance_features",
            ],
        ),
    ],
};

const DRACO: &str = "Draco and meshopt compression are not read; export it without compression";
/// Most points and corners that a file may have by its own size: nodes may share a mesh.
const MOST_SHARED: usize = 500_000;

/// `folder` is that of the file, if it may have others beside it.
pub(super) fn read(bytes: &[u8], folder: Option<&Path>) -> Result<Cells, String> {
    let damaged = |error: gltf::Error| format!("is not a glTF file: {error}");
    let mut left = LeftOut::default();
    let names = gltf::Gltf::from_slice_without_validation(bytes).map_err(damaged)?;
    for name in names.extensions_required().chain(names.extensions_used()) {
        EXTENSIONS.admit(name, 1, &mut left)?;
        if names.extensions_required().any(|known| known == name) && EXTENSIONS.meaning(name) == Meaning::LeftOut {
            return Err(format!("needs the extension {name}, which is not read; export it without"));
        }
    }
    drop(names);
    let file = gltf::Gltf::from_slice(bytes).map_err(damaged)?;
    check_tree(&file)?;
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
    let most = MOST_SHARED + buffers.iter().map(Vec::len).sum::<usize>() / 2;
    let mut reader = Reader { cells: Cells::of_corners(), buffers, most };
    let scene = file.default_scene().or_else(|| file.scenes().next());
    let scene = scene.ok_or("has no scene, so nothing of it is shown; export its scene")?;
    for node in scene.nodes() {
        reader.node(&node, Matrix4::identity(), 0)?;
    }
    let others = file.scenes().len() - 1;
    if others > 0 {
        reader.cells.notes.push(format!("{others} other scenes than the default one were left out"));
    }
    reader.cells.notes.extend(left.note());
    reader.cells.y_is_up = true;
    Ok(reader.cells)
}

/// Refuses nodes that have two parents: each would double what is below it.
fn check_tree(file: &gltf::Document) -> Result<(), String> {
    let mut parents = vec![0_u8; file.nodes().len()];
    for child in file.nodes().flat_map(|node| node.children().map(|child| child.index()).collect::<Vec<_>>()) {
        match parents.get_mut(child) {
            Some(0) => parents[child] = 1,
            _ => return Err(format!("is damaged: node {child} has two parents; a glTF file is a tree")),
        }
    }
    Ok(())
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
    /// most points and corners
    most: usize,
}

impl Reader {
    fn node(&mut self, node: &gltf::Node<'_>, outer: Matrix4<f64>, depth: usize) -> Result<(), String> {
        if depth > DEEPEST {
            return Err(format!("has nodes more than {DEEPEST} deep"));
        }
        let own = Matrix4::from_fn(|row, column| f64::from(node.transform().matrix()[column][row]));
        let placed = outer * own;
        if let Some(mesh) = node.mesh() {
            if node.skin().is_some() {
                return Err("moves a mesh by a skeleton (skin); apply the armature before the export".to_owned());
            }
            let weights = node.weights().or(mesh.weights()).unwrap_or_default();
            if weights.iter().any(|weight| *weight != 0.0) {
                return Err("moves a mesh by morph targets (shape keys); apply them before the export".to_owned());
            }
            // Primitives may share their points.
            let mut known = HashMap::new();
            for primitive in mesh.primitives() {
                let names = [node.name(), mesh.name(), primitive.material().name()];
                let mut names: Vec<String> = names.into_iter().flatten().map(str::to_owned).collect();
                names.sort_unstable();
                names.dedup();
                self.primitive(&primitive, &placed, &mut known)?;
                self.cells.name_cells(&names);
            }
        }
        node.children().try_for_each(|child| self.node(&child, placed, depth + 1))
    }

    /// Counts points and corners.
    fn count(&mut self, count: usize) -> Result<(), String> {
        self.most =
            self.most.checked_sub(count).ok_or("shares its points between too many meshes; apply the instances")?;
        Ok(())
    }

    /// `known` are the first point and the number of points of each accessor that was read for the node.
    fn primitive(
        &mut self,
        primitive: &gltf::Primitive<'_>,
        placed: &Matrix4<f64>,
        known: &mut HashMap<usize, [usize; 2]>,
    ) -> Result<(), String> {
        let positions = primitive.get(&gltf::Semantic::Positions).ok_or("has a mesh without positions")?;
        if let Entry::Vacant(entry) = known.entry(positions.index()) {
            self.count(positions.count())?;
            let reader = primitive.reader(|buffer| self.buffers.get(buffer.index()).map(Vec::as_slice));
            let places: Vec<[f32; 3]> = reader.read_positions().ok_or("has a mesh without positions")?.collect();
            let moved =
                |p: [f32; 3]| -> [f64; 3] { placed.transform_point(&Point3::from(p.map(f64::from))).coords.into() };
            entry.insert([self.cells.points.len(), places.len()]);
            self.cells.points.extend(places.into_iter().map(moved));
        }
        let [first, count] = known[&positions.index()].map(|n| n as u64);
        self.count(primitive.indices().map_or(count as usize, |indices| indices.count()))?;
        let reader = primitive.reader(|buffer| self.buffers.get(buffer.index()).map(Vec::as_slice));
        let indices: Vec<u64> = match reader.read_indices() {
            Some(list) => list.into_u32().map(|n| first + u64::from(n)).collect(),
            None => (first..first + count).collect(),
        };
        // A mirror turns the winding.
        let mirrored = placed.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        let face =
            |cells: &mut Cells, [a, b, c]: [u64; 3]| cells.add_face(&if mirrored { [a, c, b] } else { [a, b, c] });
        match primitive.mode() {
            Mode::Triangles => indices.as_chunks::<3>().0.iter().for_each(|t| face(&mut self.cells, *t)),
            Mode::TriangleStrip => indices.windows(3).enumerate().for_each(|(i, t)| {
                face(&mut self.cells, if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] });
            }),
            Mode::TriangleFan => {
                let (hub, rim) = indices.split_first().ok_or("has a fan without triangles")?;
                rim.windows(2).for_each(|pair| face(&mut self.cells, [*hub, pair[0], pair[1]]));
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
