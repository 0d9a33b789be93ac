//! Signed distance and size function of a ring, the two inputs of Persson & Strang (2004), section 2.

use crate::unit_vector::unit_vector;
use nalgebra::Vector2;
use std::f64::consts::TAU;

/// A ring around the origin, or a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ring {
    /// [m] radius of the hole; 0 for a disc
    pub inner: f64,
    /// [m] radius of the outer edge
    pub outer: f64,
}

impl Ring {
    /// Whether it has a hole.
    pub(crate) fn has_hole(&self) -> bool {
        self.inner > 0.0
    }

    /// Triangles of any triangulation of that many nodes, `boundary` of them on the loops: F = 2V - B with a hole,
    /// 2V - B - 2 without one, by Euler's formula.
    pub(crate) fn count_triangles(&self, nodes: usize, boundary: usize) -> usize {
        (2 * nodes).saturating_sub(boundary + if self.has_hole() { 0 } else { 2 })
    }

    /// [m] signed distance to the boundary, negative inside (Persson & Strang 2004, section 2.1: the intersection of
    /// a circle and the outside of another is the larger of both distances).
    #[inline]
    pub(crate) fn signed_distance(&self, p: Vector2<f64>) -> f64 {
        let r = p.norm();
        if self.has_hole() { (r - self.outer).max(self.inner - r) } else { r - self.outer }
    }

    /// The point at least `depth` [m] inside that is nearest to `p`; half way between the loops if the ring is thinner.
    pub(crate) fn pushed_inside(&self, p: Vector2<f64>, depth: f64) -> Vector2<f64> {
        if self.signed_distance(p) <= -depth {
            return p;
        }
        let middle = 0.5 * (self.inner + self.outer);
        let highest = if self.has_hole() { (self.outer - depth).max(middle) } else { (self.outer - depth).max(0.0) };
        let lowest = if self.has_hole() { (self.inner + depth).min(middle) } else { 0.0 };
        unit_vector(p).unwrap_or(Vector2::x()) * p.norm().clamp(lowest, highest)
    }
}

/// (cos, sin) of an angle [rad].
pub(super) fn on_unit_circle(angle: f64) -> Vector2<f64> {
    let (sin, cos) = angle.sin_cos();
    Vector2::new(cos, sin)
}

/// `p` turned around the origin until it is at least `depth` [m] from each of `seams` evenly spread rays, the first
/// along +x. Where the rays are too close for that, it is turned to the middle between two of them.
pub(super) fn turned_off_seams(p: Vector2<f64>, seams: usize, depth: f64) -> Vector2<f64> {
    if seams == 0 {
        return p;
    }
    let radius = p.norm();
    let sector = TAU / seams as f64;
    let angle = p.y.atan2(p.x).rem_euclid(TAU);
    let first = (angle / sector).floor() * sector;
    let least = (depth / radius).min(1.0).asin().min(0.5 * sector);
    let within = angle - first;
    let wanted = within.clamp(least, sector - least);
    if wanted == within { p } else { radius * on_unit_circle(first + wanted) }
}

/// Wanted edge length by radius: linear between its values at the loops, times a tent function that is 1 at the loops
/// and `grading` in the middle (for a disc: at the centre).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SizeFunction {
    /// the domain
    pub ring: Ring,
    /// [m] edge length on the inner loop; for a disc the same as `at_outer`
    pub at_inner: f64,
    /// [m] edge length on the outer loop
    pub at_outer: f64,
    /// [-] ratio of the edge length in the middle to that at the edges
    pub grading: f64,
}

impl SizeFunction {
    /// [m] wanted edge length at a radius [m]
    #[inline]
    pub(crate) fn at(&self, radius: f64) -> f64 {
        let Ring { inner, outer } = self.ring;
        let s = ((radius - inner) / (outer - inner)).clamp(0.0, 1.0);
        let tent = if self.ring.has_hole() { 1.0 - (2.0 * s - 1.0).abs() } else { 1.0 - s };
        (self.at_inner + (self.at_outer - self.at_inner) * s) * (1.0 + (self.grading - 1.0) * tent)
    }
}

/// Cells of a [`RadialTable`].
const CELLS: usize = 4096;

/// The integral of a density over the radius, and its inverse.
#[derive(Clone, Debug)]
pub(crate) struct RadialTable {
    /// [m] radii of the cell borders, denser at the lower end, where a small hole makes the size function steep
    radii: Vec<f64>,
    /// integral from the first radius
    sums: Vec<f64>,
}

impl RadialTable {
    /// Integrates a positive density from radius `from` to `to` with the midpoint rule.
    pub(crate) fn new(ends: [f64; 2], density: impl Fn(f64) -> f64) -> Self {
        let mut table = Self { radii: vec![ends[0]], sums: vec![0.0] };
        integrate(ends, density, |radius, sum| {
            table.radii.push(radius);
            table.sums.push(sum);
        });
        table
    }

    /// [m] the radius up to which the given fraction of the integral lies
    pub(crate) fn radius_at(&self, fraction: f64) -> f64 {
        let wanted = fraction.clamp(0.0, 1.0) * self.sums[CELLS];
        let cell = self.sums.partition_point(|&s| s < wanted).clamp(1, CELLS);
        let (low, high) = (self.sums[cell - 1], self.sums[cell]);
        let share = if high > low { (wanted - low) / (high - low) } else { 0.0 };
        self.radii[cell - 1] + share * (self.radii[cell] - self.radii[cell - 1])
    }
}

/// The same integral without a table.
pub(crate) fn integral(ends: [f64; 2], density: impl Fn(f64) -> f64) -> f64 {
    integrate(ends, density, |_, _| ())
}

/// Calls `reached(radius, integral)` at the end of every cell.
fn integrate([from, to]: [f64; 2], density: impl Fn(f64) -> f64, mut reached: impl FnMut(f64, f64)) -> f64 {
    let radius = |i: usize| from + (to - from) * (i as f64 / CELLS as f64).powi(2);
    let (mut last, mut sum) = (radius(0), 0.0);
    for i in 1..=CELLS {
        let next = radius(i);
        sum += density(0.5 * (last + next)) * (next - last);
        reached(next, sum);
        last = next;
    }
    sum
}
