//! What an adjoint run needs of the steps of a run, in their order.

use super::columns::{Columns, lagging, rows_of};
use super::error::SensitivityError;
use super::tangent_run::StepEnds;
use crate::integrate::form::StepForm;
use crate::integrate::stepper::Stepper;
use crate::model::point::Point;
use crate::scene::Scene;
use std::rc::Rc;

/// A step, or what a run begins with at its start and after an event.
pub struct StepRecord {
    /// how it was made
    pub(super) form: Rc<StepForm>,
    /// [s] times of the stages
    pub(super) times: Vec<f64>,
    /// the vectors that it begins with, then the accelerations of its stages
    pub(super) columns: Vec<Vec<f64>>,
    /// events that were passed before it
    pub(super) passed: usize,
    /// number of the step that it is, or after which the run begins there
    pub step: u64,
    /// whether forces lag behind velocities in it
    pub(super) lags: bool,
    /// whether it is a step
    pub is_step: bool,
    /// [s] its end
    pub t: f64,
}

impl StepRecord {
    /// [m] and [m/s] Positions and velocities where it begins.
    pub fn start(&self) -> [&[f64]; 2] {
        [&self.columns[0], &self.columns[1]]
    }

    /// [m/s] The velocities at which the forces at its end were found, if they are not those at its end.
    pub fn force_v(&self) -> Option<Vec<f64>> {
        self.lags.then(|| lagging(&self.form, &self.columns, self.columns[0].len()))?
    }

    /// [bytes] Memory of a step of this form in a scene.
    pub fn size(form: &StepForm, scene: &dyn Scene) -> usize {
        (form.carried() + form.stages.len()) * scene.n_dof() * size_of::<f64>()
    }
}

/// Follows a run and keeps its steps.
pub struct Recorder<'a> {
    scene: &'a dyn Scene,
    columns: Columns,
    form: Rc<StepForm>,
    /// steps that are kept
    pub records: Vec<StepRecord>,
}

/// Where a recorder stands: the vectors that the next step begins with.
#[derive(Clone, Debug)]
pub struct RecorderState(Vec<Vec<f64>>);

impl<'a> Recorder<'a> {
    /// At the start of a run, whose first step has this form.
    pub fn start(scene: &'a dyn Scene, from: &Point, form: StepForm) -> Self {
        let mut recorder =
            Recorder { scene, columns: Columns::new(scene, from), form: Rc::default(), records: Vec::new() };
        recorder.begin((0, 0), from, form);
        recorder
    }

    /// Between two steps of a run that was followed before.
    pub fn resume(scene: &'a dyn Scene, from: &Point, state: RecorderState) -> Self {
        let mut columns = Columns::new(scene, from);
        columns.all = state.0;
        Recorder { scene, columns, form: Rc::default(), records: Vec::new() }
    }

    /// Its scene.
    pub fn scene(&self) -> &'a dyn Scene {
        self.scene
    }

    /// Goes over a step that nothing is kept of, of a scheme that carries positions and velocities only.
    pub fn jump(&mut self, to: &Point) {
        self.columns.settle(&to.state);
    }

    /// Where it stands.
    pub fn state(&self) -> RecorderState {
        RecorderState(self.columns.all.clone())
    }

    /// After an event at `from`, which is the end of a step, after which the scheme has started again: `passed` events,
    /// and this number of steps.
    pub fn begin(&mut self, (passed, step): (usize, u64), from: &Point, form: StepForm) {
        self.columns.begin();
        let beginning = form.beginning();
        for stage in &beginning.stages {
            self.columns.place(stage, None);
            let acceleration = self.columns.acceleration(self.scene, from.state.t);
            self.columns.all.push(acceleration);
        }
        let times = vec![from.state.t; beginning.stages.len()];
        self.keep(StepRecord {
            form: Rc::new(beginning),
            times,
            columns: Vec::new(),
            passed,
            step,
            lags: false,
            is_step: false,
            t: from.state.t,
        });
        self.columns.settle(&from.state);
        self.form = Rc::new(form);
    }

    /// Follows a step that was attempted, and is accepted after this; `passed` are the events before it.
    ///
    /// # Errors
    /// A scheme that does not tell the accelerations of its stages.
    pub fn step(
        &mut self,
        stepper: &Stepper<'_>,
        ends: StepEnds<'_>,
        (passed, step): (usize, u64),
    ) -> Result<(), SensitivityError> {
        let StepEnds { form, to, .. } = ends;
        if *self.form != *form {
            self.form = Rc::new(form.clone());
        }
        let mut times = Vec::with_capacity(form.stages.len());
        for (number, stage) in form.stages.iter().enumerate() {
            let t = Columns::time(stage, &ends);
            let found = Columns::found(self.scene, stepper, (form, number), to)?;
            let explicit = found.is_none();
            self.columns.place(stage, found);
            if explicit {
                let acceleration = self.columns.acceleration(self.scene, t);
                self.columns.all.push(acceleration);
            }
            times.push(t);
        }
        let (form, lags) = (self.form.clone(), stepper.lags());
        self.keep(StepRecord { form, times, columns: Vec::new(), passed, step, lags, is_step: true, t: to.state.t });
        self.columns.settle(&to.state);
        Ok(())
    }

    /// Keeps a step with the columns as they are, and goes on to its end.
    fn keep(&mut self, record: StepRecord) {
        let next = rows_of(&record.form.next, &self.columns.all, self.scene.n_dof());
        let columns = std::mem::replace(&mut self.columns.all, next);
        self.records.push(StepRecord { columns, ..record });
    }
}
