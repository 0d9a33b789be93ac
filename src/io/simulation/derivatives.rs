//! Derivatives of the state of a simulation, with respect to numbers that its scene is built from.

use super::{Simulation, SimulationError, StepInfo, StopAt};
use crate::drive::observer::Observer;
use crate::drive::{Changed, Run, RunError, RunState, Status, StepEnd};
use crate::integrate::stepper::Stepper;
use crate::interrupt;
use crate::model::stop::Stop;
use crate::scene::Scene;
use crate::sensitivity::{Parameter, SensitivityError, StepEnds, TangentRun, Varied};

/// Derivatives of the positions \[m\] and the velocities \[m/s\] of the nodes, each `[n_nodes][3]`, over the unit of a
/// parameter.
pub type StateDerivative = [Vec<[f64; 3]>; 2];

const CHANGES: &str = "what a program changes on the way has no derivative by numbers of the case";

impl Simulation {
    /// Goes along with the derivatives of the state by some parameters, from the start on. Each step then costs the
    /// tangents, and each parameter four force passes and a solve a stage.
    ///
    /// # Errors
    /// A simulation that has made steps, whose steps are not of one size, or whose method has no derivative.
    pub fn follow_derivatives(&mut self, parameters: Vec<Varied>) -> Result<(), SimulationError> {
        let refused = |why: &str| Err(SimulationError::Derivatives { why: why.to_owned() });
        let fixed = self.spec.step.fixed().filter(|_| !self.spec.free_steps);
        let Some(h) = fixed else { return refused("they need steps of one size (time.step)") };
        if self.state.steps > 0 || self.resumed {
            return refused("they begin with the simulation");
        }
        if self.changed != Changed::Nothing {
            return refused(CHANGES);
        }
        let scene = self.scene.clone();
        if scene.touches().is_some() {
            return Err(SensitivityError::Contact.into());
        }
        let form = self.at_work(Stop::NEVER, |_, stepper| Ok(stepper.form(h)))?;
        let method = self.spec.method.info.name;
        let known = || SensitivityError::Method { method, known: crate::integrate::registry::with_form() };
        let form = form.ok_or_else(known)?;
        let from = &self.state.from;
        let made = parameters.into_iter().map(|varied| Parameter::new(&*scene, &from.state, varied, Some(h)));
        let parameters = made.collect::<Result<Vec<_>, _>>()?;
        self.tangent = Some(TangentRun::start(&*scene, parameters, from, &form)?);
        Ok(())
    }

    /// The derivatives of the state by each parameter that is [followed](Simulation::follow_derivatives), by name.
    pub fn derivatives(&self) -> Vec<(&str, StateDerivative)> {
        let Some(tangent) = &self.tangent else { return Vec::new() };
        let of = |number: usize| {
            let [x, v] = tangent.derivative(number)?;
            let mut made = [(); 2].map(|()| vec![[0.0; 3]; self.scene.reference().len()]);
            let [positions, velocities] = &mut made;
            // The way from degrees of freedom to nodes is linear.
            let at = crate::model::state::StateRef { t: self.time(), x, v };
            self.scene.trace(at, positions, velocities);
            Some((tangent.parameter(number)?.name.as_str(), made))
        };
        (0..tangent.parameters()).filter_map(of).collect()
    }

    /// Makes steps one by one, with the derivatives along.
    pub(super) fn make_followed_steps(
        &mut self,
        mut tangent: TangentRun,
        until: StopAt,
        observers: &mut [&mut dyn Observer],
        pause: &mut dyn FnMut() -> bool,
    ) -> Result<StepInfo, SimulationError> {
        let scene = self.scene.clone();
        let mut fault = None;
        let mut followed = || -> Result<StepInfo, SimulationError> {
            while !until.reached(self.state.steps, self.state.from.state.t) {
                if self.changed != Changed::Nothing {
                    return Err(SimulationError::Derivatives { why: CHANGES.to_owned() });
                }
                let made = self.at_work(Stop::NEVER, |run, stepper| {
                    followed_step(run, (stepper, &mut tangent, &*scene), observers, &mut fault)
                })?;
                match (made, fault.take()) {
                    (_, Some(fault)) => return Err(fault),
                    (None, _) => return Err(SimulationError::Ended { t: self.time() }),
                    (Some(StepEnd::Accepted), _) => {}
                    (Some(_), _) => return Err(self.failed()),
                }
                if pause() || interrupt::asked() {
                    break;
                }
            }
            Ok(self.info())
        };
        let done = followed();
        // Beyond what they do not go over they would be wrong.
        let lost = matches!(done, Err(SimulationError::Derivatives { .. } | SimulationError::Sensitivity(_)));
        self.tangent = Some(tangent).filter(|_| !lost);
        done
    }
}

/// Makes a step with the derivatives along; `None` at the end. What has no derivative is told in `fault`, before the
/// step is accepted.
fn followed_step(
    run: &mut Run<'_>,
    (stepper, tangent, scene): (&mut Stepper<'_>, &mut TangentRun, &dyn Scene),
    observers: &mut [&mut dyn Observer],
    fault: &mut Option<SimulationError>,
) -> Result<Option<StepEnd>, RunError> {
    let Some(tick) = run.next() else { return Ok(None) };
    if !run.spec.keep_going {
        run.state.failure = None;
    }
    let report = match run.fixed_step(stepper, tick) {
        Ok(report) => report,
        Err(status) => return Ok(Some(StepEnd::Failed(status))),
    };
    let (passed, fired) = (run.state.passed(), run.state.fired().len());
    let form = stepper.form(tick.h).unwrap_or_default();
    let ends = StepEnds { form: &form, h: tick.h, from: &run.state.from, to: &run.state.to };
    if let Err(error) = tangent.step(scene, stepper, ends) {
        *fault = Some(error.into());
        return Ok(Some(StepEnd::Failed(Status::Diverged)));
    }
    let end = run.accept_watched(stepper, &report, observers)?;
    if end != StepEnd::Accepted || (run.state.passed() == passed && run.state.fired().len() == fired) {
        return Ok(Some(end));
    }
    if let Some(why) = event_without_derivative(scene, run.state, (passed, fired)) {
        *fault = Some(SimulationError::Derivatives { why });
    } else if run.state.passed() != passed
        && let Err(error) = tangent.restart(scene, (run.state.passed(), &run.state.from), &form)
    {
        *fault = Some(error.into());
    }
    Ok(Some(end))
}

/// What has happened in the last step that no derivative goes over: an event that waits for a state, whose time moves
/// with the numbers, or a support that gets another velocity. `passed` and `fired` are how many events there were
/// before the step.
pub fn event_without_derivative(
    scene: &dyn Scene,
    state: &RunState,
    (passed, fired): (usize, usize),
) -> Option<String> {
    let named = scene.events().map_or(&[][..], |events| events.named());
    let acts = |number: usize| named.get(number).is_some_and(|event| event.acts());
    if let Some(event) = state.fired().iter().skip(fired).find(|event| acts(event.event)) {
        return Some(format!("at t = {} s the event \"{}\" happens", event.t, event.name));
    }
    let moves = state.passed() != passed && !scene.moved().is_empty();
    moves.then(|| format!("at t = {} s a support gets another velocity", state.from.state.t))
}
