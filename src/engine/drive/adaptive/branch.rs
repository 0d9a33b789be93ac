//! Forces that change their law within a step: springs that go slack or taut.
//!
//! An error estimate for smooth forces misses or underestimates such a change: a spring may go taut and slack again
//! within one step. The scene gives the impulse that depends on the changes within a step ([`Scene::branch_changes`]).
//! Where it is large compared with the tolerance, the step is made again. It then ends at the largest change, or is so
//! short that the change does not matter, whichever is longer. So a net with hundreds of changes does not need a step
//! for each.
//!
//! In a step of h in a run of T, changes may cause a share `sqrt(h/T)` of the allowed error: they come at random, so
//! the squares of their errors add up.

use super::attempt::{AttemptContext, DropReason};
use super::estimate::Deviation;
use super::{Adaptive, PlannedStep};
use crate::model::point::Point;

/// [-] Largest share of the step that remains when it is cut to end where a force changes its law.
const MOST: f64 = 0.999;
/// [-] Error that the changes of a run may cause, over the tolerance, if no stage of the scheme saw them. The stages
/// see most changes; the error of an unseen change is several times larger. With 5, a net whose springs go slack and
/// taut all the time has errors of the size of the tolerance, but a single spring that goes taut has 20 times as much.
const SHARE: f64 = 1.0;
/// An impulse falls with the square of the step, and the allowed impulse with its root.
const EXPONENT: f64 = -1.0 / 1.5;
const SAFETY: f64 = 0.9;

impl Adaptive {
    /// Drops an attempted step with more change of forces than is allowed.
    pub(super) fn check_branches(
        &mut self,
        context: &mut AttemptContext<'_, '_>,
        planned: PlannedStep,
        [from, to]: [&Point; 2],
    ) -> Result<(), DropReason> {
        if self.kick.is_empty() {
            return Ok(());
        }
        let states = [from.state.as_ref(), to.state.as_ref()];
        let changes = context.scene.springs().and_then(|springs| springs.branch_changes(states, &mut self.kick));
        let Some(fraction) = changes else { return Ok(()) };
        for (kick, m) in self.kick.iter_mut().zip(context.scene.inverse_mass()) {
            *kick *= m;
        }
        let mut off = self.missed(planned.h);
        if off > 1.0 && context.stepper.filter_error(&mut self.kick, context.counters).is_ok() {
            off = self.missed(planned.h);
        }
        // The error estimate handles values that are not finite.
        if !(off > 1.0 && off.is_finite()) {
            return Ok(());
        }
        let (to_event, small) = (planned.h * fraction.min(MOST), planned.h * (SAFETY * off.powf(EXPONENT)));
        self.state.event = (to_event > small).then_some(from.state.t + to_event);
        self.state.controller.cut(to_event.max(small));
        let worst = self.kick.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        Err(DropReason::Error(Deviation { ratio: off, dof: worst.map_or(0, |(dof, _)| dof) }))
    }

    /// [-] The impulse over what is allowed in a step of `h` [s].
    fn missed(&self, h: f64) -> f64 {
        let (motion, run) = (self.state.motion, self.spec.end);
        let kick = self.kick.iter().map(|v| v * v).sum::<f64>().sqrt();
        let allowed = SHARE * motion.allowed(self.spec.tolerance, self.free) * (h / run).sqrt();
        motion.whole_period(h) * kick / allowed
    }
}
