//! Conjugate gradients (Hestenes & Stiefel 1952), preconditioned by an incomplete factorisation that stores pivots only
//! (`relaxed_ic0`), with Eisenstat's product (1981).
//!
//! No factor is stored: it takes about as much memory as W, of which an iteration reads a third, and its setup costs
//! about thirteen iterations. The number of iterations grows with the root of stiffness over inertia, h sqrt(k/m), so
//! it suits small steps. Nets that need many iterations get multigrid (`multigrid`), with which the number does not
//! grow with the stiffness or the size. It solves
//!
//! ```text
//! (I + L)^-1 (I + J + L + L^T) (I + L^T)^-1 x^ = (I + L)^-1 E^-1 b,      x = E^-T (I + L^T)^-1 x^
//! ```
//! in single precision. Its residual is that of this system: the residual of W x = b in the norm of M^-1. Smaller
//! residuals than single precision allows come from iterative refinement in double precision (Higham 2002, chapter 12).

use super::bsr::NodeBlocks;
use super::linear::{
    Accuracy, ExpectedUse, Inertia, LinearError, LinearSolver, LinearStats, SolverWork, check_finite, check_solution,
};
use super::multigrid::Multigrid;
use super::partitioned_cg::PartitionedSystem;
use super::relaxed_ic0::RELAXATION;
use crate::assembly::Pattern;
use crate::model::workers::Workers;
use std::sync::Arc;

/// [-] default relative residual of a solve
const RELATIVE: f64 = 1e-10;
/// [-] least relative residual of a solve in single precision, which has seven digits
const SINGLE: f64 = 1e-6;
/// [-] Refinement stops if a round leaves more than this share of the residual: rounding dominates.
const ROUND: f64 = 0.1;
/// [-] Share of the largest p . W p / p . p below which the sign of p . W p is rounding.
const ROUNDING: f64 = 1e-5;
/// [-] Relative residual of a trial. Solves may leave its square, which takes twice as many iterations.
const TRIAL: f64 = 0.0316;
/// Nodes from which multigrid may save time.
const LARGE: usize = 2_000;
/// Iterations of a trial above which it does.
const EASY: u32 = 16;
/// [-] Iterations of a trial times the root of the share of inertia in W, on square nets so soft that these are fewer
/// than by [`TRIAL_OF_NODES`].
const TRIAL_OF_INERTIA: f64 = 0.5;
/// [-] Iterations of a trial over the root of the number of nodes, on stiffer ones.
const TRIAL_OF_NODES: f64 = 0.2;
/// [-] Time of an iteration with multigrid over that of one without.
const MULTIGRID_COST: f64 = 3.8;
/// Iterations after which M is checked for being nearly singular.
const PROBE: u32 = 3;
/// [-] Largest p . W p / p . p of a range of nodes with which fill in the pivots helps: it is 0.8 to 3.2 on nets with
/// few waves, largest at separators and where the elimination of a section begins. Where M is nearly singular it is 4.5
/// to 1e8: nets with waves some springs long, or six nodes of such waves in a flat net. Motions that hardly matter then
/// dominate the residual.
const LARGEST: f64 = 4.0;
/// Iterations up to which a solve continues to the tighter of its two tolerances: then one Newton iteration is enough.
const FEW: u32 = 2;
/// Maximum iterations of a solve: the number of unknowns, which suffices in exact arithmetic, within these bounds.
const MOST: [usize; 2] = [200, 20_000];

/// W x = b by conjugate gradients.
pub struct ConjugateGradients {
    pattern: Arc<Pattern>,
    /// made for a matrix that is tried without multigrid; not kept if that does not serve
    system: Option<PartitionedSystem>,
    /// made for the first matrix that needs it
    multigrid: Option<Multigrid>,
    /// whether the last matrix is solved with multigrid
    with_multigrid: bool,
    /// whether the next one is not tried without
    needs_multigrid: bool,
    /// whether matrices may be
    multigrid_allowed: bool,
    workers: Workers,
    /// accuracy of further solves
    accuracy: Accuracy,
    /// b and the residual of refinement, allocated at the first use
    refined: Option<[Vec<f64>; 2]>,
    /// maximum iterations of a solve
    most: u32,
    /// [-] share of inertia in W, by unknown
    shares: Vec<f64>,
    /// iterations of a trial with this matrix, once it was made
    tried: Option<u32>,
    /// iterations of the current solve
    iterations: u32,
    /// iterations of all solves
    total_iterations: u64,
    pub(super) indefinite: u64,
}

