//! Local improvement of the sharpest triangles after the relaxation.
//!
//! Each node of a sharp triangle moves to the position with the largest smallest angle around it, by a search as in
//! Freitag, Jones & Plassmann (1995), "An efficient parallel algorithm for mesh smoothing". Then the mesh is
//! triangulated again (a large mesh by flips). Neither step lowers the mesh's smallest angle: the first by
//! construction, the second because a (constrained) Delaunay triangulation maximises it.

use super::MeshError;
use super::adjacency::Adjacency;
use super::distmesh::follow_plan;
use super::flips::Flips;
use super::layout::{Freedom, Layout, MeshPlan};
use super::quality::{plainly_above, smallest_angle_of};
use crate::interrupt;
use nalgebra::Vector2;

/// [deg] triangles with a smaller angle are improved
const TARGET: f64 = 33.0;
/// most rounds of moving and triangulating
const ROUNDS: usize = 30;
/// [-] first and last step of a node's search, over the wanted edge length
const SEARCH: [f64; 2] = [0.2, 0.002];
/// most moves and halvings of a step in a node's search; some ten are usual
const MOVES: usize = 200;

/// Improves the mesh in place and returns its triangles; `flips` is its triangulation before the nodes moved last.
pub(super) fn polish(plan: &MeshPlan, start: &mut Layout, mut flips: Flips) -> Result<Vec<[u32; 3]>, MeshError> {
    let mut triangles = follow_plan(plan, start, &mut flips)?;
    for _ in 0..ROUNDS {
        interrupt::check()?;
        let nodes = nodes_of_sharp(&start.points, &triangles);
        let corners = triangles.iter().zip(0..).flat_map(|(corners, t)| corners.map(|node| (node, t)));
        let stars = Adjacency::new(start.points.len(), corners);
        let mut moved = false;
        for node in nodes {
            moved |= improve(plan, start, &triangles, stars.row(node), node);
        }
        if !moved {
            break;
        }
        triangles = follow_plan(plan, start, &mut flips)?;
    }
    Ok(triangles)
}

/// Nodes of triangles below the target, ascending.
fn nodes_of_sharp(points: &[Vector2<f64>], triangles: &[[u32; 3]]) -> Vec<u32> {
    let cotangent = 1.0 / TARGET.to_radians().tan();
    let is_sharp = |t: &&[u32; 3]| {
        let corners = t.map(|n| points[n as usize]);
        !plainly_above(cotangent, corners) && smallest_angle_of(corners) < TARGET
    };
    let sharp = triangles.iter().filter(is_sharp);
    let mut nodes: Vec<u32> = sharp.flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Searches along eight directions (a ray's two on a seam) with halving steps; true if the node moved.
fn improve(plan: &MeshPlan, start: &mut Layout, triangles: &[[u32; 3]], star: &[u32], node: u32) -> bool {
    let here = start.points[node as usize];
    let diagonal = Vector2::new(std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2);
    let directions = match start.freedom[node as usize] {
        Freedom::Fixed => return false,
        Freedom::Ray(direction) => vec![direction],
        Freedom::Free => vec![Vector2::x(), Vector2::y(), diagonal, Vector2::new(-diagonal.y, diagonal.x)],
    };
    let worst = |at: Vector2<f64>| {
        let corner = |n: u32| if n == node { at } else { start.points[n as usize] };
        star.iter().map(|&t| smallest_angle_of(triangles[t as usize].map(corner))).fold(f64::INFINITY, f64::min)
    };
    let first = worst(here);
    let (mut best, mut angle) = (here, first);
    let h = plan.size.at(here.norm());
    let mut reach = SEARCH[0] * h;
    for _ in 0..MOVES {
        if reach <= SEARCH[1] * h {
            break;
        }
        let candidates = directions.iter().flat_map(|d| [best + reach * *d, best - reach * *d]);
        let scored = candidates.map(|c| (worst(c), c)).max_by(|a, b| a.0.total_cmp(&b.0));
        match scored {
            Some((better, at)) if better > angle => (best, angle) = (at, better),
            _ => reach *= 0.5,
        }
    }
    // Gains of the size of rounding do not justify another round.
    let gained = angle > first + 1e-3;
    if gained {
        start.points[node as usize] = best;
    }
    gained
}
