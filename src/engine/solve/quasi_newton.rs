//! Newton's iteration on a frozen factor: the tangent of an earlier iterate, made symmetric and positive definite, with
//! L-BFGS corrections from the last steps (Nocedal & Wright 2006, algorithm 7.4, with the factor in the place of H_0).
//!
//! ```text
//! s_i = z_{i+1} - z_i,   y_i = F(z_{i+1}) - F(z_i),   rho_i = 1/(y_i . s_i)
//! H_{i+1} = (I - rho s y^T) H_i (I - rho y s^T) + rho s s^T,      dz = -H F
//! ```
//! An iteration costs a force pass and a solve, no factorisation. When to factorise again is a rent-or-buy problem.
//! Within a step: as soon as the predicted remaining iterations cost more than a new factor and its own iterations.
//! Between steps: as soon as the extra iterations on an old factor, compared with a new one, add up to a factorisation.
//! All costs are counted, none are timed.

mod secant_pairs;

use super::newton::{
    Convergence, ConvergenceCriteria, Newton, NewtonReport, NonlinearProblem, RoundingCheck, RoundingVerdict, Step,
};
use super::{ExpectedUse, LinearError, forcing, search};
pub(super) use secant_pairs::SecantPairs;

/// Iterations after which the rate of convergence is judged.
const WINDOW: usize = 4;
/// Iterations a new factor is expected to need before any was seen.
const EXPECTED: u32 = 6;
/// Maximum number of factors in a step, after which the exact tangent takes over; as many as iterations in contact.
const MOST_FACTORS: u32 = 8;
/// The same where the mixed iteration can take over.
const FEW_FACTORS: u32 = 2;
/// [-] Cost of an average solve with multigrid, in iterations without it, up to which the next matrix is tried without:
/// that of two iterations, as matrices take that hardly need it.
const EASY_SOLVE: f64 = 8.0;
/// Maximum number of steps before what has failed is tried again.
const LONGEST_REST: u32 = 64;
/// Statistics of the use of a frozen factor.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FactorHistory {
    /// whether there is a factor
    pub made: bool,
    /// iterations of the step it was made in; 0 while it is new
    pub fresh: u32,
    /// extra iterations of later steps
    pub excess: u32,
    /// total iterations with it
    pub served: u32,
    /// expected use of a factor, learnt from earlier ones
    pub expected: ExpectedUse,
    /// solves by conjugate gradients with it
    pub cg_solves: u32,
    /// their iterations, each counted as [`super::LinearSolver::cg_cost`]
    pub cg_iterations: u32,
    /// whether the last of them used multigrid
    pub multigrid: bool,
    /// from a frozen factor, after it has failed
    pub rest: Rest,
    /// from the tangents of one-sided springs as they are, after these have failed
    pub interior: Rest,
}

impl FactorHistory {
    /// Without a factor, but with what was learnt from earlier ones.
    pub fn without_factor(self) -> Self {
        FactorHistory {
            made: false,
            fresh: 0,
            excess: 0,
            served: 0,
            cg_solves: 0,
            cg_iterations: 0,
            multigrid: false,
            ..self
        }
    }

    /// The same after a change of the step size, which changes the number of iterations.
    pub fn after_step_change(self) -> Self {
        let expected = ExpectedUse { cg_iterations: 0.0, multigrid: false, ..self.expected };
        FactorHistory { expected, ..self.without_factor() }
    }

    /// Expected use of the next factor after what this one has shown. `cost` [-] is the cost of a factor in iterations.
    fn expected_use(&self, cost: f64) -> ExpectedUse {
        let useful = f64::from(self.served.saturating_sub(self.excess).max(1));
        let reuse = 0.5 * (self.expected.reuse + useful / cost.max(1.0).sqrt());
        let (cg_iterations, multigrid) = match self.cg_solves {
            0 => (self.expected.cg_iterations, self.expected.multigrid),
            solves => {
                let each = f64::from(self.cg_iterations) / f64::from(solves);
                (each, self.multigrid && each > EASY_SOLVE)
            }
        };
        ExpectedUse { reuse, cg_iterations, multigrid, left: f64::INFINITY }
    }

    /// Iterations that a step with a new factor takes.
    fn needed(&self) -> u32 {
        if self.fresh > 0 { self.fresh } else { EXPECTED }
    }

    /// The frozen factor failed in a step.
    pub(super) fn record_failure(&mut self) {
        self.rest.begin();
        *self = self.without_factor();
    }
}

/// Steps without something that has failed: twice as many after every failure, and half as many after a success.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Rest {
    /// steps left
    left: u32,
    /// the number of them after the next failure
    next: u32,
}

impl Rest {
    pub(super) fn begin(&mut self) {
        self.left = self.next.clamp(1, LONGEST_REST);
        self.next = 2 * self.left;
    }

