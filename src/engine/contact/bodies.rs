//! What may touch: nodes, edges and triangles of the scene, and obstacles.
//!
//! The corners of obstacles are numbered after the nodes of the scene. A ball is a node with a thickness, a bar an edge
//! with a thickness; a box is a surface of triangles.

use super::distance::PairKind;
use crate::model::spec::{ObstacleShape, ObstacleSpec, Series};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// One side of a contact.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Body {
    /// its corners and points, ascending
    pub nodes: Vec<u32>,
    /// nodes that are in no element, ascending
    pub points: Vec<u32>,
    /// lines and sides of triangles, ascending
    pub edges: Vec<[u32; 2]>,
    /// edges that are lines, ascending
    pub lines: Vec<[u32; 2]>,
    /// triangles
    pub triangles: Vec<[u32; 3]>,
}

impl Body {
    /// A side made of elements; all sides of its triangles are edges of it.
    pub fn new(triangles: Vec<[u32; 3]>, mut lines: Vec<[u32; 2]>, mut points: Vec<u32>) -> Self {
        let sorted = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
        lines.iter_mut().for_each(|line| *line = sorted(*line));
        lines.sort_unstable();
        lines.dedup();
        let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).map(sorted);
        let mut edges: Vec<[u32; 2]> = lines.iter().copied().chain(sides).collect();
        edges.sort_unstable();
        edges.dedup();
        points.sort_unstable();
        points.dedup();
        let corners = triangles.iter().flatten().chain(lines.iter().flatten());
        let mut nodes: Vec<u32> = corners.chain(&points).copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        Body { nodes, points, edges, lines, triangles }
    }

    /// The same without edges between triangles in one plane, which touch nothing before the triangles do.
    fn without_flat_edges(mut self, corner: impl Fn(u32) -> Vector3<f64>) -> Self {
        let mut sides: BTreeMap<[u32; 2], Vec<Vector3<f64>>> = BTreeMap::new();
        for &[a, b, c] in &self.triangles {
            let normal = (corner(b) - corner(a)).cross(&(corner(c) - corner(a))).try_normalize(0.0).unwrap_or_default();
            for [p, q] in [[a, b], [b, c], [c, a]] {
                sides.entry([p.min(q), p.max(q)]).or_default().push(normal);
            }
        }
        let flat = |edge: &[u32; 2]| {
            let normals = sides.get(edge).map_or(&[][..], Vec::as_slice);
            matches!(normals, [n, m] if n.dot(m) > 1.0 - FLAT)
        };
        self.edges.retain(|edge| !flat(edge));
        self
    }
}

/// [-] 1 - cos of the angle between triangles that are in one plane.
const FLAT: f64 = 1e-12;

/// The surface of a half-space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// [m] a point on it
    pub point: Vector3<f64>,
    /// the unit vector out of it
    pub normal: Vector3<f64>,
}

/// What two sides of a contact are.
#[derive(Clone, Debug, PartialEq)]
pub enum Other {
    /// the same body
    Itself,
    /// another body, of the scene or an obstacle
    Body(Body),
    /// a half-space
    Plane(Plane),
}

impl Other {
    /// Another body, if it is one.
    pub fn body(&self) -> Option<&Body> {
        if let Other::Body(body) = self { Some(body) } else { None }
    }
}

/// Two sides that may touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// the first side
    pub body: Body,
    /// the second one
    pub other: Other,
    /// [m] how much closer than their axes and corners they touch: the radius of an obstacle
    pub thickness: f64,
    /// [m] distance beyond this at which they begin to push
    pub gap: f64,
    /// [-] mu
    pub friction: f64,
    /// [m] displacement of the obstacle over time
    pub motion: Option<Series<[f64; 3]>>,
}

/// All contacts of a scene.
#[derive(Clone, Debug, Default)]
pub struct Contacts {
    /// in the order of the specification
    pub list: Vec<Contact>,
    /// [N/m] kappa of every node of the scene, by each contact; 0 for nodes that are held
    pub stiffness: Vec<Vec<f64>>,
    /// [m] nodes of the scene at rest `[n_nodes]`, for lengths of edges
    pub rest: Vec<Vector3<f64>>,
    /// [m] corners of obstacles without their motion
    pub corners: Vec<Vector3<f64>>,
    /// the contact that every corner belongs to
    pub contact_of: Vec<u16>,
    /// [m] how far nodes may move before pairs are looked for again, twice
    pub skin: f64,
    /// [1/kg] of every node of the scene, 0 where it is held
    pub inverse_mass: Vec<f64>,
}

impl Contacts {
    /// Adds a contact with an obstacle.
    pub fn add_obstacle(&mut self, body: Body, spec: &ObstacleSpec, (gap, friction): (f64, f64)) {
        let (other, thickness) = self.obstacle(&spec.shape);
        let motion = spec.motion.clone();
        self.list.push(Contact { body, other, thickness, gap, friction, motion });
    }

