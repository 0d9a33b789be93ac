//! Drawings of gores as gore programs write them: closed polylines side by side in millimetres.

use canopy_fem::mesh::Mesh;
use nalgebra::Vector3;
use std::fmt::Write;

/// A polyline on a layer [m].
#[derive(Clone)]
pub struct Polyline {
    pub layer: String,
    pub points: Vec<[f64; 2]>,
    pub closed: bool,
}

/// A gore of a generated canopy with one edge across each: upper end and skirt level, the skirt at y = 0. The points
/// go up the right side from the skirt, and down the left one.
pub fn gore(canopy: &Mesh) -> Vec<[f64; 2]> {
    let mut rows: Vec<[f64; 2]> = Vec::new();
    let mut before: Option<Vector3<f64>> = None;
    let mut at = 0.0;
    for row in &canopy.rows {
        let [a, b] = [0, 1].map(|i| canopy.point(row[i % row.len()]));
        let middle = 0.5 * (a + b);
        at += before.map_or(0.0, |before| (middle - before).norm());
        before = Some(middle);
        rows.push([at, 0.5 * (b - a).norm()]);
    }
    let right = rows.iter().rev().map(|[s, half]| [*half, at - s]);
    let left = rows.iter().filter(|[_, half]| *half > 0.0).map(|[s, half]| [-half, at - s]);
    right.chain(left).collect()
}

/// The same outline moved along x [m].
pub fn moved(points: &[[f64; 2]], x: f64) -> Vec<[f64; 2]> {
    points.iter().map(|p| [p[0] + x, p[1]]).collect()
}

/// As many gores beside each other, each on a layer `gore-1`, `gore-2` and so on.
pub fn side_by_side(points: &[[f64; 2]], count: usize) -> Vec<Polyline> {
    let width = 2.2 * points.iter().map(|p| p[0]).fold(0.0, f64::max);
    let one =
        |i: usize| Polyline { layer: format!("gore-{}", i + 1), points: moved(points, width * i as f64), closed: true };
    (0..count).map(one).collect()
}

/// A drawing in millimetres.
pub fn dxf(polylines: &[Polyline]) -> String {
    let mut text = "0\nSECTION\n2\nENTITIES\n".to_owned();
    for Polyline { layer, points, closed } in polylines {
        let _ = write!(text, "0\nLWPOLYLINE\n8\n{layer}\n90\n{}\n70\n{}\n", points.len(), u8::from(*closed));
        for [x, y] in points {
            let _ = write!(text, "10\n{}\n20\n{}\n", 1e3 * x, 1e3 * y);
        }
    }
    text + "0\nENDSEC\n0\nEOF\n"
}
