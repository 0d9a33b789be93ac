//! The tangent-linear run: derivatives of all vectors of a run, from step to step along with it.

use super::apparent_slope::ApparentSlope;
use super::error::SensitivityError;
use super::linearisation::Linearisation;
use super::parameter::Parameter;
use crate::integrate::form::{Row, StageForm, StepForm};
use crate::integrate::stepper::Stepper;
use crate::model::forces::Forces;
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
pub struct TangentRun<'a> {
    scene: &'a dyn Scene,
    linear: Linearisation,
    directions: Vec<Direction>,
    /// the vectors themselves
    columns: Vec<Vec<f64>>,
    /// [m/s] velocities at which the forces of the state were found, where these lag
    force_v: Option<Vec<f64>>,
    forces: Forces,
    buffers: [Vec<f64>; 4],
}

/// out = the sum of a row's shares of columns.
fn combine(row: &Row, columns: &[Vec<f64>], out: &mut [f64]) {
    out.fill(0.0);
    for (share, column) in row.iter().zip(columns).filter(|(share, _)| **share != 0.0) {
        out.iter_mut().zip(column).for_each(|(out, value)| *out += share * value);
    }
}

impl<'a> TangentRun<'a> {
    /// At the start of a run, `from`, whose first step has this form.
    ///
    /// # Errors
    /// A matrix that cannot be set up or solved with.
    pub fn start(
        scene: &'a dyn Scene,
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
            scene,
            linear: Linearisation::new(scene)?,
            directions: directions.collect(),
            columns: vec![from.state.x.clone(), from.state.v.clone()],
            force_v: None,
            forces: scene.new_forces(),
            buffers: [(); 4].map(|()| zero()),
        };
        run.begin(from, form)?;
        Ok(run)
    }

    /// After an event at `from`, after which the scheme has started again.
    ///
    /// # Errors
    /// As [`TangentRun::start`].
    pub fn restart(&mut self, passed: usize, from: &Point, form: &StepForm) -> Result<(), SensitivityError> {
        self.directions.iter().for_each(|of| of.parameter.pass_events(passed));
        let before = self.linear.factorizations;
        self.linear = Linearisation::new(self.scene)?;
        self.linear.factorizations = before;
        self.begin(from, form)
    }

    /// What the scheme carries besides positions and velocities, from those.
    fn begin(&mut self, from: &Point, form: &StepForm) -> Result<(), SensitivityError> {
        self.columns.truncate(2);
        self.directions.iter_mut().for_each(|of| of.columns.truncate(2));
        self.force_v = None;
        if form.start.is_empty() || self.directions.is_empty() {
            return Ok(());
        }
        let explicit =
            StepForm { stages: vec![StageForm { c: 0.0, x: vec![1.0], v: vec![0.0, 1.0] }], ..StepForm::default() };
        self.stage(&explicit, 0, from.state.t, None)?;
        let rows: Vec<Row> =
            [vec![1.0], vec![0.0, 1.0]].into_iter().chain(form.start.iter().map(|row| row.to_vec())).collect();
        self.end(&rows);
        Ok(())
    }

    /// Takes the derivatives over a step that was attempted, and is accepted after this.
    ///
    /// # Errors
    /// A matrix that cannot be solved with, or derivatives that are not finite.
    pub fn step(&mut self, stepper: &Stepper<'_>, step: StepEnds<'_>) -> Result<(), SensitivityError> {
        let StepEnds { form, h, from, to } = step;
        if self.directions.is_empty() {
            return Ok(());
        }
        let last = form.stages.len().saturating_sub(1);
        for (number, stage) in form.stages.iter().enumerate() {
            let t = if stage.c == 1.0 { to.state.t } else { from.state.t + stage.c * h };
            let implicit = form.own(number) != [0.0; 2];
            let found: Option<Vec<f64>> = match implicit {
                true if number == last => {
                    let f = to.forces.total.iter().zip(self.scene.inverse_mass());
                    Some(f.map(|(f, m)| f * m).collect())
                }
                true => {
                    let found = stepper.stage_acceleration(number).ok_or(SensitivityError::Stage { number })?;
                    Some(found.to_vec())
                }
                false => None,
            };
            self.stage(form, number, t, found)?;
        }
        if stepper.lags() {
            let Some(stage) = form.stages.last() else { return Ok(()) };
            let of = |columns: &[Vec<f64>]| {
                let mut v = vec![0.0; self.scene.n_dof()];
                combine(&stage.v, columns, &mut v);
                v
            };
            self.force_v = Some(of(&self.columns));
            let all: Vec<Vec<f64>> = self.directions.iter().map(|direction| of(&direction.columns)).collect();
            self.directions.iter_mut().zip(all).for_each(|(direction, v)| direction.force_v = v);
        }
        self.end(&form.next);
        // The run's own bits, without the rounding of the rows.
        self.columns[0].copy_from_slice(&to.state.x);
        self.columns[1].copy_from_slice(&to.state.v);
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
        form: &StepForm,
        number: usize,
        t: f64,
        found: Option<Vec<f64>>,
    ) -> Result<(), SensitivityError> {
        let TangentRun { scene, linear, directions, columns, forces, buffers: [x, v, dx, dv], .. } = self;
        let (stage, own) = (&form.stages[number], form.own(number));
        columns.extend(found);
        combine(&stage.x, columns, x);
        combine(&stage.v, columns, v);
        scene.evaluate(StateRef { t, x, v }, forces);
        // Of an implicit stage, that at the very state at which differences are taken: without the rest of its solve.
        let acceleration: Vec<f64> = forces.total.iter().zip(scene.inverse_mass()).map(|(f, m)| f * m).collect();
        if own == [0.0; 2] {
            columns.push(acceleration.clone());
        }
        let at = StateRef { t, x, v };
        let failed = |source| SensitivityError::Linear { t, source };
        linear.set(*scene, at, own).map_err(failed)?;
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
            let mut apparent = ApparentSlope::of(*scene, at, &acceleration);
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
        let n = self.scene.n_dof();
        let end = |columns: &mut Vec<Vec<f64>>| {
            let made = next.iter().map(|row| {
                let mut made = vec![0.0; n];
                combine(row, columns, &mut made);
                made
            });
            *columns = made.collect();
        };
        end(&mut self.columns);
        self.directions.iter_mut().for_each(|direction| end(&mut direction.columns));
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
        let TangentRun { directions, force_v, .. } = self;
        let Some(Direction { parameter, columns, force_v: dv }) = directions.get_mut(number) else { return };
        let lagging = force_v.as_ref().map(|v| [v.as_slice(), dv.as_slice()]);
        parameter.along(at, [&columns[0], &columns[1]], lagging, measure);
    }
}
