//! Pieces that are too many or missing: stray triangles, and small holes.

use super::{Cloth, gaps};
use crate::components::components;
use crate::format_number::{counted, figures};
use crate::loops::BoundaryLoop;
use crate::warning::{Warning, WarningCode};
use std::collections::{BTreeMap, HashSet};

/// Triangles of a stray piece, at most.
const FEW: usize = 10;
/// Triangles of the largest sheet for each of a stray piece, at least.
const LARGE: usize = 50;
/// Nodes around the hole that a missing face or node leaves, at most.
const AROUND: usize = 6;
/// [-] Largest extent of such a hole over that of the cloth.
const OF_CLOTH: f64 = 0.15;
/// Nodes of the longest rim for each of a small hole, at least: vents of coarse canopies have few nodes too.
const OF_RIM: usize = 4;

/// A few triangles that nothing connects to a large sheet.
pub(super) fn stray(cloth: &Cloth<'_>) -> Option<Warning> {
    let mesh = cloth.mesh;
    if cloth.topology.components() < 2 || mesh.triangles.len() <= LARGE {
        return None;
    }
    let across = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [a, c]]);
    let part = components(mesh.nodes.len(), mesh.edges.iter().copied().chain(across));
    let mut sheets: BTreeMap<u32, (usize, u32)> = BTreeMap::new();
    for (number, triangle) in (0..).zip(&mesh.triangles) {
        sheets.entry(part[triangle[0] as usize]).or_insert((0, number)).0 += 1;
    }
    let largest = sheets.values().map(|(count, _)| *count).max()?;
    let stray = || sheets.values().filter(|(count, _)| *count <= FEW && count * LARGE <= largest);
    let (pieces, triangles) = (stray().count(), stray().map(|(count, _)| *count).sum::<usize>());
    let &(_, first) = stray().next()?;
    let [x, y, z] = mesh.nodes[mesh.triangles[first as usize][0] as usize].map(|x| figures(x, 5));
    let text = format!(
        "{} in {} {} connected to nothing, beside a sheet of {largest}, such as triangle {first} at ({x}, {y}, {z}): delete them, \
         or join them to the sheet",
        counted(triangles as u64, "triangle", "triangles"),
        counted(pieces as u64, "piece", "pieces"),
        if triangles == 1 { "is" } else { "are" }
    );
    Some(Warning::new(WarningCode::StrayTriangles, text))
}

/// Holes of the size of a face or two.
pub(super) fn holes(cloth: &Cloth<'_>, gaps: &gaps::Found) -> Option<Warning> {
    let mesh = cloth.mesh;
    let open: HashSet<u32> =
        gaps.pairs.as_flattened().iter().copied().chain(gaps.beside.iter().map(|one| one.node)).collect();
    let longest = cloth.topology.loops().iter().map(|rim| rim.nodes.len()).max()?;
    // Who gives a hole a name means it; a group of most nodes names no hole.
    let named = |hole: &BoundaryLoop| {
        let mut groups = mesh.groups.values().filter(|group| 2 * group.nodes.len() < mesh.nodes.len());
        groups.any(|group| hole.nodes.iter().all(|node| group.nodes.binary_search(node).is_ok()))
    };
    let small = |hole: &&BoundaryLoop| {
        let few = hole.nodes.len() <= AROUND && OF_RIM * hole.nodes.len() <= longest;
        let size = few && hole.extent <= OF_CLOTH * cloth.extent;
        hole.closed && !hole.outer && size && !hole.nodes.iter().any(|node| open.contains(node)) && !named(hole)
    };
    let found: Vec<&BoundaryLoop> = cloth.topology.loops().iter().filter(small).collect();
    let first = found.first()?;
    let node = first.nodes.first().copied()?;
    let largest = found.iter().map(|hole| hole.extent).fold(0.0, f64::max);
    let [x, y, z] = mesh.nodes[node as usize].map(|x| figures(x, 5));
    let text = format!(
        "the cloth has {} of few nodes, at most {} m across, such as at node {node}, ({x}, {y}, {z}): faces may be missing there; \
         fill them, unless the holes are meant",
        counted(found.len() as u64, "small hole", "small holes"),
        figures(largest, 3)
    );
    Some(Warning::new(WarningCode::SmallHole, text))
}
