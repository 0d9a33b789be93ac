//! Measures of a mesh: angles, lengths, areas, radius ratios.

use super::{Mesh, MeshError, Topology};
use nalgebra::{Vector2, Vector3};
use std::fmt::Write as _;

/// Width of a bar of the angle histogram [deg].
const BAR_DEGREES: usize = 10;
const BARS: usize = 180 / BAR_DEGREES;

/// Quality of a mesh. Values of triangles are NaN without triangles, values of edges without edges.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// [deg] smallest angle of any triangle
    pub min_angle: f64,
    /// [deg] largest angle of any triangle
    pub max_angle: f64,
    /// [deg] mean over triangles of their smallest angle
    pub mean_min_angle: f64,
    /// [m] shortest edge
    pub min_edge: f64,
    /// [m] longest edge
    pub max_edge: f64,
    /// [m] mean edge length
    pub mean_edge: f64,
    /// [m^2] smallest triangle
    pub min_area: f64,
    /// [m^2] all triangles
    pub total_area: f64,
    /// [-] smallest radius ratio 2 r_in / r_circum: 1 for an equilateral triangle, 0 for a degenerate one
    pub min_radius_ratio: f64,
    /// [-] mean radius ratio
    pub mean_radius_ratio: f64,
    /// [-] number of angles in each ten degrees from 0 to 180
    pub angle_histogram: [usize; BARS],
    /// number of parts that no edge or triangle connects
    pub components: usize,
    /// nodes - edges + triangles
    pub euler_characteristic: i64,
}

impl Quality {
    /// Measures a mesh.
    ///
    /// # Errors
    /// As [`Topology::new`].
    pub fn new(mesh: &Mesh) -> Result<Self, MeshError> {
        Ok(Self::with_topology(mesh, &Topology::new(mesh)?))
    }

    /// Measures a mesh whose topology is known.
    pub fn with_topology(mesh: &Mesh, topology: &Topology) -> Self {
        let mut q = Self {
            min_angle: f64::NAN,
            max_angle: f64::NAN,
            mean_min_angle: 0.0,
            min_edge: f64::NAN,
            max_edge: f64::NAN,
            mean_edge: 0.0,
            min_area: f64::NAN,
            total_area: 0.0,
            min_radius_ratio: f64::NAN,
            mean_radius_ratio: 0.0,
            angle_histogram: [0; BARS],
            components: topology.components(),
            euler_characteristic: topology.euler_characteristic(),
        };
        for &[a, b] in &mesh.edges {
            let length = (mesh.point(a) - mesh.point(b)).norm();
            // min and max ignore the NaN that stands for "none yet".
            (q.min_edge, q.max_edge) = (q.min_edge.min(length), q.max_edge.max(length));
            q.mean_edge += length / mesh.edges.len() as f64;
        }
        for triangle in &mesh.triangles {
            q.add_triangle(triangle.map(|n| mesh.point(n)), mesh.triangles.len() as f64);
        }
        if mesh.edges.is_empty() {
            q.mean_edge = f64::NAN;
        }
        if mesh.triangles.is_empty() {
            (q.mean_min_angle, q.mean_radius_ratio) = (f64::NAN, f64::NAN);
        }
        q
    }

    fn add_triangle(&mut self, corners: [Vector3<f64>; 3], count: f64) {
        let angles = angles(corners);
        let smallest = angles.iter().copied().fold(f64::INFINITY, f64::min);
        for angle in angles {
            (self.min_angle, self.max_angle) = (self.min_angle.min(angle), self.max_angle.max(angle));
            self.angle_histogram[(angle as usize / BAR_DEGREES).min(BARS - 1)] += 1;
        }
        self.mean_min_angle += smallest / count;
        let area = 0.5 * (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).norm();
        self.min_area = self.min_area.min(area);
        self.total_area += area;
        let ratio = radius_ratio(corners, area);
        self.min_radius_ratio = self.min_radius_ratio.min(ratio);
        self.mean_radius_ratio += ratio / count;
    }

    /// The angle histogram as text, one line for every ten degrees that occur.
    pub fn histogram_text(&self) -> String {
        let most = self.angle_histogram.iter().copied().max().unwrap_or(0).max(1);
        let mut text = String::new();
        for (bar, &count) in self.angle_histogram.iter().enumerate().filter(|&(_, &count)| count > 0) {
            let (from, to) = (bar * BAR_DEGREES, (bar + 1) * BAR_DEGREES);
            let width = (count * 50).div_ceil(most);
            // Writing to a String cannot fail.
            let _ = writeln!(text, "  {from:>3}-{to:<3} {count:>9} {}", "#".repeat(width));
        }
        text
    }
}

/// Angles [deg] at the corners of a triangle.
pub(crate) fn angles(corners: [Vector3<f64>; 3]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let (u, v) = (corners[(i + 1) % 3] - corners[i], corners[(i + 2) % 3] - corners[i]);
        // The arc tangent is accurate at small and large angles, the arc cosine is not.
        u.cross(&v).norm().atan2(u.dot(&v)).to_degrees()
    })
}

/// 2 r_in / r_circum = 16 A^2 / (a b c (a + b + c)).
fn radius_ratio(corners: [Vector3<f64>; 3], area: f64) -> f64 {
    let [a, b, c]: [f64; 3] = std::array::from_fn(|i| (corners[i] - corners[(i + 1) % 3]).norm());
    16.0 * area * area / (a * b * c * (a + b + c))
}

/// Smallest angle [deg] of a plane triangle; negative if it is turned clockwise.
pub(super) fn smallest_angle_of([a, b, c]: [Vector2<f64>; 3]) -> f64 {
    let area = (b - a).perp(&(c - a));
    let angle = |u: Vector2<f64>, v: Vector2<f64>| area.atan2(u.dot(&v)).to_degrees();
    angle(b - a, c - a).min(angle(c - b, a - b)).min(angle(a - c, b - c))
}

/// Whether all angles of a plane triangle are above one with this cotangent, by more than rounding: much cheaper than
/// the angles. False where that is not plain.
pub(super) fn plainly_above(cotangent: f64, [a, b, c]: [Vector2<f64>; 3]) -> bool {
    const MARGIN: f64 = 1e-9;
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let largest = (-ab.dot(&ca)).max(-bc.dot(&ab)).max(-ca.dot(&bc));
    largest < (1.0 - MARGIN) * cotangent * ca.perp(&ab)
}

/// The sharpest triangle of a plane mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SharpestTriangle {
    /// [deg] its smallest angle
    pub degrees: f64,
    /// [m] its centroid
    pub at: Vector2<f64>,
}

/// Finds the sharpest triangle; an infinite angle if there is none.
pub(super) fn smallest_angle(points: &[Vector2<f64>], triangles: &[[u32; 3]]) -> SharpestTriangle {
    let mut worst = SharpestTriangle { degrees: f64::INFINITY, at: Vector2::zeros() };
    // No triangle is plainly above the angle of none.
    let mut cotangent = f64::NAN;
    for triangle in triangles {
        let corners = triangle.map(|n| points[n as usize]);
        if plainly_above(cotangent, corners) {
            continue;
        }
        let degrees = smallest_angle_of(corners);
        if degrees < worst.degrees {
            cotangent = 1.0 / degrees.to_radians().tan();
            worst = SharpestTriangle { degrees, at: (corners[0] + corners[1] + corners[2]) / 3.0 };
        }
    }
    worst
}
