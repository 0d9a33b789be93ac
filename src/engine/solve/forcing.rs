//! The accuracy of linear solves within Newton's iteration.

use super::{Accuracy, REUSED_RELATIVE};

/// [-] Share of the residual that the first solve may leave.
const FIRST: f64 = 1e-3;
/// [-] Share of the squared reduction of the residual that the next solve may leave.
const GAMMA: f64 = 0.9;
/// [-] A solve need not leave less than this share of the tolerance on the residual.
const ENOUGH: f64 = 0.1;

/// [-] Largest share that any solve may leave.
const LOOSEST: f64 = 0.1;

fn enough(residual: f64, tolerance: f64) -> f64 {
    ENOUGH * tolerance / residual
}

/// Accuracy of a solve with a reused matrix, for a residual [N] and the tolerance on it [N].
pub(super) fn reused(residual: f64, tolerance: f64) -> Accuracy {
    let enough = enough(residual, tolerance).min(LOOSEST);
    Accuracy { relative: REUSED_RELATIVE.max(enough), enough, checked: false }
}

/// The same if the residual is rounding and the solution decides whether the iteration has converged.
pub(super) fn settling(residual: f64, tolerance: f64) -> Accuracy {
    Accuracy::to(enough(residual, tolerance).clamp(f64::EPSILON, REUSED_RELATIVE)).checked()
}

/// The forcing terms of Eisenstat & Walker (1996, choice 2), no smaller than the tolerance requires (Kelley 1995, Eq.
/// 6.20). Their safeguard against a term far below a large previous one is not needed: terms here are small from the
/// first on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Forcing {
    /// [N] the previous residual; `None` before the first
    last: Option<f64>,
}

impl Forcing {
    /// [-] Share of the residual [N] that the next solve may leave, for a tolerance [N] on the residual.
    pub(super) fn next(&mut self, residual: f64, tolerance: f64) -> f64 {
        let wanted = match self.last {
            None => FIRST,
            Some(before) => GAMMA * (residual / before).powi(2),
        };
        self.last = Some(residual);
        wanted.min(FIRST).max(enough(residual, tolerance)).clamp(f64::EPSILON, LOOSEST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_are_as_exact_as_the_iteration_is_near() {
        let mut forcing = Forcing::default();
        assert_eq!(forcing.next(1.0, 1e-12), FIRST);
        let near = forcing.next(1e-3, 1e-12);
        assert!((near - GAMMA * 1e-6).abs() < 1e-18, "the square of the reduction: {near}");
        let last = forcing.next(1e-10, 1e-12);
        assert!((last - 1e-3).abs() < 1e-12, "no more than the tolerance asks for: {last}");
    }

    #[test]
    fn an_iteration_that_does_not_converge_is_not_solved_more_exactly() {
        let mut forcing = Forcing::default();
        forcing.next(1.0, 1e-12);
        assert_eq!(forcing.next(2.0, 1e-12), FIRST);
    }
}