    /// It has served.
    pub(super) fn shorten(&mut self) {
        self.next /= 2;
    }

    /// Whether this step rests.
    pub(super) fn takes_step(&mut self) -> bool {
        let rests = self.left > 0;
        self.left = self.left.saturating_sub(1);
        rests
    }
}

/// Iterates from `z` `[n]`, whose residual is in `newton.r`. Returns `None` if it does not converge; `z` is then
/// undefined.
pub(super) fn solve(
    newton: &mut Newton,
    problem: &mut dyn NonlinearProblem,
    z: &mut [f64],
    criteria: ConvergenceCriteria,
    frozen: &mut FactorHistory,
) -> Result<Option<NewtonReport>, LinearError> {
    let mut pairs = std::mem::take(&mut newton.pairs);
    pairs.clear();
    let found = Iteration { newton, problem, pairs: &mut pairs, criteria, frozen }.run(z);
    newton.pairs = pairs;
    found
}

struct Iteration<'a> {
    newton: &'a mut Newton,
    problem: &'a mut dyn NonlinearProblem,
    pairs: &'a mut SecantPairs,
    criteria: ConvergenceCriteria,
    frozen: &'a mut FactorHistory,
}

/// Residuals of the iterations on one factor, from which the rate of convergence follows.
struct ConvergenceRate {
    /// iterations on this factor
    iterations: u32,
    /// [N] residuals, newest first
    residuals: [f64; WINDOW + 1],
}

impl ConvergenceRate {
    fn new(residual: f64) -> Self {
        let mut residuals = [f64::NAN; WINDOW + 1];
        residuals[0] = residual;
        ConvergenceRate { iterations: 0, residuals }
    }

    fn record_residual(&mut self, residual: f64) {
        self.iterations += 1;
        self.residuals.rotate_right(1);
        self.residuals[0] = residual;
    }

    /// Predicted iterations to the tolerance [N] at the present rate; `None` as long as it is unknown.
    fn left(&self, tolerance: f64) -> Option<f64> {
        let [now, .., then] = self.residuals;
        if then.is_nan() {
            return None;
        }
        let rate = (then / now).ln() / WINDOW as f64;
        Some(if rate > 0.0 { (now / tolerance).max(1.0).ln() / rate } else { f64::INFINITY })
    }
}

