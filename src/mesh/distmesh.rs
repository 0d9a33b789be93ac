//! Graded meshes by spring relaxation: P.-O. Persson & G. Strang, "A simple mesh generator in MATLAB", SIAM Review
//! 46(2), 2004.
//!
//! Unlike there, the boundary nodes are placed first and do not move, so that their number is exact. The interior
//! starts from an even spiral with the exact number of nodes. The relaxed mesh is then polished ([`super::polish`]).
//!
//! The interior nodes of a large mesh (more nodes than [`MANY`](super::layout::MANY)) are numbered along Hilbert's
//! curve. It starts from a relaxed mesh of a quarter of its nodes ([`super::coarse`]), takes few iterations, and is
//! triangulated once; after that, edges are flipped. Full convergence would need a number of iterations that grows with
//! the number of nodes, and would hardly change the angles.

use super::delaunay::{sorted, triangulate};
use super::flips::Flips;
use super::layout::{Freedom, GradedRequest, Layout, MeshPlan};
use super::polish::polish;
use super::random::SplitMix64;
use super::sdf::{SizeFunction, turned_off_seams};
use super::{Mesh, MeshError, quality, topology};
use crate::interrupt;
use multiversion::multiversion;
use nalgebra::Vector2;

/// [-] length of the springs over the wanted length, so that the nodes spread to the boundary (`Fscale`)
const OVERLENGTH: f64 = 1.2;
/// [-] step of the relaxation times the bars at a node (`deltat`, 0.2 there, where a node has about six)
const STEP: f64 = 1.0;
/// [-] share of the last movement that a step keeps
const MOMENTUM: f64 = 0.9;
/// [-] movement since the last triangulation, over the wanted edge length, above which a new one is made (`ttol`)
const RETRIANGULATE: f64 = 0.1;
/// [-] movement in a step, over the wanted edge length, below which the mesh has converged (`dptol`)
const REST: f64 = 1e-3;
/// [-] least distance of interior nodes to the boundary, over the wanted edge length
pub(super) const CLEARANCE: f64 = 0.4;
/// most iterations to rest
const ITERATIONS: usize = 2000;
/// Iterations from a spiral of a large mesh, or of one that another starts from: the mean smallest angle of a triangle
/// is then 54.6 degrees with 100,000 nodes (55.5 at rest) and 52 with a million.
const FROM_SPIRAL: usize = 100;
/// Iterations of a large mesh from a coarser one: the mean smallest angle is then 54.6 degrees with 100,000 nodes and
/// 54.9 with a million.
const AFTER_COARSER: usize = 10;
/// attempts, each with different pseudo-random numbers
const ATTEMPTS: u64 = 5;
/// [deg] smallest angle above which no further attempt is made
const GOOD_ANGLE: f64 = 26.0;
/// [deg] least smallest angle of an accepted mesh
const LEAST_ANGLE: f64 = 20.0;

/// Makes the requested mesh.
///
/// # Errors
/// Inconsistent counts, a relaxation that does not converge, or no attempt with acceptable angles.
pub(super) fn generate(request: &GradedRequest, seed: u64) -> Result<Mesh, MeshError> {
    let plan = request.plan()?;
    let mut best: Option<(f64, Layout, Vec<[u32; 3]>)> = None;
    let mut failure = None;
    for attempt in 0..ATTEMPTS {
        // What is wrong may be wrong in the coarser mesh.
        let from_coarser = attempt.is_multiple_of(2);
        match relaxed(&plan, SplitMix64::new(seed, attempt), [from_coarser, false]) {
            Ok((layout, triangles)) => {
                let angle = quality::smallest_angle(&layout.points, &triangles).degrees;
                if best.as_ref().is_none_or(|b| angle > b.0) {
                    best = Some((angle, layout, triangles));
                }
                if angle >= GOOD_ANGLE {
                    break;
                }
            }
            Err(error @ MeshError::Interrupted(_)) => return Err(error),
            Err(error) => failure = failure.or(Some(error)),
        }
    }
    match (best, failure) {
        (Some((angle, layout, triangles)), _) => finish(angle, &layout, triangles),
        (None, Some(error)) => Err(error),
        (None, None) => Err(MeshError::Triangulation { found: 0, expected: plan.triangles() }),
    }
}

