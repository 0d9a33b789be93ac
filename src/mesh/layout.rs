//! The numbers and initial positions of nodes: on the loops, along the seams, in the interior.

use super::MeshError;
use super::annulus::GRADING_RANGE;
use super::hilbert;
use super::random::SplitMix64;
use super::sdf::{RadialTable, Ring, SizeFunction, integral, on_unit_circle};
use crate::unit_vector::unit_vector;
use nalgebra::Vector2;
use std::f64::consts::{PI, TAU};

/// [-] `grading` if neither it nor the boundary nodes are given
const DEFAULT_GRADING: f64 = 1.5;
/// [-] height of an equilateral triangle over its edge, halved: depth of the cell of a boundary node
const HALF_ROW: f64 = 0.433;
/// [-] least number of nodes on the smaller loop, for a circle of acceptable shape
pub(super) const ROUND_ENOUGH: usize = 8;

/// Number of nodes above which a mesh counts as large and is made with less work per node.
pub(super) const MANY: usize = 20_000;

/// Number of seams of a disc from which on all triangles around its centre are between seams: six equilateral ones.
const SEAMS_WITH_HUB: usize = 6;

/// The request for a graded mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GradedRequest {
    pub ring: Ring,
    pub nodes: usize,
    pub boundary_nodes: Option<usize>,
    pub seams: usize,
    pub grading: Option<f64>,
}

/// How a node may move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Freedom {
    Fixed,
    /// along a ray from the origin with this direction
    Ray(Vector2<f64>),
    Free,
}

/// Consistent counts and sizes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MeshPlan {
    pub size: SizeFunction,
    /// nodes on the inner and on the outer loop
    pub loops: [usize; 2],
    pub seams: usize,
    /// [m] on a disc with many seams, radius of the ring of fixed seam nodes around the centre without interior nodes;
    /// else 0
    pub hub: f64,
    /// nodes on each seam, loops and centre not counted
    pub seam_nodes: usize,
    /// nodes off loops and seams
    pub free: usize,
}

/// The initial mesh of the relaxation.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub points: Vec<Vector2<f64>>,
    pub freedom: Vec<Freedom>,
    /// edges of the loops, then of the seams
    pub constraints: Vec<[usize; 2]>,
    /// how many of the constraints are loops
    pub loop_edges: usize,
}

impl GradedRequest {
    /// Finds sizes and counts.
    ///
    /// # Errors
    /// Inconsistent counts.
    pub(crate) fn plan(&self) -> Result<MeshPlan, MeshError> {
        let boundary = match self.boundary_nodes {
            Some(count) => count.max(self.least_boundary()),
            None => self.derived_boundary(),
        };
        let grading = match self.grading {
            Some(grading) => grading,
            None if self.boundary_nodes.is_none() => DEFAULT_GRADING,
            None => self.derived_grading(boundary)?,
        };
        let size = self.size(boundary, grading);
        let loops = self.split(boundary);
        let hub = self.hub(&size);
        let mut plan = MeshPlan { size, loops, seams: self.seams, hub, seam_nodes: 0, free: 0 };
        plan.seam_nodes = plan.count_seam_nodes();
        let on_seams = plan.on_seams();
        if boundary != self.boundary_nodes.unwrap_or(boundary) || boundary.saturating_add(on_seams) > self.nodes {
            let (nodes, boundary_nodes) = (self.nodes, self.boundary_nodes.unwrap_or(boundary));
            return Err(MeshError::NoInterior { nodes, boundary_nodes, seam_nodes: on_seams });
        }
        plan.free = self.nodes - boundary - on_seams;
        Ok(plan)
    }

    /// Radius at which the seams of a disc are one edge length apart; 0 where they leave room for other nodes at the
    /// centre.
    fn hub(&self, size: &SizeFunction) -> f64 {
        if self.ring.has_hole() || self.seams < SEAMS_WITH_HUB {
            return 0.0;
        }
        let radius = size.at(0.0) / (2.0 * (PI / self.seams as f64).sin());
        if radius + 0.5 * size.at(radius) < self.ring.outer { radius } else { 0.0 }
    }

    /// Triangles with that many nodes on the loops.
    fn triangles(&self, boundary: usize) -> usize {
        self.ring.count_triangles(self.nodes, boundary)
    }

    /// Every seam ends at a node of each loop, and a loop needs three nodes.
    fn least_boundary(&self) -> usize {
        let each = self.seams.max(3);
        if self.ring.has_hole() { 2 * each } else { each }
    }

