//! Conjugate gradients (Hestenes & Stiefel 1952) preconditioned by an incomplete factorisation that needs pivots only
//! (`relaxed_ic0`), with Eisenstat's product (1981).
//!
//! No factor is stored: it takes about as much memory as W, of which an iteration reads a third, and making it ready
//! costs about thirteen iterations. The number of iterations grows with the root of stiffness over inertia, h
//! sqrt(k/m), so it suits small steps. It works on
//!
//! ```text
//! (I + L)^-1 (I + J + L + L^T) (I + L^T)^-1 x^ = (I + L)^-1 E^-1 b,      x = E^-T (I + L^T)^-1 x^
//! ```
//! in single precision, and its residual is that of this system: the residual of W x = b in the norm of M^-1. Smaller
//! residuals than single precision allows come from iterative refinement in double precision (Higham 2002, chapter 12).

use super::bsr::NodeBlocks;
use super::linear::{Accuracy, Inertia, LinearError, LinearSolver, LinearStats, Work, check_finite, check_solution};
use super::norms::norm;
use super::partitioned_cg::PartitionedSystem;
use super::relaxed_ic0::RELAXATION;
use super::twisted_factorization::cut;
use crate::assembly::Pattern;
use crate::model::workers::Workers;
use std::sync::Arc;

/// [-] relative residual of a solve for which nobody has asked for another
const RELATIVE: f64 = 1e-10;
/// [-] what one round in single precision may leave at least: it has seven digits
const SINGLE: f64 = 1e-6;
/// [-] A round that leaves more than this of what it began with is the last: rounding has eaten the rest.
const ROUND: f64 = 0.1;
/// [-] p . W p over p . p and its largest value, below which its sign is one of rounding
const ROUNDING: f64 = 1e-5;
/// [iterations] after which it is judged whether M is nearly singular.
const PROBE: u32 = 3;
/// [-] p . W p over p . p that a run of nodes may have. It is 0.8 to 2 on taut nets, which fill in the pivots serves;
/// where M is nearly singular (nets with waves some springs long, or six nodes of such waves in a flat net) it is 4.5
/// to 1e8, and motions that hardly matter drown all others in the residual.
const LARGEST: f64 = 2.0;
/// [iterations] in which a solve still goes on to the tighter of its two tolerances: where so few reach it, one
/// iteration around the solve is enough.
const FEW: u32 = 2;
/// [iterations] after which a solve is given up: as many as unknowns, which would do in exact arithmetic, within these
/// bounds.
const MOST: [usize; 2] = [200, 20_000];

/// W x = b by conjugate gradients.
pub struct ConjugateGradients {
    pattern: Arc<Pattern>,
    system: PartitionedSystem,
    workers: Workers,
    /// what a solve may leave
    accuracy: Accuracy,
    /// b and the residual of refinement, made when first called for
    refined: Option<[Vec<f64>; 2]>,
    /// the most of them in a solve
    most: u32,
    /// of the present solve
    iterations: u32,
    /// of all solves
    total_iterations: u64,
    indefinite: u64,
}

/// A right-hand side in r.
struct RightHandSide {
    /// largest entry of the right-hand side, over which it is taken
    scale: f64,
    /// r . r
    first: f64,
}

impl RightHandSide {
    /// [-] size of the right-hand side in the norm of residuals
    fn size(&self) -> f64 {
        self.scale * self.first.sqrt()
    }
}

impl std::fmt::Debug for ConjugateGradients {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ConjugateGradients").field("stats", &self.stats()).finish()
    }
}

impl ConjugateGradients {
    /// Finds the blocks of a pattern, which the threads share.
    ///
    /// # Errors
    /// A pattern that is not symmetric, or has too many entries.
    pub fn new(pattern: Arc<Pattern>, workers: &Workers) -> Result<Self, LinearError> {
        if !pattern.symmetric {
            return Err(LinearError::NotByNodes);
        }
        if pattern.nonzeros() > NodeBlocks::MOST_ENTRIES {
            let reason = "more entries than 32 bits can number in blocks".to_owned();
            return Err(LinearError::Analysis { unknowns: pattern.n(), reason });
        }
        let subdomains = cut(&pattern, &pattern.node_of_unknown());
        let system = PartitionedSystem::new(&pattern, subdomains, workers.clone());
        let [least, most] = MOST;
        let most = (pattern.n() + least).min(most) as u32;
        let (accuracy, iterations, total_iterations, indefinite) = (Accuracy::to(RELATIVE), 0, 0, 0);
        let (refined, workers) = (None, workers.clone());
        Ok(ConjugateGradients {
            pattern,
            system,
            workers,
            accuracy,
            refined,
            most,
            iterations,
            total_iterations,
            indefinite,
        })
    }

    /// Solves for a right-hand side that is the same everywhere and has a part of every motion, to a relative residual,
    /// in `most` iterations or not at all, and returns how many were made.
    ///
    /// # Errors
    /// As [`LinearSolver::solve`].
    pub(super) fn trial_solve(&mut self, relative: f64, most: u32) -> Result<u32, LinearError> {
        let own = std::mem::replace(&mut self.most, most);
        self.iterations = 0;
        let first = self.system.set_trial_right_hand_side();
        let found = self.iterate(first, Accuracy::to(relative));
        self.most = own;
        found.map(|()| self.iterations)
    }

    /// Whether pivots with fill serve W: residuals tell what is left of a solution.
    fn relaxation_serves(&mut self) -> bool {
        let indefinite = self.indefinite;
        let found = self.trial_solve(0.0, PROBE);
        // A nearly singular M makes rounding look like an indefinite W.
        self.indefinite = indefinite;
        matches!(found, Ok(_) | Err(LinearError::Stalled { .. })) && self.system.runs_within(LARGEST)
    }

