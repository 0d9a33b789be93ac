//! A scene linearised about a state, in coordinates q = M^1/2 x that make the mass the identity, matrix-free.

use super::critical::{DAMPING, STIFFNESS};
use super::matrices::Matrices;
use super::rates::Rates;
use crate::model::state::StateRef;
use crate::model::stop::Stop;
use crate::model::system::Weights;
use crate::scene::Scene;
use std::sync::Arc;

/// Degrees of freedom above which matrices would take more memory than a run with an explicit method.
const MOST_ASSEMBLED: usize = 400_000;

/// M^-1/2 (c C + k K) M^-1/2 at a state, as products.
pub(super) struct Linearised<'a> {
    pub scene: &'a dyn Scene,
    pub at: StateRef<'a>,
    /// [1/sqrt(kg)] diagonal of M^-1/2, 0 where fixed
    pub root: Vec<f64>,
    /// K and C as matrices, where their elements are dearer than a matrix: those of air and dashpots. Springs alone are
    /// not.
    pub matrices: Option<Arc<Matrices>>,
    /// looked at between two products of an iteration
    pub stop: Stop<'a>,
}

impl<'a> Linearised<'a> {
    pub fn of(scene: &'a dyn Scene, at: StateRef<'a>, stop: Stop<'a>) -> Self {
        let root: Vec<f64> = scene.inverse_mass().iter().map(|m| m.sqrt()).collect();
        let worth = (scene.velocity_dependent() || !scene.symmetric()) && root.len() <= MOST_ASSEMBLED;
        let matrices = if worth && !stop.asked() { Matrices::of(scene, at).map(Arc::new) } else { None };
        Linearised { scene, at, root, matrices, stop }
    }

    /// A fixed start that is rough (rich in high modes), has a part in every mode, and is 0 where the scene is held.
    pub fn start(&self) -> Vec<f64> {
        self.root.iter().enumerate().map(|(i, r)| if *r > 0.0 { rough(i) } else { 0.0 }).collect()
    }

    /// y = M^-1/2 (c C + k K) M^-1/2 q; `p` is room for M^-1/2 q.
    pub fn times(&self, w: Weights, q: &[f64], p: &mut [f64], y: &mut [f64]) {
        for ((p, q), r) in p.iter_mut().zip(q).zip(&self.root) {
            *p = r * q;
        }
        match &self.matrices {
            Some(matrices) => matrices.times([w.k, w.c], [p, p], y),
            None => self.scene.tangent_times(self.at, w, p, y),
        }
        for (y, r) in y.iter_mut().zip(&self.root) {
            *y *= r;
        }
    }

    /// Rayleigh quotients of K and C of a shape, as rates; none where they are not finite.
    pub fn quotients(&self, shape: &[f64]) -> Option<Rates> {
        // There is none where products with the tangent overflow.
        if shape.is_empty() {
            return None;
        }
        let (mut p, mut y) = (vec![0.0; shape.len()], vec![0.0; shape.len()]);
        let mut quotient = |w: Weights| {
            self.times(w, shape, &mut p, &mut y);
            dot(shape, &y) / dot(shape, shape)
        };
        let (k, c) = (quotient(STIFFNESS), quotient(DAMPING));
        let rates = Rates { frequency: k.max(0.0).sqrt(), damping: c.max(0.0), ..Rates::default() };
        (k.is_finite() && c.is_finite()).then_some(rates)
    }

    /// The degree of freedom that moves most.
    pub fn place(&self, shape: &[f64]) -> usize {
        let moves = |i: usize| (shape[i] * self.root[i]).abs();
        (0..shape.len()).max_by(|&a, &b| moves(a).total_cmp(&moves(b))).unwrap_or(0)
    }
}

/// [-] A fixed number in [-1, 1) for every index, scattered without a pattern in sign or size: a multiplicative hash.
pub(crate) fn rough(i: usize) -> f64 {
    let hash = (i as u64).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 11;
    2.0 * (hash as f64 / (1u64 << 53) as f64) - 1.0
}

/// a.b in eight lanes, which a processor can add side by side. Adds them in another order than `solve::norms`: the bits
/// of limits hang on it.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, a_rest) = a.as_chunks::<8>();
    let (b, b_rest) = b.as_chunks::<8>();
    let mut lanes = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for (lane, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            *lane += a * b;
        }
    }
    lanes.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f64>()
}

pub(super) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// y += f x
pub(super) fn add(y: &mut [f64], f: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += f * x;
    }
}

/// Takes the parts along an orthonormal basis out of q, and says how large they were and what is left. A second pass is
/// made where the first took most of q away and so left rounding (Daniel, Gragg, Kaufman & Stewart 1976).
pub(super) fn orthogonalise(q: &mut [f64], basis: &[Vec<f64>], mut part_was: impl FnMut(usize, f64)) -> f64 {
    let mut before = norm(q);
    loop {
        for (i, v) in basis.iter().enumerate() {
            let part = dot(v, q);
            part_was(i, part);
            add(q, -part, v);
        }
        let left = norm(q);
        if left > 0.5 * before || before == 0.0 || !left.is_finite() || left < f64::EPSILON * before {
            return left;
        }
        // What is left of the second pass is as good as its own size.
        before = left;
    }
}

/// Least and most shapes that a search for the largest eigenvalue keeps, and least of one for eigenvalues of L.
pub(super) const SHAPES: [usize; 2] = [12, 60];
pub(super) const LEAST_MOTIONS: usize = 20;
/// Shapes after which the largest eigenvalue of a net has mostly settled.
const SETTLED: usize = 24;

/// Numbers that a search for a critical step mostly keeps, on a scene with `n` degrees of freedom.
pub fn search_numbers(n: usize, damped: bool) -> usize {
    let shapes = n * affordable(n, SHAPES).min(SETTLED);
    // A motion has a position and a velocity.
    let motions = 2 * n * affordable(2 * n, [LEAST_MOTIONS, super::motions::PRODUCTS]);
    if damped { shapes.max(motions) } else { shapes }
}

/// Vectors of length `n` that fit into the memory an analysis may take, at least `least`, at most `most`.
pub(super) fn affordable(n: usize, [least, most]: [usize; 2]) -> usize {
    const NUMBERS: usize = 12_000_000;
    (NUMBERS / n.max(1)).clamp(least, most).min(n)
}
