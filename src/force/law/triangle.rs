//! Geometry shared by the terms that act on triangles: the area vector and its derivatives.
//!
//! ```text
//! S = 1/2 (x1 - x0) x (x2 - x0) = A N,      dS/dx_j = 1/2 [d_j]x,   d_0 = x2 - x1, d_1 = x0 - x2, d_2 = x1 - x0
//! ```

use glam::{DMat3, DVec3};

/// A vertex's share of its triangle; a product is cheaper than three divisions.
pub(crate) const THIRD: f64 = 1.0 / 3.0;

/// Area vector of a triangle and the edges opposite to its vertices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AreaVector {
    /// [m^2] S = A N
    pub s: DVec3,
    /// [m] opposite edge of each vertex
    pub opposite: [DVec3; 3],
}

impl AreaVector {
    #[inline]
    pub(crate) fn new(x: &[DVec3], nodes: [u32; 3]) -> Self {
        let [x0, x1, x2] = nodes.map(|i| x[i as usize]);
        AreaVector { s: 0.5 * (x1 - x0).cross(x2 - x0), opposite: [x2 - x1, x0 - x2, x1 - x0] }
    }

    /// dS/dx_j as a matrix.
    pub(crate) fn derivative(&self, j: usize) -> DMat3 {
        cross_matrix(0.5 * self.opposite[j])
    }
}

/// The matrix `[a]x` with `[a]x b = a x b`.
fn cross_matrix(a: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, a.z, -a.y), DVec3::new(-a.z, 0.0, a.x), DVec3::new(a.y, -a.x, 0.0))
}

/// Mean of a nodal vector over a triangle.
#[inline]
pub(crate) fn mean(v: &[DVec3], nodes: [u32; 3]) -> DVec3 {
    (v[nodes[0] as usize] + v[nodes[1] as usize] + v[nodes[2] as usize]) * THIRD
}
