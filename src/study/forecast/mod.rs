//! Forecast of the cost of runs from short trials, and of the step that an accuracy needs. Nothing is written.
//!
//! 1. A cheap adaptive run, limited to a fraction of a second, gives states along the whole run ([`states`]).
//! 2. Every method makes a few real steps from these states ([`sample`]), because the number of Newton iterations and
//!    of rejected steps is not known otherwise. Adaptive steps are first made from the start ([`beginning`]).
//! 3. What these steps cost stands for the parts of the run around them ([`estimate`]); memory is counted ([`memory`]).
//!    A forecast is marked doubtful if the step size differs much between these parts.
//! 4. The accuracy of a step is measured: runs with coarse steps are compared with a reference, as far as is affordable
//!    ([`coarse_reference`]). From them follows the longest step for an accuracy ([`search`]).
//! 5. Methods are ranked by the nominal cost of their work ([`advice`], [`units`]). If no reference is affordable, an
//!    implicit run is compared with one of twice its step (`step_doubling`).

pub mod advice;
pub mod coarse_reference;
pub mod cost;
pub mod estimate;
pub mod memory;
pub mod nominal;
pub mod output;
pub mod sample;
pub mod search;
pub mod states;
mod step_doubling;
mod trials;
pub mod work;

use advice::{Advice, Adviser};
use cost::{ForceCost, TangentCost, force_cost, tangent_cost};
use estimate::Estimate;
use memory::{Baseline, MemorySpec, Needs};
use nominal::Budget;
use output::OutputCost;
use trials::Trials;

use crate::StudyError;
use crate::analysis::critical::CriticalStep;
use crate::case::spec::Problem;
use crate::drive::clock::{Step, Tolerance};
use crate::integrate::registry::{Family, MethodChoice};
use crate::output::frame::Fields;
use crate::scene::Scene;
use crate::template::render;
use minijinja::context;

/// A method that may run, and what is known of its largest stable step.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// the method
    pub method: MethodChoice,
    /// its limit; `None` where it is not known
    pub limit: Option<CriticalStep>,
}

/// What is to be predicted.
#[derive(Clone, Copy)]
pub struct ForecastSpec<'a> {
    /// the scene, built for one thread
    pub scene: &'a dyn Scene,
    /// the case
    pub problem: &'a Problem,
    /// fields of its frames
    pub fields: Fields,
    /// the methods, in the order of the rows
    pub candidates: &'a [Candidate],
    /// [-] accuracy to advise for, relative to the motion, in (0, 1)
    pub accuracy: f64,
    /// what this process held once the scene was built
    pub baseline: Baseline,
    /// what trials may cost
    pub budget: &'a Budget,
}

/// One method's prospects.
#[derive(Clone, Debug, serde::Serialize)]
pub struct MethodForecast {
    /// name in a case
    pub method: &'static str,
    /// [-] order of accuracy
    pub order: u32,
    /// [s] largest stable step at the start; null without limit or where it is not known
    pub critical_step: Option<f64>,
    /// [s] the fixed step it would run with; null for adaptive steps
    pub step: Option<f64>,
    /// whether that is smaller than the case's step, which is not stable
    pub step_reduced: bool,
    /// [-] relative tolerance it would run with; null for fixed steps
    pub tolerance: Option<f64>,
    /// [byte] largest resident memory of the run
    pub memory_bytes: u64,
    /// the run as the case asks for it; null where it fails
    pub run: Option<Estimate>,
    /// why there is no such run
    pub refused: Option<String>,
    /// [s] fixed step for the wanted accuracy; null where it was not looked for to its end, because another method of
    /// the family is clearly cheaper
    pub accuracy_step: Option<f64>,
    /// the run with that step
    pub at_accuracy: Option<Estimate>,
}

/// What runs of a scene would cost.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Forecast {
    /// one force pass
    pub force: ForceCost,
    /// one tangent; null where it cannot be made
    pub tangent: Option<TangentCost>,
    /// why it cannot
    pub tangent_refused: Option<String>,
    /// what writing results costs
    pub output: OutputCost,
    /// [-] part of the run that the trials saw
    pub seen: f64,
    /// one row a method
    pub methods: Vec<MethodForecast>,
    /// what to take for the wanted accuracy; null where no method came to a prediction
    pub advice: Option<Advice>,
}

/// The tolerance of adaptive steps for an accuracy: a hundredth of it [m] is always allowed, as with `--tolerance`.
pub fn tolerance_of(accuracy: f64) -> Tolerance {
    Tolerance { relative: accuracy, absolute: accuracy / 100.0 }
}

