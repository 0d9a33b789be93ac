//! Line searches along Newton's direction.

use super::newton::{Newton, NonlinearProblem};

/// Trials after which a search gives up.
const MAX_TRIALS: u32 = 13;
/// Share of the decrease predicted by the tangent that a step must achieve (Armijo 1966).
const ARMIJO: f64 = 1e-4;
/// Natural monotonicity: the next correction must be smaller than the step by this share of it.
const NATURAL: f64 = 0.25;
/// Share of the initial slope that a step may leave.
const SLOPE: f64 = 0.5;
/// The same for the full step, which leaves almost none near the solution.
const FULL_SLOPE: f64 = 0.9;
/// Factor by which a search extends a step that still descends.
const STRIDE: f64 = 4.0;
/// Distance of a trial from the ends of its bracket, as a share of the bracket.
const MARGIN: f64 = 0.1;

/// Halves the step until the residual falls or the same tangent predicts a clearly smaller correction. Updates `z` and
/// the residual. Returns the accepted share of the step.
pub(super) fn smaller_residual(
    newton: &mut Newton,
    problem: &mut dyn NonlinearProblem,
    z: &mut [f64],
    tolerance: f64,
) -> Option<f64> {
    let before = newton.workers.norm(&newton.r);
    let mut lambda = 1.0;
    for _ in 0..MAX_TRIALS {
        let landed = newton.evaluate_at(problem, z, lambda, tolerance);
        let residual = newton.workers.norm(&newton.r_trial);
        if residual <= (1.0 - ARMIJO * lambda) * before
            || landed
            || newton.correction_shrinks(problem, lambda, residual)
        {
            newton.accept_trial(z);
            return Some(lambda);
        }
        lambda *= 0.5;
    }
    None
}

/// Minimises a potential along the direction, using only its slope F.d, by regula falsi in a bracket. Sums of energies
/// would lose the digits that slopes keep (Crisfield 1991, section 9.2). If the slope has not changed sign at the full
/// step, as when a convex tangent leads away from a saddle, the search extends the step.
pub(super) fn downhill(
    newton: &mut Newton,
    problem: &mut dyn NonlinearProblem,
    z: &mut [f64],
    tolerance: f64,
) -> Option<f64> {
    let slope = newton.workers.dot(&newton.r, &newton.dz);
    let mut low = (0.0, slope);
    let mut high: Option<(f64, f64)> = None;
    let mut lambda = 1.0;
    for trial in 0..MAX_TRIALS {
        let landed = newton.evaluate_at(problem, z, lambda, tolerance);
        // The slope may be finite although forces overflow, if the direction does not act on them.
        let here = if newton.workers.norm(&newton.r_trial).is_finite() {
            newton.workers.dot(&newton.r_trial, &newton.dz)
        } else {
            f64::INFINITY
        };
        let left = if trial == 0 { FULL_SLOPE } else { SLOPE } * slope.abs();
        // Beyond the direction itself something may touch.
        let ends = newton.kept_apart && trial == 0 && here < 0.0;
        if landed || here.is_finite() && (ends || here.abs() <= left) {
            newton.accept_trial(z);
            return Some(lambda);
        }
        if here < 0.0 && here.is_finite() {
            low = (lambda, here);
        } else {
            high = Some((lambda, if here > 0.0 { here } else { f64::INFINITY }));
        }
        lambda = high.map_or(STRIDE * lambda, |high| between(low, high));
    }
    // The bracket has closed on a kink or is unbounded: its lower end still lies below the start.
    (low.0 > 0.0).then(|| {
        newton.evaluate_at(problem, z, low.0, tolerance);
        newton.accept_trial(z);
        low.0
    })
}

/// Zero of the line through both ends of a bracket, kept away from the ends.
fn between((a, slope_a): (f64, f64), (b, slope_b): (f64, f64)) -> f64 {
    let share = slope_a / (slope_a - slope_b);
    let share = if share.is_finite() { share.clamp(MARGIN, 1.0 - MARGIN) } else { MARGIN };
    a + share * (b - a)
}

impl Newton {
    /// Evaluates the residual at z + lambda dz. Returns whether it is within the tolerance, which is accepted whatever
    /// the merit function says: rounding may not allow a decrease.
    pub(super) fn evaluate_at(
        &mut self,
        problem: &mut dyn NonlinearProblem,
        z: &[f64],
        lambda: f64,
        tolerance: f64,
    ) -> bool {
        let dz = &self.dz;
        self.workers.set(&mut self.trial, |range, trial| {
            for ((trial, z), dz) in trial.iter_mut().zip(&z[range.clone()]).zip(&dz[range]) {
                *trial = z + lambda * dz;
            }
        });
        problem.residual(&self.trial, &mut self.r_trial, &mut self.floor);
        self.workers.norm(&self.r_trial).is_finite() && self.workers.excess(&self.r_trial, &self.floor) <= tolerance
    }

    /// Shortens the direction of nodes that would touch others. If the rest leads uphill, that of all nodes alike.
    pub(super) fn keep_apart(&mut self, problem: &mut dyn NonlinearProblem, z: &[f64]) {
        self.workers.copy(&mut self.correction, &self.dz);
        let Some(least) = problem.keep_apart(z, &mut self.dz) else {
            self.kept_apart = false;
            return;
        };
        self.kept_apart = true;
        if least < 1.0
            && self.workers.dot(&self.r, &self.dz) >= 0.0
            && self.workers.dot(&self.r, &self.correction) < 0.0
        {
            self.dz.iter_mut().zip(&self.correction).for_each(|(dz, whole)| *dz = least * whole);
        }
    }

    /// Accepts the last trial point.
    pub(super) fn accept_trial(&mut self, z: &mut [f64]) {
        self.workers.copy(z, &self.trial);
        std::mem::swap(&mut self.r, &mut self.r_trial);
    }

    /// Whether the trial is closer to the solution although its residual norm `residual` [N] is larger: the same
    /// tangent predicts a correction clearly smaller than the step (restricted natural monotonicity: Deuflhard 2004,
    /// section 3.3, algorithm NLEQ-ERR). If a stiff spring turns or a flat sheet begins to bulge, the residual must
    /// rise first, as its norm only sees the stiff direction.
    fn correction_shrinks(&mut self, problem: &mut dyn NonlinearProblem, lambda: f64, residual: f64) -> bool {
        if !residual.is_finite() {
            return false;
        }
        self.workers.copy_negative(&mut self.correction, &self.r_trial);
        let solved = problem.solve(&mut self.correction).is_ok();
        solved && self.workers.norm(&self.correction) <= (1.0 - NATURAL * lambda) * self.workers.norm(&self.dz)
    }
}
