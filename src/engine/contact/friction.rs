//! Coulomb's friction, smoothed at rest (Li et al. 2020, equation 16).
//!
//! ```text
//! u = velocity of one side against the other, across the normal;   y = |u|/eps
//! force on the first side:  -mu lambda f(y) u/|u|,      f = 2 y - y^2 for y < 1,   1 from there on
//! -d force/du = mu lambda (f/|u| (I - n n^T - t t^T) + f'/eps t t^T),      t = u/|u|
//! ```
//! With lambda and n of the start of a step it has a potential, so that the tangent of an implicit step is symmetric.
//! What is held by friction creeps by less than eps.

use crate::force::outer;
use nalgebra::{Matrix3, Vector3};

/// [m/s] eps: the speed from which on friction has its full size.
pub const CREEP: f64 = 1e-3;

/// Friction at a place that is pressed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// [N] mu lambda
    pub limit: f64,
    /// [m/s] eps
    pub creep: f64,
    /// n
    pub normal: Vector3<f64>,
}

impl Friction {
    /// u of a relative velocity [m/s], |u|, and f/|u| [s/m].
    fn slide(&self, velocity: Vector3<f64>) -> (Vector3<f64>, f64, f64) {
        let u = velocity - self.normal * self.normal.dot(&velocity);
        let (speed, eps) = (u.norm(), self.creep);
        let share = if speed < eps { (2.0 - speed / eps) / eps } else { 1.0 / speed };
        (u, speed, share)
    }

    /// [N] The force on the first side, at a relative velocity [m/s].
    pub fn force(&self, velocity: Vector3<f64>) -> Vector3<f64> {
        let (u, _, share) = self.slide(velocity);
        u * (-self.limit * share)
    }

    /// [N s/m] Minus its derivative by the relative velocity: symmetric, without negative eigenvalues.
    pub fn tangent(&self, velocity: Vector3<f64>) -> Matrix3<f64> {
        let (u, speed, share) = self.slide(velocity);
        let across = Matrix3::identity() - outer(self.normal, self.normal);
        if speed == 0.0 {
            return across * (self.limit * share);
        }
        let along = if speed < self.creep { 2.0 * (1.0 - speed / self.creep) / self.creep } else { 0.0 };
        let t = u / speed;
        (across * share + outer(t, t) * (along - share)) * self.limit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tangent is the derivative of the force, at rest, in creep and in sliding; the force never exceeds mu lambda.
    #[test]
    fn tangents_belong_to_forces() {
        let normal = Vector3::new(1.0, -2.0, 2.0) / 3.0;
        let friction = Friction { limit: 12.0, creep: 1e-3, normal };
        let along = Vector3::new(2.0, 2.0, 1.0) / 3.0;
        for speed in [0.0, 1e-4, 7e-4, 2e-3, 0.5] {
            let v = along * speed + normal * 0.3;
            let tangent = friction.tangent(v);
            for axis in 0..3 {
                let step = Vector3::ith(axis, 1e-8);
                let slope = (friction.force(v - step) - friction.force(v + step)) / 2e-8;
                let error = (slope - tangent.column(axis)).norm();
                assert!(error < 1e-4 * tangent.norm().max(12.0), "{speed} {axis}: {error}");
            }
            assert!(friction.force(v).norm() <= 12.0 * (1.0 + 1e-12), "{speed}");
        }
        assert!((friction.force(along) + along * 12.0).norm() < 1e-12);
    }
}
