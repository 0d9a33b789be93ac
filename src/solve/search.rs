//! How far to go along Newton's direction.

use super::newton::{Newton, NonlinearProblem};
use super::norms::{dot, excess, norm};

/// Trials after which a search gives up.
const MAX_TRIALS: u32 = 13;
/// Share of the decrease promised by the tangent that a step must deliver (Armijo 1966).
const ARMIJO: f64 = 1e-4;
/// Share of Newton's step by which the correction at the end of it must be smaller.
const NATURAL: f64 = 0.25;
/// Share of the slope at the start that may be left at the end; Newton's own step may leave more.
const SLOPE: f64 = 0.5;
/// The same for the full step: near the end, where it is the right one, it leaves almost nothing.
const FULL_SLOPE: f64 = 0.9;
/// How much farther a search strides that is still going downhill as steeply as at its start.
const STRIDE: f64 = 4.0;
/// A trial keeps this share of the bracket's width from its ends.
const MARGIN: f64 = 0.1;

/// Halves the step until the residual falls or the same tangent asks for a clearly smaller correction; moves `z` and
/// the iteration's residual there.
pub(super) fn smaller_residual(
    newton: &mut Newton,
    problem: &mut dyn NonlinearProblem,
    z: &mut [f64],
    tolerance: f64,
) -> Option<f64> {
    let before = norm(&newton.r);
    let mut lambda = 1.0;
    for _ in 0..MAX_TRIALS {
        let landed = newton.look(problem, z, lambda, tolerance);
        let residual = norm(&newton.r_trial);
        if residual <= (1.0 - ARMIJO * lambda) * before || landed || newton.nears(problem, lambda, residual) {
            newton.go(z);
            return Some(lambda);
        }
        lambda *= 0.5;
    }
    None
}

/// Seeks the lowest point of a potential along the direction from its slope F.d alone, by regula falsi within a
/// bracket: sums of energies would lose the digits that slopes keep (Crisfield 1991, section 9.2). Where the slope has
/// not changed at the end of a step, as when a convex tangent leads away from a saddle, the search strides on.
pub(super) fn downhill(
    newton: &mut Newton,
    problem: &mut dyn NonlinearProblem,
    z: &mut [f64],
    tolerance: f64,
) -> Option<f64> {
    let slope = dot(&newton.r, &newton.dz);
    let mut low = (0.0, slope);
    let mut high: Option<(f64, f64)> = None;
    let mut lambda = 1.0;
    for trial in 0..MAX_TRIALS {
        let landed = newton.look(problem, z, lambda, tolerance);
        // Where forces overflow the slope may still be a number, if the direction does not touch them.
        let here = if norm(&newton.r_trial).is_finite() { dot(&newton.r_trial, &newton.dz) } else { f64::INFINITY };
        let left = if trial == 0 { FULL_SLOPE } else { SLOPE } * slope.abs();
        if landed || here.is_finite() && here.abs() <= left {
            newton.go(z);
            return Some(lambda);
        }
        if here < 0.0 && here.is_finite() {
            low = (lambda, here);
        } else {
            high = Some((lambda, if here > 0.0 { here } else { f64::INFINITY }));
        }
        lambda = high.map_or(STRIDE * lambda, |high| between(low, high));
    }
    // The bracket has closed on a kink, or has no end: its lower end is downhill of where the step started.
    (low.0 > 0.0).then(|| {
        newton.look(problem, z, low.0, tolerance);
        newton.go(z);
        low.0
    })
}

/// Where a straight line between the ends of a bracket crosses zero, kept off the ends.
fn between((a, slope_a): (f64, f64), (b, slope_b): (f64, f64)) -> f64 {
    let share = slope_a / (slope_a - slope_b);
    let share = if share.is_finite() { share.clamp(MARGIN, 1.0 - MARGIN) } else { MARGIN };
    a + share * (b - a)
}

impl Newton {
    /// Evaluates the residual at z + lambda dz. A trial within the tolerance is good whatever a merit says: rounding
    /// may not allow a decrease.
    fn look(&mut self, problem: &mut dyn NonlinearProblem, z: &[f64], lambda: f64, tolerance: f64) -> bool {
        for ((trial, z), dz) in self.trial.iter_mut().zip(z).zip(&self.dz) {
            *trial = z + lambda * dz;
        }
        problem.residual(&self.trial, &mut self.r_trial, &mut self.floor);
        norm(&self.r_trial).is_finite() && excess(&self.r_trial, &self.floor) <= tolerance
    }

    /// Takes the last trial.
    fn go(&mut self, z: &mut [f64]) {
        z.copy_from_slice(&self.trial);
        std::mem::swap(&mut self.r, &mut self.r_trial);
    }

    /// Whether the trial is nearer to the solution although its residual (of norm `residual`) is larger: the same
    /// tangent asks of it a correction clearly smaller than the step (restricted natural monotonicity: Deuflhard 2004,
    /// section 3.3, algorithm NLEQ-ERR). Where a stiff spring turns or a flat sheet begins to bulge, the residual must
    /// rise first: its norm only sees the stiff direction.
    fn nears(&mut self, problem: &mut dyn NonlinearProblem, lambda: f64, residual: f64) -> bool {
        if !residual.is_finite() {
            return false;
        }
        for (correction, r) in self.correction.iter_mut().zip(&self.r_trial) {
            *correction = -r;
        }
        let solved = problem.solve(&mut self.correction).is_ok();
        solved && norm(&self.correction) <= (1.0 - NATURAL * lambda) * norm(&self.dz)
    }
}
