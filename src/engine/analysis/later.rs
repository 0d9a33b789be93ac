//! Critical steps after events: what is held, which springs carry force, and rest lengths change during a run.

use super::critical::{CriticalStep, ElementBounds, has_limit, remedy};
use super::spectrum::Spectrum;
use super::warnings::Planned;
use crate::format_number::figures;
use crate::scene::{Scene, place_with_groups};
use crate::warning::{Warning, WarningCode};

/// Changes that are looked at; a scene with more of them is told the limit of the first.
const MOST: usize = 8;
/// [-] A limit below this share of the one at the start is told.
const LOWER: f64 = 0.999;

/// A critical step from a time on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaterLimit {
    /// [s] when it begins
    pub t: f64,
    /// the critical step
    pub limit: CriticalStep,
}

/// The smallest critical step after a change of the scene, with the nodes where they are at t = 0; `None` if it is not
/// below that at the start. Limits are searched as long as `search`, if given, allows another one; without it they are
/// bounds from the elements, as `at_start` then is.
pub fn least_later(
    planned: Planned<'_>,
    at_start: CriticalStep,
    search: Option<&dyn Fn() -> bool>,
) -> Option<LaterLimit> {
    let Planned { scene, method, end, stop, .. } = planned;
    if !has_limit(method) {
        return None;
    }
    let scene = &*scene.for_run();
    let mut state = scene.initial_state();
    let mut least: Option<LaterLimit> = None;
    let events = scene.events()?;
    for t in events.changes().into_iter().filter(|t| *t < end).take(MOST) {
        state.t = t;
        events.pass_events(events.event_times().partition_point(|event| *event <= t));
        let limit = match search {
            Some(allowed) if !allowed() => break,
            Some(_) => Spectrum::of(scene, state.as_ref()).critical_step(method),
            None => ElementBounds::of(scene, state.as_ref()).critical_step(method),
        };
        let lowest = least.map_or(LOWER * at_start.step, |least| least.limit.step);
        if limit.step < lowest && !stop.asked() {
            least = Some(LaterLimit { t, limit });
        }
    }
    least
}

/// A warning for a step that is too large only later.
pub fn later_warning(planned: Planned<'_>, at_start: CriticalStep, later: Option<LaterLimit>) -> Option<Warning> {
    let LaterLimit { t, limit } = later?;
    let step = planned.step.filter(|step| *step > limit.step && *step <= at_start.step)?;
    let text = format!(
        "the step of {} s is above the critical step of {} from t = {} s on, about {} s ({}): {}",
        figures(step, 4),
        planned.method.info.name,
        figures(t, 6),
        figures(limit.step, 3),
        set_by(planned.scene, limit),
        remedy(&limit, step)
    );
    Some(Warning::new(WarningCode::StepAboveCritical, text))
}

/// Where a limit comes from, in words.
fn set_by(scene: &dyn Scene, limit: CriticalStep) -> String {
    format!("set around {}, with nodes where they are at the start", place_with_groups(scene, limit.dof))
}
