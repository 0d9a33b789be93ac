//! Why a mesh cannot be made, read or used; every message has advice.

use crate::interrupt::Interrupted;
use std::path::PathBuf;

/// Failures of mesh generators, readers, writers and checks.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A parameter of a mesh source is outside its range.
    #[error("mesh{pointer} = {value} is not allowed: {allowed}; {hint}")]
    Parameter {
        /// JSON pointer below the mesh section, e.g. `/annulus/nodes`
        pointer: String,
        /// what was given
        value: String,
        /// what is allowed
        allowed: String,
        /// what to do
        hint: String,
    },
    /// The node counts cannot be met by a graded mesh.
    #[error(
        "{boundary_nodes} boundary nodes do not fit {nodes} nodes: that many boundary nodes call for {least} to {most} \
         nodes here; change `nodes` or `boundary_nodes`, or leave `boundary_nodes` out to have it derived"
    )]
    NodeCounts {
        /// total number of nodes asked for
        nodes: usize,
        /// boundary nodes asked for or derived
        boundary_nodes: usize,
        /// fewest nodes that go with them
        least: usize,
        /// most nodes that go with them
        most: usize,
    },
    /// Boundary and seams leave too few nodes for the interior.
    #[error(
        "{boundary_nodes} boundary nodes and {seam_nodes} nodes on seams do not fit into {nodes} nodes; raise `nodes` or \
         take fewer `seams` or `boundary_nodes`"
    )]
    NoInterior {
        /// total number of nodes asked for
        nodes: usize,
        /// nodes on the loops
        boundary_nodes: usize,
        /// nodes on the seams, loops not counted
        seam_nodes: usize,
    },
    /// The relaxation did not converge.
    #[error(
        "the mesh did not converge: after {iterations} iterations a node still moves {movement:.2e} of an edge length per step (allowed {tolerance:.1e}); try another `seed`, or a `grading` closer to 1"
    )]
    NotRelaxed {
        /// iterations done
        iterations: usize,
        /// [-] last largest movement over the wanted edge length there
        movement: f64,
        /// [-] movement below which it counts as converged
        tolerance: f64,
    },
    /// The best mesh found has a sharper angle than a simulation should start from.
    #[error(
        "the best mesh found has an angle of {angle:.1} degrees near ({x:.4}, {y:.4}) (at least {required} wanted); try \
         another `boundary_nodes` (or leave it out), a `grading` closer to 1, fewer `seams`, or more `nodes`"
    )]
    Quality {
        /// [deg] smallest angle
        angle: f64,
        /// [deg] smallest angle accepted
        required: f64,
        /// [m] where it is
        x: f64,
        /// [m] where it is
        y: f64,
    },
    /// The triangulation lost an edge that it must contain, or has another number of triangles than it must.
    #[error(
        "the triangulation has {found} triangles instead of {expected}; the nodes are too irregular, try another `seed`"
    )]
    Triangulation {
        /// triangles inside the domain
        found: usize,
        /// number by the Euler characteristic
        expected: usize,
    },
    /// Node numbers of an edge or triangle are out of range.
    #[error("{what} {index} names node {node}, but the mesh has {nodes} nodes, numbered from 0")]
    NodeOutOfRange {
        /// `edge` or `triangle`
        what: &'static str,
        /// which one
        index: usize,
        /// the node
        node: u64,
        /// nodes in the mesh
        nodes: usize,
    },
    /// An edge or triangle has a node twice.
    #[error("{what} {index} names node {node} twice; remove it or correct its nodes")]
    RepeatedNode {
        /// `edge` or `triangle`
        what: &'static str,
        /// which one
        index: usize,
        /// the node
        node: u32,
    },
    /// Two edges join the same nodes.
    #[error("edges {first} and {second} both join nodes {a} and {b}; list every edge once")]
    DuplicateEdge {
        /// first of the two
        first: usize,
        /// second of the two
        second: usize,
        /// smaller node
        a: u32,
        /// larger node
        b: u32,
    },
    /// Two triangles have the same nodes.
    #[error("triangles {first} and {second} have the same nodes; list every triangle once")]
    DuplicateTriangle {
        /// first of the two
        first: usize,
        /// second of the two
        second: usize,
    },
    /// A coordinate is not a finite number.
    #[error("node {node} has a coordinate that is not a finite number; correct its position")]
    NotFinite {
        /// the node
        node: usize,
    },
    /// An edge joins two nodes at the same place.
    #[error("edge {edge} has no length: nodes {a} and {b} coincide; merge the nodes or remove the edge")]
    ZeroLengthEdge {
        /// the edge
        edge: usize,
        /// its first node
        a: u32,
        /// its second node
        b: u32,
    },
    /// A triangle's nodes lie on a line.
    #[error(
        "triangle {triangle} is degenerate: its area is {area:.3e} m^2 with a longest edge of {longest:.3e} m; \
         remove it or move its nodes"
    )]
    DegenerateTriangle {
        /// the triangle
        triangle: usize,
        /// [m^2] its area
        area: f64,
        /// [m] its longest edge
        longest: f64,
    },
    /// Two neighbours turn opposite ways.
    #[error(
        "triangles {first} and {second} share the edge {a}-{b} but turn opposite ways, so their normals disagree; \
         swap two nodes of one of them"
    )]
    Orientation {
        /// first triangle
        first: u32,
        /// second triangle
        second: u32,
        /// smaller node of the edge
        a: u32,
        /// larger node of the edge
        b: u32,
    },
    /// More than two triangles share an edge.
    #[error("{triangles} triangles share the edge {a}-{b}; a sheet has at most two there")]
    NonManifold {
        /// triangles at the edge
        triangles: usize,
        /// smaller node of the edge
        a: u32,
        /// larger node of the edge
        b: u32,
    },
    /// A seam index is out of range.
    #[error("seam {index} names edge {edge}, but the mesh has {edges} edges, numbered from 0")]
    SeamOutOfRange {
        /// which seam entry
        index: usize,
        /// the edge
        edge: u32,
        /// edges in the mesh
        edges: usize,
    },
    /// The list of start displacements has another length than the list of nodes.
    #[error("{found} start displacements for {nodes} nodes; give one for each node or none")]
    Displacement {
        /// displacements in the list
        found: usize,
        /// nodes in the mesh
        nodes: usize,
    },
    /// The lists of what is cut have other lengths than those of the mesh.
    #[error("cut shapes of {found} {what}s for {wanted} {what}s; give one for each or none")]
    Cut {
        /// `edge` or `triangle`
        what: &'static str,
        /// shapes in the list
        found: usize,
        /// how many there are
        wanted: usize,
    },
    /// Pieces cannot be sewn.
    #[error("the pieces cannot be sewn: {0}")]
    Sew(#[from] crate::sew::SewError),
    /// A group has a bad name or bad members.
    #[error("group \"{name}\": {reason}")]
    Group {
        /// its name
        name: String,
        /// what is wrong with it and what to do
        reason: String,
    },
    /// A mesh without edges and triangles, or too large a one.
    #[error("the mesh has {nodes} nodes, {edges} edges and {triangles} triangles: {reason}")]
    Size {
        /// nodes
        nodes: usize,
        /// edges
        edges: usize,
        /// triangles
        triangles: usize,
        /// what is wrong with that
        reason: &'static str,
    },
    /// No mesh may be written there.
    #[error("{}: {reason}", path.display())]
    Target {
        /// the file
        path: PathBuf,
        /// why and what to do
        reason: &'static str,
    },
    /// The work was asked to stop.
    #[error("the mesh is not finished: {0}")]
    Interrupted(#[from] Interrupted),
    /// A mesh file cannot be read or written.
    #[error("{}: {reason}", path.display())]
    File {
        /// the file
        path: PathBuf,
        /// what is wrong and what to do
        reason: String,
    },
}
