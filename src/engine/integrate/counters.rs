//! Work counters: the same on every machine, unlike seconds.

use crate::model::forces::Forces;
use crate::model::point::Point;
use crate::model::state::StateRef;
use crate::model::step_block::StepSummary;
use crate::model::system::{KickDriftBlock, System, advance};

/// The work of a run, in operations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Counters {
    /// force passes of the scheme
    pub force_evaluations: u64,
    /// assemblies of W
    pub tangent_assemblies: u64,
    /// factorisations of W
    pub factorizations: u64,
    /// those of them by LU: W is not symmetric, or LU was asked for
    #[serde(default)]
    pub lu_factorizations: u64,
    /// solves with W
    pub linear_solves: u64,
    /// Newton iterations
    pub newton_iterations: u64,
    /// iterations of conjugate gradients, in these solves and in trials on a new W
    #[serde(default)]
    pub cg_iterations: u64,
    /// sweeps over all springs (`xpbd`) or all nodes (`vbd`)
    #[serde(default)]
    pub sweeps: u64,
}

impl Counters {
    /// The work of two runs together.
    #[must_use]
    pub fn plus(self, other: Counters) -> Self {
        Counters {
            force_evaluations: self.force_evaluations + other.force_evaluations,
            tangent_assemblies: self.tangent_assemblies + other.tangent_assemblies,
            factorizations: self.factorizations + other.factorizations,
            lu_factorizations: self.lu_factorizations + other.lu_factorizations,
            linear_solves: self.linear_solves + other.linear_solves,
            newton_iterations: self.newton_iterations + other.newton_iterations,
            cg_iterations: self.cg_iterations + other.cg_iterations,
            sweeps: self.sweeps + other.sweeps,
        }
    }

    /// A counted force pass.
    pub fn evaluate<S: System + ?Sized>(&mut self, system: &S, at: StateRef<'_>, out: &mut Forces) {
        self.force_evaluations += 1;
        system.evaluate(at, out);
    }

    /// A block of steps with its force passes counted; see [`advance`].
    pub fn advance<S: System + ?Sized>(
        &mut self,
        system: &S,
        to: &mut Point,
        block: KickDriftBlock<'_>,
        summaries: &mut [StepSummary],
    ) {
        self.force_evaluations += (block.scheme.passes() * summaries.len().max(1)) as u64;
        advance(system, &mut to.state, &mut to.forces, block, summaries);
    }
}
