//! Warnings about a step, before a run: above the critical step, or above what the scene needs once its slack springs
//! are taut.

use super::critical::{Confidence, CostLimits, CriticalStep, has_limit, implicit_for, plainly_stable, remedy};
use super::limit::critical_step;
use super::rates::Rates;
use super::spectrum::Spectrum;
use crate::format_number::figures;
use crate::integrate::registry::MethodChoice;
use crate::model::state::{State, StateRef};
use crate::model::stop::Stop;
use crate::scene::{Scene, place_of};
use crate::warning::{Warning, WarningCode};

/// [-] strain that rounding of coordinates makes
const ROUNDING: f64 = 1e-9;
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

/// The largest stable step of a case's method at the start. Searched only for methods that have a limit, and only if
/// the step is near it; else a bound from the elements.
pub fn limit_at_start(planned: Planned<'_>) -> CriticalStep {
    limit_at(planned, planned.scene.initial_state().as_ref())
}

fn limit_at(Planned { scene, method, step, stop, .. }: Planned<'_>, at: StateRef<'_>) -> CriticalStep {
    if !has_limit(method) {
        return CriticalStep::none();
    }
    let plain = step.and_then(|h| plainly_stable(scene, at, method, h));
    // With adaptive steps it still characterises the scene.
    let effort = CostLimits { sharpen_below: 2.0 * step.unwrap_or(0.0), stop, ..CostLimits::START };
    plain.unwrap_or_else(|| {
        let found = Spectrum::with(scene, at, effort).critical_step(method);
        // A stopped search has no valid result.
        if stop.asked() { CriticalStep::none() } else { found }
    })
}

/// A warning if springs that are slack at the start hide a limit below the step, or if all are slack, so that the limit
/// at the start says nothing about springs.
pub fn slack_warning(planned: Planned<'_>, limit: CriticalStep) -> Option<Warning> {
    let Planned { scene, method, step, stop, .. } = planned;
    let step = step.filter(|_| has_limit(method) && !stop.asked())?;
    // Scaled masses are those for taut springs.
    let fastest = scene.added_mass().map(|added| Rates { frequency: 2.0 / added.step, ..Rates::default() });
    if fastest.is_some_and(|rates| step <= (1.0 + MEETING) * critical_step(method, rates)) {
        return None;
    }
    let start = scene.initial_state();
    let slack = slack(scene, start.as_ref())?;
    // The scene is scaled until the slackest spring is taut: the others then carry some tension, which stiffens them a
    // little across.
    let longer = |x: &f64| x * slack.stretch;
    let taut = State { x: start.x.iter().map(longer).collect(), ..start.clone() };
    let CriticalStep { step: taut, rates, .. } = limit_at(planned, taut.as_ref());
    let name = method.info.name;
    let hidden = taut < limit.step && (step > taut || slack.count == slack.of);
    hidden.then(|| {
        let text = format!(
            "{} springs are slack at the start, so the critical step of {name} there, {} s, holds only until they go taut; with all of them \
             taut it is about {} s, and the step is {} s{}",
            if slack.count == slack.of { format!("all {}", slack.of) } else { format!("{} of {}", slack.count, slack.of) },
            figures(limit.step, 3),
            figures(taut, 3),
            figures(step, 4),
            match step > taut {
                true => format!(": take a step below {} s, or {}", figures(taut, 2), implicit_for(rates, step)),
                false => String::new(),
            }
        );
        Warning::new(WarningCode::SlackSprings, text)
    })
}

/// Springs that are shorter than at rest and carry no compression.
struct Slack {
    count: usize,
    of: usize,
    /// [-] stretch at which the slackest is taut
    stretch: f64,
}

/// `None` if no spring is slack.
fn slack(scene: &dyn Scene, at: StateRef<'_>) -> Option<Slack> {
    let n = scene.edges().len();
    let (mut tension, mut strain) = (vec![0.0; n], vec![0.0; n]);
    scene.edge_tension(at, &mut tension, &mut strain);
    // An edge without a spring has no tension, not even 0.
    let of = tension.iter().filter(|tension| !tension.is_nan()).count();
    let strains = tension.iter().zip(&strain).filter(|(tension, strain)| **tension == 0.0 && **strain < -ROUNDING);
    let (count, least) = strains.fold((0, 0.0_f64), |(n, least), (_, strain)| (n + 1, least.min(*strain)));
    (count > 0 && least > -1.0).then(|| Slack { count, of, stretch: (1.0 + ROUNDING) / (1.0 + least) })
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

/// A warning for a step that is too large, with both numbers.
pub fn step_warning(Planned { scene, method, step, .. }: Planned<'_>, limit: CriticalStep) -> Option<Warning> {
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
    (step > limit.step).then(|| {
        let Rates { frequency, damping, .. } = limit.rates;
        let text = format!(
            "the step of {} s is {} the critical step of {name} on this scene, about {} s at the start \
             ({}; set around {}, where w = {} rad/s, damping rate {} 1/s); expect it to diverge: {}",
            figures(step, 4),
            excess(step / limit.step),
            figures(limit.step, 3),
            worth(limit),
            place_of(scene, limit.dof),
            figures(frequency, 4),
            figures(damping, 4),
            remedy(&limit, step)
        );
        Warning::new(WarningCode::StepAboveCritical, text)
    })
}

/// How far a step is above its limit.
fn excess(ratio: f64) -> String {
    if ratio < 1.005 { "just above".to_owned() } else { format!("{} times", figures(ratio, 3)) }
}
