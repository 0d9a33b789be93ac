//! Meshes as .obj, .ply and .stl.

use super::members::{groups_of, lines};
use super::names::{NameRule, Names, plain};
use crate::Mesh;
use crate::read::PLY_NO_MARKS;
use nalgebra::Vector3;
use std::fmt::Write as _;

/// Blanks divide names, `#` begins a comment, and a backslash continues a line.
pub(super) const OBJ: NameRule = NameRule {
    allowed: |c| !c.is_whitespace() && c != '#' && c != '\\',
    first: |_| true,
    taken: |name| name == "default",
    caseless: false,
};

/// Properties that mean something else: places, normals, colours, texture, and what the reader takes for no group.
pub(super) const PLY: NameRule = NameRule {
    allowed: plain,
    first: |c| c.is_ascii_alphabetic() || c == '_',
    taken: |name| {
        let known = [
            "x",
            "y",
            "z",
            "nx",
            "ny",
            "nz",
            "s",
            "t",
            "u",
            "v",
            "vertex_index",
            "vertex_indices",
            "vertex1",
            "vertex2",
        ];
        let counts = ["vtk", "Global", "Original"].iter().any(|word| name.starts_with(word));
        counts || known.contains(&name) || PLY_NO_MARKS.contains(&name)
    },
    caseless: false,
};

/// A mesh as Wavefront .obj; lines only for edges that are no triangle's or in a group. Groups are `g` records.
pub fn obj_text(mesh: &Mesh) -> String {
    obj_named(mesh, &Names::new(mesh, &OBJ).written)
}

pub(super) fn obj_named(mesh: &Mesh, names: &[String]) -> String {
    let mut text = String::from("# canopy-fem\n");
    // Writing to a String cannot fail; floats print the shortest digits that read back exactly.
    for [x, y, z] in &mesh.nodes {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    let mut standing: Vec<usize> = Vec::new();
    let mut record = |groups: &[usize], letter: char, nodes: &[u32]| {
        if standing != groups {
            let named: Vec<&str> = groups.iter().filter_map(|&g| names.get(g).map(String::as_str)).collect();
            let _ = writeln!(text, "g {}", if named.is_empty() { "default".to_owned() } else { named.join(" ") });
            groups.clone_into(&mut standing);
        }
        text.push(letter);
        nodes.iter().for_each(|node| {
            let _ = write!(text, " {}", u64::from(*node) + 1);
        });
        text.push('\n');
    };
    let of_edge = groups_of(mesh, mesh.edges.len(), |group| &group.edges);
    for edge in lines(mesh) {
        record(&of_edge[edge as usize], 'l', &mesh.edges[edge as usize]);
    }
    let of_triangle = groups_of(mesh, mesh.triangles.len(), |group| &group.triangles);
    for (groups, corners) in of_triangle.iter().zip(&mesh.triangles) {
        record(groups, 'f', corners);
    }
    for (number, group) in mesh.groups.values().enumerate().filter(|(_, group)| !group.nodes.is_empty()) {
        record(&[number], 'p', &group.nodes);
    }
    text
}

/// A mesh as .ply in text. Groups are numbers of faces, edges and vertices: 1 for members.
pub(super) fn ply_text(mesh: &Mesh, names: &[String]) -> String {
    let lines = lines(mesh);
    let mut text = String::from("ply\nformat ascii 1.0\ncomment canopy-fem\n");
    let mut element = |name: &str, count: usize, own: &str, members: &dyn Fn(&crate::Group) -> bool| {
        let _ = write!(text, "element {name} {count}\n{own}");
        let held = (0..).zip(mesh.groups.values()).filter(|(_, group)| members(group)).map(|(number, _)| number);
        let held: Vec<usize> = held.collect();
        held.iter().for_each(|&number| {
            let _ = writeln!(text, "property uchar {}", names[number]);
        });
        held
    };
    let place = "property double x\nproperty double y\nproperty double z\n";
    let of_nodes = element("vertex", mesh.nodes.len(), place, &|g| !g.nodes.is_empty());
    let corners = "property list uchar int vertex_indices\n";
    let of_triangles = element("face", mesh.triangles.len(), corners, &|g| !g.triangles.is_empty());
    let ends = "property int vertex1\nproperty int vertex2\n";
    // Some readers expect no edges.
    let of_edges = match lines.len() {
        0 => Vec::new(),
        count => element("edge", count, ends, &|g| !g.edges.is_empty()),
    };
    text.push_str("end_header\n");
    let mut row = |own: String, held: &[usize], groups: &[usize]| {
        text.push_str(&own);
        held.iter().for_each(|number| text.push_str(if groups.contains(number) { " 1" } else { " 0" }));
        text.push('\n');
    };
    let groups = groups_of(mesh, mesh.nodes.len(), |group| &group.nodes);
    for ([x, y, z], groups) in mesh.nodes.iter().zip(&groups) {
        row(format!("{x} {y} {z}"), &of_nodes, groups);
    }
    let groups = groups_of(mesh, mesh.triangles.len(), |group| &group.triangles);
    for ([a, b, c], groups) in mesh.triangles.iter().zip(&groups) {
        row(format!("3 {a} {b} {c}"), &of_triangles, groups);
    }
    let groups = groups_of(mesh, mesh.edges.len(), |group| &group.edges);
    for edge in lines {
        let [a, b] = mesh.edges[edge as usize];
        row(format!("{a} {b}"), &of_edges, &groups[edge as usize]);
    }
    text
}

/// The triangles of a mesh as binary .stl, in single precision.
pub(super) fn stl(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = b"canopy-fem".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for corners in &mesh.triangles {
        let places = corners.map(|node| Vector3::from(mesh.nodes[node as usize]));
        let normal = (places[1] - places[0]).cross(&(places[2] - places[0])).normalize();
        for value in std::iter::once(&normal).chain(&places).flat_map(|v| v.iter()) {
            bytes.extend((*value as f32).to_le_bytes());
        }
        bytes.extend([0, 0]);
    }
    bytes
}
