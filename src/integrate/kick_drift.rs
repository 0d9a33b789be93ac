//! Schemes that a [`KickDriftScheme`] describes: a single step and a block of steps are made the same way.

use super::{Counters, Integrator, StepError, StepInput, StepReport};
use crate::model::point::Point;
use crate::model::step_block::{KickDriftScheme, StepSummary};
use crate::model::system::{KickDriftBlock, System};

/// Such a scheme; it carries no state between steps.
#[derive(Clone, Copy, Debug)]
pub struct KickDrift {
    /// the description of a step of a size [s], for forces that depend on velocity or not
    pub step: fn(h: f64, velocity_dependent: bool) -> KickDriftScheme,
    /// whether the forces at the end of a step are those at the velocities of its middle
    pub lags: bool,
}

impl Integrator<dyn System> for KickDrift {
    fn start(&mut self, _system: &dyn System, _at: &Point) -> Result<(), StepError> {
        Ok(())
    }

    fn attempt(
        &mut self,
        step: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        self.advance(step, to, &mut [], counters);
        Ok(StepReport { forces_at_end: true, ..Default::default() })
    }

    fn advance_block(
        &mut self,
        step: StepInput<'_, dyn System>,
        to: &mut Point,
        summaries: &mut [StepSummary],
        counters: &mut Counters,
    ) -> bool {
        debug_assert!(summaries.last().is_none_or(|last| last.t == step.t_next));
        let makes_blocks = step.system.longest_block() >= 2 && !summaries.is_empty();
        if makes_blocks {
            self.advance(step, to, summaries, counters);
        }
        makes_blocks
    }

    fn lags(&self, system: &dyn System) -> bool {
        self.lags && system.velocity_dependent()
    }
}

impl KickDrift {
    fn advance(
        self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn System>,
        to: &mut Point,
        summaries: &mut [StepSummary],
        counters: &mut Counters,
    ) {
        to.state.t = t_next;
        let scheme = (self.step)(h, system.velocity_dependent());
        counters.advance(system, to, KickDriftBlock { scheme, from }, summaries);
    }
}
