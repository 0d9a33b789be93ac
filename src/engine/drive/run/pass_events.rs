//! Events of the scene at an accepted state: those by time, those that wait for a state, and those that are only told.

use super::super::observer::Observer;
use super::change::Changed;
use super::{Run, RunError, corners_of_tables};
use crate::integrate::stepper::Stepper;

impl Run<'_> {
    /// Passes the events that the accepted state has reached. A snapshot is always of the state after them.
    pub(super) fn pass_events(
        &mut self,
        stepper: &mut Stepper<'_>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), RunError> {
        let (scene, state) = (self.scene, &mut *self.state);
        let Some(events) = scene.events() else { return Ok(()) };
        let (shown, t, all) = (state.events.fired().len(), state.from.state.t, events.event_times().len());
        let happened = state.events.happen(scene, state.from.state.as_ref(), state.policy.slack(t));
        let passed = if all > state.passed { state.policy.passed(scene, t) } else { state.passed };
        if passed != state.passed {
            log::info!("t = {t:.6e} s: event {passed} of {all} passed");
        }
        if happened || passed != state.passed {
            state.passed = passed;
            let other = events.pass_events(passed) || happened;
            if happened {
                state.policy.end_at(scene, state.events.times(scene));
                state.corners = corners_of_tables(scene);
            }
            events.put_supports(&mut state.from.state, 1.0);
            state.refresh(scene, stepper, if other { Changed::Phase } else { Changed::Motion })?;
            // What a program changes next is no part of the event.
            state.before_change = None;
        }
        self.show_events(shown, observers)
    }

    /// Shows events that have happened, without so many of the first.
    pub(super) fn show_events(&self, shown: usize, observers: &mut [&mut dyn Observer]) -> Result<(), RunError> {
        for event in self.state.events.fired().iter().skip(shown) {
            observers.iter_mut().try_for_each(|o| o.event(event))?;
        }
        Ok(())
    }
}
