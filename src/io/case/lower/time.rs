//! The time, solver and study sections. The study section is checked with the rest, so that a study does not fail after
//! its first hour.

use super::events::Plan;
use crate::case::diagnostics::{Faults, did_you_mean, one_of};
use crate::case::pointer::Pointer;
use crate::case::schema::{MassScaling, Method, Solver, Study, System, Time, UntilRest};
use crate::case::spec::TimeSpec;
use crate::drive::at_rest::RestSpec;
use crate::drive::clock::Step;
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::{Family, MethodChoice, MethodError, methods};
use crate::model::quantity::QuantityName;
use crate::solve::newton::NewtonSpec;
use crate::warning::WarningCode;

/// [-] Largest number of steps of a run: with more steps, a step is below the rounding of the end time.
const MOST_STEPS: f64 = 1e15;

/// [s] Shortest step and latest end: schemes use squares of a step and their inverses, whose products with masses and
/// accelerations must be finite.
const TIMES: [f64; 2] = [1e-120, 1e120];

/// Method and times of a run.
#[derive(Debug)]
pub(super) struct Timing {
    /// the method
    pub method: MethodChoice,
    /// end and step
    pub spec: TimeSpec,
    /// [s] step for which masses are scaled
    pub mass_scaling: Option<f64>,
}

/// Checks the `time` section.
pub(super) fn time(time: &Time, system: &System, faults: &mut Faults<'_>) -> Option<Timing> {
    let at = Pointer::root().key("time");
    let end = in_range(&at.key("end"), time.end, faults).then_some(time.end);
    let method = method(&at.key("method"), &time.method, faults);
    if let (Some(choice), System::Pendulum(_)) = (&method, system)
        && choice.info.family == Family::MatrixFree
    {
        let hint = "it goes along the springs of a network; take another method for a pendulum";
        faults.add_hint(&at.key("method"), "a method that needs no network", hint);
    }
    let step = match step(&at, time, faults)? {
        Step::Fixed(step) => fixed(&at.key("step"), step, end?, faults)?,
        adaptive @ Step::Adaptive(_) => adaptive,
    };
    let until_rest = time.until_rest.map(|rest| until_rest(rest, end));
    if let (Some(_), System::Pendulum(_)) = (&time.until, system) {
        faults.add(&at.key("until"), "only with a network");
    }
    if let (Some(_), System::Network(network)) = (&until_rest, system)
        && Plan::of(&at, network, None).waits()
    {
        let hint = "a scene at rest does not tell whether an event is still to come; leave until_rest out";
        faults.add_hint(&at.key("until_rest"), "not together with events by state (\"when\")", hint);
    }
    let mass_scaling = time.mass_scaling.and_then(|given| mass_scaling(&at, given, method.as_ref(), system, faults));
    Some(Timing {
        mass_scaling,
        method: method?,
        spec: TimeSpec { end: end?, step, until_rest: until_rest.flatten(), to_ground: time.until.is_some() },
    })
}

/// [s] The step for which masses are scaled.
fn mass_scaling(
    at: &Pointer,
    given: MassScaling,
    method: Option<&MethodChoice>,
    system: &System,
    faults: &mut Faults<'_>,
) -> Option<f64> {
    let at = at.key("mass_scaling");
    if let Some(method) = method.filter(|method| method.info.family != Family::Explicit) {
        let hint =
            "only explicit steps are limited by the lightest nodes; leave mass_scaling out, or take an explicit method";
        let value = format!("mass scaling with {}", method.info.name);
        faults.add_value(&at, value, "only with explicit methods", Some(hint.to_owned()));
    }
    if let System::Pendulum(_) = system {
        faults.add_value(&at, "mass scaling of a pendulum", "only with a network", None);
    }
    let step = at.key("step");
    in_range(&step, given.step, faults).then_some(given.step)
}

/// [-] Looks of a run at whether its scene is at rest, if the case does not say how often.
const LOOKS: f64 = 100.0;

fn until_rest(rest: UntilRest, end: Option<f64>) -> Option<RestSpec> {
    let every = rest.every.or(end.map(|end| end / LOOKS))?;
    Some(RestSpec { speed: rest.speed, every })
}

/// A fixed step, checked with the end of the run.
fn fixed(at: &Pointer, step: f64, end: f64, faults: &mut Faults<'_>) -> Option<Step> {
    if end / step > MOST_STEPS {
        let least = format!("at least {:e}, which makes {MOST_STEPS:e} steps until the end", end / MOST_STEPS);
        faults.add(at, least);
        return None;
    }
    // A step longer than the run is cut to it, whatever its size.
    if step <= end && !in_range(at, step, faults) {
        return None;
    }
    if step > end {
        let text = format!("/time/step: {step:e} s is longer than the run, so there is one step of {end:e} s");
        faults.warn(WarningCode::StepBeyondEnd, text);
    }
    Some(Step::Fixed(step))
}