/// A relaxed and polished layout with its triangles, from a coarser one if it may be and that can be made, else from a
/// spiral. It must come to rest unless it is large, or another one starts from it.
fn relaxed(
    plan: &MeshPlan,
    random: SplitMix64,
    [from_coarser, is_start]: [bool; 2],
) -> Result<(Layout, Vec<[u32; 3]>), MeshError> {
    if let Some(coarser) = plan.coarser().filter(|_| from_coarser) {
        let (coarse, triangles) = relaxed(&coarser, random, [true; 2])?;
        return settled(plan, plan.start_from(&coarse, &triangles), Iterations::Most(AFTER_COARSER));
    }
    let iterations = if plan.is_large() || is_start { Iterations::Most(FROM_SPIRAL) } else { Iterations::ToRest };
    settled(plan, plan.start(random), iterations)
}

/// How long a mesh is relaxed.
#[derive(Clone, Copy)]
enum Iterations {
    /// until it has converged; fails if it does not
    ToRest,
    /// for that many iterations at most
    Most(usize),
}

/// Relaxes and polishes a layout.
fn settled(plan: &MeshPlan, mut layout: Layout, iterations: Iterations) -> Result<(Layout, Vec<[u32; 3]>), MeshError> {
    let flips = relax(plan, &mut layout, iterations)?;
    let triangles = polish(plan, &mut layout, flips)?;
    Ok((layout, triangles))
}

/// Turns points into a mesh, or refuses bad angles.
fn finish(angle: f64, start: &Layout, triangles: Vec<[u32; 3]>) -> Result<Mesh, MeshError> {
    if angle < LEAST_ANGLE {
        let at = quality::smallest_angle(&start.points, &triangles).at;
        return Err(MeshError::Quality { angle, required: LEAST_ANGLE, x: at.x, y: at.y });
    }
    let edges = topology::unique_edges(&triangles);
    let seam = |&[a, b]: &[usize; 2]| edges.binary_search(&[a.min(b) as u32, a.max(b) as u32]).ok().map(|e| e as u32);
    let mut seams: Vec<u32> = start.constraints[start.loop_edges..].iter().filter_map(seam).collect();
    seams.sort_unstable();
    let nodes = start.points.iter().map(|p| [p.x, p.y, 0.0]).collect();
    Ok(Mesh { nodes, edges, triangles, seams, ..Mesh::default() })
}

/// Triangulates and checks the count, which is right only if all constraints are edges and no triangle is outside.
pub(super) fn triangulate_plan(plan: &MeshPlan, start: &Layout) -> Result<Vec<[u32; 3]>, MeshError> {
    let triangles = triangulate(&start.points, &start.constraints, plan.loops[0]).unwrap_or_default();
    if triangles.len() == plan.triangles() {
        Ok(triangles)
    } else {
        Err(MeshError::Triangulation { found: triangles.len(), expected: plan.triangles() })
    }
}

/// Triangulates nodes that have moved since `flips` was updated: from the beginning, or for large meshes by flips.
pub(super) fn follow_plan(plan: &MeshPlan, start: &Layout, flips: &mut Flips) -> Result<Vec<[u32; 3]>, MeshError> {
    if plan.is_large() && flips.follow(&start.points) {
        return Ok(sorted(flips.triangles().iter().copied()));
    }
    triangulate_plan(plan, start)
}

