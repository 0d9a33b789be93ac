//! What `check` says before a run: what it costs and what its numbers are worth, and which run is the cheapest within
//! an accuracy. Nothing is written.
//!
//! 1. The case's own run is made, whole or its first part, and the same with longer steps and with other methods
//!    ([`prospects`]). All of it is to cost a fifth of the run, or half a second. If an accuracy or all methods are
//!    asked for, it may cost about as much as the run.
//! 2. What is left of a long implicit run is told from its own steps along a coarse run (`along`). Where less than a
//!    twentieth of the run is affordable, nothing is said of its numbers.
//! 3. A run of which too few steps are affordable is predicted from the cost of a force pass and of a tangent
//!    ([`cost`]), and from single steps (`trials`); nothing is known of its errors then.
//! 4. Where all methods are asked for, each makes a few real steps ([`sample`]) from states along a cheap adaptive run
//!    ([`states`]); what these cost stands for the parts of the run around them ([`estimate`]).
//! 5. Memory is counted ([`memory`]), and what results cost to write ([`output`]).

mod along;
pub mod cost;
pub mod estimate;
pub mod memory;
pub mod nominal;
pub mod output;
pub mod prospects;
pub mod sample;
pub mod states;
mod trials;
pub mod work;

use cost::{ForceCost, TangentCost, force_cost, tangent_cost};
use estimate::Estimate;
use memory::{Baseline, MemorySpec, Needs};
use nominal::{Budget, NominalCosts};
use output::OutputCost;
use prospects::{KnownBy, NoProspects, Prospector, Prospects};
use trials::Trials;
pub use trials::searches;

use crate::StudyError;
use crate::accuracy::Accuracy;
use crate::analysis::critical::CriticalStep;
use crate::case::spec::{Problem, TimeSpec};
use crate::drive::clock::{Step, Tolerance};
use crate::integrate::registry::{Family, MethodChoice};
use crate::output::frame::Fields;
use crate::prepared_case::nominal_pass;
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
    /// accuracy to recommend a run for
    pub accuracy: &'a Accuracy,
    /// whether a row is wanted of every method
    pub all: bool,
    /// what this process held once the scene was built
    pub baseline: Baseline,
    /// [s] processor time from the start of the process to the first step of a run, without solvers
    pub startup: f64,
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
    /// [s] processor time before the first step: reading, meshing, setting up
    pub startup_seconds: f64,
    /// [byte] largest resident memory of the case's own run
    pub memory_bytes: u64,
    /// the case's own run and what is recommended; not given where no run came to a prediction
    #[serde(flatten)]
    pub prospects: Option<Prospects>,
    /// why the case's own run has none
    pub refused: Option<String>,
    /// one row a method; empty unless all are asked for
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub methods: Vec<MethodForecast>,
}

/// The tolerance of adaptive steps for an accuracy: a hundredth of it [m] is always allowed, as with `--tolerance`.
pub fn tolerance_of(accuracy: f64) -> Tolerance {
    Tolerance { relative: accuracy, absolute: accuracy / 100.0 }
}