    /// Divides boundary nodes among the loops by length.
    fn split(&self, boundary: usize) -> [usize; 2] {
        if !self.ring.has_hole() {
            return [0, boundary];
        }
        let share = boundary as f64 * self.ring.inner / (self.ring.inner + self.ring.outer);
        let least = self.seams.max(3);
        let round = ROUND_ENOUGH.min(boundary / 3).max(least);
        let inner = (share.round() as usize).clamp(round, (boundary - least).max(round));
        [inner, boundary.saturating_sub(inner)]
    }

    fn size(&self, boundary: usize, grading: f64) -> SizeFunction {
        let [inner, outer] = self.split(boundary);
        let chord = |radius: f64, count: usize| 2.0 * radius * (PI / count.max(2) as f64).sin();
        let at_outer = chord(self.ring.outer, outer);
        let at_inner = if self.ring.has_hole() { chord(self.ring.inner, inner) } else { at_outer };
        SizeFunction { ring: self.ring, at_inner, at_outer, grading }
    }

    /// Equilateral triangles of the wanted size that fill the domain.
    fn expected_triangles(&self, boundary: usize, grading: f64) -> f64 {
        let size = self.size(boundary, grading);
        let density = |r: f64| TAU * r * 4.0 / (3.0_f64.sqrt() * size.at(r).powi(2));
        integral([self.ring.inner, self.ring.outer], density)
    }

