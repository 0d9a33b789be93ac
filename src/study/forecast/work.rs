//! Counted work.

use crate::integrate::Counters;

/// [-] Counted work, as numbers that can be divided.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Work {
    /// force passes
    pub force_evaluations: f64,
    /// assemblies of W
    pub tangent_assemblies: f64,
    /// factorisations of W
    pub factorizations: f64,
    /// solves with W
    pub linear_solves: f64,
    /// Newton iterations
    pub newton_iterations: f64,
    /// iterations of conjugate gradients
    pub cg_iterations: f64,
    /// sweeps over all springs or nodes
    pub sweeps: f64,
}

impl Work {
    /// Every kind of work as `make` makes it, which is given the kind.
    pub fn each(make: impl Fn(fn(&Work) -> f64) -> f64) -> Work {
        Work {
            force_evaluations: make(|work| work.force_evaluations),
            tangent_assemblies: make(|work| work.tangent_assemblies),
            factorizations: make(|work| work.factorizations),
            linear_solves: make(|work| work.linear_solves),
            newton_iterations: make(|work| work.newton_iterations),
            cg_iterations: make(|work| work.cg_iterations),
            sweeps: make(|work| work.sweeps),
        }
    }

    /// Force passes only.
    pub fn passes(force_evaluations: f64) -> Work {
        Work { force_evaluations, ..Work::default() }
    }

    /// The work of so many steps like this one.
    #[must_use]
    pub fn times(&self, steps: f64) -> Work {
        Work::each(|kind| kind(self) * steps)
    }

    /// [s] What it costs where a unit of each kind costs `unit` [s].
    pub fn cost(&self, unit: &Work) -> f64 {
        let cost = Work::each(|kind| kind(unit) * kind(self));
        cost.force_evaluations
            + cost.tangent_assemblies
            + cost.factorizations
            + cost.linear_solves
            + cost.newton_iterations
            + cost.cg_iterations
            + cost.sweeps
    }
}

impl From<Counters> for Work {
    fn from(c: Counters) -> Work {
        Work {
            force_evaluations: c.force_evaluations as f64,
            tangent_assemblies: c.tangent_assemblies as f64,
            factorizations: c.factorizations as f64,
            linear_solves: c.linear_solves as f64,
            newton_iterations: c.newton_iterations as f64,
            cg_iterations: c.cg_iterations as f64,
            sweeps: c.sweeps as f64,
        }
    }
}
