//! One whole run of a case without files: its quantities, its motion, and what it costs.

use std::sync::atomic::{AtomicBool, Ordering};

use super::error::StudyError;
use super::experiment::{Experiment, Start};
use super::frames::{Frames, Sampler};
use crate::case::spec::Problem;
use crate::drive::clock::Step;
use crate::drive::observer::{AcceptedStep, ObserveError, Observer, Resumable, UpcomingStep, Wants};
use crate::drive::{Outcome, RunError, Status};
use crate::integrate::Counters;
use crate::integrate::registry::MethodChoice;
use crate::model::stop::Stop;
use crate::output::gauges::{MeasuredQuantity, Peak};
use crate::output::largest::LargestValues;
use crate::process::{Cost, Stopwatch};
use crate::scene::Scene;

/// What a run is made with.
#[derive(Clone, Copy)]
pub struct WholeRunSpec<'a> {
    /// what moves
    pub scene: &'a dyn Scene,
    /// the case without its system
    pub problem: &'a Problem,
    /// [s] interval of the frames
    pub every: f64,
    /// [s] end of the run, perhaps before that of the case
    pub end: f64,
    /// the method
    pub method: &'a MethodChoice,
    /// the steps
    pub step: Step,
    /// [s] interval of the frames that are kept, for the motion; `None`: none are
    pub frames: Option<f64>,
    /// most work, as [`WholeRun::work`] counts it; the run is stopped beyond it
    pub most_work: u64,
    /// whether so many steps and this work are enough; the run is stopped at the next state that it could be resumed
    /// from
    pub enough: Option<&'a dyn Fn(f64, Counters) -> bool>,
    /// set when the user interrupts
    pub interrupt: &'a AtomicBool,
}

/// A place on the way of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mark {
    /// steps made
    pub steps: u64,
    /// [s] time of the run
    pub t: f64,
    /// [s] processor time
    pub seconds: f64,
}

/// A run and its numbers.
#[derive(Clone, Debug)]
pub struct WholeRun {
    /// the steps
    pub step: Step,
    /// how it ended
    pub status: Status,
    /// why, if not well
    pub note: String,
    /// [s] when it failed; `None` if it did not
    pub failed_at: Option<f64>,
    /// accepted steps
    pub steps: u64,
    /// [s] time it came to
    pub t_end: f64,
    /// whether it has ended on the ground
    pub landed: bool,
    /// counted work
    pub counters: Counters,
    /// force passes for the account alone
    pub account_passes: u64,
    /// [s] processor time
    pub seconds: f64,
    /// where its later part begins: between a quarter and a half of its steps
    pub late: Mark,
    /// the quantities
    pub quantities: Vec<MeasuredQuantity>,
    /// the peaks of its gauges
    pub peaks: Vec<Peak>,
    /// the frames, if they are kept
    pub frames: Option<Frames>,
}

impl WholeRun {
    /// Whether it reached its end.
    pub fn completed(&self) -> bool {
        self.status == Status::Completed
    }

    /// [s] When the whole run ends, which is planned to `end` [s]: at the landing, if it has come to it.
    pub fn whole_end(&self, end: f64) -> f64 {
        if self.landed { self.t_end } else { end }
    }

    /// Counted work: steps and Newton iterations.
    pub fn work(&self) -> u64 {
        self.steps + self.counters.newton_iterations
    }

    /// The values of a quantity on the way to the end; none unless the run reached it.
    pub fn late(&self, name: &str) -> Option<&[f64]> {
        let of = self.quantities.iter().find(|quantity| quantity.name == name).filter(|_| self.completed());
        of.map(|quantity| quantity.late.as_slice())
    }

    /// The value of a quantity; none unless the run reached its end.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.quantities.iter().find(|quantity| quantity.name == name)?.value.filter(|_| self.completed())
    }
}

/// Counted work of a step.
fn work_of(newton_iterations: u32) -> u64 {
    1 + u64::from(newton_iterations)
}

