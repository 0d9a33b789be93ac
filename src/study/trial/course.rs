//! States sampled along a whole run, from which other methods are tried: a step at the end of a run may cost more than
//! one at its start.

use std::sync::atomic::{AtomicBool, Ordering};

use super::timing::Clock;
use crate::drive::clock::{Step, Tolerance};
use crate::drive::observer::{AcceptedStep, ObserveError, Observer, Resumable};
use crate::drive::{self, Explain, RunSpec, Snapshot};
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::MethodChoice;
use crate::integrate::stepper::Stepper;
use crate::model::stop::Stop;
use crate::scene::Scene;

/// States kept at most.
const KEPT: usize = 16;
/// [byte] they may take.
const ROOM: usize = 64 << 20;

/// What leads the way.
#[derive(Clone, Copy, Debug)]
pub struct Pilot<'a> {
    /// a method that is cheap a step
    pub method: &'a MethodChoice,
    /// how its steps are solved
    pub solver: SolverSpec,
    /// [s] end of the run
    pub end: f64,
    /// tolerance of its steps
    pub tolerance: Tolerance,
    /// [s] processor time it may take
    pub budget: f64,
}

/// A state to try methods from.
#[derive(Clone, Debug)]
pub struct Window {
    /// the state, as the pilot left it
    pub state: Snapshot,
}

/// States on the way of a run.
#[derive(Clone, Debug, Default)]
pub struct Course {
    states: Vec<Snapshot>,
    /// [s] how far the pilot came
    pub reached: f64,
}

impl Course {
    /// Follows a pilot until its end, its failure or the end of its budget; nothing of it is written. Empty when it
    /// cannot start.
    pub fn follow(scene: &dyn Scene, pilot: Pilot<'_>) -> Course {
        let Ok(mut stepper) = Stepper::bind(pilot.method.scheme(pilot.solver), scene.abilities()) else {
            return Course::default();
        };
        let step = Step::Adaptive(pilot.tolerance);
        let spec = RunSpec {
            end: pilot.end,
            step,
            frames_every: None,
            keep_going: false,
            explain: Explain::Nothing,
            interrupt: Stop::NEVER,
            method: pilot.method,
        };
        let stop = AtomicBool::new(false);
        let most = (ROOM / (48 * scene.n_dof()).max(1)).clamp(2, KEPT);
        let (clock, start) = (Clock::default(), Clock::default().seconds());
        let deadline = start + pilot.budget;
        let mut keeper = Keeper { states: Vec::new(), every: 1, most, stop: &stop, clock, deadline };
        let reached = match drive::run(scene, &mut stepper, spec, &mut [&mut keeper], &stop) {
            Ok(outcome) => outcome.t_end,
            Err(_) => 0.0,
        };
        Course { states: keeper.states, reached }
    }

    /// At most `count` states, each the one nearest to the middle of its part of the way.
    pub fn windows(&self, count: usize) -> Vec<Window> {
        let mut chosen: Vec<usize> = Vec::new();
        for part in 0..count {
            let middle = self.reached * (part as f64 + 0.5) / count as f64;
            let off = |i: &usize| (self.states[*i].t - middle).abs();
            if let Some(nearest) = (0..self.states.len()).min_by(|a, b| off(a).total_cmp(&off(b))) {
                chosen.push(nearest);
            }
        }
        chosen.dedup();
        chosen.into_iter().map(|i| Window { state: self.states[i].clone() }).collect()
    }
}

/// Keeps every so many states; when there are too many, every other one.
struct Keeper<'a> {
    states: Vec<Snapshot>,
    every: u64,
    most: usize,
    stop: &'a AtomicBool,
    clock: Clock,
    /// [s]
    deadline: f64,
}

impl Observer for Keeper<'_> {
    fn resumable(&mut self, run: &Resumable<'_>) -> Result<(), ObserveError> {
        if self.states.last().is_some_and(|last| run.step < last.step + self.every) {
            return Ok(());
        }
        if self.states.len() >= self.most {
            let mut index = 0;
            self.states.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.every *= 2;
        }
        if self.states.last().is_none_or(|last| run.step >= last.step + self.every) {
            self.states.push(run.snapshot());
        }
        Ok(())
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        // A clock is read in less time than the smallest step takes, but not in no time.
        if step.step.is_multiple_of(8) || step.step < 8 {
            self.stop.fetch_or(self.clock.seconds() >= self.deadline, Ordering::Relaxed);
        }
        Ok(())
    }
}
