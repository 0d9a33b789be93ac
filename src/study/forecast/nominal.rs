//! Nominal costs, and the budget of a forecast. A nominal cost is counted work times its cost on one core of an
//! ordinary machine, so that decisions based on it are the same on every machine.

use std::cell::Cell;

use super::cost::{TangentCost, nominal};
use super::work::Work;
use crate::case::spec::Problem;
use crate::costs;
use crate::integrate::registry::{Family, MethodChoice};
use crate::prepared_case::{nominal_pass, nominal_step};
use crate::scene::Scene;
use crate::solve::LinearStats;

/// [-] Share of the run that a forecast may cost.
const SHARE: f64 = 0.2;
/// [s] Smallest budget: with what is measured before any run, half a second.
const LEAST: f64 = 0.4;
/// [s] The same of a thorough one: a run of a few tenths of a second is made as a whole.
const LEAST_THOROUGH: f64 = 1.0;
/// [s] Largest budget: nobody waits for hours to hear that a run takes days.
const MOST: f64 = 5.0;
/// [-] Most that a machine is taken to be slower than nominally.
const SLOWEST: f64 = 16.0;
/// [-] Implicit steps cost this many times their nominal costs, until some were made (parachutes of the assets: 2 to
/// 3).
const IMPLICIT: f64 = 2.0;
/// [s] Shortest work from which it is concluded how slow the machine is.
const SURE: f64 = 5e-3;
/// [-] Largest part of the budget that a search of the spectrum for critical steps may take.
const SEARCHES: f64 = 0.5;

/// [-] Assumed work of an implicit step: two iterations and a convergence test.
const UNTRIED: Work = Work { tangent_assemblies: 2.0, factorizations: 2.0, ..KEPT };
/// The same where a matrix is kept.
const KEPT: Work = Work {
    force_evaluations: 3.0,
    tangent_assemblies: 0.0,
    factorizations: 0.0,
    linear_solves: 2.0,
    newton_iterations: 2.0,
    cg_iterations: 0.0,
    sweeps: 0.0,
};

/// [-] Time of a sweep over all springs, one after the other, over that of a pass.
const SWEEP: f64 = 2.0;

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
        let tangent_work = tangent.map(TangentCost::nominal).unwrap_or_default();
        let step = costs::STEP + costs::STEP_DOF * scene.n_dof() as f64;
        let mut implicit = if tangent.is_some_and(|t| t.kept) { KEPT } else { UNTRIED };
        implicit.cg_iterations = implicit.linear_solves * tangent.map_or(0.0, |t| t.cg_iterations as f64);
        let pass = nominal_pass(scene);
        let work = Work { force_evaluations: pass, sweeps: SWEEP * pass, ..tangent_work };
        NominalCosts { step, work, moving: scene.velocity_dependent(), implicit }
    }

    /// Those of a run that was made, by the elements of each force; `linear` of its implicit steps.
    pub fn of_run(scene: &dyn Scene, linear: Option<&LinearStats>) -> NominalCosts {
        let solving = linear.map(|linear| nominal(linear, scene.n_dof())).unwrap_or_default();
        let (state, mut f) = (scene.initial_state(), vec![0.0; scene.n_dof()]);
        let terms = scene.terms().iter().enumerate().filter_map(|(number, info)| {
            let elements = scene.term_alone(number, state.as_ref(), &mut f)? as f64;
            Some(elements * if info.on_triangles { costs::TRIANGLE } else { costs::SPRING })
        });
        let pass = costs::SMALL_PASS + costs::NODE * scene.reference().len() as f64 + terms.sum::<f64>();
        let work = Work { force_evaluations: pass, sweeps: SWEEP * pass, ..solving };
        NominalCosts { work, ..NominalCosts::new(scene, None) }
    }

    /// [s] So many steps and their work, all passes in full.
    pub fn cost(&self, steps: f64, work: Work) -> f64 {
        self.step * steps + work.cost(&self.work)
    }

    /// [s] So many steps of a method that has made none.
    pub fn untried(&self, method: &MethodChoice, steps: f64) -> f64 {
        let passes = f64::from(method.info.evaluations[usize::from(self.moving)]) - self.saved(method);
        match method.info.family {
            Family::Implicit => self.cost(steps, self.implicit.times(steps)),
            Family::Explicit | Family::MatrixFree => {
                let work = Work { sweeps: method.sweeps(), ..Work::passes(passes.max(1.0)) };
                self.cost(steps, work.times(steps))
            }
        }
    }

    /// Part of a pass that is saved in each step. A pass that a scheme makes only if forces depend on velocities is at
    /// positions for which a pass was made already.
    fn saved(&self, method: &MethodChoice) -> f64 {
        let [still, moving] = method.info.evaluations.map(f64::from);
        if self.moving { (1.0 - costs::AGAIN) * (moving - still) } else { 0.0 }
    }
}