/// Predicts runs of all candidates.
pub fn forecast(spec: &ForecastSpec<'_>) -> Forecast {
    let ForecastSpec { scene, problem, fields, candidates, baseline, .. } = *spec;
    let end = problem.time.end;
    let force = force_cost(scene);
    let h = problem.time.step.fixed().unwrap_or(1e-3 * end).min(end);
    let made = tangent_cost(scene, problem.solver, 4.0 / (h * h));
    let (tangent, tangent_refused) = match made {
        Ok(tangent) => (Some(tangent), None),
        Err(why) => (None, Some(why)),
    };
    let output = OutputCost::of(scene, &problem.output, fields, end);
    let mut trials = Trials::along(spec, &force, tangent.as_ref());
    let memory = MemorySpec { scene, baseline, output: &output, tangent: tangent.as_ref() };
    // The case's own run first: what it is to cost is asked above all.
    let own = candidates.iter().position(|c| c.method.info.name == problem.method.info.name);
    let mut known =
        own.map(|own| (own, trials.predict(&candidates[own], planned(&candidates[own], problem.time.step, end))));
    let rows = candidates.iter().enumerate().map(|(place, candidate)| {
        let step = planned(candidate, problem.time.step, end);
        let known = known.take_if(|(own, _)| *own == place).map(|(_, known)| known);
        let (run, refused) = match known.unwrap_or_else(|| trials.predict(candidate, step)) {
            Ok(estimate) => (Some(estimate.with_output(output.seconds(estimate.steps))), None),
            Err(why) => (None, Some(why)),
        };
        let needs = Needs {
            family: candidate.method.info.family,
            adaptive: step.fixed().is_none(),
            searches: trials.searches(candidate, step),
        };
        MethodForecast {
            method: candidate.method.info.name,
            order: candidate.method.order(),
            critical_step: candidate.limit.map(|limit| limit.step).filter(|step| step.is_finite()),
            step: step.fixed(),
            step_reduced: step.fixed().zip(problem.time.step.fixed()).is_some_and(|(own, asked)| own < asked.min(end)),
            tolerance: step.tolerance().map(|tolerance| tolerance.relative),
            memory_bytes: memory.predict(needs),
            run,
            refused,
            accuracy_step: None,
            at_accuracy: None,
        }
    });
    let mut methods: Vec<MethodForecast> = rows.collect();
    let adviser = Adviser::new(spec, tangent.as_ref());
    let offers = adviser.offers(&mut trials);
    let whole = adviser.sees_all();
    let mut complete = |candidate: &Candidate, step: Step, known: Option<Estimate>| {
        // A part of the run, its beginning above all, may cost more a step than the rest.
        let predicted = known.filter(|_| whole).or_else(|| trials.predict(candidate, step).ok());
        let estimate = predicted.or(known)?;
        Some(estimate.with_output(output.seconds(estimate.steps)))
    };
    for (candidate, found) in &offers {
        if let Some(row) = methods.iter_mut().find(|row| row.method == candidate.method.info.name) {
            row.accuracy_step = Some(found.step);
            row.at_accuracy = complete(candidate, Step::Fixed(found.step), found.run);
        }
    }
    let mut advice = adviser.advise(&offers, &mut complete);
    if let Some(advice) = &mut advice {
        // A run that fails, or would with the step that is asked for, is no cheaper one.
        let own = methods.iter().find(|row| row.method == problem.method.info.name);
        let made = own.is_some_and(|row| row.run.is_some() && !row.step_reduced);
        advice.own_cheaper = advice.own_cheaper.filter(|_| made);
    }
    let seen = trials.seen();
    Forecast { force, tangent, tangent_refused, output, seen, methods, advice }
}

/// The answer of a forecast: what is recommended, and what the case's own run costs. `stable` says whether its step is.
///
/// # Errors
/// What the template engine refuses.
pub fn describe_answer(
    problem: &Problem,
    scene: &dyn Scene,
    forecast: &Forecast,
    stable: &str,
) -> Result<String, StudyError> {
    let scaled_masses = scene.added_mass().is_some();
    let context = context! { forecast, own => problem.method.info.name, stable, scaled_masses };
    render("check_answer.txt", include_str!("../templates/check_answer.txt"), &context)
}

/// The tables of a forecast: costs of force passes and tangents, and runs of all methods.
///
/// # Errors
/// What the template engine refuses.
pub fn describe(problem: &Problem, forecast: &Forecast) -> Result<String, StudyError> {
    let info = problem.method.info;
    let (own, implicit, end) = (info.name, info.family == Family::Implicit, problem.time.end);
    let context = context! { forecast, own, implicit, end };
    render("check.txt", include_str!("../templates/check.txt"), &context)
}

/// The step a method would run with: the case's, or what is stable; a method that has no stable step at all keeps the
/// case's.
fn planned(candidate: &Candidate, step: Step, end: f64) -> Step {
    let Step::Fixed(asked) = step else { return step };
    let asked = asked.min(end);
    match candidate.limit {
        Some(limit) if limit.step > 0.0 && asked > limit.step => Step::Fixed(limit.safe()),
        _ => Step::Fixed(asked),
    }
}
