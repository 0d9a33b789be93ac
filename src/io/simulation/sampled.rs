//! Runs at given times, which a program may change on the way.

use super::{Simulation, SimulationError, StopAt};
use crate::drive::at_rest::{AtRest, RestSpec};
use crate::drive::observer::{AcceptedStep, ObserveError, Observer, UpcomingStep, Wants};
use crate::drive::{Outcome, Status};
use crate::output::samples::Samples;
use std::sync::atomic::AtomicBool;

/// What a program does at the time of this number.
pub type Act<'a> = dyn FnMut(&mut Simulation, usize) -> Result<(), SimulationError> + 'a;

impl Simulation {
    /// Makes all steps that are left, as [`Simulation::run`], or those up to the last of the times
    /// ([`SampleSpec::ends_run`](crate::output::samples::SampleSpec::ends_run)), and keeps samples of them. `act` is
    /// called with the number of each time of the samples, at the end of the first step that reaches it: what it sets
    /// acts from the next step on, and is not in the sample of that time. A run with `until_rest` ends once its
    /// scene is at rest.
    ///
    /// ```
    /// # use canopy_fem_io::{case::Case, output::samples::{SampleArrays, SampleSpec, Samples}, simulation::Simulation};
    /// # use std::sync::atomic::AtomicBool;
    /// # let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/cases/oscillator.json"));
    /// let case = Case::from_file(path, &[])?;
    /// let (problem, mut sim) = (case.problem(), Simulation::from_case(case.problem(), 1)?);
    /// let (times, mut x) = ([0.0, 0.5, 1.0], vec![0.0; 3 * 2 * 3]);
    /// let spec = SampleSpec { times: &times, nodes: &[], output: &problem.output, end: sim.end(), ends_run: true };
    /// let arrays = SampleArrays { positions: &mut x, ..SampleArrays::default() };
    /// let mut samples = Samples::new(&*sim.scene(), spec, arrays)?;
    /// sim.run_sampled(&mut samples, None, None, &AtomicBool::new(false))?;
    /// assert_eq!((x[3], sim.time()), (12.0, 1.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Simulation::run`], and what `act` returns.
    pub fn run_sampled(
        &mut self,
        samples: &mut Samples<'_, '_>,
        until_rest: Option<RestSpec>,
        act: Option<&mut Act<'_>>,
        stop: &AtomicBool,
    ) -> Result<Outcome, SimulationError> {
        samples.begin(&*self.scene, &self.state.from, self.state.row);
        if let Some(act) = act {
            for (number, &t) in samples.times().iter().enumerate() {
                let until = StopAt { step: u64::MAX, t };
                if !until.reached(self.step_count(), self.time()) {
                    let (outcome, over) = self.part(until, samples, until_rest, stop)?;
                    if over {
                        return Ok(outcome);
                    }
                }
                act(self, number)?;
            }
        }
        let until = StopAt { step: u64::MAX, t: f64::INFINITY };
        Ok(self.part(until, samples, until_rest, stop)?.0)
    }

    /// A part of a run, and whether the run ends with it.
    fn part(
        &mut self,
        until: StopAt,
        samples: &mut Samples<'_, '_>,
        until_rest: Option<RestSpec>,
        stop: &AtomicBool,
    ) -> Result<(Outcome, bool), SimulationError> {
        // What is set between parts may change the scene, so nothing holds it then.
        let scene = self.scene();
        let (mut sampling, mut part) = (samples.observing(&*scene), Part { until, reached: false });
        let mut rest = until_rest.map(|rest| AtRest::new(&*scene, rest, self.end()));
        let mut all: Vec<&mut dyn Observer> = vec![&mut sampling, &mut part];
        all.extend(rest.as_mut().map(|rest| rest as &mut dyn Observer));
        let outcome = self.run(&mut all, stop)?;
        let at_end = StopAt { step: u64::MAX, t: self.end() }.reached(0, self.time());
        let at_rest = rest.is_some_and(|rest| rest.ends_run());
        let over = at_end || at_rest || !part.reached || outcome.status != Status::Completed;
        Ok((outcome, over))
    }
}

/// Ends a part of a run.
struct Part {
    until: StopAt,
    reached: bool,
}

impl Observer for Part {
    fn wants(&self, next: UpcomingStep) -> Wants {
        self.until.wants(next)
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.reached = self.until.reached(step.step, step.t);
        Ok(())
    }

    fn ends_run(&self) -> bool {
        self.reached
    }
}
