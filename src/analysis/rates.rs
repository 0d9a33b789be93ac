//! The fastest rates of the linearised scene: the largest w of K phi = w^2 M phi and the largest damping rate of M^-1 C.
//!
//! Power iteration (von Mises 1929) on the symmetric parts, matrix-free: an estimate from below, within a few percent; not a bound.

use super::critical::{DAMPING, STIFFNESS};
use crate::model::state::StateRef;
use crate::model::system::Weights;
use crate::scene::{BoundRoom, Scene};

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

/// [s] h with h^2 k + 2 h c = 4 for element bounds k [1/s^2] and c [1/s] on the rates: the limit of Euler-Cromer were they reached, and for
/// other methods a measure that falls as their limit does.
pub(crate) fn step_by_bounds(scene: &dyn Scene, at: StateRef<'_>, room: &mut BoundRoom) -> f64 {
    let (k, _) = scene.rate_bound(at, STIFFNESS, room);
    let c = match scene.velocity_dependent() {
        true => scene.rate_bound(at, DAMPING, room).0,
        false => 0.0,
    };
    4.0 / (c + (c * c + 4.0 * k).sqrt())
}

/// Estimates the fastest rates at a state.
pub fn rates(scene: &dyn Scene, at: StateRef<'_>) -> Rates {
    let (square, frequency_dof) = largest(scene, at, Weights { m: 0.0, c: 0.0, k: 1.0 });
    let (damping, damping_dof) = largest(scene, at, Weights { m: 0.0, c: 1.0, k: 0.0 });
    Rates { frequency: square.max(0.0).sqrt(), frequency_dof, damping: damping.max(0.0), damping_dof }
}

/// Largest eigenvalue of M^-1/2 A M^-1/2, and where its vector is largest. Compressed springs make eigenvalues negative; where
/// one of those is the largest in size, or close to it, a shift brings them all above zero.
fn largest(scene: &dyn Scene, at: StateRef<'_>, w: Weights) -> (f64, usize) {
    let found = iterate(scene, at, w, 0.0);
    if found.quotient > 0.0 && found.defect < 0.3 * found.quotient {
        return (found.quotient, found.most);
    }
    let shift = found.size;
    let found = iterate(scene, at, w, shift);
    (found.quotient - shift, found.most)
}

/// What a power iteration found.
struct Found {
    /// Rayleigh quotient of A + shift
    quotient: f64,
    /// size of (A + shift - quotient) q, how far q is from an eigenvector
    defect: f64,
    /// size of (A + shift) q
    size: f64,
    /// degree of freedom with the largest part
    most: usize,
}

fn iterate(scene: &dyn Scene, at: StateRef<'_>, w: Weights, shift: f64) -> Found {
    let inverse = scene.inverse_mass();
    let n = inverse.len();
    let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let root: Vec<f64> = inverse.iter().map(|m| m.sqrt()).collect();
    // A fixed start that is rough (rich in high modes) and has a part in every mode.
    let mut q: Vec<f64> = (0..n).map(|i| if root[i] > 0.0 { rough(i) } else { 0.0 }).collect();
    let (mut p, mut y) = (vec![0.0; n], vec![0.0; n]);
    let mut found = Found { quotient: 0.0, defect: 0.0, size: 0.0, most: 0 };
    for _ in 0..ITERATIONS {
        let size = norm(&q);
        if !(size > 0.0 && size.is_finite()) {
            break;
        }
        q.iter_mut().for_each(|q| *q /= size);
        for ((p, q), r) in p.iter_mut().zip(&q).zip(&root) {
            *p = r * q;
        }
        scene.tangent_times(at, w, &p, &mut y);
        for ((y, r), q) in y.iter_mut().zip(&root).zip(&q) {
            *y = r * *y + shift * q;
        }
        found.quotient = q.iter().zip(&y).map(|(q, y)| q * y).sum();
        found.size = norm(&y);
        found.defect = (found.size * found.size - found.quotient * found.quotient).max(0.0).sqrt();
        std::mem::swap(&mut q, &mut y);
    }
    found.most = (0..n).max_by(|&a, &b| p[a].abs().total_cmp(&p[b].abs())).unwrap_or(0);
    if !(found.quotient.is_finite() && found.size.is_finite()) {
        return Found { quotient: 0.0, defect: 0.0, size: 0.0, most: found.most };
    }
    found
}

/// A fixed number in [-1, 1] of alternating sign, from a multiplicative hash.
fn rough(i: usize) -> f64 {
    let hash = (i as u64).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 11;
    2.0 * (hash as f64 / (1u64 << 53) as f64) - 1.0
}
