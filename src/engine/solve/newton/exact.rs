//! Newton's iteration on the exact tangent, globalised by line searches.
//!
//! If F is the gradient of a potential (a symmetric tangent), the iteration descends in the potential. An indefinite
//! tangent is replaced by its convex part, and the line search along the direction d follows the slope F.d. Otherwise
//! the residual must fall, or the same tangent must predict a clearly smaller correction. If both make little progress,
//! the convex direction and its slope are used until full steps are possible again.

use super::{
    Convergence, ConvergenceCriteria, Curvature, Newton, NewtonFailure, NewtonReport, NonlinearProblem, RoundingCheck,
    RoundingVerdict, Step,
};
use crate::solve::forcing::{self, Forcing};
use crate::solve::{Accuracy, Inertia, LinearError, search};

/// A step that is shortened below this share of Newton's makes little progress: the residual's norm is a poor merit
/// function there.
const CRAWL: f64 = 0.125;

/// For how many steps a problem without a potential uses the convex tangent after the exact one made too little
/// progress.
#[derive(Clone, Copy, Debug, Default)]
struct ConvexPhase {
    /// full steps left with the convex tangent
    left: u32,
    /// number of them the next time: twice as many as the last
    next: u32,
}

impl ConvexPhase {
    fn raise(&mut self) {
        self.next = (2 * self.next).clamp(1, 64);
        self.left = self.next;
    }
}

impl Newton {
    /// Iterates from `z` `[n]` on the exact tangent.
    pub(super) fn exact(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        z: &mut [f64],
        criteria: ConvergenceCriteria,
    ) -> Result<NewtonReport, NewtonFailure> {
        let ConvergenceCriteria { tolerance, .. } = criteria;
        let (mut caution, mut forcing) = (ConvexPhase::default(), Forcing::default());
        let mut residual = self.workers.norm(&self.r);
        let (mut convergence, mut settling) = (Convergence::NotConverged, RoundingCheck::default());
        for made in 1..=self.spec.max_iterations {
            let (before, iterations) = (residual, self.spent + made);
            let hidden = (convergence == Convergence::Rounding).then_some(&mut settling);
            let step = match hidden {
                Some(settling) => {
                    problem.set_accuracy(forcing::settling(residual, tolerance));
                    self.correct_at_rounding(problem, z, criteria, settling)
                }
                None => {
                    problem.set_accuracy(Accuracy::to(forcing.next(residual, tolerance)));
                    self.step(problem, z, &mut caution, tolerance)
                }
            };
            let worst = self.worst();
            let lambda = match step.map_err(|error| NewtonFailure::Linear { iterations, error, worst })? {
                Step::Taken(lambda) => lambda,
                Step::NotNeeded => return Ok(NewtonReport { iterations, residual: criteria.over_scale(residual) }),
                Step::Stuck => return Err(NewtonFailure::Stuck { iterations, residual: before, tolerance, worst }),
                Step::Hidden => {
                    let (rounding, forces) = (self.workers.norm(&self.floor), criteria.scales.residual);
                    return Err(NewtonFailure::Hidden { iterations, rounding, forces, worst });
                }
            };
            residual = self.workers.norm(&self.r);
            convergence = self.convergence(z, criteria, lambda * (residual / before));
            if convergence == Convergence::Converged {
                return Ok(NewtonReport { iterations, residual: criteria.over_scale(residual) });
            }
        }
        let (iterations, worst) = (self.spent + self.spec.max_iterations, self.worst());
        Err(NewtonFailure::MaxIterations { iterations, residual, tolerance, worst })
    }

    /// One direction and the line search along it; updates `z` and `self.r`.
    fn step(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        z: &mut [f64],
        caution: &mut ConvexPhase,
        tolerance: f64,
    ) -> Result<Step, LinearError> {
        let taken = |lambda: Option<f64>| lambda.map_or(Step::Stuck, Step::Taken);
        if problem.conservative() {
            self.downhill_direction(problem)?;
            self.keep_apart(problem, z);
            return Ok(taken(search::downhill(self, problem, z, tolerance)));
        }
        if caution.left == 0 {
            self.direction(problem, Curvature::Exact)?;
            self.keep_apart(problem, z);
            let lambda = search::smaller_residual(self, problem, z, tolerance);
            if lambda.is_none_or(|lambda| lambda < CRAWL) {
                caution.raise();
            }
            if lambda.is_some() {
                return Ok(taken(lambda));
            }
            problem.residual(z, &mut self.r, &mut self.floor);
        }
        self.direction(problem, Curvature::Convex)?;
        self.keep_apart(problem, z);
        let lambda = search::downhill(self, problem, z, tolerance);
        if lambda.is_some_and(|lambda| lambda >= 1.0) {
            caution.left = caution.left.saturating_sub(1);
        }
        Ok(taken(lambda))
    }

    /// The next correction if the residual is rounding, and a line search along it if it is not small.
    fn correct_at_rounding(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        z: &mut [f64],
        criteria: ConvergenceCriteria,
        settling: &mut RoundingCheck,
    ) -> Result<Step, LinearError> {
        if problem.conservative() {
            self.downhill_direction(problem)?;
        } else {
            self.direction(problem, Curvature::Exact)?;
        }
        self.keep_apart(problem, z);
        Ok(match self.settled(z, criteria, settling) {
            RoundingVerdict::Yes => Step::NotNeeded,
            RoundingVerdict::Never => Step::Hidden,
            RoundingVerdict::NotYet if problem.conservative() => {
                search::downhill(self, problem, z, criteria.tolerance).map_or(Step::Stuck, Step::Taken)
            }
            RoundingVerdict::NotYet => {
                search::smaller_residual(self, problem, z, criteria.tolerance).map_or(Step::Stuck, Step::Taken)
            }
        })
    }

    /// A descent direction of the potential, from the convex tangent if the exact one gives none.
    fn downhill_direction(&mut self, problem: &mut dyn NonlinearProblem) -> Result<(), LinearError> {
        if !self.direction(problem, Curvature::Exact)? {
            self.direction(problem, Curvature::Convex)?;
        }
        Ok(())
    }

    /// dz = -W^-1 r. Returns whether it is a descent direction.
    pub(super) fn direction(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        curvature: Curvature,
    ) -> Result<bool, LinearError> {
        if problem.linearise(curvature)? == Inertia::Indefinite && problem.conservative() {
            return Ok(false);
        }
        self.workers.copy_negative(&mut self.dz, &self.r);
        match problem.solve(&mut self.dz) {
            Err(LinearError::Indefinite { .. }) if problem.conservative() => return Ok(false),
            solved => solved?,
        }
        Ok(self.workers.dot(&self.r, &self.dz) < 0.0)
    }
}
