//! A mesh as Gmsh .msh, version 4.1 in text, after the Gmsh reference manual, "MSH file format".

use super::members::lines;
use super::names::NameRule;
use crate::Mesh;
use crate::group::GroupNumbers;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// A name ends at a quotation mark.
pub(super) const MSH: NameRule = NameRule { allowed: |c| c != '"', first: |_| true, taken: |_| false, caseless: false };

/// Groups are physical groups: of surfaces for triangles, of curves for edges, of points for nodes. Members of the same
/// groups are one entity. Lines only for edges that are no triangle's or in a group.
pub(super) fn msh_text(mesh: &Mesh, written: &[String]) -> String {
    let numbers = GroupNumbers::new(&mesh.groups, [mesh.nodes.len(), mesh.triangles.len(), mesh.edges.len()]);
    let mut elements: BTreeMap<(usize, i32), Vec<&[u32]>> = BTreeMap::new();
    let one_node: Vec<[u32; 1]> = (0..mesh.nodes.len() as u32).map(|node| [node]).collect();
    for (node, number) in one_node.iter().zip(&numbers.nodes).filter(|(_, number)| **number != 0) {
        elements.entry((0, *number)).or_default().push(node);
    }
    for edge in lines(mesh).into_iter().map(|edge| edge as usize) {
        elements.entry((1, numbers.cells[mesh.triangles.len() + edge])).or_default().push(&mesh.edges[edge]);
    }
    for (corners, number) in mesh.triangles.iter().zip(&numbers.cells) {
        elements.entry((2, *number)).or_default().push(corners);
    }
    let mut text = String::from("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n");
    // Each group by dimension, with the numbers of its entities.
    let cells = numbers.cell_groups.iter().flat_map(|(name, list)| [(1, name, list), (2, name, list)]);
    let named = numbers.node_groups.iter().map(|(name, list)| (0, name, list)).chain(cells);
    let named: Vec<_> = named.filter(|(d, _, list)| list.iter().any(|n| elements.contains_key(&(*d, *n)))).collect();
    let written: BTreeMap<&String, &String> = mesh.groups.keys().zip(written).collect();
    if !named.is_empty() {
        let _ = writeln!(text, "$PhysicalNames\n{}", named.len());
        for (tag, (dimension, name, _)) in (1..).zip(&named) {
            let _ = writeln!(text, "{dimension} {tag} \"{}\"", written.get(name).copied().unwrap_or(name));
        }
        text.push_str("$EndPhysicalNames\n");
    }
    let count = |dimension: usize| elements.keys().filter(|(d, _)| *d == dimension).count();
    let _ = writeln!(text, "$Entities\n{} {} {} 0", count(0), count(1), count(2));
    for (dimension, number) in elements.keys() {
        let physical = (1..).zip(&named).filter(|(_, (d, _, list))| d == dimension && list.contains(number));
        let physical: Vec<String> = physical.map(|(tag, _): (i32, _)| tag.to_string()).collect();
        let place = if *dimension == 0 { "0 0 0" } else { "0 0 0 0 0 0" };
        let bounds = if *dimension == 0 { "" } else { " 0" };
        let list = physical.iter().fold(physical.len().to_string(), |text, tag| text + " " + tag);
        let _ = writeln!(text, "{} {place} {list}{bounds}", number + 1);
    }
    text.push_str("$EndEntities\n$Nodes\n");
    let (nodes, (dimension, entity)) = (mesh.nodes.len(), elements.keys().last().copied().unwrap_or((2, 0)));
    let _ = writeln!(text, "1 {nodes} 1 {nodes}\n{dimension} {} 0 {nodes}", entity + 1);
    (1..=nodes).for_each(|node| {
        let _ = writeln!(text, "{node}");
    });
    mesh.nodes.iter().for_each(|[x, y, z]| {
        let _ = writeln!(text, "{x} {y} {z}");
    });
    let all: usize = elements.values().map(Vec::len).sum();
    let _ = writeln!(text, "$EndNodes\n$Elements\n{} {all} 1 {all}", elements.len());
    let mut tag = 0;
    for ((dimension, number), members) in &elements {
        let kind = [15, 1, 2][*dimension];
        let _ = writeln!(text, "{dimension} {} {kind} {}", number + 1, members.len());
        for nodes in members {
            tag += 1;
            let _ = write!(text, "{tag}");
            nodes.iter().for_each(|node| {
                let _ = write!(text, " {}", u64::from(*node) + 1);
            });
            text.push('\n');
        }
    }
    text.push_str("$EndElements\n");
    text
}
