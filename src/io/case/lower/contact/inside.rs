//! Nodes that are inside of a rigid body at the start, where nothing could push them out in order.

use super::{Scene, name_of, nodes_of};
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::contact::distance::{PairKind, nearest};
use crate::format_number::figures;
use crate::mesh::box_tree::{Bounds, BoxTree};
use crate::model::spec::{ContactSide, ContactSpec, ObstacleShape, ObstacleSpec};
use nalgebra::Vector3;

/// [-] Depth over the largest coordinate up to which a node only touches a body.
const TOUCHING: f64 = 1e-9;
/// [-] Boxes of triangles that the search of a node may look at, which is more than a surface of any use needs.
const LOOKS: u64 = 1_000_000;

/// Adds a fault for nodes that can move and are inside of the body of a contact.
pub(super) fn at_start(at: &Pointer, spec: &ContactSpec, scene: &Scene<'_>, faults: &mut Faults<'_>) {
    let ContactSide::Obstacle(body) = &spec.other else { return };
    let solid = Solid::of(body);
    let candidates = nodes_of(&spec.parts, scene.geometry).into_iter().filter(|node| (scene.moves)(*node));
    let mut inside = candidates.filter(|node| {
        let x = scene.start(*node);
        solid.depth(x).is_some_and(|depth| depth > TOUCHING * x.amax())
    });
    let Some(first) = inside.next() else { return };
    let depth = solid.depth(scene.start(first)).unwrap_or(0.0);
    let (key, name) = name_of(body);
    let below = if key == "plane" { "below" } else { "inside of" };
    let more = match inside.count() {
        0 => String::new(),
        1 => "; so is another node".to_owned(),
        n => format!("; so are {n} other nodes"),
    };
    let value = format!("node {first} is {} m {below} the {name} at the start{more}", figures(depth, 3));
    let hint = format!("move the {name} or these nodes, at least until they touch");
    let place = at.key("between").index(1).key(key);
    faults.add_value(&place, value, format!("a {name} with all nodes that can move outside of it"), Some(hint));
}

/// A body where it is at the start.
struct Solid<'a> {
    shape: &'a ObstacleShape,
    /// [m] its motion at t = 0
    shift: Vector3<f64>,
    /// around the triangles of a surface
    tree: Option<BoxTree>,
}

impl<'a> Solid<'a> {
    fn of(body: &'a ObstacleSpec) -> Self {
        let shift = body.motion.as_ref().map_or(Vector3::zeros(), |motion| Vector3::from(motion.at(0.0)));
        let tree = match &body.shape {
            ObstacleShape::Surface { nodes, triangles } => {
                let boxes = triangles.iter().map(|corners| Bounds::of(corners.map(|n| &nodes[n as usize])));
                Some(BoxTree::new(&boxes.collect::<Vec<_>>()))
            }
            _ => None,
        };
        Solid { shape: &body.shape, shift, tree }
    }

    /// [m] How far a point is below the surface; `None` or not above 0 outside.
    fn depth(&self, x: Vector3<f64>) -> Option<f64> {
        let x = x - self.shift;
        match self.shape {
            ObstacleShape::Plane { point, normal } => Some((Vector3::from(*point) - x).dot(&Vector3::from(*normal))),
            ObstacleShape::Sphere { center, radius } => Some(radius - (x - Vector3::from(*center)).norm()),
            ObstacleShape::Cylinder { from, to, radius } => {
                let [from, to] = [from, to].map(|end| Vector3::from(*end));
                Some(radius - nearest(PairKind::NodeEdge, &[x, from, to, to]).distance)
            }
            ObstacleShape::Box { min, max } => {
                let along = |k: usize| f64::min(x[k] - min[k], max[k] - x[k]);
                Some((0..3).map(along).fold(f64::INFINITY, f64::min))
            }
            ObstacleShape::Surface { nodes, triangles } => {
                let tree = self.tree.as_ref()?;
                let corners = |t: u32| triangles[t as usize];
                inside(x, nodes, corners, tree).then(|| {
                    let at = |node: u32| Vector3::from(nodes[node as usize]);
                    let distance = |corners: &[u32; 3]| {
                        let [a, b, c] = corners.map(at);
                        nearest(PairKind::NodeTriangle, &[x, a, b, c]).distance
                    };
                    triangles.iter().map(distance).fold(f64::INFINITY, f64::min)
                })
            }
        }
    }
}

/// Whether a ray from a point along x leaves a closed surface more often than it enters it.
fn inside(x: Vector3<f64>, nodes: &[[f64; 3]], corners: impl Fn(u32) -> [u32; 3], tree: &BoxTree) -> bool {
    let all = tree.bounds();
    if !(0..3).all(|k| all.low[k] < x[k] && x[k] < all.high[k]) {
        return false;
    }
    let ray = Bounds { low: x.into(), high: [all.high[0] + all.extent(), x.y, x.z] };
    // A box that a line runs through on its very side does not overlap it: the ray gets a width of rounding.
    let width = TOUCHING * all.low.iter().chain(&all.high).fold(0.0, |most: f64, x| most.max(x.abs()));
    let (mut looks, mut turns) = (LOOKS, 0);
    tree.within(&ray.grown(width), &mut looks, |triangle| turns += crossed(x, nodes, corners(triangle)));
    looks > 0 && turns > 0
}

/// 1 if a ray along x leaves through a triangle, -1 if it enters, 0 if it passes it.
///
/// A ray that meets an edge passes on one side of it, the same for both of its triangles.
fn crossed(x: Vector3<f64>, nodes: &[[f64; 3]], corners: [u32; 3]) -> i32 {
    let [a, b, c] = corners;
    let sides = [[a, b], [b, c], [c, a]].map(|[from, to]| {
        let turn = left_of(x, [from.min(to), from.max(to)].map(|node| nodes[node as usize]));
        if from < to { turn } else { -turn }
    });
    let turn = sides[0];
    if turn == 0 || sides != [turn; 3] {
        return 0;
    }
    let [a, b, c] = corners.map(|node| Vector3::from(nodes[node as usize]));
    let normal = (b - a).cross(&(c - a));
    let beyond = (a - x).dot(&normal) / normal.x;
    if beyond > 0.0 { turn } else { 0 }
}

/// Whether a point is on the left (1) or the right (-1) of an edge, as seen along -x; 0 for an edge along x. A point in
/// line with the edge counts as one that is a little further along y, and far less along z.
fn left_of(x: Vector3<f64>, [from, to]: [[f64; 3]; 2]) -> i32 {
    let (dy, dz) = (to[1] - from[1], to[2] - from[2]);
    let turn = dy * (x.z - from[2]) - dz * (x.y - from[1]);
    let sign = |value: f64| i32::from(value > 0.0) - i32::from(value < 0.0);
    [turn, -dz, dy].map(sign).into_iter().find(|sign| *sign != 0).unwrap_or(0)
}
