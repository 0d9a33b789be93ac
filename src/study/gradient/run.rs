//! A run with its tangent-linear run beside it.

use super::error::GradientError;
use super::making::{Along, Made, Making};
use crate::case::Problem;
use crate::integrate::form::StepForm;
use crate::integrate::stepper::Stepper;
use crate::model::point::Point;
use crate::model::stop::Stop;
use crate::output::gauges::GaugesSpec;
use crate::output::gauges::derivatives::{GaugeDerivatives, QuantityDerivatives};
use crate::scene::Scene;
use crate::sensitivity::{Parameter, SensitivityError, StepEnds, Switches, TangentRun, Varied};

/// What such a run finds.
pub(super) struct Followed {
    pub quantities: Vec<QuantityDerivatives>,
    /// of each parameter
    pub switches: Vec<Switches>,
    pub steps: u64,
    pub run_factorizations: u64,
    pub factorizations: u64,
}

/// Makes the run of a problem on its scene, and finds its quantities and their derivatives by some parameters.
pub(super) fn follow(
    problem: &Problem,
    scene: &dyn Scene,
    varied: Vec<Varied>,
    interrupt: Stop<'_>,
) -> Result<Followed, GradientError> {
    let mut making = Making::start(problem, scene, interrupt)?;
    let (h, from) = (making.h, &making.state.from);
    let gauges = GaugesSpec::of(&problem.output, problem.run_spec().end);
    let mut quantities = GaugeDerivatives::new(scene, &gauges, varied.len())?;
    let parameter = |varied| Parameter::new(scene, &from.state, varied, Some(h));
    let parameters: Vec<Parameter> = varied.into_iter().map(parameter).collect::<Result<_, SensitivityError>>()?;
    let tangent = TangentRun::start(scene, parameters, from, &making.form(h)?)?;
    quantities.measure(scene, 0, from);
    let mut beside = Beside { scene, tangent, quantities };
    beside.note(from);
    making.to(u64::MAX, &mut beside)?;
    let last = &making.state.from;
    if beside.quantities.measure_last(scene, last) {
        beside.note(last);
    }
    let Beside { tangent, quantities, .. } = beside;
    let switches = (0..tangent.parameters()).filter_map(|number| tangent.parameter(number)).map(|of| of.switches);
    Ok(Followed {
        quantities: quantities.results(),
        switches: switches.collect(),
        steps: making.state.steps,
        run_factorizations: making.state.counters.factorizations,
        factorizations: tangent.factorizations(),
    })
}

/// The tangent-linear run, with the gauges along its derivatives.
struct Beside<'a> {
    scene: &'a dyn Scene,
    tangent: TangentRun,
    quantities: GaugeDerivatives,
}

impl Beside<'_> {
    /// Measures along the derivatives of the state that was measured last.
    fn note(&mut self, at: &Point) {
        let Beside { tangent, quantities, .. } = self;
        for number in 0..tangent.parameters() {
            tangent.along(number, at.state.as_ref(), |place, scene, at| quantities.measure_at(place, scene, at));
            let h = tangent.parameter(number).map_or(1.0, Parameter::h);
            quantities.note(number, h);
        }
    }
}

impl Along for Beside<'_> {
    fn step(&mut self, stepper: &Stepper<'_>, ends: StepEnds<'_>, made: Made) -> Result<(), GradientError> {
        self.tangent.step(self.scene, stepper, ends)?;
        if self.quantities.wants(made.step, [ends.from.state.t, ends.to.state.t]) {
            self.quantities.measure(self.scene, made.step, ends.to);
            self.note(ends.to);
        }
        Ok(())
    }

    fn event(&mut self, from: &Point, form: StepForm, made: Made) -> Result<(), GradientError> {
        Ok(self.tangent.restart(self.scene, (made.passed, from), &form)?)
    }
}
