//! One run of a study whose runs are planned: measured without files, and saved where it may stop.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::error::StudyError;
use super::experiment::{Experiment, Start};
use super::forecast::nominal::NominalCosts;
use super::keeper::{Course, Keeper};
use super::measure::measured;
use super::row::RunResult;
use super::store::{Store, StudyJob, StudyPlan, Unfinished};
use crate::case::spec::Problem;
use crate::drive::event::Fired;
use crate::drive::max_displacement::MaxDisplacement;
use crate::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, Point, Resumable, UpcomingStep, Wants};
use crate::drive::{Explain, RunError, Status};
use crate::model::added_mass::AddedMass;
use crate::model::stop::Stop;
use crate::output::gauges::{MeasuredQuantity, Peak};
use crate::output::largest::{LargestSoFar, LargestValues};
use crate::process::{Cost, Stopwatch};
use crate::simulation::{SetupError, build_scene};

/// A run that is to be made.
pub(super) struct SavedRun<'a, P: StudyPlan> {
    /// where it is saved
    pub store: &'a Store<P>,
    /// the run
    pub job: &'a P::Job,
    /// when the budget is spent
    pub deadline: Option<Instant>,
    /// set when the user interrupts
    pub interrupt: &'a AtomicBool,
}

/// How a run ended, if the user did not interrupt it.
pub(super) enum SavedEnd {
    Done(Box<Measured>),
    /// the scene or its start does not allow it, and why
    Refused(String),
    /// the budget was spent at this time [s] of the run, where it is saved
    OutOfTime(f64),
}

/// What a run has measured.
pub(super) struct Measured {
    /// how it ended, and its cost
    pub run: RunResult,
    /// [m/s] largest speed of a node
    pub max_speed: f64,
    /// [-] largest strain of a spring
    pub max_strain: f64,
    /// [m] largest displacement of a node at the end
    pub displacement_end: f64,
    /// largest values of the gauges
    pub peaks: Vec<Peak>,
    /// the quantities
    pub quantities: Vec<MeasuredQuantity>,
    /// [s] its counted work at nominal costs
    pub work: f64,
    /// what mass scaling has added
    pub mass_scaling: Option<AddedMass>,
}

impl<P: StudyPlan> SavedRun<'_, P> {
    /// Makes the run, from where an earlier process left it.
    ///
    /// # Errors
    /// An interrupt, a quantity that is not there, or files of the study that cannot be written.
    pub(super) fn make(&self, mut problem: Problem) -> Result<SavedEnd, StudyError> {
        let &SavedRun { store, job, deadline, interrupt } = self;
        let scene = match build_scene(problem.take_system(), 1) {
            Ok(scene) => scene,
            Err(why @ SetupError::Threads(_)) => return Err(why.into()),
            Err(why) => return Ok(SavedEnd::Refused(why.to_string())),
        };
        let experiment = Experiment {
            frames_every: problem.output.frames_every,
            explain: Explain::Failures,
            ends_by_event: problem.time.to_ground,
            interrupt: Stop::on(interrupt),
            ..Experiment::new(&*scene, &problem.method, problem.solver, problem.time.step, problem.time.end)
        };
        let mut stepper = match experiment.stepper() {
            Ok(stepper) => stepper,
            Err(why) => return Ok(SavedEnd::Refused(why.to_string())),
        };
        let earlier: Option<Unfinished<LargestSoFar>> = store.unfinished(job);
        let spent = earlier.as_ref().map_or(0.0, |earlier| earlier.spent);
        let before = Cost { cpu: (spent > 0.0).then_some(spent), wall: Duration::from_secs_f64(spent) };
        let stop = AtomicBool::new(false);
        let so_far = earlier.as_ref().map(|earlier| &earlier.measured);
        let largest = LargestValues::new(&*scene, &problem.output, problem.time.end, so_far)
            .map_err(|why| StudyError::Usage(why.to_string()))?;
        let mut watcher = Watcher {
            of: self,
            largest,
            keeper: Keeper::new(scene.n_dof(), interrupt, deadline),
            watch: Stopwatch::of_thread(before),
            stop: &stop,
        };
        let mut farthest = MaxDisplacement::new(&*scene);
        let start = earlier.map_or(Start::Initial, |earlier| Start::Snapshot(Box::new(earlier.snapshot)));
        let run = experiment.observed(&mut stepper, start, &mut [&mut watcher, &mut farthest], &stop);
        let Watcher { largest, keeper, watch, .. } = watcher;
        let seconds = watch.seconds();
        keeper.done()?;
        let outcome = match run {
            Ok(outcome) => outcome,
            Err(RunError::Start(why)) => return Ok(SavedEnd::Refused(why.to_string())),
            Err(why) => return Err(StudyError::Usage(format!("{}: {why}", job.id()))),
        };
        // A failure whose cause was not searched to the end is not a result yet.
        if interrupt.load(Ordering::Relaxed) && outcome.status != Status::Completed {
            return Err(StudyError::Interrupted);
        }
        if outcome.status == Status::Interrupted {
            return Ok(SavedEnd::OutOfTime(outcome.t_end));
        }
        let so_far = largest.so_far();
        let steps = (outcome.steps + outcome.rejected_steps) as f64;
        let work = NominalCosts::of_run(&*scene, outcome.linear.as_ref()).cost(steps, outcome.counters.into());
        Ok(SavedEnd::Done(Box::new(Measured {
            run: measured(&outcome, None, seconds),
            max_speed: so_far.speed,
            max_strain: so_far.strain,
            displacement_end: farthest.found.distance,
            peaks: largest.peaks(),
            quantities: largest.quantities(),
            work,
            mass_scaling: scene.added_mass(),
        })))
    }
}

/// The observer of a run: measures, and saves the run where it may stop.
struct Watcher<'a, 's, P: StudyPlan> {
    of: &'a SavedRun<'a, P>,
    largest: LargestValues<'s>,
    keeper: Keeper<'a>,
    watch: Stopwatch,
    stop: &'a AtomicBool,
}

impl<P: StudyPlan> Observer for Watcher<'_, '_, P> {
    fn started(&mut self, at: &Point, ledger: Energies) -> Result<(), ObserveError> {
        self.largest.started(at, ledger)
    }

    fn resumed(&mut self, at: &Point, ledger: Energies) -> Result<(), ObserveError> {
        self.largest.resumed(at, ledger)
    }

    fn resumable(&mut self, run: &Resumable<'_>) -> Result<(), ObserveError> {
        let Self { of, largest, watch, .. } = self;
        let course = self.keeper.goes_on(run.occasion, || {
            let unfinished =
                Unfinished { snapshot: run.snapshot(), measured: largest.so_far(), spent: watch.seconds() };
            of.store.keep_unfinished(of.job, &unfinished)
        });
        if course == Course::Ends {
            self.stop.store(true, Ordering::Relaxed);
        }
        Ok(())
    }

    fn wants(&self, step: UpcomingStep) -> Wants {
        self.largest.wants(step)
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        // A case without frames has no other place where it is seen.
        if self.of.interrupt.load(Ordering::Relaxed) {
            self.stop.store(true, Ordering::Relaxed);
        }
        self.largest.accepted(step)
    }

    fn event(&mut self, event: &Fired) -> Result<(), ObserveError> {
        self.largest.event(event)
    }

    fn failed(&mut self) -> Result<(), ObserveError> {
        self.largest.failed()
    }

    fn finished(&mut self, last: &Point) -> Result<(), ObserveError> {
        self.largest.finished(last)
    }
}
