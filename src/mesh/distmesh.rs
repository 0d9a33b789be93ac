//! Graded meshes by spring relaxation: P.-O. Persson & G. Strang, "A simple mesh generator in MATLAB", SIAM Review 46(2), 2004.
//!
//! Other than there, the boundary nodes are laid out first and stay, so that their number is met exactly, and the interior starts
//! from an even spiral of the exact number of nodes. The relaxed mesh is then polished ([`super::polish`]).

use super::delaunay::triangulate;
use super::layout::{Freedom, Plan, Request, Start};
use super::polish::polish;
use super::random::SplitMix64;
use super::sdf::SizeFunction;
use super::{Mesh, MeshError, quality, topology};
use glam::DVec2;

/// [-] how much longer than wanted the springs are, so that the nodes spread to the boundary (`Fscale`)
const OVERLENGTH: f64 = 1.2;
/// [-] step of the explicit Euler relaxation (`deltat`)
const STEP: f64 = 0.2;
/// [-] movement since the last triangulation, over the wanted edge length, that calls for a new one (`ttol`)
const RETRIANGULATE: f64 = 0.1;
/// [-] movement in a step, over the wanted edge length, below which the mesh rests (`dptol`)
const REST: f64 = 1e-3;
/// [-] distance to the boundary, over the wanted edge length, that interior nodes keep
const CLEARANCE: f64 = 0.4;
/// most iterations of an attempt
const ITERATIONS: usize = 2000;
/// attempts, each from other pseudo-random numbers
const ATTEMPTS: u64 = 5;
/// [deg] smallest angle at which no further attempt is made
const GOOD_ANGLE: f64 = 26.0;
/// [deg] smallest angle with which a mesh is handed out
const LEAST_ANGLE: f64 = 20.0;

/// Makes the mesh that a request asks for.
///
/// # Errors
/// Counts that do not go together, a relaxation that finds no rest, or no attempt with acceptable angles.
pub(super) fn generate(request: &Request, seed: u64) -> Result<Mesh, MeshError> {
    let plan = request.plan()?;
    let mut best: Option<(f64, Start, Vec<[u32; 3]>)> = None;
    let mut failure = None;
    for attempt in 0..ATTEMPTS {
        let mut start = plan.start(SplitMix64::new(seed, attempt));
        match relax(&plan, &mut start).and_then(|()| polish(&plan, &mut start)) {
            Ok(triangles) => {
                let angle = quality::smallest_angle(&start.points, &triangles).degrees;
                if best.as_ref().is_none_or(|b| angle > b.0) {
                    best = Some((angle, start, triangles));
                }
                if angle >= GOOD_ANGLE {
                    break;
                }
            }
            Err(error) => failure = failure.or(Some(error)),
        }
    }
    match (best, failure) {
        (Some((angle, start, triangles)), _) => finish(angle, &start, triangles),
        (None, Some(error)) => Err(error),
        (None, None) => Err(MeshError::Triangulation { found: 0, expected: plan.triangles }),
    }
}

/// Turns points into a mesh, or refuses bad angles.
fn finish(angle: f64, start: &Start, triangles: Vec<[u32; 3]>) -> Result<Mesh, MeshError> {
    if angle < LEAST_ANGLE {
        let at = quality::smallest_angle(&start.points, &triangles).at;
        return Err(MeshError::Quality { angle, required: LEAST_ANGLE, x: at.x, y: at.y });
    }
    let edges = topology::unique_edges(&triangles);
    let seam = |&[a, b]: &[usize; 2]| edges.binary_search(&[a.min(b) as u32, a.max(b) as u32]).ok().map(|e| e as u32);
    let mut seams: Vec<u32> = start.constraints[start.loop_edges..].iter().filter_map(seam).collect();
    seams.sort_unstable();
    let nodes = start.points.iter().map(|p| [p.x, p.y, 0.0]).collect();
    Ok(Mesh { nodes, edges, triangles, seams })
}

