//! Cuts faces into triangles.

use earcut::utils3d::project3d_to_2d;
use earcut::{Earcut, Refiner};
use nalgebra::Vector3;

/// [-] largest difference between the area of a face and that of its triangles, relative to the latter
const AREA_ERROR: f64 = 1e-6;

/// Cuts faces; keeps its memory from face to face.
pub(super) struct Cutter {
    cut: Earcut<f64>,
    refiner: Refiner,
    space: Vec<[f64; 3]>,
    plane: Vec<[f64; 2]>,
    indices: Vec<u32>,
}

/// The triangles of a face, as positions among its corners, which turn as the face does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Pieces {
    /// a triangle
    Whole,
    /// a quad, cut along the diagonal between its corners 0 and 2, or 1 and 3; `both` if the other diagonal lies in it
    /// too
    Quad { first: bool, both: bool },
    /// more corners
    Polygon(Vec<[usize; 3]>),
}

/// A face whose corners are not in order around it, or that crosses itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Crossed;

impl Cutter {
    pub(super) fn new() -> Self {
        let (space, plane, indices) = (Vec::new(), Vec::new(), Vec::new());
        Cutter { cut: Earcut::new(), refiner: Refiner::new(), space, plane, indices }
    }

    /// Cuts a face with these corners, at least three.
    pub(super) fn cut(&mut self, corners: &[Vector3<f64>]) -> Result<Pieces, Crossed> {
        match corners {
            [_, _, _] => Ok(Pieces::Whole),
            [a, b, c, d] => quad([a, b, c, d]),
            _ => self.polygon(corners),
        }
    }

    /// Ears are cut off in the plane of the face, and diagonals are turned where that makes better triangles.
    fn polygon(&mut self, corners: &[Vector3<f64>]) -> Result<Pieces, Crossed> {
        self.space.clear();
        self.space.extend(corners.iter().map(|p| [p.x, p.y, p.z]));
        if !project3d_to_2d(&self.space, corners.len(), &mut self.plane) {
            return Err(Crossed);
        }
        self.cut.earcut(self.plane.iter().copied(), &[], &mut self.indices);
        self.refiner.refine(&mut self.indices, &self.plane);
        let twice = |t: [usize; 3]| {
            let [a, b, c] = t.map(|i| self.plane[i]);
            (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        };
        let fan = (1..corners.len() - 1).map(|i| twice([0, i, i + 1])).sum::<f64>();
        let turned = |t: [usize; 3]| if twice(t) * fan < 0.0 { [t[0], t[2], t[1]] } else { t };
        let triangles: Vec<_> =
            self.indices.as_chunks().0.iter().map(|t: &[u32; 3]| turned(t.map(|i| i as usize))).collect();
        let area = triangles.iter().map(|t| twice(*t).abs()).sum::<f64>();
        if (fan.abs() - area).abs() <= AREA_ERROR * area { Ok(Pieces::Polygon(triangles)) } else { Err(Crossed) }
    }
}

/// A convex quad is cut along its first diagonal. A concave one, and one with three corners in line, is cut along the
/// diagonal whose triangles turn the same way and have an area. A quad so warped that they do so along neither is seen
/// along its vector area, in whose plane it is largest.
fn quad([a, b, c, d]: [&Vector3<f64>; 4]) -> Result<Pieces, Crossed> {
    let normal = |p: &Vector3<f64>, q: &Vector3<f64>, r: &Vector3<f64>| (q - p).cross(&(r - p));
    let halves = [[normal(a, b, c), normal(a, c, d)], [normal(a, b, d), normal(b, c, d)]];
    let [first, second] = halves.map(|[p, q]| p.dot(&q));
    match (first > 0.0, second > 0.0) {
        (true, both) => return Ok(Pieces::Quad { first: true, both }),
        (false, true) => return Ok(Pieces::Quad { first: false, both: false }),
        (false, false) => {}
    }
    let [p, q] = halves[0];
    let seen = halves.map(|pair| pair.iter().all(|normal| normal.dot(&(p + q)) > 0.0));
    match seen {
        // The less folded of two.
        [true, true] => Ok(Pieces::Quad { first: first >= second, both: false }),
        [true, false] => Ok(Pieces::Quad { first: true, both: false }),
        [false, true] => Ok(Pieces::Quad { first: false, both: false }),
        // Without any area it is dropped later, with its number.
        [false, false] if first == 0.0 || second == 0.0 => Ok(Pieces::Quad { first: true, both: false }),
        [false, false] => Err(Crossed),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(flat: &[[f64; 2]]) -> Vec<Vector3<f64>> {
        flat.iter().map(|[x, y]| Vector3::new(*x, *y, 0.3 * x - 0.2 * y)).collect()
    }

    fn area(points: &[Vector3<f64>], triangles: &[[usize; 3]]) -> Vector3<f64> {
        let half = |t: &[usize; 3]| 0.5 * (points[t[1]] - points[t[0]]).cross(&(points[t[2]] - points[t[0]]));
        triangles.iter().map(half).sum()
    }

    /// The diagonal of a quad lies within it.
    #[test]
    fn quads_are_cut_inside() {
        let cut = |corners: [[f64; 2]; 4]| Cutter::new().cut(&points(&corners));
        let arrow = [[0.0, 0.0], [2.0, -1.0], [1.0, 0.0], [2.0, 1.0]];
        assert_eq!(cut([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), Ok(Pieces::Quad { first: true, both: true }));
        assert_eq!(cut(arrow), Ok(Pieces::Quad { first: true, both: false }));
        let [a, b, c, d] = arrow;
        assert_eq!(cut([b, c, d, a]), Ok(Pieces::Quad { first: false, both: false }));
        assert_eq!(cut([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]), Err(Crossed));
        let folded = [[0.0, 0.0, 0.0], [1.0, 0.0, 3.0], [1.0, 1.0, 0.0], [0.0, 1.0, 3.0]].map(Vector3::from);
        let along = Cutter::new().cut(&folded);
        assert_eq!(along, Ok(Pieces::Quad { first: true, both: false }), "warped by more than a right angle");
        let in_line = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 1.0]];
        assert_eq!(cut(in_line), Ok(Pieces::Quad { first: false, both: false }));
    }

    /// The triangles of a polygon have its area and its normal, also where it is concave; both ways around.
    #[test]
    fn polygons_keep_area_and_side() {
        let mut l = vec![[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        for _ in 0..2 {
            let corners = points(&l);
            let Ok(Pieces::Polygon(triangles)) = Cutter::new().cut(&corners) else { panic!("{l:?} is a polygon") };
            assert_eq!(triangles.len(), 4);
            let fan: Vec<[usize; 3]> = (1..5).map(|i| [0, i, i + 1]).collect();
            assert!((area(&corners, &triangles) - area(&corners, &fan)).norm() < 1e-12, "{triangles:?}");
            l.reverse();
        }
        let star: Vec<[f64; 2]> =
            (0..5).map(|i| f64::from(i) * 4.0 * std::f64::consts::PI / 5.0).map(|t| [t.cos(), t.sin()]).collect();
        assert_eq!(Cutter::new().cut(&points(&star)), Err(Crossed));
    }
}