/// Time that a forecast may still spend. Nominal costs are taken off, times what this machine is slower than nominally,
/// in steps of a factor of two: the clock has little part in what is decided. Small pieces of work, each of a fraction
/// of a second, are not counted.
#[derive(Clone, Debug)]
pub struct Budget {
    left: Cell<f64>,
    /// [s] as it was
    all: Cell<f64>,
    /// [-] slower than nominally, in force passes and in implicit steps
    slower: [Cell<f64>; 2],
    /// whether about as much as the run may be spent
    thorough: bool,
}

impl Budget {
    /// Half a second, until the cost of the case's own run is known. A thorough one is a fifth of the run that a case
    /// asks for by nominal costs, which comes to about what parachutes cost.
    pub fn of(scene: &dyn Scene, problem: &Problem, thorough: bool) -> Self {
        let steps = problem.time.step.fixed().map_or(0.0, |step| (problem.time.end / step).ceil());
        let run = if thorough { steps * nominal_step(scene, &problem.method) } else { 0.0 };
        let least = if thorough { LEAST_THOROUGH } else { LEAST };
        Self::with((SHARE * run).clamp(least, MOST), thorough)
    }

    fn with(all: f64, thorough: bool) -> Self {
        let slower = [1.0, if thorough { 1.0 } else { IMPLICIT }].map(Cell::new);
        Budget { left: Cell::new(all), all: Cell::new(all), slower, thorough }
    }

    /// Whether about as much as the run may be spent.
    pub fn thorough(&self) -> bool {
        self.thorough
    }

    /// Notes that a force pass takes `times` as long as it should.
    pub fn calibrate(&self, times: f64) {
        if !self.thorough {
            let times = rounded(times.max(1.0));
            self.slower[0].set(times);
            self.slower[1].set(IMPLICIT * times);
        } else if self.all.get() <= LEAST {
            let most = LEAST / rounded(times).clamp(1.0, 0.5 * SLOWEST);
            self.left.set(self.left.get() - (self.all.replace(most) - most));
        }
    }

    /// [s] Nominal cost of what may be spent on a method, of these seconds.
    pub fn nominal(&self, family: Family, seconds: f64) -> f64 {
        seconds / self.slower[usize::from(family == Family::Implicit)].get()
    }

    /// Takes off what a piece of work cost that took `seconds` instead of `nominal` ones.
    pub fn charge(&self, family: Family, nominal: f64, seconds: f64) {
        let slower = &self.slower[usize::from(family == Family::Implicit)];
        if !self.thorough && nominal > 0.0 && seconds > SURE {
            slower.set(rounded(seconds / nominal));
        }
        self.spend(nominal * slower.get());
    }

    /// Makes the budget a fifth of a run that takes so long [s].
    pub fn extend(&self, run: f64) {
        if !self.thorough {
            let all = rounded(SHARE * run).clamp(LEAST, MOST).max(self.all.get());
            self.spend(self.all.replace(all) - all);
        }
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
        let cost = costs::SEARCH_DOF * scene.n_dof() as f64;
        cost <= SEARCHES * self.left() && self.affords(cost)
    }
}

/// To a power of two, so that noise has little part in it.
fn rounded(times: f64) -> f64 {
    times.log2().round().exp2().clamp(1.0 / SLOWEST, SLOWEST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_spent_is_not_spent_twice() {
        let budget = Budget::with(1.0, false);
        assert!(budget.affords(0.75) && !budget.affords(0.5) && budget.affords(0.25));
        budget.spend(1.0);
        assert!(budget.left() == 0.0 && budget.affords(0.0));
    }

    /// Work that takes five times its nominal cost is taken off four times, and the next is planned with that.
    #[test]
    fn a_slow_machine_spends_sooner() {
        let budget = Budget::with(1.0, false);
        budget.charge(Family::Explicit, 0.1, 0.5);
        assert!((budget.left() - 0.6).abs() < 1e-12 && budget.nominal(Family::Explicit, 0.4) == 0.1);
        budget.extend(10.0);
        assert!((budget.left() - 1.6).abs() < 1e-12, "{}", budget.left());
        let thorough = Budget::with(1.0, true);
        thorough.charge(Family::Explicit, 0.1, 0.5);
        thorough.extend(10.0);
        assert_eq!(thorough.left(), 0.9);
    }

    /// A second pass at the same positions is cheaper than the first.
    #[test]
    fn a_pass_at_the_same_positions_costs_less() {
        let units = NominalCosts { step: 0.0, work: Work::passes(1.0), moving: true, implicit: KEPT };
        let method = |name| MethodChoice::with_defaults(name).expect("in the registry");
        assert_eq!(units.untried(&method("velocity-verlet"), 1.0), 1.0 + costs::AGAIN);
        let still = NominalCosts { moving: false, ..units };
        assert_eq!(still.untried(&method("velocity-verlet"), 1.0), 1.0);
    }
}
