//! Newton's iteration for F(z) = 0. It does not depend on time or schemes. Vectors are `[n]`, by unknown.
//!
//! There are three ways, the next where one fails: on a frozen factor (`quasi_newton`), with the tensions of springs as
//! unknowns (`mixed`), and on the exact tangent (`newton/exact`).

mod convergence;
mod exact;

use super::LinearError;
pub use super::failure::NewtonFailure;
use super::mixed::{self, Sides, Tensions};
pub use super::problem::{Curvature, MixedSprings, NonlinearProblem, Scales};
use super::quasi_newton::{self, FactorHistory, SecantPairs};
use crate::model::workers::Workers;
pub(super) use convergence::{Convergence, ConvergenceCriteria, RoundingCheck, RoundingVerdict};

/// When the tangent is computed again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// As `quasi` where, by counted work, a factorisation costs about as much as an iteration with an old factor, or
    /// more: everywhere but on very small scenes. Otherwise, and where `quasi` fails, as `full`.
    #[default]
    Auto,
    /// In every iteration.
    Full,
    /// Seldom: the factor of a symmetric tangent is used as long as the iteration converges fast enough with it.
    Modified,
    /// The same, corrected by the iteration's last steps (L-BFGS).
    Quasi,
}

impl Strategy {
    /// Whether a factor is reused. `factor_cost` [-] is the cost of a factorisation in iterations on an existing
    /// factor; 0 if the scene has no factor to reuse. `unknowns` is the size of the matrix.
    pub fn reuses_factors(self, factor_cost: f64, unknowns: usize) -> bool {
        match self {
            Strategy::Full => false,
            Strategy::Auto => factor_cost >= if unknowns < FEW { WORTH_KEEPING_SMALL } else { WORTH_KEEPING },
            Strategy::Modified | Strategy::Quasi => factor_cost > 0.0,
        }
    }
}

/// Settings of the iteration.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct NewtonSpec {
    /// [-] tolerance on residual and increment, relative to their scales
    pub relative: f64,
    /// maximum number of iterations on the exact tangent, and before that on a reused factor
    pub max_iterations: u32,
    /// how often the tangent is factorised
    pub strategy: Strategy,
}

impl Default for NewtonSpec {
    fn default() -> Self {
        NewtonSpec { relative: 1e-8, max_iterations: 100, strategy: Strategy::Auto }
    }
}

/// A converged iteration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NewtonReport {
    /// iterations made
    pub iterations: u32,
    /// [-] final residual over its scale
    pub residual: f64,
}

/// [-] Cost of a symmetric factorisation, in iterations without one, from which on factors are reused: that of chains.
/// With reuse, nets of 700 to 10,000 nodes take 0.6 to 0.75 of the time.
const WORTH_KEEPING: f64 = 0.7;
/// [-] The same for few unknowns: that of nets of 24 nodes, which take 0.15 to 0.77 of the time. Short chains and
/// smaller nets would gain little. Without reuse they keep the digits of the exact tangent, which resolves motions that
/// are small beside the rounding of forces.
const WORTH_KEEPING_SMALL: f64 = 1.0;
const FEW: usize = 1000;

/// [-] Rounding of the residual over the step's forces from which on it may hide the motion if no iteration makes
/// progress. Rounding acts along stiff springs, so iterations may resolve the motion across them far above this limit.
pub(super) const HIDING: f64 = 1e-3;
/// [-] Residual of pure rounding, over the step's forces and the residual of the first guess, from which on motion
/// across stiff springs is lost too. On a chain the motion was right up to 1e3 and wrong from 6e6 on.
const HIDDEN: f64 = 1e5;

/// Outcome of a search along a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    /// This share of the direction was taken.
    Taken(f64),
    /// No step along it reduces the merit function.
    Stuck,
    /// The iterate had converged.
    NotNeeded,
    /// Rounding hides the solution.
    Hidden,
}

/// The iteration and its buffers.
#[derive(Clone, Debug)]
pub struct Newton {
    spec: NewtonSpec,
    pub(super) workers: Workers,
    pub(super) r: Vec<f64>,
    pub(super) floor: Vec<f64>,
    pub(super) dz: Vec<f64>,
    /// trial point along `dz`, its residual, and the correction predicted there `[n]`
    pub(super) trial: Vec<f64>,
    pub(super) r_trial: Vec<f64>,
    pub(super) correction: Vec<f64>,
    pub(super) pairs: SecantPairs,
    pub(super) tensions: Tensions,
    /// the first guess, restored if an iteration fails `[n]`
    guess: Vec<f64>,
    /// iterations on a reused factor
    pub(super) spent: u32,
    /// whether the direction is one along which nothing touches
    pub(super) kept_apart: bool,
}

