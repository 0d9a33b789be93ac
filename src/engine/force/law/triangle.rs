//! Geometry shared by the terms that act on triangles: the area vector and its derivatives.
//!
//! ```text
//! S = 1/2 (x1 - x0) x (x2 - x0) = A N,      dS/dx_j = 1/2 [d_j]x,   d_0 = x2 - x1, d_1 = x0 - x2, d_2 = x1 - x0
//! ```

use nalgebra::{Matrix3, Vector3};

/// A vertex's share of its triangle; a product is cheaper than three divisions.
pub(crate) const THIRD: f64 = 1.0 / 3.0;

/// Area vector of a triangle and the edges opposite to its vertices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AreaVector {
    /// [m^2] S = A N
    pub s: Vector3<f64>,
    /// [m] opposite edge of each vertex
    pub opposite: [Vector3<f64>; 3],
}

impl AreaVector {
    #[inline]
    pub(crate) fn new(x: &[Vector3<f64>], nodes: [u32; 3]) -> Self {
        Self::of(nodes.map(|i| x[i as usize]))
    }

    #[inline]
    pub(crate) fn of([x0, x1, x2]: [Vector3<f64>; 3]) -> Self {
        AreaVector { s: 0.5 * (x1 - x0).cross(&(x2 - x0)), opposite: [x2 - x1, x0 - x2, x1 - x0] }
    }

    /// dS/dx_j as a matrix.
    pub(crate) fn derivative(&self, j: usize) -> Matrix3<f64> {
        cross_matrix(0.5 * self.opposite[j])
    }
}

/// The matrix `[a]x` with `[a]x b = a x b`.
fn cross_matrix(a: Vector3<f64>) -> Matrix3<f64> {
    Matrix3::from_columns(&[Vector3::new(0.0, a.z, -a.y), Vector3::new(-a.z, 0.0, a.x), Vector3::new(a.y, -a.x, 0.0)])
}

/// Mean of a nodal vector over a triangle.
#[inline]
pub(crate) fn mean(v: &[Vector3<f64>], nodes: [u32; 3]) -> Vector3<f64> {
    (v[nodes[0] as usize] + v[nodes[1] as usize] + v[nodes[2] as usize]) * THIRD
}
