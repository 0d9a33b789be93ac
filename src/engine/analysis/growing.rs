//! Motions that grow by themselves, made of the lowest modes.
//!
//! Where K is not symmetric, two modes can grow together although neither does alone. So K and C, both whole, are
//! projected onto the modes, and the eigenvalues z of q'' + C q' + K q = 0 are found there (Ritz, Galerkin).

use super::low_mode::LowMode;
use super::operators::{DAMPING, STIFFNESS};
use super::vectors::dot;
use crate::model::state::StateRef;
use crate::scene::Scene;
use nalgebra::DMatrix;
use nalgebra::linalg::Schur;

/// [-] A rate below this share of the fastest one is rounding; that of modes of frequency 0 is about its root.
const NO_RATE: f64 = 1e-5;
/// Iterations of the eigenvalue solver for each eigenvalue.
const ITERATIONS: usize = 100;

/// A motion that grows as exp(rate t).
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct GrowingMotion {
    /// [Hz] frequency; 0 for a motion that does not oscillate
    pub frequency: f64,
    /// [1/s]
    pub rate: f64,
}

/// Those of a symmetric K, without damping: the modes themselves. The fastest first.
pub(super) fn growing_modes(modes: &[LowMode]) -> Vec<GrowingMotion> {
    let rates = modes.iter().map(LowMode::growth).filter(|rate| *rate > 0.0);
    sorted(rates.map(|rate| GrowingMotion { frequency: 0.0, rate }).collect())
}

/// Those that modes make together, damped. The fastest first; `None` if the eigenvalues are not found.
pub(super) fn growing_together(scene: &dyn Scene, at: StateRef<'_>, modes: &[LowMode]) -> Option<Vec<GrowingMotion>> {
    let n = modes.len();
    let mut image = vec![0.0; scene.n_dof()];
    let [mut k, mut c] = [DMatrix::zeros(n, n), DMatrix::zeros(n, n)];
    for (w, projected) in [(STIFFNESS, &mut k), (DAMPING, &mut c)] {
        for (j, mode) in modes.iter().enumerate() {
            scene.tangent_times(at, w, &mode.shape, &mut image);
            modes.iter().enumerate().for_each(|(i, of)| projected[(i, j)] = dot(&of.shape, &image));
        }
    }
    // Acts on (unit q, q'), so that both halves have one scale.
    let unit = k.amax().sqrt().max(c.amax()).max(f64::MIN_POSITIVE);
    let mut first = DMatrix::zeros(2 * n, 2 * n);
    for i in 0..n {
        first[(i, n + i)] = 1.0;
        for j in 0..n {
            first[(n + i, j)] = -k[(i, j)] / (unit * unit);
            first[(n + i, n + j)] = -c[(i, j)] / unit;
        }
    }
    let values = Schur::try_new(first, f64::EPSILON, ITERATIONS * 2 * n)?.complex_eigenvalues();
    let fastest = values.iter().fold(0.0, |most: f64, z| most.max(z.norm()));
    let growing = values.iter().filter(|z| z.im >= 0.0 && z.re > NO_RATE * fastest);
    let of = |z: &nalgebra::Complex<f64>| GrowingMotion {
        frequency: unit * z.im / std::f64::consts::TAU,
        rate: unit * z.re,
    };
    Some(sorted(growing.map(of).collect()))
}

fn sorted(mut growing: Vec<GrowingMotion>) -> Vec<GrowingMotion> {
    growing.sort_by(|a, b| b.rate.total_cmp(&a.rate));
    growing
}
