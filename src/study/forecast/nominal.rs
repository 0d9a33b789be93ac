//! Nominal costs, and the budget of a forecast. A nominal cost is counted work times its cost on one core of an
//! ordinary machine, so that decisions based on it are the same on every machine.

use std::cell::Cell;

use super::coarse_reference::MeasuredRun;
use super::cost::TangentCost;
use super::sample::Work;
use crate::case::spec::Problem;
use crate::integrate::registry::{Family, MethodChoice};
use crate::prepared_case::{nominal_pass, nominal_step};
use crate::scene::Scene;

/// [-] Share of the run that a forecast may cost.
const SHARE: f64 = 0.25;
/// [s] Smallest budget for scenes of up to [`SMALL`] degrees of freedom. It decreases for larger scenes, because the
/// time to build them and to choose their solver is not counted here.
const LEAST: f64 = 3.0;
const SMALL: f64 = 60_000.0;
/// [s] A search of the spectrum for critical steps, a degree of freedom: some two hundred tangent products.
const SEARCH: f64 = 1e-5;
/// [-] Largest part of the budget that such a search may take.
const SEARCHES: f64 = 0.5;

/// [s] Cost of a step besides its forces and its equations: per step, and per degree of freedom.
const OVERHEAD: [f64; 2] = [3e-7, 4e-9];
/// [-] Cost of a second force pass at the same positions over that of the first, from which it takes what follows from
/// positions (annuli of 703 nodes in the wind: 0.88; of 10,000 and 100,000 nodes without: 0.65; with a first pass that
/// kept all sums apart).
const AGAIN: f64 = 0.7;
/// [-] Assumed work of an implicit step: two iterations and a convergence test.
const UNTRIED: Work = [3.0, 2.0, 2.0, 2.0, 2.0, 0.0];
/// The same where a matrix is kept.
const KEPT: Work = [3.0, 0.0, 0.0, 2.0, 2.0, 0.0];

/// What the units of work cost on a scene, nominally.
#[derive(Clone, Copy, Debug)]
pub struct NominalCosts {
    /// [s] a step without its work
    step: f64,
    /// [s] what each kind of work costs
    work: Work,
    /// whether forces depend on velocities
    moving: bool,
    /// what an implicit step is expected to need
    implicit: Work,
}

impl NominalCosts {
    /// Those of a scene; `tangent` where implicit steps are possible.
    pub fn new(scene: &dyn Scene, tangent: Option<&TangentCost>) -> NominalCosts {
        let [assembly, factorization, solve, iteration] = tangent.map_or([0.0; 4], TangentCost::nominal);
        let step = OVERHEAD[0] + OVERHEAD[1] * scene.n_dof() as f64;
        let mut implicit = if tangent.is_some_and(|t| t.kept) { KEPT } else { UNTRIED };
        implicit[5] = implicit[3] * tangent.map_or(0.0, |t| t.cg_iterations as f64);
        let work = [nominal_pass(scene), assembly, factorization, solve, 0.0, iteration];
        NominalCosts { step, work, moving: scene.velocity_dependent(), implicit }
    }

    /// [s] So many steps and their work, all passes in full.
    pub fn cost(&self, steps: f64, work: Work) -> f64 {
        self.step * steps + self.work.iter().zip(work).map(|(unit, n)| unit * n).sum::<f64>()
    }

    /// [s] So many steps, from the work of those that were made.
    pub fn as_made(&self, method: &MethodChoice, made: &MeasuredRun, steps: f64) -> f64 {
        let share = steps / made.sample.steps.max(1.0);
        let mut work = made.sample.work.map(|n| n * share);
        work[0] += made.account_passes * share - self.saved(method) * steps;
        self.cost(steps, work)
    }

    /// [s] So many steps of a method that has made none.
    pub fn untried(&self, method: &MethodChoice, steps: f64) -> f64 {
        let passes = f64::from(method.info.evaluations[usize::from(self.moving)]) - self.saved(method);
        match method.info.family {
            Family::Implicit => self.cost(steps, self.implicit.map(|n| n * steps)),
            Family::Explicit | Family::MatrixFree => {
                self.cost(steps, [passes.max(1.0) * steps, 0.0, 0.0, 0.0, 0.0, 0.0])
            }
        }
    }

    /// Part of a pass that is saved in each step. A pass that a scheme makes only if forces depend on velocities is at
    /// positions for which a pass was made already.
    fn saved(&self, method: &MethodChoice) -> f64 {
        let [still, moving] = method.info.evaluations.map(f64::from);
        if self.moving { (1.0 - AGAIN) * (moving - still) } else { 0.0 }
    }
}

/// Nominal time that a forecast may still spend. Small pieces of work, each of a fraction of a second, are not counted.
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

    /// Charges a search of the spectrum, which gives the stability limits of all methods, if it is affordable.
    /// Otherwise the bounds from the elements are used.
    pub fn affords_search(&self, scene: &dyn Scene) -> bool {
        let cost = SEARCH * scene.n_dof() as f64;
        cost <= SEARCHES * self.left() && self.affords(cost)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forecast::sample::Sample;

    #[test]
    fn what_is_spent_is_not_spent_twice() {
        let budget = Budget { left: Cell::new(1.0) };
        assert!(budget.affords(0.75) && !budget.affords(0.5) && budget.affords(0.25));
        budget.spend(1.0);
        assert!(budget.left() == 0.0 && budget.affords(0.0));
    }

    /// A second pass at the same positions is cheaper than the first, before a step was made and by its count; one for
    /// the account alone costs as much as any, and is known when it was made.
    #[test]
    fn a_pass_at_the_same_positions_costs_less_and_one_for_the_account_as_much() {
        let units = NominalCosts { step: 0.0, work: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0], moving: true, implicit: KEPT };
        let method = |name| MethodChoice::with_defaults(name).expect("in the registry");
        let cost = |name, passes: f64, account_passes: f64| {
            let work = [10.0 * passes, 0.0, 0.0, 0.0, 0.0, 0.0];
            let sample = Sample { steps: 10.0, work, ..Sample::default() };
            let made = MeasuredRun { sample, account_passes: 10.0 * account_passes, ..MeasuredRun::default() };
            units.as_made(&method(name), &made, 1.0)
        };
        assert_eq!(cost("velocity-verlet", 2.0, 0.0), 1.0 + AGAIN);
        assert_eq!(units.untried(&method("velocity-verlet"), 1.0), 1.0 + AGAIN);
        assert_eq!(cost("improved-euler", 2.0, 0.0), 2.0);
        assert_eq!(cost("improved-euler-pec", 1.0, 1.0), 2.0);
        let still = NominalCosts { moving: false, ..units };
        assert_eq!(still.untried(&method("velocity-verlet"), 1.0), 1.0);
    }
}
