//! The vectors of a run from step to step, made by the form of its steps.

use super::error::SensitivityError;
use super::tangent_run::StepEnds;
use crate::integrate::form::{Row, StageForm, StepForm};
use crate::integrate::stepper::Stepper;
use crate::model::forces::Forces;
use crate::model::point::Point;
use crate::model::state::{State, StateRef};
use crate::scene::Scene;

/// x, v and what a scheme carries besides, then the accelerations of the stages of a step.
pub(super) struct Columns {
    /// the vectors, each `[n_dof]`
    pub all: Vec<Vec<f64>>,
    /// [m/s] velocities at which the forces of the state were found, where these lag
    pub force_v: Option<Vec<f64>>,
    /// [m] and [m/s] the state of the stage that was placed last
    pub stage: [Vec<f64>; 2],
    forces: Forces,
}

/// out = the sum of a row's shares of columns.
pub(super) fn combine(row: &Row, columns: &[Vec<f64>], out: &mut [f64]) {
    out.fill(0.0);
    for (share, column) in row.iter().zip(columns).filter(|(share, _)| **share != 0.0) {
        out.iter_mut().zip(column).for_each(|(out, value)| *out += share * value);
    }
}

/// The columns that rows make of others.
pub(super) fn rows_of(rows: &[Row], columns: &[Vec<f64>], n: usize) -> Vec<Vec<f64>> {
    let made = rows.iter().map(|row| {
        let mut made = vec![0.0; n];
        combine(row, columns, &mut made);
        made
    });
    made.collect()
}

/// The velocities at which the forces at the end of a step were found, if they lag, or their derivatives.
pub(super) fn lagging(form: &StepForm, columns: &[Vec<f64>], n: usize) -> Option<Vec<f64>> {
    let stage = form.stages.last()?;
    let mut v = vec![0.0; n];
    combine(&stage.v, columns, &mut v);
    Some(v)
}

impl Columns {
    /// At the start of a run.
    pub(super) fn new(scene: &dyn Scene, from: &Point) -> Self {
        let zero = || vec![0.0; scene.n_dof()];
        let all = vec![from.state.x.clone(), from.state.v.clone()];
        Columns { all, force_v: None, stage: [zero(), zero()], forces: scene.new_forces() }
    }

    /// Leaves x and v.
    pub(super) fn begin(&mut self) {
        self.all.truncate(2);
        self.force_v = None;
    }

    /// [s] Time of a stage.
    pub(super) fn time(stage: &StageForm, step: &StepEnds<'_>) -> f64 {
        if stage.c == 1.0 { step.to.state.t } else { step.from.state.t + stage.c * step.h }
    }

    /// [m/s^2] The acceleration of an implicit stage, as the scheme has found it; `None` for an explicit one.
    ///
    /// # Errors
    /// A scheme that does not tell it.
    pub(super) fn found(
        scene: &dyn Scene,
        stepper: &Stepper<'_>,
        (form, number): (&StepForm, usize),
        to: &Point,
    ) -> Result<Option<Vec<f64>>, SensitivityError> {
        if form.own(number) == [0.0; 2] {
            return Ok(None);
        }
        if number + 1 == form.stages.len() {
            let f = to.forces.total.iter().zip(scene.inverse_mass());
            return Ok(Some(f.map(|(f, m)| f * m).collect()));
        }
        let found = stepper.stage_acceleration(number).ok_or(SensitivityError::Stage { number })?;
        Ok(Some(found.to_vec()))
    }

    /// Finds the state of a stage, of which `found` is the acceleration if it is implicit.
    pub(super) fn place(&mut self, stage: &StageForm, found: Option<Vec<f64>>) {
        self.all.extend(found);
        let [x, v] = &mut self.stage;
        combine(&stage.x, &self.all, x);
        combine(&stage.v, &self.all, v);
    }

    /// [m/s^2] M^-1 f at that state.
    pub(super) fn acceleration(&mut self, scene: &dyn Scene, t: f64) -> Vec<f64> {
        let [x, v] = &self.stage;
        scene.evaluate(StateRef { t, x, v }, &mut self.forces);
        self.forces.total.iter().zip(scene.inverse_mass()).map(|(f, m)| f * m).collect()
    }

    /// Goes on to the end of a step.
    pub(super) fn end(&mut self, next: &[Row]) {
        self.all = rows_of(next, &self.all, self.stage[0].len());
    }

    /// Takes the run's own bits, without the rounding of the rows.
    pub(super) fn settle(&mut self, at: &State) {
        for (own, run) in self.all.iter_mut().zip([&at.x, &at.v]) {
            own.copy_from_slice(run);
        }
    }
}
