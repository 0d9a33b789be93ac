//! A run with its tangent-linear run beside it.

use super::error::GradientError;
use crate::case::Problem;
use crate::drive::{Explain, Run, RunSpec, RunState, Status, StepEnd};
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::{MethodInfo, methods};
use crate::integrate::stepper::{Scheme, Stepper};
use crate::model::point::Point;
use crate::model::stop::Stop;
use crate::output::gauges::GaugesSpec;
use crate::output::gauges::derivatives::{GaugeDerivatives, QuantityDerivatives};
use crate::scene::Scene;
use crate::sensitivity::{Parameter, SensitivityError, StepEnds, Switches, TangentRun};

/// What such a run finds.
pub(super) struct Followed {
    pub quantities: Vec<QuantityDerivatives>,
    /// of each parameter
    pub switches: Vec<Switches>,
    pub steps: u64,
    pub run_factorizations: u64,
    pub factorizations: u64,
}

/// A parameter by its name, its scenes and its step.
pub(super) type Varied = (String, [Box<dyn Scene>; 4], f64);

/// The names of all methods whose steps have a derivative.
fn with_derivative() -> String {
    let has = |info: &MethodInfo| {
        let defaults: Vec<f64> = info.parameters.iter().map(|p| p.default).collect();
        match (info.build)(&defaults, SolverSpec::default()) {
            Scheme::Explicit(scheme) => scheme.form(1.0, true).is_some(),
            Scheme::Implicit(scheme) => scheme.form(1.0, true).is_some(),
            Scheme::Graph(scheme) => scheme.form(1.0, true).is_some(),
        }
    };
    methods().iter().filter(|info| has(info)).map(|info| info.name).collect::<Vec<_>>().join(", ")
}

/// Makes the run of a problem on its scene, and finds its quantities and their derivatives by some parameters.
pub(super) fn follow(
    problem: &Problem,
    scene: &dyn Scene,
    varied: Vec<Varied>,
    interrupt: Stop<'_>,
) -> Result<Followed, GradientError> {
    let spec = RunSpec { explain: Explain::Nothing, ..problem.run_spec() };
    let Some(step) = spec.step.fixed() else {
        let what = "time.tolerance gives steps whose sizes depend on the motion".to_owned();
        return Err(GradientError::Without { what, advice: "give time.step, or --step" });
    };
    if problem.time.until_rest.is_some() {
        let what = "time.until_rest ends the run by the motion".to_owned();
        return Err(GradientError::Without { what, advice: "leave it out, and give time.end" });
    }
    let mut stepper = Stepper::bind(problem.method.scheme(problem.solver), scene.interfaces())?;
    let mut state = RunState::start(scene, &mut stepper, &spec, scene.initial_state())?;
    let gauges = GaugesSpec::of(&problem.output, spec.end);
    let mut quantities = GaugeDerivatives::new(scene, &gauges, varied.len())?;
    let method = problem.method.info.name;
    let unknown = || SensitivityError::Method { method, known: with_derivative() };
    let parameter = |(name, scenes, h)| Parameter::new(name, scene, &state.from.state, (scenes, h), Some(step));
    let parameters: Vec<Parameter> = varied.into_iter().map(parameter).collect::<Result<_, _>>()?;
    let first = stepper.form(step).ok_or_else(unknown)?;
    let mut tangent = TangentRun::start(scene, parameters, &state.from, &first)?;
    quantities.measure(scene, 0, &state.from);
    note(&mut tangent, &mut quantities, &state.from);
    loop {
        let mut run = Run { scene, spec: &spec, stop: Stop::NEVER, interrupt, state: &mut state };
        let Some(tick) = run.next() else { break };
        if interrupt.asked() {
            return Err(GradientError::Interrupted);
        }
        let form = stepper.form(tick.h).ok_or_else(unknown)?;
        let report = match run.fixed_step(&mut stepper, tick) {
            Ok(report) => report,
            Err(status) => return Err(failed(&state, status)),
        };
        let ends = StepEnds { form: &form, h: tick.h, from: &run.state.from, to: &run.state.to };
        tangent.step(&stepper, ends)?;
        // Before events of the end of this step happen.
        let (number, times) = (run.state.steps + 1, [run.state.from.state.t, tick.t]);
        if quantities.wants(number, times) {
            quantities.measure(scene, number, &run.state.to);
            note(&mut tangent, &mut quantities, &run.state.to);
        }
        let before = [run.state.passed(), run.state.fired().len()];
        match run.accept_fixed(&mut stepper, &report)? {
            StepEnd::Accepted => {}
            StepEnd::Failed(status) => return Err(failed(&state, status)),
            StepEnd::TakenBack | StepEnd::Stopped => return Err(GradientError::Interrupted),
        }
        pass_events(scene, (&mut tangent, &mut stepper), &state, (before, step))?;
    }
    if quantities.measure_last(scene, &state.from) {
        note(&mut tangent, &mut quantities, &state.from);
    }
    let switches = (0..tangent.parameters()).filter_map(|number| tangent.parameter(number)).map(|of| of.switches);
    Ok(Followed {
        quantities: quantities.results(),
        switches: switches.collect(),
        steps: state.steps,
        run_factorizations: state.counters.factorizations,
        factorizations: tangent.factorizations(),
    })
}

/// Measures along the derivatives of the state that was measured last.
fn note(tangent: &mut TangentRun<'_>, quantities: &mut GaugeDerivatives, at: &Point) {
    for number in 0..tangent.parameters() {
        tangent.along(number, at.state.as_ref(), |place, scene, at| quantities.measure_at(place, scene, at));
        let h = tangent.parameter(number).map_or(1.0, Parameter::h);
        quantities.note(number, h);
    }
}

/// Follows the run over events at given times. `before` are the numbers of events that were passed and that had
/// happened before this step, `h` \[s\] the next step.
fn pass_events(
    scene: &dyn Scene,
    (tangent, stepper): (&mut TangentRun<'_>, &mut Stepper<'_>),
    state: &RunState,
    ([passed, fired], h): ([usize; 2], f64),
) -> Result<(), GradientError> {
    let acts = |number: usize| scene.events().is_some_and(|of| of.named().get(number).is_some_and(|of| of.acts()));
    if let Some(event) = state.fired().iter().skip(fired).find(|event| acts(event.event)) {
        let what = format!("at t = {} s the event \"{}\" happens", event.t, event.name);
        return Err(GradientError::Without { what, advice: "end the run before it, with --end" });
    }
    if state.passed() == passed {
        return Ok(());
    }
    if !scene.moved().is_empty() {
        let what = format!("at t = {} s a support gets another velocity", state.from.state.t);
        return Err(GradientError::Without { what, advice: "end the run before it, with --end" });
    }
    let form = stepper.form(h).unwrap_or_default();
    Ok(tangent.restart(state.passed(), &state.from, &form)?)
}

fn failed(state: &RunState, status: Status) -> GradientError {
    if status == Status::Interrupted {
        return GradientError::Interrupted;
    }
    let why =
        state.failure.as_ref().map_or_else(|| "a step cannot be made".to_owned(), |failure| failure.cause.clone());
    GradientError::Failed { t: state.from.state.t, why }
}
