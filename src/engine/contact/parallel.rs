//! The mollifier of pairs of edges (Li et al. 2020, "Incremental potential contact", section 5).
//!
//! The closest points of two edges that become parallel jump from end to end, and with them the gradient of their
//! distance. A potential of the distance times the mollifier has no such jump: with u and v the edges, L_u and L_v
//! their lengths at rest, c = |u x v|^2 and e = 1e-3 L_u^2 L_v^2,
//!
//! ```text
//! m = (2 - c/e) c/e  for c < e,   1  otherwise
//! ```

use nalgebra::{Matrix3, Vector3};

/// [-] Square of the sine of the angle between edges of the lengths at rest, below which they count as almost parallel.
const ALMOST: f64 = 1e-3;

/// The mollifier of the edges 0-1 and 2-3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mollifier {
    u: Vector3<f64>,
    v: Vector3<f64>,
    cross: Vector3<f64>,
    /// [m^4] e
    threshold: f64,
}

impl Mollifier {
    /// Of edges between `x` [m] with these lengths at rest [m]. It is 1 where one of them has no length.
    pub fn new(x: &[Vector3<f64>; 4], lengths: [f64; 2]) -> Self {
        let (u, v) = (x[1] - x[0], x[3] - x[2]);
        Self { u, v, cross: u.cross(&v), threshold: ALMOST * (lengths[0] * lengths[1]).powi(2) }
    }

    /// c/e
    fn ratio(&self) -> f64 {
        self.cross.norm_squared() / self.threshold
    }

    /// Whether the edges are almost parallel. Where they are not the value is 1 and the derivatives are 0.
    pub fn is_below_1(&self) -> bool {
        self.cross.norm_squared() < self.threshold
    }

    /// [-] m, from 0 at parallel edges to 1
    pub fn value(&self) -> f64 {
        if self.is_below_1() { (2.0 - self.ratio()) * self.ratio() } else { 1.0 }
    }

    /// [1/m] First derivatives of m by node.
    pub fn gradient(&self) -> [Vector3<f64>; 4] {
        if !self.is_below_1() {
            return [Vector3::zeros(); 4];
        }
        let slope = 2.0 * (1.0 - self.ratio()) / self.threshold;
        let [by_u, by_v] = self.gradient_of_square().map(|g| g * slope);
        [-by_u, by_u, -by_v, by_v]
    }

    /// [m^3] Derivatives of c by u and v.
    fn gradient_of_square(&self) -> [Vector3<f64>; 2] {
        [self.v.cross(&self.cross) * 2.0, self.cross.cross(&self.u) * 2.0]
    }

    /// [1/m^2] Second derivatives of m by pairs of nodes. They jump where m becomes 1.
    pub fn hessian(&self) -> [[Matrix3<f64>; 4]; 4] {
        if !self.is_below_1() {
            return [[Matrix3::zeros(); 4]; 4];
        }
        let (slope, bend) = (2.0 * (1.0 - self.ratio()) / self.threshold, -2.0 / self.threshold.powi(2));
        let (u, v, dot) = (&self.u, &self.v, self.u.dot(&self.v));
        let [by_u, by_v] = self.gradient_of_square();
        let without = |a: &Vector3<f64>| (Matrix3::from_diagonal_element(a.norm_squared()) - a * a.transpose()) * 2.0;
        let uv = (u * v.transpose() * 2.0 - Matrix3::from_diagonal_element(dot) - v * u.transpose()) * 2.0;
        let uu = without(v) * slope + by_u * by_u.transpose() * bend;
        let vv = without(u) * slope + by_v * by_v.transpose() * bend;
        let uv = uv * slope + by_u * by_v.transpose() * bend;
        let vu = uv.transpose();
        [[uu, -uu, uv, -uv], [-uu, uu, -uv, uv], [vu, -vu, vv, -vv], [-vu, vu, -vv, vv]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::random::SplitMix64;

    /// Edges at an angle whose sine is `sine`, and their lengths at rest, which differ from those now.
    fn edges(draw: &mut SplitMix64, sine: f64) -> ([Vector3<f64>; 4], [f64; 2]) {
        let mut random = || Vector3::from_fn(|_, _| 2.0 * draw.uniform() - 1.0);
        let (u, v, across) = (random(), random(), random());
        let v = u * v.x + u.cross(&across) * (sine * v.x / across.norm());
        let (from, other) = (random(), random());
        ([from, from + u, other, other + v], [1.1 * u.norm(), 0.8 * v.norm()])
    }

    #[test]
    fn it_goes_from_0_at_parallel_edges_to_1() {
        let x = [[0.0; 3], [1.0, 0.0, 0.0], [0.3, 0.1, 0.2], [0.3 + 2.0, 0.1, 0.2]].map(Vector3::from);
        let at = |height: f64| {
            let mut x = x;
            x[3].z += height;
            Mollifier::new(&x, [1.0, 2.0])
        };
        assert_eq!((at(0.0).value(), at(0.0).gradient()), (0.0, [Vector3::zeros(); 4]));
        // c = height^2 and e = 4e-3: half of e gives (2 - 1/2)/2.
        assert!((at(2e-3_f64.sqrt()).value() - 0.75).abs() < 1e-14);
        assert!((at(4e-3_f64.sqrt() * (1.0 - 1e-9)).value() - 1.0).abs() < 1e-15);
        let beyond = at(0.07);
        assert_eq!((beyond.value(), beyond.gradient()), (1.0, [Vector3::zeros(); 4]));
        assert_eq!(beyond.hessian(), [[Matrix3::zeros(); 4]; 4]);
        assert_eq!(Mollifier::new(&x, [0.0, 1.0]).value(), 1.0);
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let mut draw = SplitMix64::of_seed(1);
        let mut worst = (0.0_f64, 0.0_f64);
        for n in 0..500 {
            let (x, lengths) = edges(&mut draw, 0.025 * (n % 20) as f64 / 20.0);
            let mollifier = Mollifier::new(&x, lengths);
            assert!(mollifier.is_below_1());
            let (gradient, hessian) = (mollifier.gradient(), mollifier.hessian());
            let size = hessian.iter().flatten().map(|h| h.norm()).fold(0.0, f64::max);
            // [m] small against the length on which it changes
            let step = 1e-4 / size.sqrt();
            for (j, axis) in (0..4).flat_map(|j| (0..3).map(move |axis| (j, axis))) {
                let moved = |by: f64| {
                    let mut x = x;
                    x[j][axis] += by;
                    Mollifier::new(&x, lengths)
                };
                let (before, after) = (moved(-step), moved(step));
                let difference = (after.value() - before.value()) / (2.0 * step);
                worst.0 = worst.0.max((difference - gradient[j][axis]).abs() / size.sqrt());
                for (k, (a, b)) in after.gradient().iter().zip(before.gradient()).enumerate() {
                    let difference = (a - b) / (2.0 * step);
                    worst.1 = worst.1.max((difference - hessian[k][j].column(axis)).norm() / size);
                    assert_eq!(hessian[j][k], hessian[k][j].transpose());
                }
            }
        }
        assert!(worst.0 < 1e-7 && worst.1 < 1e-7, "{worst:?}");
    }
}
