//! Constrained Delaunay triangulation of a ring, and of outlines with holes, by `spade` (exact predicates).

use super::tuples::in_order;
use nalgebra::Vector2;
use spade::{AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation};
use std::collections::HashSet;

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
    let faces: Vec<[u32; 3]> = faces.filter(|t| t.iter().any(|&n| n as usize >= hole)).collect();
    Some(sorted(faces.iter().copied()))
}

/// Triangles inside outlines, and the points that they have beside those of the outlines.
pub(super) struct Filled {
    pub inner: Vec<Vector2<f64>>,
    /// counter-clockwise; points of the outlines are counted first
    pub triangles: Vec<[u32; 3]>,
}

/// Why outlines are not filled.
pub(super) enum Unfilled {
    /// two points coincide, or two sides cross
    Crossed,
    /// more points than allowed would be needed
    Unending,
}

/// [deg] Angle below which a triangle gets a point at its circumcentre; from about 30 on this may never end.
const ANGLE: f64 = 25.0;

/// Fills an outline with holes, whose sides stay as they are: Delaunay refinement (Ruppert 1995) until no triangle is
/// larger than `largest` and none has a small angle, where the sides allow. It adds at most `most` points.
pub(super) fn fill(
    points: &[Vector2<f64>],
    sides: &[[usize; 2]],
    largest: f64,
    most: usize,
) -> Result<Filled, Unfilled> {
    // Away from zero, near which spade takes no coordinates.
    let bound = |pick: fn(f64, f64) -> f64| points.iter().copied().reduce(|a, b| a.zip_map(&b, pick));
    let (low, high) = bound(f64::min).zip(bound(f64::max)).ok_or(Unfilled::Crossed)?;
    let size = (high - low).max();
    let vertices = points.iter().map(|p| (p - low) / size).map(|p| Point2::new(1.0 + p.x, 1.0 + p.y)).collect();
    let mut crossed = false;
    let cdt = ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(vertices, sides.to_vec(), |_| {
        crossed = true;
    });
    let loaded = cdt.ok().filter(|cdt| !crossed && cdt.num_vertices() == points.len());
    let mut cdt = loaded.ok_or(Unfilled::Crossed)?;
    let wanted = RefinementParameters::new().exclude_outer_faces(true).keep_constraint_edges();
    let wanted = wanted.with_angle_limit(AngleLimit::from_deg(ANGLE)).with_max_additional_vertices(most);
    let largest = largest / (size * size);
    let refined = cdt.refine(wanted.with_max_allowed_area(largest).with_min_required_area(1e-6 * largest));
    if !refined.refinement_complete {
        return Err(Unfilled::Unending);
    }
    let outside: HashSet<_> = refined.excluded_faces.into_iter().collect();
    let inside = cdt.inner_faces().filter(|face| !outside.contains(&face.fix()));
    let triangles: Vec<[u32; 3]> = inside.map(|face| face.vertices().map(|v| v.index() as u32)).collect();
    let triangles = sorted(triangles.iter().copied());
    let place = |p: Point2<f64>| low + size * Vector2::new(p.x - 1.0, p.y - 1.0);
    let inner = cdt.vertices().skip(points.len()).map(|vertex| place(vertex.position())).collect();
    Ok(Filled { inner, triangles })
}

/// The same triangles in ascending order, each turned until its smallest node comes first.
pub(super) fn sorted(triangles: impl Iterator<Item = [u32; 3]> + Clone) -> Vec<[u32; 3]> {
    let mut sorted = Vec::new();
    in_order(triangles.map(from_smallest), |triangle, _| sorted.push(triangle));
    sorted
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
