//! Meshes as input of finite-element programs: Abaqus and CalculiX .inp, Nastran .bdf, Kratos .mdpa. Triangles are
//! shells, lines are bars; sections, materials and supports are left to the user. Labels count from 1, triangles before
//! lines.

use super::members::{groups_of, lines};
use super::names::{NameRule, plain};
use crate::{Group, Mesh};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// A label begins with a letter; upper and lower case are the same.
pub(super) const INP: NameRule =
    NameRule { allowed: plain, first: |c| c.is_ascii_alphabetic(), taken: |_| false, caseless: true };

/// A point divides the names of nested parts, and a slash may begin a comment.
pub(super) const MDPA: NameRule = NameRule {
    allowed: |c| !c.is_whitespace() && c != '.' && c != '/',
    first: |_| true,
    taken: |_| false,
    caseless: false,
};

/// Lines of a mesh, and their labels.
struct Lines {
    edges: Vec<u32>,
    label: BTreeMap<u32, usize>,
}

impl Lines {
    fn new(mesh: &Mesh) -> Self {
        let edges = lines(mesh);
        let label = edges.iter().copied().zip(mesh.triangles.len() + 1..).collect();
        Lines { edges, label }
    }

    /// Labels of a group's elements.
    fn elements(&self, group: &Group) -> Vec<usize> {
        let triangles = group.triangles.iter().map(|&triangle| triangle as usize + 1);
        triangles.chain(group.edges.iter().filter_map(|edge| self.label.get(edge).copied())).collect()
    }
}

/// Labels of a group's nodes.
fn nodes(group: &Group) -> Vec<usize> {
    group.nodes.iter().map(|&node| node as usize + 1).collect()
}

/// The labels of some nodes, with `between` between them.
fn joined(corners: &[u32], between: &str) -> String {
    corners.iter().map(|node| (u64::from(*node) + 1).to_string()).collect::<Vec<_>>().join(between)
}

/// Shells S3 and trusses T3D2; groups are sets of elements and of nodes. After the Abaqus keywords reference.
pub(super) fn inp_text(mesh: &Mesh, names: &[String]) -> String {
    let bars = Lines::new(mesh);
    let mut text = String::from("*HEADING\ncanopy-fem\n*NODE\n");
    for (label, [x, y, z]) in (1..).zip(&mesh.nodes) {
        let _ = writeln!(text, "{label}, {x:?}, {y:?}, {z:?}");
    }
    if !mesh.triangles.is_empty() {
        text.push_str("*ELEMENT, TYPE=S3\n");
    }
    for (label, corners) in (1..).zip(&mesh.triangles) {
        let _ = writeln!(text, "{label}, {}", joined(corners, ", "));
    }
    if !bars.edges.is_empty() {
        text.push_str("*ELEMENT, TYPE=T3D2\n");
    }
    for (edge, label) in &bars.label {
        let _ = writeln!(text, "{label}, {}", joined(&mesh.edges[*edge as usize], ", "));
    }
    for (name, group) in names.iter().zip(mesh.groups.values()) {
        for (word, labels) in [("ELSET", bars.elements(group)), ("NSET", nodes(group))] {
            if !labels.is_empty() {
                let _ = writeln!(text, "*{word}, {word}={name}");
            }
            // A data line has at most sixteen labels.
            for row in labels.chunks(16) {
                let row: Vec<String> = row.iter().map(usize::to_string).collect();
                let _ = writeln!(text, "{}", row.join(", "));
            }
        }
    }
    text
}