    /// Iterates until x^ is found, with the right-hand side and its square in r.
    fn iterate(&mut self, first: f64, Accuracy { relative, enough, .. }: Accuracy) -> Result<(), LinearError> {
        self.system.begin();
        let mut square = first;
        let left = |square: f64| (square / first).sqrt();
        let stalled = |iterations, square| LinearError::Stalled { iterations, residual: left(square), asked: relative };
        let (mut beta, mut largest) = (0.0, 1.0_f64);
        while square > 0.0 && left(square) > if self.iterations < FEW { enough } else { relative } {
            if self.iterations == self.most {
                return Err(stalled(self.iterations, square));
            }
            self.iterations += 1;
            self.total_iterations += 1;
            let curvature = self.system.product(beta);
            if !curvature.along.is_finite() {
                return Err(LinearError::Singular { unknown: None });
            }
            largest = largest.max(curvature.along / curvature.squares);
            if curvature.along <= -ROUNDING * largest * curvature.squares {
                self.indefinite += 1;
                return Err(LinearError::Indefinite { iterations: self.iterations });
            }
            if curvature.along <= 0.0 {
                return Err(stalled(self.iterations, square));
            }
            let alpha = square / curvature.along;
            let before = square;
            square = self.system.advance(alpha as f32);
            if !square.is_finite() {
                return Err(LinearError::Singular { unknown: None });
            }
            beta = (square / before) as f32;
        }
        Ok(())
    }

    /// Replaces b by an approximation of W^-1 b, which leaves of it what single precision can reach or what is asked
    /// for.
    fn round(&mut self, b: &mut [f64], asked: Accuracy) -> Result<(), LinearError> {
        let RightHandSide { scale, first } = self.set_right_hand_side(b)?;
        let possible = Accuracy { relative: asked.relative.max(SINGLE), enough: asked.enough.max(SINGLE), ..asked };
        self.iterate(first, possible)?;
        self.system.finish(scale, b);
        Ok(())
    }

    /// r <- (I + L)^-1 E^-1 b over the scale of b.
    fn set_right_hand_side(&mut self, b: &[f64]) -> Result<RightHandSide, LinearError> {
        let [scale, first] = self.system.set_right_hand_side(b);
        if first.is_finite() {
            Ok(RightHandSide { scale, first })
        } else {
            Err(LinearError::Singular { unknown: None })
        }
    }

    /// Solves for what is left of the right-hand side in double precision, until that is no more than was asked for.
    fn refine(&mut self, values: &[f64], x: &mut [f64], asked: Accuracy) -> Result<(), LinearError> {
        let n = x.len();
        let [mut b, mut r] = self.refined.take().unwrap_or_else(|| [vec![0.0; n], vec![0.0; n]]);
        b.copy_from_slice(x);
        r.copy_from_slice(x);
        x.fill(0.0);
        let found = self.rounds(values, &b, asked, [x, &mut r]);
        if found.is_err() {
            x.copy_from_slice(&b);
        }
        self.refined = Some([b, r]);
        found
    }

    fn rounds(
        &mut self,
        values: &[f64],
        b: &[f64],
        Accuracy { relative: asked, checked, .. }: Accuracy,
        [x, r]: [&mut [f64]; 2],
    ) -> Result<(), LinearError> {
        let first = self.set_right_hand_side(b)?.size();
        let size = if checked { norm(b) } else { 0.0 };
        let mut left = 1.0;
        while first > 0.0 && left > asked {
            self.round(r, Accuracy::to(asked / left)).map_err(|error| match error {
                LinearError::Stalled { iterations, residual, .. } => {
                    LinearError::Stalled { iterations, residual: residual * left, asked }
                }
                other => other,
            })?;
            for (x, r) in x.iter_mut().zip(&*r) {
                *x += r;
            }
            self.pattern.multiply(values, x, r);
            for (r, b) in r.iter_mut().zip(b) {
                *r = b - *r;
            }
            // No number where x has left the range of numbers.
            let mut now = self.set_right_hand_side(r).map_or(f64::NAN, |taken| taken.size()) / first;
            if checked {
                // M is that of a rounded W, and its norm may not see what the rounding has taken from W.
                now = now.max(norm(r) / size);
            }
            if now > asked && now > ROUND * left || now.is_nan() {
                return Err(LinearError::Stalled { iterations: self.iterations, residual: now, asked });
            }
            left = now;
        }
        Ok(())
    }
}

impl LinearSolver for ConjugateGradients {
    /// Makes the blocks ready. Whether W is definite shows only in a solve.
    fn factor(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        check_finite(&self.pattern, values, &self.workers)?;
        let served = self.system.set_values(values, RELAXATION) && self.relaxation_serves();
        if served || self.system.set_values(values, 0.0) {
            return Ok(Inertia::Unknown);
        }
        self.indefinite += 1;
        Ok(Inertia::Indefinite)
    }

    fn solve(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), LinearError> {
        self.iterations = 0;
        let asked = self.accuracy;
        if asked.relative < SINGLE || asked.checked {
            self.refine(values, b, asked)?
        } else {
            self.round(b, asked)?
        }
        check_solution(b, &self.workers)
    }

    fn ask(&mut self, accuracy: Accuracy) {
        self.accuracy = accuracy;
    }

    fn work(&self) -> Work {
        Work { factorizations: 0, iterations: self.total_iterations }
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