/// Moves the nodes until the springs are in equilibrium (Persson & Strang 2004, section 3, steps 3 to 8), or for the
/// given iterations; returns the triangulation so far.
fn relax(plan: &MeshPlan, start: &mut Layout, iterations: Iterations) -> Result<Flips, MeshError> {
    if plan.free == 0 && plan.seam_nodes == 0 {
        return Ok(Flips::default());
    }
    let count = start.points.len();
    let mut bars = Bars::default();
    let mut size = vec![0.0; count];
    let mut last = vec![Vector2::repeat(f64::INFINITY); count];
    let mut forces = vec![Vector2::zeros(); count];
    let mut momentum = vec![Vector2::zeros(); count];
    let mut movement = f64::INFINITY;
    let mut flips = Flips::default();

    let most = if let Iterations::Most(most) = iterations { most } else { ITERATIONS };
    for _ in 0..most {
        interrupt::check()?;
        wanted_lengths(&plan.size, &start.points, &mut size);
        if moved_far(&size, &start.points, &last) {
            if !flips.follow(&start.points) {
                flips = Flips::new(triangulate_plan(plan, start)?, &start.constraints);
            }
            bars.take(&flips, &start.freedom);
            last.copy_from_slice(&start.points);
        }
        bars.forces(&size, &start.points, &mut forces);
        movement = bars.step(plan, start, &size, &forces, &mut momentum);
        if movement < REST {
            return Ok(flips);
        }
    }
    match iterations {
        Iterations::Most(_) => Ok(flips),
        Iterations::ToRest => Err(MeshError::NotRelaxed { iterations: most, movement, tolerance: REST }),
    }
}

/// Writes the wanted edge length [m] at every point.
#[multiversion(targets("x86_64+avx+avx2"))]
fn wanted_lengths(size: &SizeFunction, points: &[Vector2<f64>], lengths: &mut [f64]) {
    for (length, point) in lengths.iter_mut().zip(points) {
        *length = size.at(point.norm());
    }
}

fn moved_far(size: &[f64], points: &[Vector2<f64>], last: &[Vector2<f64>]) -> bool {
    // In this form a point with NaN counts as far, and the triangulation will refuse it.
    let near = |((p, q), size): ((&Vector2<f64>, &Vector2<f64>), &f64)| {
        (p - q).norm_squared() < (RETRIANGULATE * size).powi(2)
    };
    !points.iter().zip(last).zip(size).all(near)
}

/// Edges with at least one end that can move, as springs.
#[derive(Default)]
struct Bars {
    ends: Vec<[u32; 2]>,
    /// bars at each node
    degree: Vec<u32>,
}

/// A bar while its force is computed.
#[derive(Clone, Copy, Default)]
struct MeasuredBar {
    /// [m] from its first end to the second
    across: Vector2<f64>,
    /// [m^2] length squared
    square: f64,
    /// [m] wanted length
    wanted: f64,
}

impl MeasuredBar {
    #[inline(always)]
    fn new([a, b]: [u32; 2], size: &[f64], points: &[Vector2<f64>]) -> Self {
        let across = points[b as usize] - points[a as usize];
        // The size function is almost linear along a bar, so its value in the middle is taken as the mean of the ends.
        let wanted = 0.5 * (size[a as usize] + size[b as usize]);
        MeasuredBar { across, square: across.norm_squared(), wanted }
    }
}

impl Bars {
    /// Takes the edges of a triangulation.
    fn take(&mut self, flips: &Flips, freedom: &[Freedom]) {
        let Self { ends, degree } = self;
        let moves = |n: u32| !matches!(freedom[n as usize], Freedom::Fixed);
        ends.clear();
        degree.clear();
        degree.resize(freedom.len(), 0);
        flips.each_edge(|bar| {
            if bar.into_iter().any(moves) {
                ends.push(bar);
                bar.into_iter().for_each(|n| degree[n as usize] += 1);
            }
        });
    }

    /// Forces max(F0 - L, 0), repulsive only; the wanted lengths are scaled so that their squares sum up to those of
    /// the actual ones. `size` has the wanted lengths at the nodes.
    fn forces(&self, size: &[f64], points: &[Vector2<f64>], forces: &mut [Vector2<f64>]) {
        forces.fill(Vector2::zeros());
        add_forces(&self.ends, size, points, forces);
    }

