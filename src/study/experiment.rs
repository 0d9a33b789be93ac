//! One run of a method on a scene: the single place of the studies that starts, follows and stops runs.
//!
//! An [`Experiment`] says what is run. [`Experiment::run`] makes it and calls a function with every [`Event`]; that
//! function collects what its study needs and may stop the run. A [`Sampler`] keeps or compares frames on the way.

use std::sync::atomic::{AtomicBool, Ordering};

use super::frames::{Distance, Sampler};
use crate::drive::clock::Step;
use crate::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, Resumable, UpcomingStep, Wants};
use crate::drive::{Explain, Outcome, Run, RunError, RunSpec, RunState, Snapshot};
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::MethodChoice;
use crate::integrate::stepper::{Stepper, Unfit};
use crate::model::point::Point;
use crate::model::state::State;
use crate::model::stop::Stop;
use crate::output::schedule::Schedule;
use crate::scene::Scene;

/// What is run. Fields without a word from the study have the values of [`Experiment::new`].
#[derive(Clone, Copy)]
pub struct Experiment<'a> {
    /// what moves
    pub scene: &'a dyn Scene,
    /// method with its parameters
    pub method: &'a MethodChoice,
    /// how implicit steps are solved
    pub solver: SolverSpec,
    /// fixed or adaptive steps
    pub step: Step,
    /// [s] end of the run
    pub end: f64,
    /// [s] end of the whole run, of which this may be a part
    pub whole: f64,
    /// [s] interval of the frames, where adaptive steps of some schemes end; `None`: only the last state is one
    pub frames_every: Option<f64>,
    /// whether the run goes on past a divergence
    pub keep_going: bool,
    /// whether the run ends at an event that says so, as when the payload reaches the ground
    pub ends_by_event: bool,
    /// whether the cause of a failure is searched for
    pub explain: Explain,
    /// set when the user interrupts
    pub interrupt: Stop<'a>,
    /// number of first steps that are made one by one; later ones may be made in blocks that end at the frames
    pub single_steps: u64,
}

/// Where a run starts.
#[derive(Clone, Debug)]
pub enum Start {
    /// at the initial state of the scene
    Initial,
    /// at t = 0 from another state
    State(State),
    /// where an earlier part of the run ended
    Snapshot(Box<Snapshot>),
}

