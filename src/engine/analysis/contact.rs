//! The steps that contact allows explicit methods, once gaps are nearly closed.
//!
//! Critical steps are those of a state. What touches there counts with the stiffness that it has; what does not touch
//! yet counts with none. In explicit steps the stiffness of a pair along its normal has a largest value
//! ([`crate::contact::survey`]), so that the step that a closed pair allows can be estimated before anything touches.

use super::limit::critical_step;
use super::rates::Rates;
use super::warnings::Planned;
use crate::format_number::figures;
use crate::integrate::registry::{Family, MethodChoice};
use crate::model::abilities::ContactSurvey;
use crate::scene::Scene;
use crate::warning::{Warning, WarningCode};

/// [-] Share of the step that is advised: gaps of several pairs may be nearly closed at one node.
const ADVISED: f64 = 0.5;

/// [s] The largest stable step of a method on one closed pair of a contact with this rate [1/s^2]; infinite without
/// limit. `n` closed pairs that share a node allow at least this over the root of `n`.
pub fn step_of_pair(method: &MethodChoice, rate: f64) -> f64 {
    critical_step(method, Rates { frequency: rate.sqrt(), ..Rates::default() })
}

/// The contact, by its place among these rates [1/s^2], that allows an explicit method the shortest step, with that
/// step [s]; `None` for another method, and without contact.
pub fn limiting(method: &MethodChoice, rates: impl Iterator<Item = f64>) -> Option<(usize, f64)> {
    let steps = rates.map(|rate| step_of_pair(method, rate)).enumerate();
    let least = steps.min_by(|(_, a), (_, b)| a.total_cmp(b));
    least.filter(|(_, step)| step.is_finite() && method.info.family == Family::Explicit)
}

/// What every contact of a scene is made of, and has at the start; empty without contact.
pub fn surveys(scene: &dyn Scene) -> Vec<ContactSurvey> {
    let start = scene.initial_state();
    scene.touches().map_or_else(Vec::new, |touches| touches.survey(start.as_ref()))
}

/// A warning for a step of an explicit method that is longer than one closed pair of a contact allows.
pub fn contact_warning(planned: Planned<'_>) -> Option<Warning> {
    let Planned { scene, method, step, .. } = planned;
    let step = step?;
    let rates = scene.touches()?.most_rates();
    let (contact, allowed) = limiting(method, rates.into_iter()).filter(|(_, allowed)| step > *allowed)?;
    let text = format!(
        "contact {contact}: the step of {} s is longer than the {} s that {} may take once 60 % of the gap of a pair is \
         closed, by an estimate; such a pair may then be thrown apart: take a step of {} s or smaller, a larger gap, or an \
         implicit method",
        figures(step, 4),
        figures(allowed, 3),
        method.info.name,
        figures(ADVISED * allowed, 2),
    );
    Some(Warning::new(WarningCode::ContactStep, text))
}
