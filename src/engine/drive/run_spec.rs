//! The specification of a run.

use super::clock::{Step, Tolerance};
use super::error::RunError;
use crate::analysis::warnings::Planned;
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::{MethodChoice, MethodError};
use crate::integrate::stepper::Scheme;
use crate::model::stop::Stop;
use crate::scene::Scene;

/// For which events a run searches the cause. The search is an analysis of the scene that takes as long as some hundred
/// steps of a small scene. Without it a report still says what happened and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Explain {
    /// nothing
    Nothing,
    /// a run that fails
    Failures,
    /// a run that fails, and energy that the scheme makes
    All,
}

/// By which method a run moves, and in which steps.
#[derive(Clone, Debug)]
pub struct RunSpec {
    /// method with its parameters
    pub method: MethodChoice,
    /// how an implicit step is solved
    pub solver: SolverSpec,
    /// [s] end of the run; adaptive steps share their tolerance out over it
    pub end: f64,
    /// [s] end of the whole run, of which this may be a part: up to there a kept matrix may serve
    pub whole: f64,
    /// fixed or adaptive steps
    pub step: Step,
    /// [s] interval of the frames; `None` where only ends of steps are shown. Adaptive steps of a scheme with an
    /// embedded pair end at its multiples, because cubic interpolation would be less accurate than such a step; other
    /// steps do not
    pub frames_every: Option<f64>,
    /// whether a program gives the size of each step; others are then as long as a fixed step
    pub free_steps: bool,
    /// continue after a divergence until a value is not finite
    pub keep_going: bool,
    /// whether the run ends at an event of the scene that says so, as when the payload reaches the ground
    pub ends_by_event: bool,
    /// events for which the cause is searched; none where the cost of a run is measured
    pub explain: Explain,
    /// threads of a scene above 2,000 nodes, at least 1; a scene that is built already keeps its own
    pub threads: usize,
}

impl RunSpec {
    /// Fixed steps of `step` [s] until `end` [s], by the method of this name with its default parameters.
    ///
    /// # Errors
    /// An unknown method.
    pub fn fixed(method: &str, step: f64, end: f64) -> Result<Self, MethodError> {
        Ok(Self::of(MethodChoice::with_defaults(method)?, Step::Fixed(step), end))
    }

    /// Adaptive steps within a tolerance until `end` [s], likewise.
    ///
    /// # Errors
    /// An unknown method.
    pub fn adaptive(method: &str, tolerance: Tolerance, end: f64) -> Result<Self, MethodError> {
        Ok(Self::of(MethodChoice::with_defaults(method)?, Step::Adaptive(tolerance), end))
    }

    /// Any method, also [one of your own](crate::integrate).
    pub fn of(method: MethodChoice, step: Step, end: f64) -> Self {
        RunSpec {
            method,
            solver: SolverSpec::default(),
            end,
            whole: end,
            step,
            frames_every: None,
            free_steps: false,
            keep_going: false,
            ends_by_event: false,
            explain: Explain::Failures,
            threads: 1,
        }
    }

    /// A new scheme.
    pub fn scheme(&self) -> Scheme {
        self.method.scheme(self.solver)
    }

    /// The method on a scene, for a search of its critical step that `stop` ends.
    pub fn planned<'a>(&'a self, scene: &'a dyn Scene, stop: Stop<'a>) -> Planned<'a> {
        let step = self.step.fixed().map(|step| step.min(self.end));
        Planned { scene, method: &self.method, step, end: self.end, stop }
    }

    /// [s] The step, where all steps have this size.
    pub fn steps_of_one_size(&self) -> Option<f64> {
        self.step.fixed().filter(|_| !self.free_steps)
    }

    /// Checks the numbers of the specification.
    ///
    /// # Errors
    /// [`RunError::OutOfRange`]: an end, step, interval of frames or absolute tolerance that is not finite and above 0,
    /// or a relative tolerance outside (0, 1).
    pub fn check(&self) -> Result<(), RunError> {
        let above = |what: &'static str, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(RunError::OutOfRange { what, value, needed: "a finite number above 0" }),
        };
        above("end [s]", self.end)?;
        self.frames_every.map_or(Ok(()), |every| above("time between frames [s]", every))?;
        match self.step {
            Step::Fixed(step) => above("step [s]", step),
            Step::Adaptive(Tolerance { relative, absolute }) => {
                above("absolute tolerance", absolute)?;
                let (what, needed) = ("relative tolerance", "a number between 0 and 1");
                match relative > 0.0 && relative < 1.0 {
                    true => Ok(()),
                    false => Err(RunError::OutOfRange { what, value: relative, needed }),
                }
            }
        }
    }
}
