//! A mesh as glTF 2.0 in one binary file, .glb: what Blender and other programs of pictures read.

use super::members::{groups_of, lines};
use crate::Mesh;
use gltf::binary::{Glb, Header};
use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::buffer::{Target, View};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::{Checked, USize64};
use gltf::json::{Accessor, Buffer, Index, Material, Node, Root, Scene, Value};
use std::collections::BTreeMap;

/// Groups that a part can name: by its material, its node and its mesh.
const NAMED: usize = 3;

/// Triangles and lines of the same groups are one part. The largest of its groups is its material, the smallest its
/// node, and one between its mesh. Places are in single precision, with +Y up as the format asks for: (x, z, -y). After
/// the glTF 2.0 specification of the Khronos Group.
///
/// # Errors
/// What the library refuses: a file of more than 4 GiB.
pub(super) fn glb(mesh: &Mesh) -> Result<Vec<u8>, String> {
    let mut file = File::new(mesh);
    let (triangles, bars) = cells_by_groups(mesh);
    for (groups, corners) in &triangles {
        file.part(groups, corners.as_flattened(), Mode::Triangles);
    }
    for (groups, ends) in &bars {
        file.part(groups, ends.as_flattened(), Mode::Lines);
    }
    file.finish()
}

/// Groups of cells beyond those that a part can name.
pub(super) fn unnamed(mesh: &Mesh) -> usize {
    let triangles = groups_of(mesh, mesh.triangles.len(), |group| &group.triangles);
    let edges = groups_of(mesh, mesh.edges.len(), |group| &group.edges);
    triangles.iter().chain(&edges).map(|groups| groups.len().saturating_sub(NAMED)).max().unwrap_or(0)
}

/// Triangles and lines by the groups that they are in.
#[expect(clippy::type_complexity)]
fn cells_by_groups(mesh: &Mesh) -> (BTreeMap<Vec<usize>, Vec<[u32; 3]>>, BTreeMap<Vec<usize>, Vec<[u32; 2]>>) {
    let mut triangles: BTreeMap<Vec<usize>, Vec<[u32; 3]>> = BTreeMap::new();
    let groups = groups_of(mesh, mesh.triangles.len(), |group| &group.triangles);
    for (groups, corners) in groups.into_iter().zip(&mesh.triangles) {
        triangles.entry(groups).or_default().push(*corners);
    }
    let mut bars: BTreeMap<Vec<usize>, Vec<[u32; 2]>> = BTreeMap::new();
    let groups = groups_of(mesh, mesh.edges.len(), |group| &group.edges);
    for edge in lines(mesh) {
        bars.entry(groups[edge as usize].clone()).or_default().push(mesh.edges[edge as usize]);
    }
    (triangles, bars)
}

/// A file in the making.
struct File<'a> {
    mesh: &'a Mesh,
    /// names of groups, and how many cells each has
    groups: Vec<(&'a str, usize)>,
    root: Root,
    binary: Vec<u8>,
    materials: BTreeMap<&'a str, Index<Material>>,
}