/// The observer that counts work, and ends the run beyond the most.
struct Limit<'a> {
    left: u64,
    made: u64,
    /// at the last two powers of two of steps
    marks: [Mark; 2],
    watch: Stopwatch,
    enough: Option<&'a dyn Fn(f64, Counters) -> bool>,
    interrupt: Stop<'a>,
    stop: &'a AtomicBool,
}

impl Observer for Limit<'_> {
    fn resumable(&mut self, run: &Resumable<'_>) -> Result<(), ObserveError> {
        if self.enough.is_some_and(|enough| enough(run.step as f64, run.counters)) {
            self.stop.store(true, Ordering::Relaxed);
        }
        Ok(())
    }

    fn wants(&self, _step: UpcomingStep) -> Wants {
        Wants::ACCOUNT
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.left = self.left.saturating_sub(work_of(step.newton_iterations));
        self.made += 1;
        if self.made.is_power_of_two() {
            let mark = Mark { steps: self.made, t: step.t, seconds: self.watch.seconds() };
            self.marks = [self.marks[1], mark];
        }
        if self.left == 0 || self.interrupt.asked() {
            self.stop.store(true, Ordering::Relaxed);
        }
        Ok(())
    }
}

impl WholeRunSpec<'_> {
    /// Makes the run. One that cannot start has its reason in `note`.
    ///
    /// # Errors
    /// An interrupt, or a quantity that is not there.
    pub fn run(&self) -> Result<WholeRun, StudyError> {
        let WholeRunSpec { scene, problem, every, end, method, step, interrupt, .. } = *self;
        let experiment = Experiment {
            whole: problem.time.end,
            frames_every: Some(every),
            ends_by_event: problem.time.to_ground,
            interrupt: Stop::on(interrupt),
            ..Experiment::new(scene, method, problem.solver, step, end)
        };
        let measured = LargestValues::new(scene, &problem.output, problem.time.end, None);
        let mut measured = measured.map_err(|why| StudyError::Usage(why.to_string()))?;
        let mut sampler = self.frames.map(|every| Sampler::keeping(scene, every));
        let stop = AtomicBool::new(false);
        let (watch, most) = (Stopwatch::of_thread(Cost::default()), self.most_work);
        let mut limit = Limit {
            left: most,
            made: 0,
            marks: [Mark::default(); 2],
            watch,
            enough: self.enough,
            interrupt: Stop::on(interrupt),
            stop: &stop,
        };
        let mut observers: Vec<&mut dyn Observer> = vec![&mut measured, &mut limit];
        observers.extend(sampler.as_mut().map(|sampler| sampler as &mut dyn Observer));
        let made = match experiment.stepper() {
            Ok(mut stepper) => experiment.observed(&mut stepper, Start::Initial, &mut observers, &stop),
            Err(why) => return Ok(self.without(why.to_string())),
        };
        let (seconds, mark) = (limit.watch.seconds(), limit.marks[0]);
        if Stop::on(interrupt).asked() {
            return Err(StudyError::Interrupted);
        }
        let outcome = match made {
            Ok(outcome) => outcome,
            Err(RunError::Start(why)) => return Ok(self.without(why.to_string())),
            Err(why) => return Err(StudyError::Usage(why.to_string())),
        };
        let landed = problem.time.to_ground && outcome.landed();
        let Outcome { status, steps, t_end, counters, account_passes, failure, .. } = outcome;
        Ok(WholeRun {
            step,
            status,
            failed_at: failure.as_ref().map(|failure| failure.time),
            note: failure.map_or_else(String::new, |failure| failure.cause),
            steps,
            t_end,
            landed,
            counters,
            account_passes,
            seconds,
            late: mark,
            quantities: measured.quantities(),
            peaks: measured.peaks(),
            frames: sampler.map(Sampler::into_frames),
        })
    }

    fn without(&self, note: String) -> WholeRun {
        WholeRun {
            step: self.step,
            status: Status::NotConverged,
            note,
            failed_at: Some(0.0),
            steps: 0,
            t_end: 0.0,
            landed: false,
            counters: Counters::default(),
            account_passes: 0,
            seconds: 0.0,
            late: Mark::default(),
            quantities: Vec::new(),
            peaks: Vec::new(),
            frames: None,
        }
    }
}
