//! Forces that change their law within a step: springs that go slack or taut.
//!
//! An estimate that trusts in smooth forces does not see such a change, or takes it for less than it is: a step may
//! pass over the whole of a catch. The scene says what impulse hangs on the changes within a step
//! ([`Scene::branch_changes`]). Where that is no small part of the tolerance, the step is made again to end where the
//! largest of them happens, or so short that it does not matter, whichever is longer: where hundreds of springs change
//! all the time, steps do not go from change to change.
//!
//! A step of h in a run of T may leave a share `sqrt(h/T)` to the changes within it: they come at random, so their
//! errors add up as their squares do.

use super::attempt::{AttemptContext, DropReason};
use super::estimate::Deviation;
use super::{Adaptive, PlannedStep};
use crate::model::point::Point;

/// [-] of the step, the most that is left of one that ends where a force changes its law.
const MOST: f64 = 0.999;
/// [-] of the tolerance that changes within a run could make if no scheme saw anything of them. Its stages see most,
/// but where a change is not seen at all the error is several times larger: at 5 a net whose springs go slack and taut
/// all the time is left with errors of the tolerance, but a single catch with 20 times that.
const SHARE: f64 = 1.0;
/// An impulse falls with the square of the step, and what is allowed with its root.
const EXPONENT: f64 = -1.0 / 1.5;
const SAFETY: f64 = 0.9;

impl Adaptive {
    /// Drops a step that was tried from one point to another where more changes within it than may.
    pub(super) fn check_branches(
        &mut self,
        bench: &mut AttemptContext<'_, '_>,
        trial: PlannedStep,
        [from, to]: [&Point; 2],
    ) -> Result<(), DropReason> {
        if self.kick.is_empty() {
            return Ok(());
        }
        let states = [from.state.as_ref(), to.state.as_ref()];
        let Some(fraction) = bench.scene.branch_changes(states, &mut self.kick) else { return Ok(()) };
        for (kick, m) in self.kick.iter_mut().zip(bench.scene.inverse_mass()) {
            *kick *= m;
        }
        let mut off = self.missed(trial.h);
        if off > 1.0 && bench.stepper.filter_error(&mut self.kick, bench.counters).is_ok() {
            off = self.missed(trial.h);
        }
        // What is not a number is the affair of the error's estimate.
        if !(off > 1.0 && off.is_finite()) {
            return Ok(());
        }
        let (to_event, small) = (trial.h * fraction.min(MOST), trial.h * (SAFETY * off.powf(EXPONENT)));
        self.state.event = (to_event > small).then_some(from.state.t + to_event);
        self.state.controller.cut(to_event.max(small));
        let worst = self.kick.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        Err(DropReason::Error(Deviation { ratio: off, dof: worst.map_or(0, |(dof, _)| dof) }))
    }

    /// [-] What the kick makes of what a step of `h` [s] may.
    fn missed(&self, h: f64) -> f64 {
        let (motion, run) = (self.state.motion, self.spec.end);
        let kick = self.kick.iter().map(|v| v * v).sum::<f64>().sqrt();
        let allowed = SHARE * motion.allowed(self.spec.tolerance, self.free) * (h / run).sqrt();
        motion.whole_period(h) * kick / allowed
    }
}