    /// One step of gradient descent with momentum; returns the largest step without the momentum, over the wanted edge
    /// length.
    ///
    /// Each node's step is its force over its number of bars: then no pattern of forces can overshoot, for any number
    /// of bars at a node.
    fn step(
        &self,
        plan: &MeshPlan,
        start: &mut Layout,
        size: &[f64],
        forces: &[Vector2<f64>],
        momentum: &mut [Vector2<f64>],
    ) -> f64 {
        let uphill: f64 = forces.iter().zip(momentum.iter()).map(|(f, m)| f.dot(m)).sum();
        let memory = if uphill < 0.0 { 0.0 } else { MOMENTUM };
        let mut largest: f64 = 0.0;
        for node in 0..start.points.len() {
            let (point, freedom) = (start.points[node], start.freedom[node]);
            let h = size[node];
            let mut push = STEP / f64::from(self.degree[node].max(1)) * forces[node];
            match freedom {
                Freedom::Fixed => continue,
                Freedom::Free => {}
                Freedom::Ray(direction) => push = push.dot(&direction) * direction,
            }
            let target = |to: Vector2<f64>| {
                // Mostly the node stays clear of everything.
                let clear = freedom == Freedom::Free
                    && plan.seams == 0
                    && plan.hub == 0.0
                    && plan.size.ring.signed_distance(to) <= -CLEARANCE * h;
                if clear { to } else { kept_clear(plan, freedom, to, CLEARANCE * h) }
            };
            largest = largest.max((target(point + push) - point).norm() / h);
            let moved = target(point + (push + memory * momentum[node]));
            momentum[node] = moved - point;
            start.points[node] = moved;
        }
        largest
    }
}

/// Bars that are measured together, so that what is known of them stays in the innermost cache.
const TOGETHER: usize = 256;

/// Bars are measured twice, for the scale and for the forces: what is known of all of them would not stay in the caches
/// meanwhile. Roots and quotients are in a loop of their own, so that they are computed side by side.
#[multiversion(targets("x86_64+avx+avx2"))]
fn add_forces(ends: &[[u32; 2]], size: &[f64], points: &[Vector2<f64>], forces: &mut [Vector2<f64>]) {
    let (mut sum_actual, mut sum_wanted) = (0.0, 0.0);
    for ends in ends {
        let MeasuredBar { square, wanted, .. } = MeasuredBar::new(*ends, size, points);
        sum_actual += square;
        sum_wanted += wanted.powi(2);
    }
    let scale = OVERLENGTH * (sum_actual / sum_wanted).sqrt();
    let mut measured = [MeasuredBar::default(); TOGETHER];
    for ends in ends.chunks(TOGETHER) {
        for (bar, ends) in measured.iter_mut().zip(ends) {
            *bar = MeasuredBar::new(*ends, size, points);
        }
        for MeasuredBar { across, square, wanted } in &mut measured {
            let full = scale * *wanted;
            let share = if *square < full * full && *square > 0.0 { full / square.sqrt() - 1.0 } else { 0.0 };
            *across *= share;
        }
        for (&[a, b], MeasuredBar { across: force, .. }) in ends.iter().zip(&measured) {
            forces[a as usize] -= *force;
            forces[b as usize] += *force;
        }
    }
}

/// The place nearest to `to`, on its ray if it has one, at least `depth` [m] from boundary, hub and seams.
#[inline(never)]
pub(super) fn kept_clear(plan: &MeshPlan, freedom: Freedom, to: Vector2<f64>, depth: f64) -> Vector2<f64> {
    match freedom {
        Freedom::Ray(direction) => {
            // Kept away from the centre, which on a disc is the common end of the seams.
            let radius = to.dot(&direction).max(plan.hub + depth);
            plan.size.ring.pushed_inside(radius * direction, depth)
        }
        _ => {
            let inside = plan.size.ring.pushed_inside(to, depth);
            turned_off_seams(plan.off_hub(inside, depth), plan.seams, depth)
        }
    }
}