impl Newton {
    /// Buffers for `n` unknowns; loops over them run on `workers`.
    pub fn new(spec: NewtonSpec, n: usize, workers: &Workers) -> Self {
        let zero = || vec![0.0; n];
        let pairs = match spec.strategy {
            Strategy::Full => SecantPairs::default(),
            Strategy::Modified => SecantPairs::new(n, 0, workers),
            Strategy::Auto | Strategy::Quasi => SecantPairs::for_unknowns(n, workers),
        };
        let (r, r_trial, floor, dz, trial, correction, guess) =
            (zero(), zero(), zero(), zero(), zero(), zero(), zero());
        let (workers, tensions) = (workers.clone(), Tensions::default());
        let (spent, kept_apart) = (0, false);
        Newton { spec, workers, r, r_trial, floor, dz, trial, correction, pairs, tensions, guess, spent, kept_apart }
    }

    /// Whether the balance of forces is far from the start `z` `[n]` across springs: there is no linear step to it, or
    /// one that moves an unknown by more than `far` [m] and does not push a spring by more than its length.
    pub(crate) fn leaps(&mut self, problem: &mut dyn NonlinearProblem, z: &[f64], far: f64) -> bool {
        problem.residual(z, &mut self.r, &mut self.floor);
        if !self.direction(problem, Curvature::Exact).is_ok_and(|downhill| downhill) {
            return true;
        }
        let leaps = self.dz.iter().any(|dz| dz.abs() > far);
        leaps && problem.mixed().is_some_and(|springs| !self.tensions.is_pushed_over(springs, &self.dz))
    }

    /// Iterations of the last solve that were made before the exact tangent took over.
    pub(crate) fn iterations(&self) -> u32 {
        self.spent
    }

    pub(super) fn most_iterations(&self) -> u32 {
        self.spec.max_iterations
    }

    /// Iterates from `z` `[n]` until residual and increment are both small. On success the problem's last evaluated
    /// residual is the one at the returned `z`.
    ///
    /// The increment test predicts the next increment from the last one times the reduction of the residual. So a
    /// linear problem takes one iteration, and a residual that stalls does not pass.
    ///
    /// # Errors
    /// When the tolerances are not reached; `z` is then worthless.
    pub fn solve(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        z: &mut [f64],
        scales: Scales,
        frozen: &mut FactorHistory,
    ) -> Result<NewtonReport, NewtonFailure> {
        let tolerance = self.spec.relative * scales.residual;
        let criteria = ConvergenceCriteria { tolerance, scales };
        problem.residual(z, &mut self.r, &mut self.floor);
        while problem.replace_far_guess(z) {
            problem.residual(z, &mut self.r, &mut self.floor);
        }
        let residual = self.workers.norm(&self.r);
        let (rounding, forces) = (self.workers.norm(&self.floor), scales.residual);
        if !residual.is_finite() || !rounding.is_finite() {
            return Err(NewtonFailure::NotFinite { worst: self.worst() });
        }
        // The rounding of stiff springs may hide all motion of soft ones, so a guess is not accepted on rounding alone.
        let rounding_only = self.excess() == 0.0;
        if rounding_only && residual <= tolerance {
            return Ok(NewtonReport { iterations: 0, residual: criteria.over_scale(residual) });
        }
        self.spent = 0;
        self.workers.copy(&mut self.guess, z);
        let hides = |what: f64, share: f64, forces: f64, problem: &mut dyn NonlinearProblem| {
            what > share * forces && what > share * problem.stopping_force()
        };
        let iterations = match self.iterate(problem, z, criteria, frozen) {
            Ok(report) if hides(self.workers.norm(&self.r), HIDDEN, forces.max(residual), problem) => report.iterations,
            Err(failure @ NewtonFailure::Linear { error: LinearError::Interrupted(_), .. }) => return Err(failure),
            // A failed linear solve says nothing about rounding.
            Err(failure @ NewtonFailure::Linear { .. }) if !rounding_only || !self.is_trusted(residual, criteria) => {
                return Err(failure);
            }
            Err(failure) if rounding_only => {
                let iterations = failure.iterations();
                if self.is_trusted(residual, criteria) || !hides(rounding, HIDING, forces, problem) {
                    // Accept the first guess.
                    self.return_to_guess(problem, z);
                    return Ok(NewtonReport { iterations, residual: criteria.over_scale(self.workers.norm(&self.r)) });
                }
                iterations
            }
            found => return found,
        };
        Err(NewtonFailure::Hidden { iterations, rounding, forces, worst: self.worst() })
    }

    /// Iterates from `z` `[n]`, whose residual was the last one that was evaluated, to one below `tolerance` [N], from
    /// tensions of the size of the loads. `None` where that fails or there are no springs; `z` is then worthless.
    ///
    /// # Errors
    /// A linear system that cannot be solved.
    pub(crate) fn load(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        z: &mut [f64],
        (tolerance, scales): (f64, Scales),
        most: u32,
    ) -> Result<Option<NewtonReport>, LinearError> {
        self.spent = 0;
        let asked = std::mem::replace(&mut self.spec.max_iterations, most);
        let found = mixed::solve(self, problem, z, (ConvergenceCriteria { tolerance, scales }, Sides::Loaded));
        self.spec.max_iterations = asked;
        found
    }

