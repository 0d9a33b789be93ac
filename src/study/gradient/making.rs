//! A run in fixed steps, with what goes along with it.

use super::error::GradientError;
use crate::case::Problem;
use crate::drive::snapshot::Snapshot;
use crate::drive::{Explain, Run, RunSpec, RunState, Status, StepEnd};
use crate::integrate::form::StepForm;
use crate::integrate::registry::with_form;
use crate::integrate::stepper::Stepper;
use crate::model::point::Point;
use crate::model::stop::Stop;
use crate::scene::Scene;
use crate::sensitivity::{SensitivityError, StepEnds};
use crate::simulation::event_without_derivative;

/// What was made of a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Made {
    /// number of the step, or steps so far
    pub step: u64,
    /// events that are passed
    pub passed: usize,
}

/// What goes along with a run.
pub(super) trait Along {
    /// A step that was attempted, and is accepted after this: before events of its end happen.
    fn step(&mut self, stepper: &Stepper<'_>, ends: StepEnds<'_>, made: Made) -> Result<(), GradientError>;

    /// Events at the end of a step, `from`, after which the scheme has started again with steps of this form.
    fn event(&mut self, from: &Point, form: StepForm, made: Made) -> Result<(), GradientError>;
}

/// A run in fixed steps.
pub(super) struct Making<'a> {
    pub scene: &'a dyn Scene,
    pub stepper: Stepper<'a>,
    pub state: RunState,
    spec: RunSpec,
    /// [s] step
    pub h: f64,
    interrupt: Stop<'a>,
}

impl<'a> Making<'a> {
    /// Before its first step.
    pub(super) fn start(problem: &Problem, scene: &'a dyn Scene, interrupt: Stop<'a>) -> Result<Self, GradientError> {
        let spec = RunSpec { explain: Explain::Nothing, ..problem.run_spec() };
        let Some(h) = spec.step.fixed() else {
            let what = "time.tolerance gives steps whose sizes depend on the motion".to_owned();
            return Err(GradientError::Without { what, advice: "give time.step, or --step" });
        };
        if problem.time.until_rest.is_some() {
            let what = "time.until_rest ends the run by the motion".to_owned();
            return Err(GradientError::Without { what, advice: "leave it out, and give time.end" });
        }
        let mut stepper = Stepper::bind(problem.method.scheme(problem.solver), scene.interfaces())?;
        let state = RunState::start(scene, &mut stepper, &spec, scene.initial_state())?;
        Ok(Making { scene, stepper, state, spec, h, interrupt })
    }

    /// The form of a step of `h` [s].
    pub(super) fn form(&self, h: f64) -> Result<StepForm, GradientError> {
        if self.scene.touches().is_some() {
            return Err(SensitivityError::Contact.into());
        }
        let method = self.spec.method.info.name;
        Ok(self.stepper.form(h).ok_or_else(|| SensitivityError::Method { method, known: with_form() })?)
    }

    /// A snapshot of the run as it is.
    pub(super) fn snapshot(&self) -> Snapshot {
        self.state.snapshot(&self.stepper)
    }

    /// Goes back to a snapshot.
    pub(super) fn resume(&mut self, snapshot: Snapshot) -> Result<(), GradientError> {
        self.state = RunState::restore(self.scene, &mut self.stepper, &self.spec, snapshot)?;
        Ok(())
    }

    /// Makes steps until there are `until` of them, or the run is over.
    pub(super) fn to(&mut self, until: u64, along: &mut dyn Along) -> Result<(), GradientError> {
        while self.state.steps < until {
            if self.interrupt.asked() {
                return Err(GradientError::Interrupted);
            }
            if !self.step(along)? {
                break;
            }
        }
        Ok(())
    }

    /// Makes a step; `false` if the run is over.
    fn step(&mut self, along: &mut dyn Along) -> Result<bool, GradientError> {
        let Making { scene, stepper, state, spec, interrupt, .. } = self;
        let mut run = Run { scene: *scene, spec, stop: Stop::NEVER, interrupt: *interrupt, state };
        let Some(tick) = run.next() else { return Ok(false) };
        let report = match run.fixed_step(stepper, tick) {
            Ok(report) => report,
            Err(status) => return Err(failed(&self.state, status)),
        };
        let form = self.form(tick.h)?;
        let (passed, fired) = (self.state.passed(), self.state.fired().len());
        let ends = StepEnds { form: &form, h: tick.h, from: &self.state.from, to: &self.state.to };
        along.step(&self.stepper, ends, Made { step: self.state.steps + 1, passed })?;
        let Making { scene, stepper, state, spec, interrupt, .. } = self;
        let mut run = Run { scene: *scene, spec, stop: Stop::NEVER, interrupt: *interrupt, state };
        match run.accept_fixed(stepper, &report)? {
            StepEnd::Accepted => {}
            StepEnd::Failed(status) => return Err(failed(&self.state, status)),
            StepEnd::TakenBack | StepEnd::Stopped => return Err(GradientError::Interrupted),
        }
        if let Some(what) = event_without_derivative(self.scene, &self.state, (passed, fired)) {
            return Err(GradientError::Without { what, advice: "end the run before it, with --end" });
        }
        if self.state.passed() != passed {
            let made = Made { step: self.state.steps, passed: self.state.passed() };
            along.event(&self.state.from, self.form(self.h)?, made)?;
        }
        Ok(true)
    }
}

fn failed(state: &RunState, status: Status) -> GradientError {
    if status == Status::Interrupted {
        return GradientError::Interrupted;
    }
    let why =
        state.failure.as_ref().map_or_else(|| "a step cannot be made".to_owned(), |failure| failure.cause.clone());
    GradientError::Failed { t: state.from.state.t, why }
}
