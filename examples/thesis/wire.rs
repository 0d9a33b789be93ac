//! A canopy as a wire frame seen from the side and a little above.

use canopy_fem::plot::chart::{Axis, Chart, Line, Stroke};

/// Edges in an oblique view: x to the right, z up, y into the picture.
pub fn wireframe(positions: &[[f64; 3]], edges: &[[u32; 2]]) -> Chart {
    let seen = |n: u32| {
        let [x, y, z] = positions[n as usize];
        (x + 0.3 * y, z + 0.15 * y)
    };
    let gap = (f64::NAN, f64::NAN);
    let points = edges.iter().flat_map(|&[a, b]| [seen(a), seen(b), gap]).collect();
    let line = Line { points, stroke: Stroke::Thin, color: Some(0), ..Line::default() };
    Chart { x: Axis::linear("x + 0.3 y [m]"), y: Axis::linear("z + 0.15 y [m]"), lines: vec![line], ..Chart::default() }
}
