//! What work costs nominally: the same on every machine, so that what is decided by it is the same everywhere.

use super::coarse_reference::Delivered;
use super::cost::TangentCost;
use crate::integrate::registry::{Family, MethodChoice};
use crate::scene::Scene;
use crate::study::bench::{nominal_pass, nominal_step};

/// [s] What a step costs besides its forces and its equations: of itself, and a degree of freedom.
const OVERHEAD: [f64; 2] = [3e-7, 4e-9];
/// [-] Cost of a second force pass at the same positions over that of the first, from which it takes what follows from
/// positions (annuli of 703 nodes in the wind: 0.88; of 10,000 and 100,000 nodes without: 0.65; with a first pass that
/// kept all sums apart).
const AGAIN: f64 = 0.7;
/// Force passes, assemblies, factorisations and solves of an implicit step as far as it is not known: two iterations
/// and a look whether they were enough.
const UNTRIED: [f64; 4] = [3.0, 2.0, 2.0, 2.0];
/// The same where a matrix is kept.
const KEPT: [f64; 4] = [3.0, 0.0, 0.0, 2.0];

/// What the units of work cost here.
#[derive(Clone, Copy, Debug)]
pub struct Units {
    /// [s] a step without its work
    step: f64,
    /// [s] force pass, assembly, factorisation, solve
    work: [f64; 4],
    /// whether forces depend on velocities
    moving: bool,
    /// what an implicit step is expected to need
    implicit: [f64; 4],
}

impl Units {
    /// All units are nominal, in proportions that hold on one core of an ordinary machine: what is recommended is the
    /// same in every call, whatever else the machine does.
    pub fn new(scene: &dyn Scene, tangent: Option<&TangentCost>) -> Units {
        let [assembly, factorization, solve] = tangent.map_or([0.0; 3], TangentCost::nominal);
        let step = OVERHEAD[0] + OVERHEAD[1] * scene.n_dof() as f64;
        let implicit = if tangent.is_some_and(|t| t.kept) { KEPT } else { UNTRIED };
        let work = [nominal_pass(scene), assembly, factorization, solve];
        Units { step, work, moving: scene.velocity_dependent(), implicit }
    }

    /// [s] So many steps and their work, all passes in full.
    pub fn cost(&self, steps: f64, work: [f64; 4]) -> f64 {
        self.step * steps + self.work.iter().zip(work).map(|(unit, n)| unit * n).sum::<f64>()
    }

    /// [s] So many steps, from the work of those that were made.
    pub fn as_made(&self, method: &MethodChoice, made: &Delivered, steps: f64) -> f64 {
        let share = steps / made.steps.max(1.0);
        let mut work = made.work.map(|n| n * share);
        work[0] += made.account_passes * share - self.saved(method) * steps;
        self.cost(steps, work)
    }

    /// [s] So many steps of a method that has made none.
    pub fn untried(&self, method: &MethodChoice, steps: f64) -> f64 {
        let passes = f64::from(method.info.evaluations[usize::from(self.moving)]) - self.saved(method);
        match method.info.family {
            Family::Implicit => self.cost(steps, self.implicit.map(|n| n * steps)),
            Family::Explicit | Family::MatrixFree => self.cost(steps, [passes.max(1.0) * steps, 0.0, 0.0, 0.0]),
        }
    }

    /// Passes a step that are not made in full. What a scheme evaluates only where forces depend on velocities is at
    /// positions that it has been to.
    fn saved(&self, method: &MethodChoice) -> f64 {
        let [still, moving] = method.info.evaluations.map(f64::from);
        if self.moving { (1.0 - AGAIN) * (moving - still) } else { 0.0 }
    }

    /// [s] What a step of a method costs before any was made, where that decides how far trials go. An implicit one is
    /// known by its equations, which mostly keep a matrix, an explicit one as a study measures it.
    pub fn affordable(&self, scene: &dyn Scene, method: &MethodChoice) -> f64 {
        match method.info.family {
            Family::Implicit => self.untried(method, 1.0),
            Family::Explicit | Family::MatrixFree => nominal_step(scene, method),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A second pass at the same positions is cheaper than the first, before a step was made and by its count; one for
    /// the account alone costs as much as any, and is known when it was made.
    #[test]
    fn a_pass_at_the_same_positions_costs_less_and_one_for_the_account_as_much() {
        let units = Units { step: 0.0, work: [1.0, 0.0, 0.0, 0.0], moving: true, implicit: KEPT };
        let method = |name| MethodChoice::with_defaults(name).expect("in the registry");
        let cost = |name, passes: f64, account_passes: f64| {
            let work = [10.0 * passes, 0.0, 0.0, 0.0];
            let made = Delivered { steps: 10.0, work, account_passes: 10.0 * account_passes, ..Delivered::default() };
            units.as_made(&method(name), &made, 1.0)
        };
        assert_eq!(cost("velocity-verlet", 2.0, 0.0), 1.0 + AGAIN);
        assert_eq!(units.untried(&method("velocity-verlet"), 1.0), 1.0 + AGAIN);
        assert_eq!(cost("improved-euler", 2.0, 0.0), 2.0);
        assert_eq!(cost("improved-euler-pec", 1.0, 1.0), 2.0);
        let still = Units { moving: false, ..units };
        assert_eq!(still.untried(&method("velocity-verlet"), 1.0), 1.0);
    }
}
