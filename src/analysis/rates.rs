//! The fastest rates of the linearised scene: the largest w of K phi = w^2 M phi and the largest damping rate of M^-1 C.
//!
//! Power iteration (von Mises 1929) on the symmetric parts, matrix-free: an estimate from below, within a few percent; not a bound.

use crate::model::state::StateRef;
use crate::model::system::Weights;
use crate::scene::Scene;

/// Iterations; the estimate changes by less than a percent after about thirty on cloth meshes.
const ITERATIONS: usize = 80;

/// Fastest rates at one state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rates {
    /// [rad/s] largest w of the tangent system
    pub frequency: f64,
    /// degree of freedom that moves most in that mode
    pub frequency_dof: usize,
    /// [1/s] largest eigenvalue of M^-1 C
    pub damping: f64,
    /// degree of freedom that moves most in that mode
    pub damping_dof: usize,
}

impl Rates {
    /// [-] damping ratio of the fastest oscillation if both rates belong to the same mode.
    pub fn damping_ratio(&self) -> f64 {
        if self.frequency > 0.0 { 0.5 * self.damping / self.frequency } else { 0.0 }
    }
}

/// Estimates the fastest rates at a state.
pub fn rates(scene: &dyn Scene, at: StateRef<'_>) -> Rates {
    let (square, frequency_dof) = largest(scene, at, Weights { m: 0.0, c: 0.0, k: 1.0 });
    let (damping, damping_dof) = largest(scene, at, Weights { m: 0.0, c: 1.0, k: 0.0 });
    Rates { frequency: square.max(0.0).sqrt(), frequency_dof, damping: damping.max(0.0), damping_dof }
}

/// Largest (in size) eigenvalue of M^-1/2 A M^-1/2 by Rayleigh quotient, and where its vector is largest.
fn largest(scene: &dyn Scene, at: StateRef<'_>, w: Weights) -> (f64, usize) {
    let inverse = scene.inverse_mass();
    let n = inverse.len();
    let root: Vec<f64> = inverse.iter().map(|m| m.sqrt()).collect();
    // A fixed start that is rough (rich in high modes) and has a part in every mode.
    let mut q: Vec<f64> = (0..n).map(|i| if root[i] > 0.0 { rough(i) } else { 0.0 }).collect();
    let (mut p, mut y) = (vec![0.0; n], vec![0.0; n]);
    let mut quotient = 0.0;
    for _ in 0..ITERATIONS {
        let size = q.iter().map(|q| q * q).sum::<f64>().sqrt();
        if !(size > 0.0 && size.is_finite()) {
            break;
        }
        q.iter_mut().for_each(|q| *q /= size);
        for ((p, q), r) in p.iter_mut().zip(&q).zip(&root) {
            *p = r * q;
        }
        scene.tangent_times(at, w, &p, &mut y);
        quotient = 0.0;
        for ((q, y), r) in q.iter_mut().zip(&y).zip(&root) {
            let z = r * y;
            quotient += *q * z;
            *q = z;
        }
    }
    let most = (0..n).max_by(|&a, &b| p[a].abs().total_cmp(&p[b].abs())).unwrap_or(0);
    (if f64::is_finite(quotient) { quotient } else { 0.0 }, most)
}

/// A fixed number in [-1, 1] of alternating sign, from a multiplicative hash.
fn rough(i: usize) -> f64 {
    let hash = (i as u64).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 11;
    2.0 * (hash as f64 / (1u64 << 53) as f64) - 1.0
}