/// Scales of a right-hand side that is stored in r.
struct RightHandSide {
    /// its largest scaled entry, by which r is divided
    scale: f64,
    /// r . r
    first: f64,
}

impl RightHandSide {
    /// [-] its norm, in that of the residuals
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
    /// For a pattern. The first matrix finds its blocks and divides them among threads.
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
        let [least, most] = MOST;
        let most = (pattern.n() + least).min(most) as u32;
        let (accuracy, iterations, total_iterations, indefinite) = (Accuracy::to(RELATIVE), 0, 0, 0);
        let (refined, workers, multigrid_allowed) = (None, workers.clone(), pattern.position.len() >= LARGE);
        Ok(ConjugateGradients {
            pattern,
            system: None,
            multigrid: None,
            with_multigrid: false,
            needs_multigrid: false,
            multigrid_allowed,
            workers,
            accuracy,
            refined,
            most,
            shares: Vec::new(),
            tried: None,
            iterations,
            total_iterations,
            indefinite,
        })
    }

    /// Solves for a fixed pseudo-random right-hand side to the relative residual [`TRIAL`] in at most `most`
    /// iterations. Returns their number.
    ///
    /// # Errors
    /// As [`LinearSolver::solve`].
    pub(super) fn trial_solve(&mut self, most: u32) -> Result<u32, LinearError> {
        match self.tried {
            Some(iterations) if iterations <= most => Ok(iterations),
            Some(_) => Err(LinearError::Stalled { iterations: most, residual: 1.0, asked: TRIAL }),
            None => self.iterate_on_trial(TRIAL, most).map(|_| *self.tried.insert(self.iterations)),
        }
    }

    /// As [`LinearSolver::solve`] in at most `most` iterations.
    ///
    /// # Errors
    /// As [`LinearSolver::solve`].
    pub(super) fn solve_within(&mut self, most: u32, values: &[f64], b: &mut [f64]) -> Result<(), LinearError> {
        let own = self.most;
        self.most = own.min(most);
        let found = self.solve(values, b);
        self.most = own;
        found
    }

    /// Leaves the count of indefinite matrices as it is: with a nearly singular M rounding looks like an indefinite W.
    fn iterate_on_trial(&mut self, relative: f64, most: u32) -> Result<(), LinearError> {
        let (own, indefinite) = (std::mem::replace(&mut self.most, most), self.indefinite);
        self.iterations = 0;
        let first = match self.grid() {
            Some(grid) => grid.set_trial_right_hand_side()?,
            None => self.system().set_trial_right_hand_side(),
        };
        let found = self.iterate(first, Accuracy::to(relative));
        (self.most, self.indefinite) = (own, indefinite);
        found
    }

    /// Whether pivots with fill suit W: then residuals measure the error of a solution.
    fn relaxation_serves(&mut self) -> bool {
        let found = self.iterate_on_trial(0.0, PROBE);
        matches!(found, Ok(_) | Err(LinearError::Stalled { .. })) && self.system().runs_within(LARGEST)
    }

    /// Whether matrices of many nodes may be solved with multigrid; they may if nothing is said.
    pub(super) fn allow_multigrid(&mut self, allowed: bool) {
        self.multigrid_allowed &= allowed;
    }

    /// As [`LinearSolver::cg_cost`].
    pub(super) fn cost(with_multigrid: bool) -> f64 {
        if with_multigrid { MULTIGRID_COST } else { 1.0 }
    }

    pub(super) fn multigrid_is_allowed(&self) -> bool {
        self.multigrid_allowed
    }

    fn system(&mut self) -> &mut PartitionedSystem {
        self.system.get_or_insert_with(|| PartitionedSystem::new(&self.pattern, &self.workers))
    }

    /// Sets up the incomplete factorisation. Returns whether W may be positive definite; `None` if W needs multigrid.
    fn preconditioned_alone(&mut self, values: &[f64]) -> Option<bool> {
        // Of this matrix only: a dropped attempt must leave no trace.
        let needs_multigrid = std::mem::take(&mut self.needs_multigrid);
        if self.multigrid_allowed && (needs_multigrid || self.is_plainly_stiff(values)) {
            return None;
        }
        let served = self.system().set_values(values, RELAXATION) && self.relaxation_serves();
        let made = served || self.system().set_values(values, 0.0);
        (!made || !self.multigrid_allowed || self.trial_solve(EASY).is_ok()).then_some(made)
    }

    /// Whether a trial without multigrid would take far more than [`EASY`] iterations, by the lesser of both estimates.
    /// The share of inertia is the median of row sums over diagonal entries, as springs resist no translation.
    fn is_plainly_stiff(&mut self, values: &[f64]) -> bool {
        let many = 2.0 * f64::from(EASY);
        if TRIAL_OF_NODES * (self.pattern.position.len() as f64).sqrt() < many {
            return false;
        }
        let ConjugateGradients { pattern, shares, .. } = self;
        shares.resize(pattern.n(), 0.0);
        pattern.row_sums(values, shares);
        shares.iter_mut().zip(&pattern.col_ptr).for_each(|(share, first)| *share /= values[*first as usize]);
        let (_, median, _) = shares.select_nth_unstable_by(pattern.n() / 2, f64::total_cmp);
        TRIAL_OF_INERTIA / median.max(0.0).sqrt() > many
    }

    fn grid(&mut self) -> Option<&mut Multigrid> {
        self.multigrid.as_mut().filter(|_| self.with_multigrid)
    }

    /// Iterates from x^ = 0 with the right-hand side in r; `first` is its square, and that of a residual its product
    /// with the preconditioned one.
    fn iterate(&mut self, first: f64, Accuracy { relative, enough, .. }: Accuracy) -> Result<(), LinearError> {
        match self.grid() {
            Some(grid) => grid.begin(),
            None => self.system().begin(),
        }
        let left = |square: f64| (square / first).sqrt();
        let stalled = |iterations, square| LinearError::Stalled { iterations, residual: left(square), asked: relative };
        let (mut square, mut beta, mut largest) = (first, 0.0, 1.0_f64);
        while square > 0.0 && left(square) > if self.iterations < FEW { enough } else { relative } {
            if self.iterations == self.most {
                return Err(stalled(self.iterations, square));
            }
            self.iterations += 1;
            self.total_iterations += 1;
            let curvature = match self.grid() {
                Some(grid) => grid.product(beta),
                None => self.system().product(beta),
            };
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
            square = match self.grid() {
                Some(grid) => grid.advance(alpha as f32)?,
                None => self.system().advance(alpha as f32),
            };
            if !square.is_finite() {
                return Err(LinearError::Singular { unknown: None });
            }
            beta = (square / before) as f32;
        }
        Ok(())
    }

    /// Replaces b `[n]` by an approximation of W^-1 b, as accurate as asked for and as single precision allows. Returns
    /// the size of b.
    fn round(&mut self, b: &mut [f64], asked: Accuracy) -> Result<f64, LinearError> {
        let right = self.set_right_hand_side(b)?;
        let possible = Accuracy { relative: asked.relative.max(SINGLE), enough: asked.enough.max(SINGLE), ..asked };
        self.iterate(right.first, possible)?;
        match self.grid() {
            Some(grid) => grid.finish(right.scale, b),
            None => self.system().finish(right.scale, b),
        }
        Ok(right.size())
    }

    /// Sets r to b over its scale: (I + L)^-1 E^-1 b, or b itself with multigrid.
    fn set_right_hand_side(&mut self, b: &[f64]) -> Result<RightHandSide, LinearError> {
        let [scale, first] = match self.grid() {
            Some(grid) => grid.set_right_hand_side(b)?,
            None => self.system().set_right_hand_side(b),
        };
        if first.is_finite() {
            Ok(RightHandSide { scale, first })
        } else {
            Err(LinearError::Singular { unknown: None })
        }
    }

    /// Iterative refinement: solves for the residual in double precision until it is small enough; `x` `[n]` is b
    /// before.
    fn refine(&mut self, values: &[f64], x: &mut [f64], asked: Accuracy) -> Result<(), LinearError> {
        let n = x.len();
        let [mut b, mut r] = self.refined.take().unwrap_or_else(|| [vec![0.0; n], vec![0.0; n]]);
        self.workers.copy(&mut b, x);
        self.workers.copy(&mut r, x);
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
        accuracy: Accuracy,
        [x, r]: [&mut [f64]; 2],
    ) -> Result<(), LinearError> {
        let Accuracy { relative: asked, checked, .. } = accuracy;
        let size = if checked { self.workers.norm(b) } else { 0.0 };
        let (mut left, mut first) = (1.0, None);
        while left > asked {
            let aim = if first.is_none() { accuracy } else { Accuracy::to(asked / left) };
            let size_of_b = self.round(r, aim).map_err(|error| match error {
                LinearError::Stalled { iterations, residual, .. } => {
                    LinearError::Stalled { iterations, residual: residual * left, asked }
                }
                other => other,
            })?;
            self.workers.add(x, 1.0, r);
            let first = *first.get_or_insert(size_of_b);
            if first == 0.0 {
                return Ok(());
            }
            self.pattern.multiply(values, x, r);
            self.workers.set(r, |range, r| r.iter_mut().zip(&b[range]).for_each(|(r, b)| *r = b - *r));
            // NaN if x has overflowed.
            let mut now = self.set_right_hand_side(r).map_or(f64::NAN, |taken| taken.size()) / first;
            if checked {
                // M belongs to a rounded W, and its norm may not see what rounding has changed.
                now = now.max(self.workers.norm(r) / size);
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
    /// Sets up the preconditioner. Whether W is positive definite shows only in a solve.
    fn factor(&mut self, values: &[f64]) -> Result<Inertia, LinearError> {
        check_finite(&self.pattern, values, &self.workers)?;
        (self.tried, self.with_multigrid) = (None, false);
        let definite = match self.preconditioned_alone(values) {
            Some(definite) => definite,
            None => {
                // Multigrid takes its place in memory.
                self.system = None;
                let grid = match &mut self.multigrid {
                    Some(grid) => grid,
                    none => none.insert(Multigrid::new(&self.pattern, &self.workers)?),
                };
                self.with_multigrid = grid.set_values(values)?;
                self.with_multigrid
            }
        };
        self.indefinite += u64::from(!definite);
        Ok(if definite { Inertia::Unknown } else { Inertia::Indefinite })
    }

    fn solve(&mut self, values: &[f64], b: &mut [f64]) -> Result<(), LinearError> {
        if self.system.is_none() && !self.with_multigrid {
            return Err(LinearError::Singular { unknown: None });
        }
        self.iterations = 0;
        let asked = self.accuracy;
        if asked.relative < SINGLE || asked.checked {
            self.refine(values, b, asked)?;
        } else {
            self.round(b, asked)?;
        }
        check_solution(b, &self.workers)
    }

    fn set_accuracy(&mut self, accuracy: Accuracy) {
        self.accuracy = accuracy;
    }

    fn set_expected_use(&mut self, expected: ExpectedUse) {
        self.needs_multigrid = expected.multigrid;
    }

    fn with_multigrid(&self) -> bool {
        self.with_multigrid
    }

    fn cg_cost(&self) -> f64 {
        Self::cost(self.with_multigrid)
    }

    fn work(&self) -> SolverWork {
        SolverWork { iterations: self.total_iterations, ..SolverWork::default() }
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