    fn obstacle(&mut self, shape: &ObstacleShape) -> (Other, f64) {
        match shape {
            ObstacleShape::Plane { point, normal } => {
                (Other::Plane(Plane { point: Vector3::from(*point), normal: Vector3::from(*normal) }), 0.0)
            }
            ObstacleShape::Sphere { center, radius } => {
                let [node] = self.add_corners([*center]);
                (Other::Body(Body::new(Vec::new(), Vec::new(), vec![node])), *radius)
            }
            ObstacleShape::Cylinder { from, to, radius } => {
                let axis = self.add_corners([*from, *to]);
                (Other::Body(Body::new(Vec::new(), vec![axis], Vec::new())), *radius)
            }
            ObstacleShape::Box { min, max } => {
                let place = |i: usize| std::array::from_fn(|k| if i >> k & 1 == 0 { min[k] } else { max[k] });
                let nodes = self.add_corners(std::array::from_fn::<[f64; 3], 8, _>(place));
                (self.surface(BOX.iter().map(|t| t.map(|i| nodes[i]))), 0.0)
            }
            ObstacleShape::Surface { nodes, triangles } => {
                let first = (self.rest.len() + self.corners.len()) as u32;
                nodes.iter().for_each(|node| _ = self.add_corners([*node]));
                (self.surface(triangles.iter().map(|t| t.map(|i| first + i))), 0.0)
            }
        }
    }

    fn surface(&self, triangles: impl Iterator<Item = [u32; 3]>) -> Other {
        let body = Body::new(triangles.collect(), Vec::new(), Vec::new());
        Other::Body(body.without_flat_edges(|node| self.corners[node as usize - self.rest.len()]))
    }

    fn add_corners<const N: usize>(&mut self, corners: [[f64; 3]; N]) -> [u32; N] {
        let first = (self.rest.len() + self.corners.len()) as u32;
        self.corners.extend(corners.map(Vector3::from));
        self.contact_of.extend([self.list.len() as u16; N]);
        std::array::from_fn(|i| first + i as u32)
    }

    /// Whether a node is one of the scene.
    pub fn is_node(&self, node: u32) -> bool {
        (node as usize) < self.rest.len()
    }

    /// [m] Where a node is at rest, or a corner without its motion.
    pub fn at_rest(&self, node: u32) -> Vector3<f64> {
        let i = node as usize;
        self.rest.get(i).copied().unwrap_or_else(|| self.corners[i - self.rest.len()])
    }

    /// [N/m] kappa of a pair: that of its softer side.
    pub(super) fn stiffness_of(&self, contact: usize, sides: [&[u32]; 2]) -> f64 {
        let mean = |side: &[u32]| {
            let of = |node: &u32| self.stiffness[contact].get(*node as usize).copied().unwrap_or(0.0);
            side.iter().map(of).sum::<f64>() / side.len() as f64
        };
        let softest = sides.map(mean).into_iter().filter(|k| *k > 0.0).fold(f64::INFINITY, f64::min);
        if softest.is_finite() { softest } else { 0.0 }
    }

    /// Whether something moves by itself.
    pub fn moves(&self) -> bool {
        self.list.iter().any(|contact| contact.motion.is_some())
    }

    /// Whether there is friction.
    pub fn rubs(&self) -> bool {
        self.list.iter().any(|contact| contact.friction > 0.0)
    }
}

/// Corners of the triangles of a box, right-handed about the outer normal; the bits of a corner say where it is the
/// larger one along x, y and z.
const BOX: [[usize; 3]; 12] = [
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
];

/// How the nodes of a pair are divided between its sides.
pub fn sides(kind: PairKind, nodes: &[u32; 4]) -> [&[u32]; 2] {
    nodes[..kind.nodes()].split_at(kind.nodes_of_first()).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box is closed, turned outwards, of its volume, and has its twelve edges only.
    #[test]
    fn a_box_is_a_closed_surface() {
        let mut contacts = Contacts::default();
        let shape = ObstacleShape::Box { min: [-1.0, 2.0, 0.5], max: [1.0, 5.0, 1.5] };
        contacts.add_obstacle(Body::default(), &ObstacleSpec { shape, motion: None }, (0.1, 0.0));
        let Other::Body(body) = &contacts.list[0].other else { panic!("a body") };
        let corner = |node: u32| contacts.corners[node as usize];
        let volume: f64 = body.triangles.iter().map(|t| t.map(corner)).map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum();
        assert!((volume - 6.0).abs() < 1e-12, "{volume}");
        assert_eq!((body.nodes.len(), body.edges.len(), body.lines.len()), (8, 12, 0));
    }
}
