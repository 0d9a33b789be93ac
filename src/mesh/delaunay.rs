//! Constrained Delaunay triangulation of a ring, by `spade` (exact predicates).

use nalgebra::Vector2;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

/// Triangles, counter-clockwise, of the constrained Delaunay triangulation of the nodes, without those in the hole.
///
/// The first `hole` nodes are those of the inner loop, which is convex: a triangle of such nodes only is in the hole,
/// and all others are outside it. `None` if two nodes coincide, a coordinate is not finite, or two constraints cross.
pub(super) fn triangulate(points: &[Vector2<f64>], constraints: &[[usize; 2]], hole: usize) -> Option<Vec<[u32; 3]>> {
    let vertices = points.iter().map(|p| Point2::new(p.x, p.y)).collect();
    let mut conflict = false;
    let edges = constraints.to_vec();
    let cdt = ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(vertices, edges, |_| conflict = true);
    let cdt = cdt.ok().filter(|cdt| !conflict && cdt.num_vertices() == points.len())?;
    let faces = cdt.inner_faces().map(|face| face.vertices().map(|v| v.index() as u32));
    // The order of spade's faces is not part of its interface; ours is.
    Some(sorted(faces.filter(|t| t.iter().any(|&n| n as usize >= hole)).collect()))
}

/// The same triangles in ascending order, each turned until its smallest node comes first.
pub(super) fn sorted(mut triangles: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
    for triangle in &mut triangles {
        *triangle = from_smallest(*triangle);
    }
    triangles.sort_unstable();
    triangles
}

/// Turns a triangle until its smallest node comes first.
fn from_smallest([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}
