//! Changes between two steps, by a program or an event: forces and the account are found again.

use super::super::ledger::{Elastic, Ledger};
use super::super::observer::Energies;
use super::super::step_policy::StepPolicy;
use super::RunState;
use super::scene_limits::SceneLimits;
use crate::integrate::stepper::Stepper;
use crate::integrate::{LawChange, StepError};
use crate::model::point::Point;
use crate::model::state::StateRef;
use crate::scene::Scene;

/// What a program or an event has changed since the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Changed {
    /// nothing
    #[default]
    Nothing,
    /// velocities of held nodes: tangents stay the same
    Motion,
    /// forces that do not depend on the state: tangents stay the same
    Values,
    /// factors of loads or the wind: how forces depend on the state
    Loads,
    /// rest lengths of springs, and perhaps loads
    RestLengths,
    /// also the nodes that forces depend on: the matrix has another pattern
    Pattern,
    /// what is held, or which springs carry force: an event of the scene
    Phase,
}

impl RunState {
    /// Takes up what a program or an event has changed since the last step: finds the forces at the present state
    /// again, and corrects the ledger.
    ///
    /// Where only values change, of forces, wind, loads, rest lengths or a support's velocity, the scheme and adaptive
    /// steps go on: forces jump, but position and velocity do not. What they carry jumps with the forces
    /// ([`Integrator::keep_over_change`](crate::integrate::Integrator::keep_over_change)). All of it is kept relative
    /// to the last accepted step, so values may be set again and again there, and only the last ones count. Where
    /// constraints or masses jump, which only events do, the scheme and adaptive steps start again.
    pub fn refresh(&mut self, scene: &dyn Scene, stepper: &mut Stepper<'_>, changed: Changed) -> Result<(), StepError> {
        let kept = changed != Changed::Phase && self.keep_over_change(scene, stepper);
        let at = stepper.force_velocities().filter(|_| kept);
        let at = StateRef { v: at.unwrap_or(&self.from.state.v), ..self.from.state.as_ref() };
        self.counters.evaluate(scene, at, &mut self.from.forces);
        let fate = if changed == Changed::Phase { Elastic::Dissipated } else { Elastic::FromOutside };
        (self.ledger, self.row) = self.changed_account(scene, &self.from, fate);
        let law = match changed {
            Changed::Loads => Some(LawChange::Loads),
            Changed::RestLengths => Some(LawChange::RestLengths),
            Changed::Pattern => Some(LawChange::Pattern),
            Changed::Nothing | Changed::Motion | Changed::Values | Changed::Phase => None,
        };
        match (changed, law) {
            (Changed::Phase, _) => {
                if let StepPolicy::Adaptive(policy) = &mut self.policy {
                    policy.forget_history();
                    policy.recount(scene);
                }
                self.watch.scene_changed(scene);
                self.scene_limits = SceneLimits::of(scene);
                stepper.start(&self.from)?;
                stepper.restart(&self.from);
            }
            (_, Some(change)) => {
                self.watch.loads_changed(scene);
                if kept { stepper.laws_changed(&self.from, change)? } else { stepper.start(&self.from)? }
            }
            (_, None) if !kept => stepper.restart(&self.from),
            (_, None) => {}
        }
        Ok(())
    }

    /// Before forces of changed values are found: what the scheme and adaptive steps carry, and the account, are kept
    /// as they are with those of before. Returns whether the scheme can do that.
    pub fn keep_over_change(&mut self, scene: &dyn Scene, stepper: &mut Stepper<'_>) -> bool {
        if let StepPolicy::Adaptive(policy) = &mut self.policy {
            policy.keep_over_change(&self.from, scene.inverse_mass());
        }
        self.before_change.get_or_insert((self.ledger, self.row));
        stepper.keep_over_change(&self.from)
    }

    /// The account with the forces of `at`, the present state, after a change since the last step.
    pub fn changed_account(&self, scene: &dyn Scene, at: &Point, elastic: Elastic) -> (Ledger, Energies) {
        let (mut ledger, row) = self.before_change.unwrap_or((self.ledger, self.row));
        let row = ledger.changed(scene, at, &row, elastic);
        (ledger, row)
    }
}
