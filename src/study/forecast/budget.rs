//! What a forecast may cost: a part of the run that it forecasts.

use crate::case::spec::Problem;
use crate::scene::Scene;
use crate::study::bench::nominal_step;
use std::cell::Cell;

/// [-] Share of the run.
const SHARE: f64 = 0.25;
/// [s] What is always allowed on scenes of up to so many degrees of freedom. On larger ones it falls as these grow: to
/// build them and to choose their solver costs time that is not counted here.
const LEAST: f64 = 3.0;
const SMALL: f64 = 60_000.0;
/// [s] A search of the spectrum for critical steps, a degree of freedom: some two hundred tangent products.
const SEARCH: f64 = 1e-5;
/// [-] Part of what is allowed that such a search may take.
const SEARCHES: f64 = 0.5;

/// Nominal seconds that are left to spend: counted work times what it costs on an ordinary machine, so that what is
/// left out is the same on every machine. Small pieces of work, each of a fraction of a second, are not counted.
#[derive(Clone, Debug)]
pub struct Budget {
    left: Cell<f64>,
}

impl Budget {
    /// A quarter of the run that a case asks for, but enough for a scene of some thousand nodes.
    pub fn of(scene: &dyn Scene, problem: &Problem) -> Self {
        let steps = problem.time.step.fixed().map_or(0.0, |step| (problem.time.end / step).ceil());
        let run = steps * nominal_step(scene, &problem.method);
        let least = LEAST * (SMALL / scene.n_dof().max(1) as f64).min(1.0);
        Budget { left: Cell::new((SHARE * run).max(least)) }
    }

    /// [s] What is left.
    pub fn left(&self) -> f64 {
        self.left.get().max(0.0)
    }

    /// Takes so many seconds [s] off.
    pub fn spend(&self, seconds: f64) {
        self.left.set(self.left.get() - seconds);
    }

    /// Takes so many seconds [s] off if they are left.
    pub fn affords(&self, seconds: f64) -> bool {
        let left = seconds <= self.left();
        if left {
            self.spend(seconds);
        }
        left
    }

    /// Whether a search of the spectrum is affordable, which the limits of all methods come from; else bounds from the
    /// elements must do.
    pub fn affords_search(&self, scene: &dyn Scene) -> bool {
        let cost = SEARCH * scene.n_dof() as f64;
        cost <= SEARCHES * self.left() && self.affords(cost)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_spent_is_not_spent_twice() {
        let budget = Budget { left: Cell::new(1.0) };
        assert!(budget.affords(0.75) && !budget.affords(0.5) && budget.affords(0.25));
        budget.spend(1.0);
        assert!(budget.left() == 0.0 && budget.affords(0.0));
    }
}
