//! Conjugate gradients (Hestenes & Stiefel 1952) preconditioned by symmetric block Gauss-Seidel, with Eisenstat's product (1981).
//!
//! Nothing is factorised: making the solver ready costs about three of its iterations, and its memory is that of W. Iterations grow like the
//! root of stiffness over inertia, h sqrt(k/m), so it serves small steps. It works on
//!
//! ```text
//! (I + L)^-1 (I + L + L^T) (I + L^T)^-1 x^ = (I + L)^-1 E^-1 b,      x = E^-T (I + L^T)^-1 x^
//! ```
//! and its residual is the one of this system: W's residual in the norm of the inverse preconditioner.

use super::blocks::{NodeBlocks, Sweep};
use super::linear::{Accuracy, Inertia, LinearError, LinearSolver, LinearStats, Work, check_finite};
use crate::assembly::Pattern;
use glam::DVec3;
use std::sync::Arc;

/// [-] relative residual of a solve for which nobody has asked for another
const RELATIVE: f64 = 1e-10;
/// Iterations that are made if anything is to be gained: where so few are enough, so is one iteration around them
const FEW: u32 = 2;
/// Iterations after which a solve is given up: in exact arithmetic as many as unknowns would do.
const MOST: [usize; 2] = [200, 20_000];

/// W x = b by conjugate gradients.
pub struct ConjugateGradients {
    pattern: Arc<Pattern>,
    blocks: NodeBlocks,
    /// what a solve may leave
    accuracy: Accuracy,
    /// x^
    x: Vec<DVec3>,
    r: Vec<DVec3>,
    p: Vec<DVec3>,
    t: Vec<DVec3>,
    q: Vec<DVec3>,
    /// the most of them in a solve
    most: u32,
    /// of the last solve
    iterations: u32,
    /// of all solves
    all: u64,
    indefinite: u64,
}

impl std::fmt::Debug for ConjugateGradients {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ConjugateGradients").field("stats", &self.stats()).finish()
    }
}

impl ConjugateGradients {
    /// Finds the blocks of a pattern.
    ///
    /// # Errors
    /// A pattern that is not symmetric, or has too many entries.
    pub fn new(pattern: Arc<Pattern>) -> Result<Self, LinearError> {
        if !pattern.symmetric {
            return Err(LinearError::NotByNodes);
        }
        if pattern.nonzeros() > NodeBlocks::MOST_ENTRIES {
            let reason = "more entries than 32 bits can number in blocks".to_owned();
            return Err(LinearError::Analysis { unknowns: pattern.n(), reason });
        }
        let blocks = NodeBlocks::new(&pattern);
        let zero = || vec![DVec3::ZERO; blocks.nodes()];
        let [x, r, p, t, q] = [zero(), zero(), zero(), zero(), zero()];
        let [least, most] = MOST;
        let most = (pattern.n() + least).min(most) as u32;
        let (accuracy, iterations, all, indefinite) = (Accuracy::to(RELATIVE), 0, 0, 0);
        Ok(ConjugateGradients { pattern, blocks, accuracy, x, r, p, t, q, most, iterations, all, indefinite })
    }

    /// Solves for a right-hand side that is the same everywhere and has a part of every motion, to a relative residual, in `most` iterations
    /// or not at all, and returns how many were made.
    ///
    /// # Errors
    /// As [`LinearSolver::solve`].
    pub(super) fn rehearse(&mut self, relative: f64, most: u32) -> Result<u32, LinearError> {
        let mut seed = 0x9E37_79B9_7F4A_7C15_u64;
        let mut rough = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 0.5
        };
        self.r.fill_with(|| DVec3::new(rough(), rough(), rough()));
        let accuracy = Accuracy::to(relative);
        let own = (std::mem::replace(&mut self.accuracy, accuracy), std::mem::replace(&mut self.most, most));
        let found = self.iterate();
        (self.accuracy, self.most) = own;
        found.map(|()| self.iterations)
    }

    /// Iterates until x^ is found, with the right-hand side in r.
    fn iterate(&mut self) -> Result<(), LinearError> {
        self.x.fill(DVec3::ZERO);
        self.p.fill(DVec3::ZERO);
        self.iterations = 0;
        let mut square = squared(&self.r);
        let first = square;
        let left = |square: f64| (square / first).sqrt();
        let Accuracy { relative, enough } = self.accuracy;
        let mut beta = 0.0;
        while square > 0.0 && left(square) > if self.iterations < FEW { enough } else { relative } {
            if self.iterations == self.most {
                let (iterations, residual) = (self.iterations, left(square));
                return Err(LinearError::Stalled { iterations, residual, asked: relative });
            }
            self.iterations += 1;
            self.all += 1;
            let sweep = Sweep { p: &mut self.p, t: &mut self.t, q: &mut self.q };
            let curvature = self.blocks.times(&self.r, beta, sweep);
            if curvature.is_nan() {
                return Err(LinearError::Singular { unknown: None });
            }
            if curvature <= 0.0 {
                self.indefinite += 1;
                return Err(LinearError::Indefinite { iterations: self.iterations });
            }
            let alpha = square / curvature;
            let before = square;
            square = advance(alpha, [&mut self.x, &mut self.r], [&self.p, &self.q]);
            beta = square / before;
        }
        Ok(())
    }
}

fn squared(v: &[DVec3]) -> f64 {
    v.iter().fold(DVec3::ZERO, |sum, v| sum + *v * *v).element_sum()
}

/// x += alpha p, r -= alpha q; returns r . r.
fn advance(alpha: f64, [x, r]: [&mut [DVec3]; 2], [p, q]: [&[DVec3]; 2]) -> f64 {
    let mut sum = DVec3::ZERO;
    for (((x, r), p), q) in x.iter_mut().zip(r).zip(p).zip(q) {
        *x += alpha * *p;
        *r -= alpha * *q;
        sum += *r * *r;
    }
    sum.element_sum()
}

impl LinearSolver for ConjugateGradients {
    /// Makes the blocks ready. Whether W is definite shows only in a solve.
    fn factor(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        check_finite(&self.pattern, values)?;
        if self.blocks.fill(values) {
            return Ok(Inertia::Unknown);
        }
        self.indefinite += 1;
        Ok(Inertia::Indefinite)
    }

    fn solve(&mut self, _values: &[f64], b: &mut [f64]) -> Result<(), LinearError> {
        self.blocks.gather(b, &mut self.r);
        self.blocks.forward(&mut self.r);
        self.iterate()?;
        self.blocks.backward(&mut self.x);
        self.blocks.scatter(&mut self.x, b);
        match b.iter().position(|x| !x.is_finite()) {
            None => Ok(()),
            unknown => Err(LinearError::Singular { unknown }),
        }
    }

    fn ask(&mut self, accuracy: Accuracy) {
        self.accuracy = accuracy;
    }

    fn work(&self) -> Work {
        Work { factorizations: 0, iterations: self.all }
    }

    fn stats(&self) -> LinearStats {
        LinearStats {
            name: "cg",
            matrix_nonzeros: self.pattern.nonzeros(),
            factor_nonzeros: None,
            factor_operations: None,
            indefinite: self.indefinite,
            prediction: None,
        }
    }
}
