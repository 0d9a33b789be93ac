//! The tangent-linear run: derivatives of all vectors of a run, from step to step along with it.

use super::apparent_slope::ApparentSlope;
use super::columns::{Columns, combine, lagging, rows_of};
use super::error::SensitivityError;
use super::linearisation::Linearisation;
use super::parameter::Parameter;
use crate::integrate::form::{Row, StepForm};
use crate::integrate::stepper::Stepper;
use crate::model::point::Point;
use crate::model::state::StateRef;
use crate::scene::Scene;

/// A step that was attempted: how it was made, and its ends.
#[derive(Clone, Copy)]
pub struct StepEnds<'a> {
    /// the step
    pub form: &'a StepForm,
    /// [s] its size
    pub h: f64,
    /// where it starts
    pub from: &'a Point,
    /// where it ends
    pub to: &'a Point,
}

/// The derivatives of one parameter: of the vectors that a step begins with, then of the accelerations of its stages.
struct Direction {
    parameter: Parameter,
    columns: Vec<Vec<f64>>,
    /// of the velocities at which the forces of the state were found
    force_v: Vec<f64>,
}

/// The tangent-linear run of some parameters.
pub struct TangentRun {
    linear: Linearisation,
    directions: Vec<Direction>,
    columns: Columns,
    buffers: [Vec<f64>; 2],
}

impl TangentRun {
    /// At the start of a run, `from`, whose first step has this form.
    ///
    /// # Errors
    /// A matrix that cannot be set up or solved with.
    pub fn start(
        scene: &dyn Scene,
        parameters: Vec<Parameter>,
        from: &Point,
        form: &StepForm,
    ) -> Result<Self, SensitivityError> {
        let directions = parameters.into_iter().map(|parameter| {
            let columns = parameter.start().to_vec();
            Direction { parameter, columns, force_v: Vec::new() }
        });
        let zero = || vec![0.0; scene.n_dof()];
        let mut run = TangentRun {
            linear: Linearisation::new(scene, false)?,
            directions: directions.collect(),
            columns: Columns::new(scene, from),
            buffers: [zero(), zero()],
        };
        run.begin(scene, from, form)?;
        Ok(run)
    }

    /// After an event at `from`, after which the scheme has started again.
    ///
    /// # Errors
    /// As [`TangentRun::start`].
    pub fn restart(
        &mut self,
        scene: &dyn Scene,
        (passed, from): (usize, &Point),
        form: &StepForm,
    ) -> Result<(), SensitivityError> {
        self.directions.iter().for_each(|of| of.parameter.pass_events(passed));
        let before = self.linear.factorizations;
        self.linear = Linearisation::new(scene, false)?;
        self.linear.factorizations = before;
        self.begin(scene, from, form)
    }

    /// What the scheme carries besides positions and velocities, from those.
    fn begin(&mut self, scene: &dyn Scene, from: &Point, form: &StepForm) -> Result<(), SensitivityError> {
        self.columns.begin();
        self.directions.iter_mut().for_each(|of| of.columns.truncate(2));
        if self.directions.is_empty() {
            return Ok(());
        }
        let beginning = form.beginning();
        for number in 0..beginning.stages.len() {
            self.stage(scene, &beginning, (number, from.state.t), None)?;
        }
        self.end(&beginning.next);
        Ok(())
    }

    /// Takes the derivatives over a step that was attempted, and is accepted after this.
    ///
    /// # Errors
    /// A matrix that cannot be solved with, or derivatives that are not finite.
    pub fn step(
        &mut self,
        scene: &dyn Scene,
        stepper: &Stepper<'_>,
        step: StepEnds<'_>,
    ) -> Result<(), SensitivityError> {
        let StepEnds { form, to, .. } = step;
        if self.directions.is_empty() {
            return Ok(());
        }
        for (number, stage) in form.stages.iter().enumerate() {
            let found = Columns::found(scene, stepper, (form, number), to)?;
            self.stage(scene, form, (number, Columns::time(stage, &step)), found)?;
        }
        if stepper.lags() {
            let n = scene.n_dof();
            self.columns.force_v = lagging(form, &self.columns.all, n);
            for direction in &mut self.directions {
                direction.force_v = lagging(form, &direction.columns, n).unwrap_or_default();
            }
        }
        self.end(&form.next);
        self.columns.settle(&to.state);
        for direction in &self.directions {
            if !direction.columns.iter().flatten().all(|value| value.is_finite()) {
                let parameter = direction.parameter.name.clone();
                return Err(SensitivityError::NotFinite { parameter, t: to.state.t });
            }
        }
        Ok(())
    }

