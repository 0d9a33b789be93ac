//! The critical step of a run and warnings about its step, before it begins: above the critical step, or above what the
//! scene needs once its slack springs are taut.

use super::critical::{
    Confidence, CostLimits, CriticalStep, below_bounds, has_limit, implicit_for, plainly_stable, remedy,
    search_outweighs,
};
use super::limit::critical_step;
use super::rates::Rates;
use super::spectrum::Spectrum;
use super::taut::{AllTaut, WhileSlack};
use crate::format_number::figures;
use crate::integrate::registry::{Family, MethodChoice};
use crate::model::state::StateRef;
use crate::model::stop::Stop;
use crate::scene::{Scene, place_with_groups};
use crate::warning::{Warning, WarningCode};

/// [-] error that rounding makes in an undamped limit, where two eigenvalues meet
const MEETING: f64 = 1e-6;

/// A method on a scene, with the step it is to take.
#[derive(Clone, Copy)]
pub struct Planned<'a> {
    /// the scene
    pub scene: &'a dyn Scene,
    /// the method
    pub method: &'a MethodChoice,
    /// [s] the fixed step, no longer than the run; `None` for adaptive steps, which find the limit themselves
    pub step: Option<f64>,
    /// [s] end of the run
    pub end: f64,
    /// stops the searches
    pub stop: Stop<'a>,
}

/// The largest stable step of a case's method with the nodes as at the start and all springs taut. Searched only for
/// methods that have a limit, and only if the step is near it; else a bound from the elements.
pub fn limit_at_start(planned: Planned<'_>) -> CriticalStep {
    let _all = AllTaut::of(planned.scene);
    limit_at(planned, planned.scene.initial_state().as_ref())
}

/// The same as long as the springs that are slack at the start stay so, where that is longer than `taut`.
pub fn while_slack(planned: Planned<'_>, taut: CriticalStep) -> Option<WhileSlack> {
    let start = planned.scene.initial_state();
    WhileSlack::find(planned.scene, start.as_ref(), taut, || limit_at(planned, start.as_ref()))
}

fn limit_at(Planned { scene, method, step, end, stop }: Planned<'_>, at: StateRef<'_>) -> CriticalStep {
    if !has_limit(method) {
        return CriticalStep::none();
    }
    // What touches has the stiffness of the method's steps.
    scene.touches().into_iter().for_each(|touches| touches.set_explicit(method.info.family == Family::Explicit));
    let plain = step.and_then(|h| match search_outweighs(scene, end / h) {
        true => below_bounds(scene, at, method, h),
        false => plainly_stable(scene, at, method, h),
    });
    // With adaptive steps it still characterises the scene.
    let effort = CostLimits { sharpen_below: 2.0 * step.unwrap_or(0.0), stop, ..CostLimits::START };
    plain.unwrap_or_else(|| {
        let found = Spectrum::with(scene, at, effort).critical_step(method);
        // A stopped search has no valid result.
        if stop.asked() { CriticalStep::none() } else { found }
    })
}

/// How far a critical step can be trusted, in a word.
pub fn worth(limit: CriticalStep) -> &'static str {
    match limit.confidence {
        Confidence::Certified { .. } => "certified",
        Confidence::Estimate | Confidence::NoLimit => "an estimate",
    }
}

/// [-] Share of the mass that moves up to which mass scaling adds no doubt.
const LITTLE: f64 = 0.05;

/// A warning if mass scaling adds much.
pub fn mass_warning(scene: &dyn Scene) -> Option<Warning> {
    let added = scene.added_mass().filter(|added| added.share > LITTLE)?;
    let text = format!(
        "mass scaling: {}; what moves fast may move otherwise, and a body that falls freely falls slower by this share, so compare with a run for a shorter step, or let tradeoff measure the error",
        added.text()
    );
    Some(Warning::new(WarningCode::MassScaling, text))
}

/// A warning for a step that is too large, with both numbers; `limit` is that with all springs taut.
pub fn step_warning(planned: Planned<'_>, limit: CriticalStep) -> Option<Warning> {
    let Planned { scene, method, step, stop, .. } = planned;
    let name = method.info.name;
    let step = step?;
    if limit.step == 0.0 {
        let text = format!(
            "{name} has no stable step on this scene, where nothing damps the fastest motion: its energy grows at every \
             step; {}",
            remedy(&limit, step)
        );
        return Some(Warning::new(WarningCode::StepAboveCritical, text));
    }
    if step <= limit.step || stop.asked() {
        return None;
    }
    let slack = while_slack(planned, limit);
    // Scaled masses are those for taut springs.
    let fastest = scene.added_mass().map(|added| Rates { frequency: 2.0 / added.step, ..Rates::default() });
    if slack.is_some() && fastest.is_some_and(|rates| step <= (1.0 + MEETING) * critical_step(method, rates)) {
        return None;
    }
    if let Some(slack) = slack.filter(|slack| step <= slack.limit.step) {
        let text = format!(
            "{} are slack at the start; with all of them taut the critical step of {name} is about {} s, below the step of {} s, which is \
             stable only while they are slack (critical step: {}): take a step below {} s, or {}",
            slack.springs(),
            figures(limit.step, 3),
            figures(step, 4),
            slack.step(),
            figures(limit.step, 2),
            implicit_for(limit.rates, step),
        );
        return Some(Warning::new(WarningCode::SlackSprings, text));
    }
    let Rates { frequency, damping, .. } = limit.rates;
    let text = format!(
        "the step of {} s is {} the critical step of {name} on this scene, about {} s at the start{} \
         ({}; set around {}, where w = {} rad/s, damping rate {} 1/s); expect it to diverge: {}",
        figures(step, 4),
        excess(step / limit.step),
        figures(limit.step, 3),
        slack.map_or_else(String::new, |slack| format!(
            " with all springs taut, {} while {} are slack",
            slack.step(),
            slack.springs()
        )),
        worth(limit),
        place_with_groups(scene, limit.dof),
        figures(frequency, 4),
        figures(damping, 4),
        remedy(&limit, step)
    );
    Some(Warning::new(WarningCode::StepAboveCritical, text))
}

/// How far a step is above its limit.
fn excess(ratio: f64) -> String {
    if ratio < 1.005 { "just above".to_owned() } else { format!("{} times", figures(ratio, 3)) }
}
