//! What lies on cloth that it does not belong to: ends of lines, and other triangles.

use super::rim::Rim;
use super::{Cloth, GAP, LOOKS};
use crate::box_tree::{Bounds, BoxTree};
use crate::hanging::HangingNode;
use crate::warning::{Warning, WarningCode};
use nalgebra::Vector3;

/// [-] Distance over the size of a triangle within which a point lies on it.
const ON: f64 = 1e-4;
/// [-] Distance of a line's end from cloth, over the length of the edges there, within which it is meant to be on it.
const END: f64 = 0.3;
/// [-] Least cosine between the normals of triangles that lie on each other.
const FLAT: f64 = 0.9999;

/// What lies on cloth.
#[derive(Debug, Default)]
pub(super) struct Found {
    /// ends of lines near a node of the cloth, each with that node
    pub line_ends: Vec<[u32; 2]>,
    pub warnings: Vec<Warning>,
}

/// Finds ends of lines on cloth that does not have them, and triangles on triangles.
///
/// Those among the hanging nodes, ascending, are told there.
pub(super) fn find(cloth: &Cloth<'_>, rim: &Rim, hanging: &[HangingNode]) -> Found {
    let mut found = Found::default();
    let mut ends = loose_ends(cloth);
    ends.retain(|end| hanging.binary_search_by_key(end, |one| one.node).is_err());
    let mut on: Vec<(u32, u32, f64)> = Vec::new();
    let points: Vec<Vector3<f64>> = ends.iter().map(|node| cloth.mesh.point(*node)).collect();
    let reach = GAP * cloth.extent;
    near_triangles(cloth, &points, reach, |end, triangle, size| {
        let away = from_triangle(cloth, points[end], triangle);
        if away <= reach.min(END * size) {
            on.push((ends[end], triangle, away));
        }
    });
    on.sort_by(|a, b| a.0.cmp(&b.0).then(a.2.total_cmp(&b.2)).then(a.1.cmp(&b.1)));
    on.dedup_by_key(|one| one.0);
    let mut beside = Vec::new();
    for (node, triangle, _) in on {
        let from = |corner: u32| (cloth.mesh.point(corner) - cloth.mesh.point(node)).norm();
        let corners = cloth.mesh.triangles[triangle as usize];
        let nearest = corners.into_iter().min_by(|a, b| from(*a).total_cmp(&from(*b)));
        match nearest.filter(|corner| from(*corner) <= reach) {
            Some(corner) => found.line_ends.push([corner, node]),
            None => beside.push((node, triangle)),
        }
    }
    found.warnings.extend(told(&beside));
    found.warnings.extend(overlaps(cloth, rim));
    found
}

/// Ends of lines that belong to no triangle.
fn loose_ends(cloth: &Cloth<'_>) -> Vec<u32> {
    let mut lines = vec![0_u32; cloth.mesh.nodes.len()];
    cloth.lines().for_each(|(_, pair)| pair.iter().for_each(|node| lines[*node as usize] += 1));
    let ends = (0_u32..).zip(&lines).filter(|(node, lines)| **lines == 1 && !cloth.of_triangle[*node as usize]);
    ends.map(|(node, _)| node).collect()
}

/// Calls `visit` for points and triangles whose box with a margin of `reach` [m] has the point, with the triangle's
/// longest side [m]. The points are in the tree, since they are few.
fn near_triangles(cloth: &Cloth<'_>, points: &[Vector3<f64>], reach: f64, mut visit: impl FnMut(usize, u32, f64)) {
    if points.is_empty() {
        return;
    }
    let boxes: Vec<Bounds> = points.iter().map(|x| Bounds::of([&(*x).into()])).collect();
    let tree = BoxTree::new(&boxes);
    let all = tree.bounds();
    let mut looks = LOOKS * (points.len() + cloth.mesh.triangles.len()) as u64;
    for (number, triangle) in (0..).zip(&cloth.mesh.triangles) {
        let bounds = Bounds::of(triangle.map(|node| &cloth.mesh.nodes[node as usize]));
        let size = bounds.extent();
        let bounds = bounds.grown(reach.max(ON * size));
        if bounds.overlaps(&all) {
            tree.within(&bounds, &mut looks, |point| visit(point as usize, number, size));
        }
    }
}

