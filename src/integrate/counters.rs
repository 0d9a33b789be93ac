//! Work counters: the same on every machine, unlike seconds.

use crate::model::forces::Forces;
use crate::model::point::Point;
use crate::model::state::StateRef;
use crate::model::stride::{Passed, Stages};
use crate::model::system::{Around, Onward, System};

/// What a run cost, in operations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Counters {
    /// force passes the scheme asked for
    pub force_evaluations: u64,
    /// assemblies of W
    pub tangent_assemblies: u64,
    /// factorisations of W
    pub factorizations: u64,
    /// solves with W
    pub linear_solves: u64,
    /// Newton iterations
    pub newton_iterations: u64,
    /// iterations of conjugate gradients, in these solves and to see what serves a new W
    #[serde(default)]
    pub cg_iterations: u64,
}

impl Counters {
    /// The work of two runs together.
    #[must_use]
    pub fn plus(self, other: Counters) -> Self {
        Counters {
            force_evaluations: self.force_evaluations + other.force_evaluations,
            tangent_assemblies: self.tangent_assemblies + other.tangent_assemblies,
            factorizations: self.factorizations + other.factorizations,
            linear_solves: self.linear_solves + other.linear_solves,
            newton_iterations: self.newton_iterations + other.newton_iterations,
            cg_iterations: self.cg_iterations + other.cg_iterations,
        }
    }

    /// A counted force pass.
    pub fn evaluate<S: System + ?Sized>(&mut self, system: &S, at: StateRef<'_>, out: &mut Forces) {
        self.force_evaluations += 1;
        system.evaluate(at, out);
    }

    /// Counted force passes of several steps, if the system makes them in one go.
    pub fn stride<S: System + ?Sized>(
        &mut self,
        system: &S,
        to: &mut Point,
        scheme: &dyn Onward,
        passed: &mut [Passed],
    ) -> bool {
        let made = system.stride(&mut to.state, &mut to.forces, scheme, passed);
        self.force_evaluations += if made { (scheme.kicks().passes() * passed.len()) as u64 } else { 0 };
        made
    }

    /// The same by stages, from a point on.
    pub fn stride_by_stages<S: System + ?Sized>(
        &mut self,
        system: &S,
        to: &mut Point,
        (from, stages): (&Point, Stages<'_>),
        passed: &mut [Passed],
    ) -> bool {
        let made = system.stride_by_stages((from, stages), &mut to.state, &mut to.forces, passed);
        self.force_evaluations += if made { (stages.passes() * passed.len()) as u64 } else { 0 };
        made
    }

    /// A counted force pass with what comes before and after it.
    pub fn evaluate_around<S: System + ?Sized>(&mut self, system: &S, to: &mut Point, around: &dyn Around) {
        self.force_evaluations += 1;
        system.evaluate_around(&mut to.state, &mut to.forces, around);
    }

    /// The same, then a counted force pass at the velocities that what came after has left.
    pub fn evaluate_twice<S: System + ?Sized>(&mut self, system: &S, to: &mut Point, around: &dyn Around) {
        self.force_evaluations += 2;
        system.evaluate_twice(&mut to.state, &mut to.forces, around);
    }
}