impl<'a> File<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        let sizes = mesh.groups.iter().map(|(name, group)| (name.as_str(), group.triangles.len() + group.edges.len()));
        let groups = sizes.collect();
        File { mesh, groups, root: Root::default(), binary: Vec::new(), materials: BTreeMap::new() }
    }

    /// The names of some groups, from the largest to the smallest.
    fn named(&self, groups: &[usize]) -> Vec<&'a str> {
        let mut named: Vec<(&str, usize)> =
            groups.iter().filter_map(|&group| self.groups.get(group).copied()).collect();
        named.sort_by_key(|(name, size)| (usize::MAX - size, *name));
        named.into_iter().map(|(name, _)| name).collect()
    }

    /// Cells of the same groups, by the numbers of their nodes.
    fn part(&mut self, groups: &[usize], corners: &[u32], mode: Mode) {
        let named = self.named(groups);
        let mut used: Vec<u32> = corners.to_vec();
        used.sort_unstable();
        used.dedup();
        let places: Vec<[f32; 3]> = used.iter().map(|&node| upright(self.mesh.nodes[node as usize])).collect();
        let indices = corners.iter().map(|node| used.binary_search(node).unwrap_or_default() as u32);
        let indices: Vec<u8> = indices.flat_map(u32::to_le_bytes).collect();
        let bounds = |pick: fn(f32, f32) -> f32| {
            let start = places.first().copied().unwrap_or_default();
            let bound = places.iter().fold(start, |a, b| std::array::from_fn(|axis| pick(a[axis], b[axis])));
            Some(Value::from(bound.to_vec()))
        };
        let bytes: Vec<u8> = places.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let positions = Accessor {
            min: bounds(f32::min),
            max: bounds(f32::max),
            ..self.accessor((&bytes, Target::ArrayBuffer), places.len(), (ComponentType::F32, Type::Vec3))
        };
        let positions = self.root.push(positions);
        let indices =
            self.accessor((&indices, Target::ElementArrayBuffer), corners.len(), (ComponentType::U32, Type::Scalar));
        let primitive = Primitive {
            attributes: BTreeMap::from([(Checked::Valid(Semantic::Positions), positions)]),
            indices: Some(self.root.push(indices)),
            material: named.first().map(|name| self.material(name)),
            mode: Checked::Valid(mode),
            extensions: None,
            extras: Default::default(),
            targets: None,
        };
        let owned = |name: Option<&&str>| name.map(|name| (*name).to_owned());
        let mesh = gltf::json::Mesh {
            name: owned(named.get(1).filter(|_| named.len() > 2)),
            primitives: vec![primitive],
            extensions: None,
            extras: Default::default(),
            weights: None,
        };
        let mesh = Some(self.root.push(mesh));
        let name = owned(named.last().filter(|_| named.len() > 1));
        self.root.push(Node { name, mesh, ..Node::default() });
    }

    /// The material of a group, seen from both sides.
    fn material(&mut self, name: &'a str) -> Index<Material> {
        let root = &mut self.root;
        let new = || root.push(Material { name: Some(name.to_owned()), double_sided: true, ..Material::default() });
        *self.materials.entry(name).or_insert_with(new)
    }

    /// Appends an array of `count` members to the binary part.
    fn accessor(&mut self, (bytes, target): (&[u8], Target), count: usize, kind: (ComponentType, Type)) -> Accessor {
        let view = self.root.push(View {
            buffer: Index::new(0),
            byte_length: USize64::from(bytes.len()),
            byte_offset: Some(USize64::from(self.binary.len())),
            byte_stride: None,
            name: None,
            target: Some(Checked::Valid(target)),
            extensions: None,
            extras: Default::default(),
        });
        self.binary.extend(bytes);
        Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            count: USize64::from(count),
            component_type: Checked::Valid(GenericComponentType(kind.0)),
            type_: Checked::Valid(kind.1),
            min: None,
            max: None,
            name: None,
            normalized: false,
            sparse: None,
            extensions: None,
            extras: Default::default(),
        }
    }

    fn finish(mut self) -> Result<Vec<u8>, String> {
        self.root.buffers.push(Buffer {
            byte_length: USize64::from(self.binary.len()),
            name: None,
            uri: None,
            extensions: None,
            extras: Default::default(),
        });
        let nodes = (0..self.root.nodes.len() as u32).map(Index::new).collect();
        let scene = self.root.push(Scene { nodes, name: None, extensions: None, extras: Default::default() });
        self.root.scene = Some(scene);
        self.root.asset.generator = Some("canopy-fem".to_owned());
        let json = self.root.to_vec().map_err(|error| error.to_string())?;
        // The library writes the length itself.
        let header = Header { magic: *b"glTF", version: 2, length: 0 };
        let file = Glb { header, json: json.into(), bin: Some(self.binary.into()) };
        file.to_vec().map_err(|error| error.to_string())
    }
}

/// A place with +Y up, in single precision.
fn upright([x, y, z]: [f64; 3]) -> [f32; 3] {
    [x as f32, z as f32, -y as f32]
}