    /// Adds the acceleration of a stage, and its derivatives, to the columns; `found` is that of an implicit stage.
    fn stage(
        &mut self,
        scene: &dyn Scene,
        form: &StepForm,
        (number, t): (usize, f64),
        found: Option<Vec<f64>>,
    ) -> Result<(), SensitivityError> {
        let TangentRun { linear, directions, columns, buffers: [dx, dv] } = self;
        let (stage, own) = (&form.stages[number], form.own(number));
        let explicit = found.is_none();
        columns.place(stage, found);
        // Of an implicit stage, that at the very state at which differences are taken: without the rest of its solve.
        let acceleration = columns.acceleration(scene, t);
        if explicit {
            columns.all.push(acceleration.clone());
        }
        let [x, v] = &columns.stage;
        let at = StateRef { t, x, v };
        let failed = |source| SensitivityError::Linear { t, source };
        linear.set(scene, at, own).map_err(failed)?;
        let n = linear.n();
        let [mut b, mut m, mut picked_x, mut picked_v] = [(); 4].map(|()| vec![0.0; n]);
        for Direction { parameter, columns, .. } in directions {
            combine(&stage.x, columns, dx);
            combine(&stage.v, columns, dv);
            linear.pick(dx, &mut picked_x);
            linear.pick(dv, &mut picked_v);
            linear.forces(&picked_x, &picked_v, &mut b);
            let mut slope = vec![0.0; scene.n_dof()];
            parameter.acceleration_slope(at, &acceleration, &mut slope);
            linear.pick(&slope, &mut picked_x);
            linear.mass_times(&picked_x, &mut m);
            b.iter_mut().zip(&m).for_each(|(b, m)| *b = m - *b);
            slope.fill(0.0);
            let mut apparent = ApparentSlope::of(scene, at, &acceleration);
            let found = loop {
                let mut next = b.clone();
                apparent.subtract([dx, dv], own, &slope, linear, &mut next);
                linear.solve(&mut next).map_err(failed)?;
                linear.put(&next, &mut slope);
                if apparent.settled(&next) {
                    break slope;
                }
                crate::interrupt::check().map_err(|source| failed(source.into()))?;
            };
            columns.push(found);
        }
        Ok(())
    }

    /// The columns at the end of a step.
    fn end(&mut self, next: &[Row]) {
        let n = self.columns.stage[0].len();
        self.columns.end(next);
        self.directions.iter_mut().for_each(|direction| direction.columns = rows_of(next, &direction.columns, n));
    }

    /// Number of parameters.
    pub fn parameters(&self) -> usize {
        self.directions.len()
    }

    /// The parameters.
    pub fn parameter(&self, number: usize) -> Option<&Parameter> {
        self.directions.get(number).map(|direction| &direction.parameter)
    }

    /// Factorisations so far.
    pub fn factorizations(&self) -> u64 {
        self.linear.factorizations
    }

    /// Derivatives of positions and velocities with respect to a parameter, in the unit of these over that of the
    /// parameter `[n_dof]`.
    pub fn derivative(&self, number: usize) -> Option<[&[f64]; 2]> {
        self.directions.get(number).map(|of| [of.columns[0].as_slice(), of.columns[1].as_slice()])
    }

    /// Calls `measure` with the scenes of a parameter, [each at its place](Parameter::along) along the derivative of
    /// the state `at`.
    pub fn along(&mut self, number: usize, at: StateRef<'_>, measure: impl FnMut(usize, &dyn Scene, &Point)) {
        let TangentRun { directions, columns: Columns { force_v, .. }, .. } = self;
        let Some(Direction { parameter, columns, force_v: dv }) = directions.get_mut(number) else { return };
        let lagging = force_v.as_ref().map(|v| [v.as_slice(), dv.as_slice()]);
        parameter.along(at, [&columns[0], &columns[1]], lagging, measure);
    }
}
