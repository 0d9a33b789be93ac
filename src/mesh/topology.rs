//! From the triangles at every edge the boundary loops, orientation and components.

use super::components::components;
use super::loops::{self, BoundaryLoop};
pub(crate) use super::sides::unique_edges;
use super::sides::{NOT_A_SIDE, Sides};
use super::tuples::{repeated, sorted};
use super::{Mesh, MeshError};

/// The position of an edge in the sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeKind {
    /// no triangle: a suspension line or a chain's segment
    Line,
    /// one triangle
    Boundary,
    /// two triangles, or more where sheets are joined along a line
    Interior,
}

/// Adjacency and boundary of a mesh.
#[derive(Clone, Debug)]
pub struct Topology {
    sides: Sides,
    /// for every edge of the mesh its number among the triangles' edges, or `NOT_A_SIDE`
    side_of_edge: Vec<u32>,
    loops: Vec<BoundaryLoop>,
    components: usize,
    euler: i64,
    boundary_nodes: Vec<u32>,
    outer_nodes: Vec<u32>,
    inner_nodes: Vec<u32>,
}

/// The edges of a mesh that no triangle has.
fn lines_of<'a>(mesh: &'a Mesh, side_of_edge: &'a [u32]) -> impl Iterator<Item = [u32; 2]> + Clone {
    mesh.edges.iter().zip(side_of_edge).filter(|(_, side)| **side == NOT_A_SIDE).map(|(line, _)| *line)
}

impl Topology {
    /// Finds adjacency and boundary loops of a mesh.
    ///
    /// # Errors
    /// Edges or triangles that name a missing node or a node twice, or the same edge or triangle listed twice
    /// (see [`Mesh::check`]).
    pub fn new(mesh: &Mesh) -> Result<Self, MeshError> {
        mesh.check_numbers()?;
        let sides = Sides::new(&mesh.triangles);
        let side_of_edge = sides.of_edges(&mesh.edges);
        let repeats = !repeated(lines_of(mesh, &side_of_edge).map(sorted)).is_empty();
        if repeats || sides.has_repeats(&mesh.triangles, &side_of_edge) {
            mesh.check()?;
        }
        mesh.check_shapes()?;
        Ok(Self::of_sides(mesh, sides, side_of_edge))
    }

    /// The same for a mesh that has passed [`Mesh::check`], as those of files have; it panics for numbers out of range.
    pub fn of_checked(mesh: &Mesh) -> Self {
        let sides = Sides::new(&mesh.triangles);
        let side_of_edge = sides.of_edges(&mesh.edges);
        Self::of_sides(mesh, sides, side_of_edge)
    }

    fn of_sides(mesh: &Mesh, sides: Sides, side_of_edge: Vec<u32>) -> Self {
        let lines = lines_of(mesh, &side_of_edge);
        let component = components(mesh.nodes.len(), sides.nodes.iter().copied().chain(lines));
        let components = component.iter().enumerate().filter(|&(node, &name)| node as u32 == name).count();
        let loops = loops::find(mesh, &sides, &component);
        let nodes_of = |wanted: &dyn Fn(&BoundaryLoop) -> bool| {
            let mut nodes: Vec<u32> =
                loops.iter().filter(|l| wanted(l)).flat_map(|l| l.nodes.iter().copied()).collect();
            nodes.sort_unstable();
            nodes.dedup();
            nodes
        };
        let (boundary_nodes, outer_nodes, inner_nodes) =
            (nodes_of(&|_| true), nodes_of(&|l| l.outer), nodes_of(&|l| !l.outer));
        let lines = side_of_edge.iter().filter(|&&s| s == NOT_A_SIDE).count();
        let euler = mesh.nodes.len() as i64 - (sides.nodes.len() + lines) as i64 + mesh.triangles.len() as i64;
        Self { sides, side_of_edge, loops, components, euler, boundary_nodes, outer_nodes, inner_nodes }
    }

    /// All nodes on boundary loops, ascending.
    pub fn boundary_nodes(&self) -> &[u32] {
        &self.boundary_nodes
    }

    /// Nodes on the loop that encloses the others, ascending; one such loop in every connected component.
    pub fn outer_nodes(&self) -> &[u32] {
        &self.outer_nodes
    }

    /// Nodes on all other loops, ascending.
    pub fn inner_nodes(&self) -> &[u32] {
        &self.inner_nodes
    }