impl Iteration<'_> {
    fn run(&mut self, z: &mut [f64]) -> Result<Option<NewtonReport>, LinearError> {
        let serves = self.frozen.made
            && f64::from(self.frozen.excess) < self.problem.factor_cost()
            && !self.another_would_serve();
        if !serves && !self.freeze()? {
            return Ok(None);
        }
        self.problem.take_frozen();
        // In contact the exact tangent often needs an LU, and the mixed iteration seldom serves.
        let most_factors = if self.problem.presses() {
            self.newton.most_iterations()
        } else if self.problem.mixed().is_some() {
            FEW_FACTORS
        } else {
            MOST_FACTORS
        };
        let mut fresh = self.frozen.fresh == 0;
        let (mut residual, mut factors) = (self.newton.workers.norm(&self.newton.r), 0);
        let mut rate_seen = ConvergenceRate::new(residual);
        let mut settling = None;
        for iterations in 1..=self.newton.most_iterations() {
            self.newton.spent = iterations;
            let step = match &mut settling {
                Some(settling) => self.correct_at_rounding(z, settling)?,
                None => self.step(z)?,
            };
            let lambda = match step {
                Step::Taken(lambda) => lambda,
                Step::NotNeeded => {
                    self.record_step(rate_seen.iterations + 1, fresh);
                    return Ok(Some(NewtonReport { iterations, residual: self.criteria.over_scale(residual) }));
                }
                Step::Hidden => return Ok(None),
                Step::Stuck => {
                    // No descent direction: the factor of another state may be the cause.
                    factors += 1;
                    if rate_seen.iterations == 0 && fresh || factors > most_factors || !self.refreeze(z)? {
                        return Ok(None);
                    }
                    (fresh, rate_seen) = (true, ConvergenceRate::new(residual));
                    continue;
                }
            };
            let before = residual;
            residual = self.newton.workers.norm(&self.newton.r);
            rate_seen.record_residual(residual);
            match self.newton.convergence(z, self.criteria, lambda * residual / before) {
                Convergence::Converged => {
                    self.record_step(rate_seen.iterations, fresh);
                    return Ok(Some(NewtonReport { iterations, residual: self.criteria.over_scale(residual) }));
                }
                // An old factor, or secant pairs of rounded differences, would prove nothing.
                Convergence::Rounding if settling.is_none() => {
                    if !self.refreeze(z)? {
                        return Ok(None);
                    }
                    (fresh, rate_seen, settling) =
                        (true, ConvergenceRate::new(residual), Some(RoundingCheck::default()));
                    continue;
                }
                Convergence::Rounding => continue,
                Convergence::NotConverged => settling = None,
            }
            let needed = self.frozen.needed();
            if rate_seen
                .left(self.criteria.tolerance)
                .is_some_and(|left| left > self.problem.factor_cost() + f64::from(needed))
            {
                factors += 1;
                if factors > most_factors || !self.refreeze(z)? {
                    return Ok(None);
                }
                (fresh, rate_seen) = (true, ConvergenceRate::new(residual));
            }
        }
        Ok(None)
    }

    /// Whether the other solver would have been chosen with the present knowledge of the number of uses and of
    /// iterations per solve.
    fn another_would_serve(&self) -> bool {
        let (seen, expected) = (self.frozen.expected_use(self.problem.factor_cost()), self.frozen.expected);
        // Before the expected number of uses is reached, its total use is unknown.
        let reuse = seen.reuse.max(expected.reuse);
        self.problem.prefers_other_solver(ExpectedUse { reuse, left: self.left(), ..seen })
    }

    /// [-] Useful iterations from here to the end of the run.
    fn left(&self) -> f64 {
        self.problem.steps_left() * f64::from(self.frozen.needed())
    }

    /// Records the iterations of a step.
    fn record_step(&mut self, iterations: u32, fresh: bool) {
        self.frozen.served += iterations;
        self.frozen.rest.shorten();
        if fresh {
            self.frozen.fresh = iterations.max(1);
            self.frozen.excess = 0;
        } else {
            self.frozen.excess += iterations.saturating_sub(self.frozen.fresh);
        }
    }

    /// Factorises the tangent at the last evaluated residual.
    fn freeze(&mut self) -> Result<bool, LinearError> {
        self.pairs.clear();
        if self.frozen.made {
            self.frozen.expected = self.frozen.expected_use(self.problem.factor_cost());
        }
        let made = self.problem.freeze(ExpectedUse { left: self.left(), ..self.frozen.expected })?;
        *self.frozen = FactorHistory { made, ..self.frozen.without_factor() };
        Ok(made)
    }

    fn refreeze(&mut self, z: &[f64]) -> Result<bool, LinearError> {
        // The line search may have ended at another point.
        let Newton { r, floor, .. } = &mut *self.newton;
        self.problem.residual(z, r, floor);
        let made = self.freeze()?;
        self.problem.take_frozen();
        Ok(made)
    }

    /// The next correction if the residual is rounding, and a line search along it if it is not small.
    fn correct_at_rounding(&mut self, z: &mut [f64], settling: &mut RoundingCheck) -> Result<Step, LinearError> {
        let Newton { r, dz, workers, .. } = &mut *self.newton;
        self.problem.set_accuracy(forcing::settling(workers.norm(r), self.criteria.tolerance));
        workers.copy(dz, r);
        self.problem.solve(dz)?;
        workers.negate(dz);
        self.newton.keep_apart(self.problem, z);
        Ok(match self.newton.settled(z, self.criteria, settling) {
            RoundingVerdict::Yes => Step::NotNeeded,
            RoundingVerdict::Never => Step::Hidden,
            RoundingVerdict::NotYet => self.search(z).map_or(Step::Stuck, Step::Taken),
        })
    }

    /// One direction and the line search along it.
    fn step(&mut self, z: &mut [f64]) -> Result<Step, LinearError> {
        let Newton { r, dz, workers, .. } = &mut *self.newton;
        self.problem.set_accuracy(forcing::reused(workers.norm(r), self.criteria.tolerance));
        workers.copy(&mut self.pairs.before, r);
        workers.copy(dz, r);
        let before = self.problem.cg_iterations();
        self.pairs.apply(dz, |b| self.problem.solve(b))?;
        let iterations = self.problem.cg_iterations() - before;
        if iterations > 0 {
            self.frozen.cg_solves = self.frozen.cg_solves.saturating_add(1);
            let cost = (iterations as f64 * self.problem.cg_cost()).round() as u32;
            self.frozen.cg_iterations = self.frozen.cg_iterations.saturating_add(cost);
            self.frozen.multigrid = self.problem.with_multigrid();
        }
        workers.negate(dz);
        self.newton.keep_apart(self.problem, z);
        let Some(lambda) = self.search(z) else { return Ok(Step::Stuck) };
        self.pairs.push(lambda, &self.newton.dz, &self.newton.r);
        Ok(Step::Taken(lambda))
    }

    /// The share of the direction that descends, if any. Without a potential the slope is that of the symmetric part,
    /// which still serves; the norm of the residual need not fall.
    fn search(&mut self, z: &mut [f64]) -> Option<f64> {
        if self.newton.workers.dot(&self.newton.r, &self.newton.dz) >= 0.0 {
            return None;
        }
        search::downhill(self.newton, self.problem, z, self.criteria.tolerance)
    }
}