/// [m] Distance of a point from a triangle.
fn from_triangle(cloth: &Cloth<'_>, x: Vector3<f64>, triangle: u32) -> f64 {
    let [a, b, c] = cloth.mesh.triangles[triangle as usize].map(|node| cloth.mesh.point(node));
    let ([u, v, w], height) = place(x, [a, b, c]);
    if u >= 0.0 && v >= 0.0 && w >= 0.0 {
        return height.abs();
    }
    let from_side = |p: Vector3<f64>, q: Vector3<f64>| {
        let along = q - p;
        (x - p - along * ((x - p).dot(&along) / along.norm_squared()).clamp(0.0, 1.0)).norm()
    };
    from_side(a, b).min(from_side(b, c)).min(from_side(c, a))
}

/// Barycentric coordinates of a point and its height [m] over a triangle.
fn place(x: Vector3<f64>, [a, b, c]: [Vector3<f64>; 3]) -> ([f64; 3], f64) {
    let normal = (b - a).cross(&(c - a));
    let square = normal.norm_squared();
    let v = (x - a).cross(&(c - a)).dot(&normal) / square;
    let w = (b - a).cross(&(x - a)).dot(&normal) / square;
    ([1.0 - v - w, v, w], (x - a).dot(&normal) / square.sqrt())
}

fn told(beside: &[(u32, u32)]) -> Option<Warning> {
    let &(node, triangle) = beside.first()?;
    let more = if beside.len() > 1 { format!(" (the first of {} such ends)", beside.len()) } else { String::new() };
    let text = format!(
        "the line that ends at node {node} ends on triangle {triangle}{more}, away from its corners, so it is not joined to the \
         cloth: end it at a node of the cloth, or split the triangle there"
    );
    Some(Warning::new(WarningCode::HangingNode, text))
}

/// Triangles that lie on others: neighbours that are folded onto each other, and rims over cloth. Where sheets in one
/// surface overlap, one of them has its rim over the other.
fn overlaps(cloth: &Cloth<'_>, rim: &Rim) -> Option<Warning> {
    let mesh = cloth.mesh;
    let corners = |triangle: u32| mesh.triangles[triangle as usize].map(|node| mesh.point(node));
    let normal = |[a, b, c]: [Vector3<f64>; 3]| (b - a).cross(&(c - a));
    let in_plane = |[s, t]: [u32; 2]| {
        let [n, m] = [s, t].map(|triangle| normal(corners(triangle)));
        n.dot(&m).abs() > FLAT * (n.norm_squared() * m.norm_squared()).sqrt()
    };
    let mut pairs: Vec<[u32; 2]> = Vec::new();
    for ([a, b], triangles) in cloth.topology.sides() {
        let [from, along] = [mesh.point(a), mesh.point(b) - mesh.point(a)];
        let square = along.norm_squared();
        // To the corner across the edge.
        let up = |triangle: u32| {
            let corners = mesh.triangles[triangle as usize];
            mesh.point(corners.into_iter().find(|node| *node != a && *node != b).unwrap_or(a)) - from
        };
        // Of the parts of both that are square to the edge, times its length squared.
        let dot = |u: Vector3<f64>, v: Vector3<f64>| u.dot(&v) * square - u.dot(&along) * v.dot(&along);
        for (i, s) in triangles.iter().enumerate() {
            for t in triangles.iter().skip(i + 1).take(8) {
                let [u, v] = [*s, *t].map(up);
                let cosine = dot(u, v);
                if cosine > 0.0 && cosine > FLAT * (dot(u, u) * dot(v, v)).sqrt() {
                    pairs.push([*s, *t]);
                }
            }
        }
    }
    // A point inside the triangle at every edge of the rim, where lines between other nodes hardly pass.
    let inside = |triangle: u32| {
        let [a, b, c] = corners(triangle);
        a * 0.45 + b * 0.34 + c * 0.21
    };
    let points: Vec<Vector3<f64>> = rim.edges.iter().map(|edge| inside(edge.triangle)).collect();
    near_triangles(cloth, &points, 0.0, |point, triangle, size| {
        let own = rim.edges[point].triangle;
        if own == triangle {
            return;
        }
        let (at, height) = place(points[point], corners(triangle));
        if at.iter().all(|x| *x > 0.02) && height.abs() <= ON * size && in_plane([own, triangle]) {
            pairs.push([own.min(triangle), own.max(triangle)]);
        }
    });
    pairs.sort_unstable();
    pairs.dedup();
    let &[s, t] = pairs.first()?;
    let text = match pairs.len() {
        1 => format!("triangle {t} lies on triangle {s}"),
        n => format!("{n} pairs of triangles lie on each other, such as {s} and {t}"),
    };
    let text = format!(
        "{text}: the cloth is double there, with twice its mass and load; delete one of the two, or move its nodes apart"
    );
    Some(Warning::new(WarningCode::OverlappingTriangles, text))
}
