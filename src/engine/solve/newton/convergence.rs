//! When Newton's iteration has converged, and what corrections show where the residual is rounding.

use super::{Newton, Scales};

/// [-] A residual of pure rounding is accepted up to this share of the step's forces. Above it, the residual alone says
/// nothing about soft springs beside stiff ones: the next correction must be small as well.
const TRUSTED: f64 = 1e-5;
/// [-] A correction that rounding keeps from shrinking is accepted up to this share of the step's motion.
const SETTLED: f64 = 1e-4;
/// [-] A correction above this share of the previous one has stopped shrinking.
const SHRINKS: f64 = 0.5;

/// Whether the iteration has converged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::solve) enum Convergence {
    /// Residual and increment are small.
    Converged,
    /// At least one is not.
    NotConverged,
    /// The residual is rounding of stiff springs, which may hide the motion of soft ones: the next correction decides.
    Rounding,
}

/// What the corrections show about an iterate whose residual is rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::solve) enum RoundingVerdict {
    /// They are small, or as small as rounding allows: this is the solution.
    Yes,
    /// They still shrink.
    NotYet,
    /// They have stopped shrinking and are not small.
    Never,
}

/// The corrections at iterates whose residual is rounding.
#[derive(Clone, Copy, Debug)]
pub(in crate::solve) struct RoundingCheck {
    /// [m] norm of the last one
    last: f64,
}

impl Default for RoundingCheck {
    fn default() -> Self {
        RoundingCheck { last: f64::INFINITY }
    }
}

/// Convergence criteria of an iteration.
#[derive(Clone, Copy, Debug)]
pub(in crate::solve) struct ConvergenceCriteria {
    /// [N] tolerance on the residual
    pub tolerance: f64,
    pub scales: Scales,
}

impl ConvergenceCriteria {
    /// [-] a residual over its scale
    pub(in crate::solve) fn over_scale(&self, residual: f64) -> f64 {
        if self.scales.residual > 0.0 { residual / self.scales.residual } else { 0.0 }
    }
}

impl Newton {
    /// Whether residual and increment at `z` `[n]` are small. `next` [-] predicts the next increment over the last: the
    /// accepted share of the direction times the reduction of the residual.
    pub(in crate::solve) fn convergence(&self, z: &[f64], criteria: ConvergenceCriteria, next: f64) -> Convergence {
        let next_increment = next * self.workers.norm(&self.dz);
        let excess = self.excess();
        let small =
            excess <= criteria.tolerance && (next_increment <= self.increment_tolerance(z, criteria) || excess == 0.0);
        match small {
            false => Convergence::NotConverged,
            true if self.is_trusted(self.workers.norm(&self.r), criteria) => Convergence::Converged,
            true => Convergence::Rounding,
        }
    }

    /// Whether a residual [N] of pure rounding is small enough to determine all motions.
    pub(super) fn is_trusted(&self, residual: f64, criteria: ConvergenceCriteria) -> bool {
        residual <= criteria.tolerance.max(TRUSTED * criteria.scales.residual)
    }

    /// [m] Tolerance on the increment at `z`.
    pub(super) fn increment_tolerance(&self, z: &[f64], criteria: ConvergenceCriteria) -> f64 {
        (self.spec.relative * criteria.scales.increment.max(self.workers.norm(z))).max(criteria.scales.increment_floor)
    }

    /// Checks `z` by the correction in `self.dz`.
    pub(in crate::solve) fn settled(
        &self,
        z: &[f64],
        criteria: ConvergenceCriteria,
        settling: &mut RoundingCheck,
    ) -> RoundingVerdict {
        let increment = self.workers.norm(&self.dz);
        let shrinks = increment <= SHRINKS * std::mem::replace(&mut settling.last, increment);
        if increment <= self.increment_tolerance(z, criteria) {
            RoundingVerdict::Yes
        } else if shrinks {
            RoundingVerdict::NotYet
        } else if increment <= SETTLED * criteria.scales.increment.max(self.workers.norm(z)) {
            RoundingVerdict::Yes
        } else {
            RoundingVerdict::Never
        }
    }
}