    /// Iterates from `z` `[n]` on the frozen factor. If that fails, from the same guess by the mixed iteration, then on
    /// the exact tangent; without a frozen factor and in contact, on the exact tangent first.
    fn iterate(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        z: &mut [f64],
        criteria: ConvergenceCriteria,
        frozen: &mut FactorHistory,
    ) -> Result<NewtonReport, NewtonFailure> {
        if !problem.reuses_factors() {
            return self.exact_then_mixed(problem, z, criteria, frozen);
        }
        if !frozen.rest.takes_step() {
            match quasi_newton::solve(self, problem, z, criteria, frozen) {
                Ok(Some(report)) => return Ok(report),
                // A failed solve with the frozen tangent says nothing about the exact one.
                Ok(None)
                | Err(LinearError::Stalled { .. } | LinearError::Singular { .. } | LinearError::Indefinite { .. }) => {}
                Err(error) => {
                    return Err(NewtonFailure::Linear { iterations: self.spent, error, worst: self.worst() });
                }
            }
            match self.spec.strategy {
                Strategy::Auto => frozen.record_failure(),
                _ => *frozen = frozen.without_factor(),
            }
            self.return_to_guess(problem, z);
        }
        if problem.presses() {
            return self.exact_then_mixed(problem, z, criteria, frozen);
        }
        if let Some(report) = self.mixed(problem, z, criteria, frozen)? {
            return Ok(report);
        }
        problem.leave_to_gradients(Some(frozen.expected));
        self.exact(problem, z, criteria)
    }

    /// Iterates from `z` `[n]` on the exact tangent; if that fails, from the same guess by the mixed iteration.
    fn exact_then_mixed(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        z: &mut [f64],
        criteria: ConvergenceCriteria,
        frozen: &mut FactorHistory,
    ) -> Result<NewtonReport, NewtonFailure> {
        problem.leave_to_gradients(Some(frozen.expected));
        let failure = match self.exact(problem, z, criteria) {
            // Without springs the iterate stays where it is: it may be of use.
            Err(failure @ (NewtonFailure::MaxIterations { .. } | NewtonFailure::Stuck { .. }))
                if problem.mixed().is_some() =>
            {
                failure
            }
            ended => return ended,
        };
        self.spent = failure.iterations();
        self.return_to_guess(problem, z);
        self.mixed(problem, z, criteria, frozen)?.ok_or(failure)
    }

    /// The mixed iteration from the first guess, if there are springs: with the tangents of one-sided springs and, if
    /// that fails, by interior points. `None` if both fail; `z` is then the first guess.
    fn mixed(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        z: &mut [f64],
        criteria: ConvergenceCriteria,
        frozen: &mut FactorHistory,
    ) -> Result<Option<NewtonReport>, NewtonFailure> {
        if problem.mixed().is_none() {
            return Ok(None);
        }
        let rests = frozen.interior.takes_step();
        for sides in [Sides::AsTheyAre, Sides::Interior].into_iter().skip(usize::from(rests)) {
            // Matrices of interior points have springs of all stiffnesses.
            problem.leave_to_gradients((sides == Sides::AsTheyAre).then_some(frozen.expected));
            match mixed::solve(self, problem, z, (criteria, sides)) {
                Ok(Some(report)) => {
                    match sides {
                        Sides::AsTheyAre => frozen.interior.shorten(),
                        Sides::Interior if !rests => frozen.interior.begin(),
                        _ => {}
                    }
                    return Ok(Some(report));
                }
                // What stops it says nothing about the exact tangent.
                Err(error @ LinearError::Interrupted(_)) => {
                    return Err(NewtonFailure::Linear { iterations: self.spent, error, worst: self.worst() });
                }
                Ok(None) | Err(_) => {}
            }
            self.return_to_guess(problem, z);
        }
        Ok(None)
    }

    fn return_to_guess(&mut self, problem: &mut dyn NonlinearProblem, z: &mut [f64]) {
        self.workers.copy(z, &self.guess);
        problem.residual(z, &mut self.r, &mut self.floor);
    }

    /// [N] norm of the residual beyond rounding.
    fn excess(&self) -> f64 {
        self.workers.excess(&self.r, &self.floor)
    }

    fn worst(&self) -> usize {
        let size = |r: f64| if r.is_finite() { r.abs() } else { f64::INFINITY };
        (0..self.r.len()).max_by(|&a, &b| size(self.r[a]).total_cmp(&size(self.r[b]))).unwrap_or(0)
    }
}
