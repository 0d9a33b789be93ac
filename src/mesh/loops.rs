//! Boundary loops, found by turning around each boundary node from one boundary edge to the next.

use super::Mesh;
use super::sides::Sides;
use nalgebra::Vector3;

/// A chain of boundary edges.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryLoop {
    /// nodes in the order they follow each other, each once
    pub nodes: Vec<u32>,
    /// whether the last node connects to the first; false only if it ends at an edge of three or more triangles
    pub closed: bool,
    /// whether it encloses the other loops of its component: it has the largest extent
    pub outer: bool,
    /// [m] length of the loop
    pub length: f64,
    /// [m] diagonal of the box around the loop
    pub extent: f64,
}

/// All loops: outer ones first, then by their smallest node. `component` names the component of every node.
pub(super) fn find(mesh: &Mesh, sides: &Sides, component: &[u32]) -> Vec<BoundaryLoop> {
    let mut seen = vec![false; sides.nodes.len()];
    let mut loops = Vec::new();
    for start in 0..sides.nodes.len() {
        if sides.at(start).len() == 1 && !seen[start] {
            loops.push(follow(mesh, sides, start, &mut seen));
        }
    }
    mark_outer(&mut loops, component);
    // Sorting is stable and the loops were found in the order of their smallest node.
    loops.sort_by_key(|l| !l.outer);
    loops
}

/// Follows boundary edges from `start` until they close; if they end instead, the other way as well.
fn follow(mesh: &Mesh, sides: &Sides, start: usize, seen: &mut [bool]) -> BoundaryLoop {
    let [first, second] = sides.nodes[start];
    seen[start] = true;
    let mut nodes = vec![first, second];
    let closed = walk(mesh, sides, start, second, seen, &mut nodes);
    if closed {
        // The search returned to `first` and listed it again.
        nodes.pop();
    } else {
        let mut backwards = Vec::new();
        walk(mesh, sides, start, first, seen, &mut backwards);
        backwards.reverse();
        backwards.extend(nodes);
        nodes = backwards;
    }
    let points: Vec<Vector3<f64>> = nodes.iter().map(|&n| mesh.point(n)).collect();
    let mut length: f64 = points.windows(2).map(|p| (p[0] - p[1]).norm()).sum();
    if let (true, [from, .., to]) = (closed, points.as_slice()) {
        length += (from - to).norm();
    }
    let low = points.iter().fold(Vector3::repeat(f64::INFINITY), |low, p| low.inf(p));
    let high = points.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |high, p| high.sup(p));
    BoundaryLoop { nodes, closed, outer: false, length, extent: (low - high).norm() }
}

/// Appends node after node from the far end `node` of boundary edge `start`; true if the walk returned to `start`.
fn walk(mesh: &Mesh, sides: &Sides, start: usize, node: u32, seen: &mut [bool], nodes: &mut Vec<u32>) -> bool {
    let (mut edge, mut node) = (start, node);
    while let Some(next) = next_boundary(mesh, sides, edge, node) {
        if next == start {
            return true;
        }
        seen[next] = true;
        let [a, b] = sides.nodes[next];
        node = if a == node { b } else { a };
        nodes.push(node);
        edge = next;
    }
    false
}

/// The boundary edge at the other end of the fan of triangles that `edge` opens at `node`.
///
/// The turn through the fan, instead of a search for any boundary edge at the node, separates loops that touch at one
/// node. `None` if the fan ends at an edge of three or more triangles.
fn next_boundary(mesh: &Mesh, sides: &Sides, edge: usize, node: u32) -> Option<usize> {
    let mut edge = edge;
    let mut triangle = *sides.at(edge).first()?;
    loop {
        let others = sides.of_triangle[triangle as usize].iter().map(|&s| s as usize);
        let next = others.filter(|&s| s != edge).find(|&s| sides.nodes[s].contains(&node))?;
        debug_assert!(mesh.triangles[triangle as usize].contains(&node));
        match *sides.at(next) {
            [_] => return Some(next),
            [a, b] => (edge, triangle) = (next, if a == triangle { b } else { a }),
            _ => return None,
        }
    }
}

/// Marks the loop of largest extent in every component; among equals the longest, then the first.
fn mark_outer(loops: &mut [BoundaryLoop], component: &[u32]) {
    let part = |l: &BoundaryLoop| l.nodes.first().map(|&n| component[n as usize]);
    let larger = |a: &BoundaryLoop, b: &BoundaryLoop| (a.extent, a.length) > (b.extent, b.length);
    let mut best: std::collections::BTreeMap<Option<u32>, usize> = std::collections::BTreeMap::new();
    for (i, candidate) in loops.iter().enumerate() {
        let current = best.entry(part(candidate)).or_insert(i);
        if larger(candidate, &loops[*current]) {
            *current = i;
        }
    }
    for i in best.into_values() {
        loops[i].outer = true;
    }
}