/// Triangulates and checks the count, which only holds if all constraints are there and nothing lies outside.
pub(super) fn triangulate_plan(plan: &Plan, start: &Start) -> Result<Vec<[u32; 3]>, MeshError> {
    let triangles = triangulate(&start.points, &start.constraints, plan.loops[0]).unwrap_or_default();
    if triangles.len() == plan.triangles {
        Ok(triangles)
    } else {
        Err(MeshError::Triangulation { found: triangles.len(), expected: plan.triangles })
    }
}

/// Moves the nodes until the springs are at rest (Persson & Strang 2004, section 3, steps 3 to 8).
fn relax(plan: &Plan, start: &mut Start) -> Result<(), MeshError> {
    if plan.free == 0 && plan.seam_nodes == 0 {
        return Ok(());
    }
    let mut bars = Vec::new();
    let mut last = vec![DVec2::INFINITY; start.points.len()];
    let mut forces = vec![DVec2::ZERO; start.points.len()];
    let mut movement = f64::INFINITY;
    for _ in 0..ITERATIONS {
        if moved_far(&plan.size, &start.points, &last) {
            bars = bars_of(&triangulate_plan(plan, start)?, &start.freedom);
            last.copy_from_slice(&start.points);
        }
        spring_forces(&plan.size, &start.points, &bars, &mut forces);
        movement = step(&plan.size, start, &forces);
        if movement < REST {
            return Ok(());
        }
    }
    Err(MeshError::NotRelaxed { iterations: ITERATIONS, movement, tolerance: REST })
}

fn moved_far(size: &SizeFunction, points: &[DVec2], last: &[DVec2]) -> bool {
    let far = |(p, q): (&DVec2, &DVec2)| !(p.distance_squared(*q) < (RETRIANGULATE * size.at(p.length())).powi(2));
    points.iter().zip(last).any(far)
}

/// Edges with at least one end that can move.
fn bars_of(triangles: &[[u32; 3]], freedom: &[Freedom]) -> Vec<[u32; 2]> {
    let mut bars = topology::unique_edges(triangles);
    bars.retain(|bar| bar.iter().any(|&n| freedom[n as usize] != Freedom::Fixed));
    bars
}

/// Forces max(F0 - L, 0), repulsive only; the wanted lengths are scaled so that their squares sum up to those of the actual ones.
fn spring_forces(size: &SizeFunction, points: &[DVec2], bars: &[[u32; 2]], forces: &mut [DVec2]) {
    let ends = |bar: &[u32; 2]| bar.map(|n| points[n as usize]);
    let (mut actual, mut wanted) = (0.0, 0.0);
    for bar in bars {
        let [a, b] = ends(bar);
        actual += a.distance_squared(b);
        wanted += size.at((0.5 * (a + b)).length()).powi(2);
    }
    let scale = OVERLENGTH * (actual / wanted).sqrt();
    forces.fill(DVec2::ZERO);
    for bar in bars {
        let [a, b] = ends(bar);
        let length = a.distance(b);
        let push = scale * size.at((0.5 * (a + b)).length()) - length;
        if push > 0.0 && length > 0.0 {
            let force = (b - a) * (push / length);
            forces[bar[0] as usize] -= force;
            forces[bar[1] as usize] += force;
        }
    }
}

/// One step; returns the largest movement over the wanted edge length.
fn step(size: &SizeFunction, start: &mut Start, forces: &[DVec2]) -> f64 {
    let ring = size.ring;
    let mut largest: f64 = 0.0;
    for ((point, freedom), force) in start.points.iter_mut().zip(&start.freedom).zip(forces) {
        let h = size.at(point.length());
        let target = match *freedom {
            Freedom::Fixed => continue,
            Freedom::Free => *point + STEP * *force,
            Freedom::Ray(direction) => {
                // Kept off the loops and, on a disc, off the centre.
                let radius = point.length() + STEP * force.dot(direction);
                let low = if ring.has_hole() { 0.0 } else { CLEARANCE * h };
                radius.max(low) * direction
            }
        };
        let target = ring.pushed_inside(target, CLEARANCE * h);
        largest = largest.max(target.distance(*point) / h);
        *point = target;
    }
    largest
}