/// What a run reports on its way, in this order.
pub enum Event<'e> {
    /// the run starts at t = 0
    Started(&'e Point, Energies),
    /// a step or a block of steps is about to begin, or the run is interrupted
    Boundary(&'e Resumable<'e>),
    /// a step was accepted
    Step(AcceptedStep<'e>),
    /// the run has ended, at this state
    Finished(&'e Point),
}

/// Why there was no run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExperimentError {
    /// The method does not fit the scene.
    #[error(transparent)]
    Method(#[from] Unfit),
    /// The run could not start.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl<'a> Experiment<'a> {
    /// A run of `method` to `end` [s], without frames; failures are not explained and every step is made singly.
    pub fn new(scene: &'a dyn Scene, method: &'a MethodChoice, solver: SolverSpec, step: Step, end: f64) -> Self {
        Experiment {
            scene,
            method,
            solver,
            step,
            end,
            whole: end,
            frames_every: None,
            keep_going: false,
            ends_by_event: false,
            explain: Explain::Nothing,
            interrupt: Stop::NEVER,
            single_steps: u64::MAX,
        }
    }

    /// The scheme, bound to the scene. Several runs of one method may share it.
    ///
    /// # Errors
    /// A method that does not fit the scene.
    pub fn stepper(&self) -> Result<Stepper<'a>, Unfit> {
        Stepper::bind(self.method.scheme(self.solver), self.scene.interfaces())
    }

    /// Makes the run with a stepper of its own. `frames` visits the frames; `on_event` gets every event after it, and
    /// returns `true` to stop the run.
    ///
    /// # Errors
    /// When the run cannot start. A run that fails on its way is an [`Outcome`].
    pub fn run(
        &self,
        start: Start,
        frames: Option<&mut Sampler<'_>>,
        on_event: &mut dyn FnMut(Event<'_>, Distance) -> bool,
    ) -> Result<Outcome, ExperimentError> {
        Ok(self.run_with(&mut self.stepper()?, start, frames, on_event)?)
    }

    /// As [`Experiment::run`], with the stepper of [`Experiment::stepper`].
    ///
    /// # Errors
    /// As [`Experiment::run`].
    pub fn run_with(
        &self,
        stepper: &mut Stepper<'_>,
        start: Start,
        frames: Option<&mut Sampler<'_>>,
        on_event: &mut dyn FnMut(Event<'_>, Distance) -> bool,
    ) -> Result<Outcome, RunError> {
        self.run_beside(stepper, start, frames, std::iter::empty(), on_event)
    }

    /// As [`Experiment::run_with`], with more observers.
    ///
    /// # Errors
    /// As [`Experiment::run`].
    pub fn run_beside<'o>(
        &self,
        stepper: &mut Stepper<'_>,
        start: Start,
        frames: Option<&mut Sampler<'_>>,
        more: impl Iterator<Item = &'o mut dyn Observer>,
        on_event: &mut dyn FnMut(Event<'_>, Distance) -> bool,
    ) -> Result<Outcome, RunError> {
        let stop = AtomicBool::new(false);
        let (single_steps, frames_every, made) = (self.single_steps, self.frames_every, 0);
        let mut monitor = Monitor { frames, frames_every, single_steps, made, stop: &stop, on_event };
        let mut observers: Vec<&mut dyn Observer> = vec![&mut monitor];
        observers.extend(more.map(|observer| observer as &mut dyn Observer));
        self.observed(stepper, start, &mut observers, &stop)
    }

    /// Makes the run with these observers; it is interrupted when `stop` is set.
    ///
    /// # Errors
    /// As [`Experiment::run`].
    pub fn observed(
        &self,
        stepper: &mut Stepper<'_>,
        start: Start,
        observers: &mut [&mut dyn Observer],
        stop: &AtomicBool,
    ) -> Result<Outcome, RunError> {
        let Experiment { scene, method, solver, step, end, whole, frames_every, keep_going, .. } = *self;
        let (ends_by_event, explain, interrupt) = (self.ends_by_event, self.explain, self.interrupt);
        let spec = RunSpec::of(method.clone(), step, end);
        let spec = RunSpec { whole, solver, frames_every, keep_going, ends_by_event, explain, ..spec };
        let begins = !matches!(start, Start::Snapshot(_));
        let state = &mut match start {
            Start::Initial => RunState::start(scene, stepper, &spec, scene.initial_state())?,
            Start::State(state) => RunState::start(scene, stepper, &spec, state)?,
            Start::Snapshot(snapshot) => RunState::restore(scene, stepper, &spec, *snapshot)?,
        };
        let mut run = Run { scene, spec: &spec, stop: Stop::on(stop), interrupt, state };
        if begins { run.begin(stepper, observers) } else { run.go_on(stepper, observers) }
    }
}

/// The observer of all experiments.
struct Monitor<'m, 'f> {
    frames: Option<&'m mut Sampler<'f>>,
    frames_every: Option<f64>,
    single_steps: u64,
    made: u64,
    stop: &'m AtomicBool,
    on_event: &'m mut dyn FnMut(Event<'_>, Distance) -> bool,
}

impl Monitor<'_, '_> {
    fn tell(&mut self, event: Event<'_>) {
        let distance = self.frames.as_ref().map(|frames| frames.distance()).unwrap_or_default();
        if (self.on_event)(event, distance) {
            self.stop.store(true, Ordering::Relaxed);
        }
    }
}

impl Observer for Monitor<'_, '_> {
    fn started(&mut self, at: &Point, ledger: Energies) -> Result<(), ObserveError> {
        self.tell(Event::Started(at, ledger));
        Ok(())
    }

    fn resumable(&mut self, run: &Resumable<'_>) -> Result<(), ObserveError> {
        self.tell(Event::Boundary(run));
        Ok(())
    }

    fn wants(&self, step: UpcomingStep) -> Wants {
        match &self.frames {
            _ if self.made < self.single_steps => Wants::default(),
            Some(frames) => frames.wants(step),
            None => Wants { states: Schedule::new(self.frames_every, step.from).states(step), strain: false },
        }
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        if let Some(frames) = &mut self.frames {
            frames.accepted(step)?;
        }
        self.made += 1;
        self.tell(Event::Step(step));
        Ok(())
    }

    fn finished(&mut self, last: &Point) -> Result<(), ObserveError> {
        if let Some(frames) = &mut self.frames {
            frames.finished(last)?;
        }
        self.tell(Event::Finished(last));
        Ok(())
    }
}