/// Predicts the case's own run, what to take for the accuracy, and if they are asked for runs of all candidates.
pub fn forecast(spec: &ForecastSpec<'_>) -> Forecast {
    let ForecastSpec { scene, problem, fields, candidates, baseline, .. } = *spec;
    let end = problem.time.end;
    let force = force_cost(scene);
    spec.budget.calibrate(force.pass_seconds / nominal_pass(scene));
    let h = problem.time.step.fixed().unwrap_or(1e-3 * end).min(end);
    let made = tangent_cost(scene, problem.solver, 4.0 / (h * h));
    let (tangent, tangent_refused) = match made {
        Ok(tangent) => (Some(tangent), None),
        Err(why) => (None, Some(why)),
    };
    let output = OutputCost::of(scene, &problem.output, fields, end);
    let startup = spec.startup + tangent.as_ref().map_or(0.0, |tangent| tangent.analysis_seconds);
    let startup_seconds = if problem.method.info.family == Family::Implicit { startup } else { spec.startup };
    let besides = |steps: f64| output.seconds(steps) + startup_seconds;
    let costs = NominalCosts::new(scene, tangent.as_ref());
    let (prospects, mut refused, dear) = match (Prospector { spec, costs, besides: &besides }).prospects() {
        Ok(found) => (Some(found), None, false),
        Err(NoProspects::TooDear) => (None, None, true),
        Err(NoProspects::Fails { why, instead }) => (instead.map(|found| *found), Some(why), false),
    };
    // A run that lands costs nothing after it.
    let landing = prospects.as_ref().and_then(|found| found.landing);
    let to_landing = landing.map(|end| Problem { time: TimeSpec { end, ..problem.time }, ..problem.clone() });
    let spec = &ForecastSpec { problem: to_landing.as_ref().unwrap_or(problem), ..*spec };
    let memory = MemorySpec { scene, baseline, output: &output, tangent: tangent.as_ref() };
    let needs = |candidate: &Candidate, step: Step| Needs {
        family: candidate.method.info.family,
        adaptive: step.fixed().is_none(),
        searches: searches(scene, candidate, step),
    };
    let own = candidates.iter().find(|c| c.method.info.name == problem.method.info.name);
    let memory_bytes = own.map_or(0, |own| memory.predict(needs(own, problem.time.step)));
    let mut trials = (spec.all || dear).then(|| Trials::along(spec, &force, tangent.as_ref()));
    let mut predict = |candidate: &Candidate, step: Step| {
        let trials = trials.as_mut().ok_or_else(|| "not tried".to_owned())?;
        trials.predict(candidate, step).map(|estimate| estimate.with(besides(estimate.steps)))
    };
    let mut prospects = prospects;
    if let (true, Some(own)) = (dear, own) {
        match predict(own, planned(own, problem.time.step, end)) {
            Ok(estimate) => prospects = Some(Prospects::without_errors(spec, costs, KnownBy::Counts, estimate)),
            Err(why) => refused = Some(why),
        }
    }
    let row = |candidate: &Candidate| {
        let step = planned(candidate, problem.time.step, end);
        let same = |found: &&Prospects| refused.is_none() && found.is_of(candidate, step);
        let (run, refused) = match prospects.as_ref().filter(same) {
            Some(found) => (Some(found.this_case.estimate), None),
            None => match predict(candidate, step) {
                Ok(estimate) => (Some(estimate), None),
                Err(why) => (None, Some(why)),
            },
        };
        MethodForecast {
            method: candidate.method.info.name,
            order: candidate.method.order(),
            critical_step: candidate.limit.map(|limit| limit.step).filter(|step| step.is_finite()),
            step: step.fixed(),
            step_reduced: step.fixed().zip(problem.time.step.fixed()).is_some_and(|(own, asked)| own < asked.min(end)),
            tolerance: step.tolerance().map(|tolerance| tolerance.relative),
            memory_bytes: memory.predict(needs(candidate, step)),
            run,
            refused,
        }
    };
    let methods = if spec.all { candidates.iter().map(row).collect() } else { Vec::new() };
    Forecast { force, tangent, tangent_refused, output, startup_seconds, memory_bytes, prospects, refused, methods }
}

/// The answer of a forecast: what the case's own run costs and is worth, and what is recommended. `stable` says whether
/// its step is.
///
/// # Errors
/// What the template engine refuses.
pub fn describe_answer(
    problem: &Problem,
    scene: &dyn Scene,
    forecast: &Forecast,
    accuracy: &Accuracy,
    stable: &str,
) -> Result<String, StudyError> {
    let scaled_masses = scene.added_mass().is_some();
    let lines =
        forecast.prospects.as_ref().map(|found| found.lines(forecast.refused.is_none(), &problem.time, accuracy));
    let own = problem.method.info.name;
    let context = context! { forecast, own, lines, stable, scaled_masses };
    render("check_answer.txt", include_str!("../templates/check_answer.txt"), &context)
}

/// The tables of a forecast: costs of force passes and tangents, and runs of all methods.
///
/// # Errors
/// What the template engine refuses.
pub fn describe(problem: &Problem, forecast: &Forecast) -> Result<String, StudyError> {
    let info = problem.method.info;
    let landing = forecast.prospects.as_ref().and_then(|found| found.landing);
    let (own, implicit, end) = (info.name, info.family == Family::Implicit, landing.unwrap_or(problem.time.end));
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