/// Shells CTRIA3 and rods CROD. A property stands for the elements of the same groups; SET1 entries list nodes.
/// Comments say which group is which number, and so do the sentences that are returned with the text. After the MSC
/// Nastran quick reference guide.
pub(super) fn bdf_text(mesh: &Mesh) -> (String, Vec<String>) {
    let bars = Lines::new(mesh);
    let (of_triangle, of_edge) = (
        groups_of(mesh, mesh.triangles.len(), |group| &group.triangles),
        groups_of(mesh, mesh.edges.len(), |group| &group.edges),
    );
    let mut properties: BTreeMap<(usize, &[usize]), usize> = BTreeMap::new();
    for groups in &of_triangle {
        properties.insert((3, groups), 0);
    }
    for &edge in &bars.edges {
        properties.insert((2, &of_edge[edge as usize]), 0);
    }
    let mut text = String::from("$ canopy-fem\nSOL 101\nCEND\nBEGIN BULK\n");
    let names: Vec<&String> = mesh.groups.keys().collect();
    let with_nodes = || (0..).zip(mesh.groups.iter()).filter(|(_, (_, group))| !group.nodes.is_empty());
    // What stands for each group.
    let mut held: BTreeMap<usize, Vec<String>> = BTreeMap::new();
    for (number, ((corners, groups), property)) in (1..).zip(&mut properties) {
        *property = number;
        let named: Vec<&str> = groups.iter().filter_map(|&group| names.get(group).map(|name| name.as_str())).collect();
        let what = if *corners == 3 { "triangles" } else { "lines" };
        for &group in groups.iter() {
            held.entry(group).or_default().push(format!("property {number}"));
        }
        let named = if named.is_empty() { "no group".to_owned() } else { named.join(", ") };
        let _ = writeln!(text, "$ property {number}: {what} of {named}");
    }
    for (number, (group, (name, _))) in (1..).zip(with_nodes()) {
        held.entry(group).or_default().push(format!("set {number}"));
        let _ = writeln!(text, "$ set {number}: nodes of {name}");
    }
    for (label, [x, y, z]) in (1..).zip(&mesh.nodes) {
        let _ = writeln!(text, "{:<8}{label:<16}{:<16}{}{}", "GRID*", "", real(*x), real(*y));
        let _ = writeln!(text, "{:<8}{}", "*", real(*z));
    }
    for (label, (groups, corners)) in (1..).zip(of_triangle.iter().zip(&mesh.triangles)) {
        let property = properties.get(&(3, groups.as_slice())).copied().unwrap_or_default();
        let _ = writeln!(text, "CTRIA3,{label},{property},{}", joined(corners, ","));
    }
    for (edge, label) in &bars.label {
        let property = properties.get(&(2, of_edge[*edge as usize].as_slice())).copied().unwrap_or_default();
        let _ = writeln!(text, "CROD,{label},{property},{}", joined(&mesh.edges[*edge as usize], ","));
    }
    for (number, (_, (_, group))) in (1_usize..).zip(with_nodes()) {
        let labels = nodes(group);
        // The first line has the number of the set and seven labels, those after it eight.
        let (first, rest) = labels.split_at(labels.len().min(7));
        let row = |row: &[usize]| row.iter().fold(String::new(), |text, label| format!("{text},{label}"));
        let _ = writeln!(text, "SET1,{number}{}", row(first));
        for more in rest.chunks(8) {
            let _ = writeln!(text, "{}", row(more));
        }
    }
    text.push_str("ENDDATA\n");
    let told = held.iter().filter_map(|(group, parts)| {
        let name = names.get(*group)?;
        Some(format!("group \"{name}\" is written as {}", parts.join(", ")))
    });
    let rounded = mesh.nodes.iter().flatten().filter(|x| real(**x).trim_end().parse() != Ok(**x)).count();
    let rounded = (rounded > 0).then(|| format!(".bdf rounds {rounded} coordinates to nine digits"));
    let told: Vec<String> = told.chain(rounded).collect();
    (text, told)
}

/// A number in sixteen columns.
fn real(x: f64) -> String {
    let exact = format!("{x:?}");
    if exact.len() <= 16 && exact.contains('.') && !exact.contains('e') {
        return format!("{exact:<16}");
    }
    format!("{:<16}", format!("{x:.8E}"))
}

/// Elements Element3D3N and Element3D2N of the core; groups are sub model parts, which also list the nodes of their
/// elements. After the Kratos documentation, "Input data: the .mdpa format".
pub(super) fn mdpa_text(mesh: &Mesh, names: &[String]) -> String {
    let bars = Lines::new(mesh);
    let mut text = String::from("// canopy-fem\nBegin Properties 0\nEnd Properties\n\nBegin Nodes\n");
    for (label, [x, y, z]) in (1..).zip(&mesh.nodes) {
        let _ = writeln!(text, "{label} {x:?} {y:?} {z:?}");
    }
    text.push_str("End Nodes\n");
    let mut element = |kind: &str, elements: &mut dyn Iterator<Item = (usize, &[u32])>| {
        let _ = writeln!(text, "\nBegin Elements {kind}");
        for (label, corners) in elements {
            let _ = writeln!(text, "{label} 0 {}", joined(corners, " "));
        }
        text.push_str("End Elements\n");
    };
    if !mesh.triangles.is_empty() {
        element("Element3D3N", &mut (1..).zip(mesh.triangles.iter().map(<[u32; 3]>::as_slice)));
    }
    if !bars.edges.is_empty() {
        let elements = bars.label.iter().map(|(edge, label)| (*label, mesh.edges[*edge as usize].as_slice()));
        element("Element3D2N", &mut { elements });
    }
    for (name, group) in names.iter().zip(mesh.groups.values()) {
        let _ = writeln!(text, "\nBegin SubModelPart {name}");
        let corners = group.triangles.iter().filter_map(|&triangle| mesh.triangles.get(triangle as usize)).flatten();
        let ends = group.edges.iter().filter_map(|&edge| mesh.edges.get(edge as usize)).flatten();
        let mut all: Vec<usize> = corners.chain(ends).chain(&group.nodes).map(|&node| node as usize + 1).collect();
        all.sort_unstable();
        all.dedup();
        for (word, labels) in [("Nodes", all), ("Elements", bars.elements(group))] {
            let _ = writeln!(text, "Begin SubModelPart{word}");
            labels.iter().for_each(|label| {
                let _ = writeln!(text, "{label}");
            });
            let _ = writeln!(text, "End SubModelPart{word}");
        }
        text.push_str("End SubModelPart\n");
    }
    text
}