    /// Boundary loops, the outer ones first, then by their smallest node.
    pub fn loops(&self) -> &[BoundaryLoop] {
        &self.loops
    }

    /// Where an edge of the mesh lies; [`EdgeKind::Line`] for a number that is no edge.
    pub fn edge_kind(&self, edge: usize) -> EdgeKind {
        match self.edge_triangles(edge).len() {
            0 => EdgeKind::Line,
            1 => EdgeKind::Boundary,
            _ => EdgeKind::Interior,
        }
    }

    /// Triangles at an edge of the mesh, ascending; none for a line or a number that is no edge.
    pub fn edge_triangles(&self, edge: usize) -> &[u32] {
        match self.side_of_edge.get(edge) {
            Some(&side) if side != NOT_A_SIDE => self.sides.at(side as usize),
            _ => &[],
        }
    }

    /// Triangles that have both nodes, ascending.
    pub fn triangles_at(&self, pair: [u32; 2]) -> &[u32] {
        self.sides.find(pair).map_or(&[], |side| self.sides.at(side))
    }

    /// Edges of the triangles, the smaller node first, with their triangles, both ascending.
    pub(crate) fn sides(&self) -> impl Iterator<Item = ([u32; 2], &[u32])> {
        self.sides.nodes.iter().enumerate().map(|(side, nodes)| (*nodes, self.sides.at(side)))
    }

    /// Edges of one triangle, the smaller node first, with that triangle; ascending.
    pub fn boundary_edges(&self) -> impl Iterator<Item = ([u32; 2], u32)> {
        let sides = self.sides.nodes.iter().enumerate().map(|(side, nodes)| (*nodes, self.sides.at(side)));
        sides.filter(|(_, triangles)| triangles.len() == 1).map(|(nodes, triangles)| (nodes, triangles[0]))
    }

    /// Number of parts that no edge or triangle connects.
    pub fn components(&self) -> usize {
        self.components
    }

    /// Euler characteristic nodes - edges + triangles, with the triangles' edges counted whether they are in the
    /// mesh's edge list or not: 1 for a disc, 0 for an annulus, 2 for a closed surface.
    pub fn euler_characteristic(&self) -> i64 {
        self.euler
    }

    /// Edges of more than two triangles, the smaller node first, with their triangles, both ascending.
    pub fn branching_edges(&self) -> impl Iterator<Item = ([u32; 2], &[u32])> {
        let sides = self.sides.nodes.iter().enumerate().map(|(side, nodes)| (*nodes, self.sides.at(side)));
        sides.filter(|(_, triangles)| triangles.len() > 2)
    }

    /// Checks that no edge has more than two triangles.
    ///
    /// # Errors
    /// [`MeshError::NonManifold`] with the first such edge.
    pub fn check_manifold(&self) -> Result<(), MeshError> {
        match (0..self.sides.nodes.len()).find(|&s| self.sides.at(s).len() > 2) {
            Some(s) => {
                let [a, b] = self.sides.nodes[s];
                Err(MeshError::NonManifold { triangles: self.sides.at(s).len(), a, b })
            }
            None => Ok(()),
        }
    }

    /// Checks that neighbours turn the same way, so that normals all point to the same side of the sheet.
    ///
    /// Edges of more than two triangles are skipped, because no such side exists there.
    ///
    /// # Errors
    /// [`MeshError::Orientation`] with the first offending pair, in the order of the triangles.
    pub fn check_orientation(&self, mesh: &Mesh) -> Result<(), MeshError> {
        let forward = |triangle: u32, [a, b]: [u32; 2]| {
            mesh.triangles
                .get(triangle as usize)
                .is_some_and(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].contains(&[a, b]))
        };
        let mut worst: Option<(u32, u32, usize)> = None;
        for side in 0..self.sides.nodes.len() {
            if let &[first, second] = self.sides.at(side) {
                let pair = self.sides.nodes[side];
                if forward(first, pair) == forward(second, pair) && worst.is_none_or(|w| (first, second, side) < w) {
                    worst = Some((first, second, side));
                }
            }
        }
        match worst {
            Some((first, second, side)) => {
                let [a, b] = self.sides.nodes[side];
                Err(MeshError::Orientation { first, second, a, b })
            }
            None => Ok(()),
        }
    }
}