    /// The number of boundary nodes at which expected and exact triangles agree; both grow with it, one up, one down.
    fn derived_boundary(&self) -> usize {
        let grading = self.grading.unwrap_or(DEFAULT_GRADING);
        let (mut low, mut high) = (self.least_boundary(), self.nodes.max(self.least_boundary()));
        while low < high {
            let middle = low + (high - low) / 2;
            if self.expected_triangles(middle, grading) < self.triangles(middle) as f64 {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low
    }

    /// The grading at which expected and exact triangles agree.
    fn derived_grading(&self, boundary: usize) -> Result<f64, MeshError> {
        let [mut low, mut high] = GRADING_RANGE;
        let target = self.triangles(boundary) as f64;
        let [most, least] = [low, high].map(|g| self.expected_triangles(boundary, g));
        if target > most || target < least {
            let nodes_for = |triangles: f64| (0.5 * (triangles + boundary as f64)) as usize;
            let (least, most) = (nodes_for(least) + 1, nodes_for(most));
            return Err(MeshError::NodeCounts { nodes: self.nodes, boundary_nodes: boundary, least, most });
        }
        // The Illinois method: secants between two ends of unlike signs; an end that stays twice counts half.
        let (mut above, mut below) = (most - target, least - target);
        let (mut grading, mut last) = (low, 0.0);
        for _ in 0..60 {
            let before = std::mem::replace(&mut grading, (low * below - high * above) / (below - above));
            let excess = self.expected_triangles(boundary, grading) - target;
            if (grading - before).abs() <= f64::EPSILON * grading || excess == 0.0 {
                break;
            }
            let stays = if excess * last > 0.0 { 0.5 } else { 1.0 };
            if excess > 0.0 {
                (low, above, below) = (grading, excess, stays * below);
            } else {
                (high, below, above) = (grading, excess, stays * above);
            }
            last = excess;
        }
        Ok(grading)
    }
}

impl MeshPlan {
    /// Nodes on the loops.
    pub(super) fn boundary(&self) -> usize {
        self.loops[0] + self.loops[1]
    }

    /// Nodes on seams that are not on loops, the centre among them.
    fn on_seams(&self) -> usize {
        let centre = usize::from(self.seams > 0 && !self.size.ring.has_hole());
        self.seams.saturating_mul(self.seam_nodes).saturating_add(centre)
    }

    /// Wanted edges along a radius from the inner loop, the hub or the centre to the outer loop.
    pub(super) fn edges_across(&self) -> f64 {
        let Ring { inner, outer } = self.size.ring;
        integral([self.hub.max(inner), outer], |r| 1.0 / self.size.at(r))
    }

    /// Nodes on each seam by the wanted edge lengths along it.
    pub(super) fn count_seam_nodes(&self) -> usize {
        let between = (self.edges_across().round() as usize).max(1) - 1;
        if self.seams == 0 { 0 } else { between + usize::from(self.hub > 0.0) }
    }

    /// Triangles that any triangulation of these nodes has.
    pub(super) fn triangles(&self) -> usize {
        let boundary = self.boundary();
        self.size.ring.count_triangles(boundary + self.on_seams() + self.free, boundary)
    }

    /// Whether it has many nodes.
    pub(crate) fn is_large(&self) -> bool {
        self.free > MANY
    }

    /// `p` moved out of the hub by at least `depth` [m].
    pub(crate) fn off_hub(&self, p: Vector2<f64>, depth: f64) -> Vector2<f64> {
        let least = self.hub + depth;
        if self.hub == 0.0 || p.norm() >= least { p } else { least * unit_vector(p).unwrap_or(Vector2::x()) }
    }

    /// Lays out the nodes: inner loop, outer loop, centre, seams, interior.
    pub(crate) fn start(&self, random: SplitMix64) -> Layout {
        self.with_interior(self.spiral(random))
    }

    /// The same with a given interior.
    pub(super) fn with_interior(&self, mut interior: Vec<Vector2<f64>>) -> Layout {
        let mut start = Layout { points: Vec::new(), freedom: Vec::new(), constraints: Vec::new(), loop_edges: 0 };
        let ring = self.size.ring;
        let firsts = [0, self.loops[0]];
        self.add_loop(ring.inner, self.loops[0], &mut start);
        self.add_loop(ring.outer, self.loops[1], &mut start);
        start.loop_edges = start.constraints.len();
        self.add_seams(firsts, &mut start);
        if self.is_large() {
            // In other orders consecutive nodes are far apart, so every later pass over the mesh would miss the cache.
            interior.sort_by_cached_key(|&p| hilbert::place(p, ring.outer));
        }
        start.freedom.resize(start.points.len() + interior.len(), Freedom::Free);
        start.points.extend(interior);
        start
    }

    /// Nodes of a loop; every seam's angle gets one, the rest are spread evenly between the seams.
    fn add_loop(&self, radius: f64, count: usize, start: &mut Layout) {
        let first = start.points.len();
        let arcs = self.seams.max(1);
        for arc in 0..arcs {
            let edges = seam_node(arc + 1, arcs, count) - seam_node(arc, arcs, count);
            for i in 0..edges {
                let angle = TAU * (arc as f64 + i as f64 / edges as f64) / arcs as f64;
                start.points.push(radius * on_unit_circle(angle));
                start.freedom.push(Freedom::Fixed);
            }
        }
        start.constraints.extend((0..count).map(|i| [first + i, first + (i + 1) % count]));
    }

    /// Nodes along the seams, equally spaced as measured in wanted edge lengths.
    fn add_seams(&self, firsts: [usize; 2], start: &mut Layout) {
        if self.seams == 0 {
            return;
        }
        let ring = self.size.ring;
        let centre = start.points.len();
        if !ring.has_hole() {
            start.points.push(Vector2::zeros());
            start.freedom.push(Freedom::Fixed);
        }
        let along = RadialTable::new([self.hub.max(ring.inner), ring.outer], |r| 1.0 / self.size.at(r));
        let on_hub = usize::from(self.hub > 0.0);
        for seam in 0..self.seams {
            let ends = [0, 1].map(|l| firsts[l] + seam_node(seam, self.seams, self.loops[l]));
            let ray = on_unit_circle(TAU * seam as f64 / self.seams as f64);
            let mut previous = if ring.has_hole() { ends[0] } else { centre };
            for i in 1..=self.seam_nodes {
                let radius = along.radius_at((i - on_hub) as f64 / (self.seam_nodes + 1 - on_hub) as f64);
                let node = start.points.len();
                start.points.push(radius * ray);
                start.freedom.push(if i <= on_hub { Freedom::Fixed } else { Freedom::Ray(ray) });
                start.constraints.push([previous, node]);
                previous = node;
            }
            start.constraints.push([previous, ends[1]]);
        }
    }

    /// Interior nodes with the density 1/h^2 of Persson & Strang (2004), section 3.
    ///
    /// They choose nodes at random and drop some. Here a spiral that turns by the golden angle (Vogel 1979), with radii
    /// from the integral of the density, gives the exact number, and is so even that few iterations are needed.
    fn spiral(&self, mut random: SplitMix64) -> Vec<Vector2<f64>> {
        let Ring { inner, outer } = self.size.ring;
        let base = self.hub.max(inner);
        let low = if base > 0.0 { base + HALF_ROW * self.size.at(base) } else { 0.0 };
        let high = outer - HALF_ROW * self.size.at(outer);
        // In a ring thinner than a row of triangles the limits cross; then the interior is the middle of the ring.
        let range = if low < high { [low, high] } else { [0.5 * (inner + outer); 2] };
        let table = RadialTable::new(range, |r| r / self.size.at(r).powi(2));
        let golden = PI * (3.0 - 5.0_f64.sqrt());
        let phase = PI * random.signed();
        let node = |i: usize| {
            let radius = table.radius_at((i as f64 + 0.5) / self.free as f64);
            let jitter = Vector2::new(random.signed(), random.signed()) * 0.1 * self.size.at(radius);
            radius * on_unit_circle(phase + golden * i as f64) + jitter
        };
        (0..self.free).map(node).collect()
    }
}

/// Which node of a loop (counted within the loop) a seam ends in.
fn seam_node(seam: usize, seams: usize, count: usize) -> usize {
    seam * count / seams
}
