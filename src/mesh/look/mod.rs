//! A look at a mesh that somebody else made: what lets a simulation run, but on other cloth than the one that is meant.
//! Generated meshes are right by construction and need none. O(n log n), and mostly O(n): the sheet is passed through a
//! few times, and only its rim is searched.

mod gaps;
mod on_cloth;
mod pieces;
mod rim;
mod seam;
pub(crate) mod size;

use super::box_tree::Bounds;
use super::hanging::{describe, hanging_nodes};
use super::read::extent;
use super::warning::{Warning, WarningCode};
use super::{EdgeKind, Mesh, Topology};
use rim::Rim;
pub use seam::Gaps;
pub use size::{Y_IS_UP, canopy_along_y, units};

/// [-] Distance over the extent of the mesh within which two nodes coincide.
pub const COINCIDENT: f64 = 1e-6;

/// [-] Widest gap over the extent of the cloth. Slots of canopies are wider.
const GAP: f64 = 3.2e-3;

/// Boxes that a search may compare for each thing that it asks about, in the mean.
const LOOKS: u64 = 400;

/// What a mesh shows.
#[derive(Clone, Debug)]
pub struct Look {
    /// cloth that is open along its seams, and lines that end beside it
    pub gaps: Gaps,
    /// all other doubts
    pub others: Vec<Warning>,
}

/// Looks at a mesh. `near` are pairs of nodes to be joined together with those of the gaps.
pub fn look(mesh: &Mesh, topology: &Topology, near: &[[u32; 2]]) -> Look {
    let cloth = Cloth::new(mesh, topology);
    let rim = Rim::new(&cloth);
    let found = gaps::find(&cloth, &rim);
    let mut hanging = hanging_nodes(mesh, topology);
    let on = on_cloth::find(&cloth, &rim, &hanging);
    let mut pairs = [near, &found.pairs, &on.line_ends].concat();
    // A node near the end of the edge is joined to that end.
    hanging.retain(|one| {
        let end = gaps::end_beside(&cloth, one);
        pairs.extend(end.map(|end| [one.node, end]));
        end.is_none()
    });
    let told = describe(&hanging).map(|text| Warning::new(WarningCode::HangingNode, text));
    let pieces = [pieces::stray(&cloth), pieces::holes(&cloth, &found)];
    let others = told.into_iter().chain(on.warnings).chain(pieces.into_iter().flatten()).collect();
    Look { gaps: Gaps::new(mesh, &pairs, &found.beside), others }
}

/// The mesh with what all looks need.
struct Cloth<'a> {
    mesh: &'a Mesh,
    topology: &'a Topology,
    /// whether a node belongs to a triangle
    of_triangle: Vec<bool>,
    /// [m] largest side of the box around the triangles
    extent: f64,
}

impl<'a> Cloth<'a> {
    fn new(mesh: &'a Mesh, topology: &'a Topology) -> Self {
        let mut of_triangle = vec![false; mesh.nodes.len()];
        mesh.triangles.as_flattened().iter().for_each(|node| of_triangle[*node as usize] = true);
        let nodes = mesh.nodes.iter().zip(&of_triangle).filter(|(_, of)| **of);
        let extent = Bounds::of(nodes.map(|(x, _)| x)).extent();
        Cloth { mesh, topology, of_triangle, extent }
    }

    /// Lines, each with its number.
    fn lines(&self) -> impl Iterator<Item = (usize, [u32; 2])> {
        let edges = self.mesh.edges.iter().copied().enumerate();
        edges.filter(|(edge, _)| self.topology.edge_kind(*edge) == EdgeKind::Line)
    }
}

/// Nodes that are at the same place as an earlier one, and ends of lines near others, each with the other.
pub fn near_nodes(mesh: &Mesh, topology: &Topology) -> Vec<[u32; 2]> {
    let cloth = Cloth::new(mesh, topology);
    let pairs_of = |distance: f64| {
        let kept = super::read::joined(&mesh.nodes, distance);
        (0_u32..).zip(kept).filter(|(node, kept)| node != kept).map(|(node, kept)| [kept, node])
    };
    let mut pairs: Vec<[u32; 2]> = pairs_of(COINCIDENT * extent(&mesh.nodes)).collect();
    let mut longest = vec![0.0_f64; mesh.nodes.len()];
    let (mut sum, mut count) = (0.0, 0);
    for (_, [a, b]) in cloth.lines() {
        let length = (mesh.point(a) - mesh.point(b)).norm();
        (sum, count) = (sum + length, count + 1);
        [a, b].iter().for_each(|node| longest[*node as usize] = longest[*node as usize].max(length));
    }
    if count > 0 {
        let line = |[a, b]: &[u32; 2]| {
            let own = longest[*a as usize].min(longest[*b as usize]);
            own > 0.0 && (mesh.point(*a) - mesh.point(*b)).norm() < SAME * own
        };
        let off = |pair: &[u32; 2]| pair.iter().any(|node| !cloth.of_triangle[*node as usize]);
        pairs.extend(pairs_of(SAME * sum / f64::from(count)).filter(|pair| off(pair) && line(pair)));
    }
    let joined: std::collections::HashSet<[u32; 2]> = if pairs.is_empty() {
        Default::default()
    } else {
        mesh.edges.iter().map(|[a, b]| [*a.min(b), *a.max(b)]).collect()
    };
    pairs.retain(|[a, b]| !joined.contains(&[*a.min(b), *a.max(b)]));
    pairs
}

/// [-] Distance over the length of a line within which its end is taken to be meant as another node.
const SAME: f64 = 0.1;

#[cfg(test)]
mod tests;