/// Adds a fault unless `t` [s] is a time that schemes can compute with.
fn in_range(at: &Pointer, t: f64, faults: &mut Faults<'_>) -> bool {
    let [least, most] = TIMES;
    let good = (least..=most).contains(&t) && !faults.unread(at);
    if !good {
        faults.add(at, format!("{least:e} to {most:e} seconds, whose squares are within the range of a double"));
    }
    good
}

fn step(at: &Pointer, time: &Time, faults: &mut Faults<'_>) -> Option<Step> {
    match (time.step, time.tolerance) {
        (Some(step), None) => (!faults.unread(&at.key("step"))).then_some(Step::Fixed(step)),
        (Some(_), Some(_)) => {
            faults.add_hint(&at.key("tolerance"), "not together with step", "remove time.step for adaptive steps");
            None
        }
        (None, Some(given)) => Some(Step::Adaptive(given)),
        (None, None) => {
            let hint = "give the fixed step in seconds: \"step\": 1e-3, or adaptive steps: \"tolerance\": {\"relative\": 1e-4, \
                        \"absolute\": 1e-6}";
            faults.add_hint(&at.key("step"), "a number above 0", hint);
            None
        }
    }
}

/// Looks a method up and checks its parameters; the pointer leads to the name or the parameter at fault.
fn method(at: &Pointer, method: &Method, faults: &mut Faults<'_>) -> Option<MethodChoice> {
    let error = match MethodChoice::new(&method.name, &method.parameters) {
        Ok(choice) => return Some(choice),
        Err(error) => error,
    };
    match error {
        MethodError::Unknown { name, .. } => {
            let names: Vec<&str> = methods().iter().map(|m| m.name).collect();
            let hint = did_you_mean(&name, names.iter().copied()).unwrap_or_default();
            let key = at.key(&name);
            if faults.is_there(&key) {
                faults.add_key(&key, one_of("known names here", &names), hint);
            } else {
                faults.add_hint(at, one_of("known names here", &names), hint);
            }
        }
        MethodError::UnknownParameter { method, name, known } => {
            let of_method = methods().iter().filter(|m| m.name == method);
            let names = of_method.flat_map(|m| m.parameters.iter().map(|p| p.name));
            let hint = did_you_mean(&name, names).unwrap_or_default();
            faults.add_key(&at.key(method).key(&name), format!("parameters of {method}: {known}"), hint);
        }
        MethodError::OutOfRange { method, name, allowed, .. } => {
            faults.add(&at.key(method).key(name), allowed);
        }
    }
    None
}

/// Fills in the defaults of the `solver` section.
pub(super) fn solver(solver: Option<&Solver>) -> SolverSpec {
    let section = solver.cloned().unwrap_or_default();
    let given = section.newton.unwrap_or_default();
    let default = NewtonSpec::default();
    let newton = NewtonSpec {
        relative: given.relative.unwrap_or(default.relative),
        max_iterations: given.max_iterations.unwrap_or(default.max_iterations),
        strategy: given.strategy,
    };
    SolverSpec { newton, linear: section.linear }
}

/// Checks the methods of the `study` section, and reads the names of its quantities, each kept once.
pub(super) fn study(study: Option<&Study>, faults: &mut Faults<'_>) -> Vec<QuantityName> {
    let at = Pointer::root().key("study");
    for (i, choice) in study.and_then(|study| study.methods.as_ref()).into_iter().flatten().enumerate() {
        method(&at.key("methods").index(i), choice, faults);
    }
    let mut once: Vec<QuantityName> = Vec::new();
    for (i, text) in study.and_then(|study| study.quantities.as_ref()).into_iter().flatten().enumerate() {
        match text.parse::<QuantityName>() {
            Ok(name) if !once.contains(&name) => once.push(name),
            Ok(_) => {}
            Err(_) => {
                let at = at.key("quantities").index(i);
                let hint = "such as \"riser.tension.peak\", \"tip.z@0.5\", \"opening_load\" or \"motion\"";
                faults.add_hint(
                    &at,
                    "GAUGE.COLUMN.STATISTIC, GAUGE.COLUMN@TIME or the name of a number of the report",
                    hint,
                );
            }
        }
    }
    once
}
