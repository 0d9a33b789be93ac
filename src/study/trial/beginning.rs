//! A run from its start, as far as its allowance takes it.

use std::sync::atomic::{AtomicBool, Ordering};

use super::sample::{Attempted, Sample, SampleError, work};
use super::timing::Clock;
use crate::drive;
use crate::drive::observer::{AcceptedStep, ObserveError, Observer, UpcomingStep, Wants};
use crate::integrate::stepper::Stepper;
use crate::scene::Scene;

/// What a run came to from its start.
#[derive(Clone, Copy, Debug)]
pub struct Beginning {
    /// all of its steps
    pub sample: Sample,
    /// [1/s] steps a second simulated, in its first quarter to half by steps, and after that
    pub pace: [f64; 2],
}

/// A run from its start until its allowance is spent, without leaving anything.
///
/// # Errors
/// Where it fails before.
pub fn beginning(scene: &dyn Scene, stepper: &mut Stepper<'_>, tried: Attempted<'_>) -> Result<Beginning, SampleError> {
    let stop = AtomicBool::new(false);
    let clock = Clock::default();
    let start = clock.seconds();
    let deadline = start + tried.allowance;
    let mut watch = Until { clock, deadline, stop: &stop, made: 0, marks: [(0, 0.0); 2] };
    let outcome = drive::run(scene, stepper, tried.spec(), &mut [&mut watch], &stop)?;
    if let Some(failure) = outcome.failure {
        return Err(SampleError::Failed { time: failure.time, cause: failure.cause });
    }
    if outcome.steps == 0 {
        return Err(SampleError::Nothing);
    }
    let sample = Sample {
        steps: outcome.steps as f64,
        simulated: outcome.t_end,
        seconds: clock.seconds() - start,
        work: work(outcome.counters).map(|n| n as f64),
    };
    Ok(Beginning { sample, pace: watch.pace(sample) })
}

/// Ends a run at a time of the clock.
struct Until<'a> {
    clock: Clock,
    /// [s]
    deadline: f64,
    stop: &'a AtomicBool,
    made: u64,
    /// steps made and the time [s] then, at the last two powers of two
    marks: [(u64, f64); 2],
}

impl Until<'_> {
    fn stepped(&mut self, t: f64) {
        self.made += 1;
        if self.made.is_power_of_two() {
            self.marks = [self.marks[1], (self.made, t)];
        }
        if self.made.is_multiple_of(16) || self.made < 16 {
            self.stop.fetch_or(self.clock.seconds() >= self.deadline, Ordering::Relaxed);
        }
    }

    fn pace(&self, all: Sample) -> [f64; 2] {
        let (steps, t) = (self.marks[0].0 as f64, self.marks[0].1);
        let mean = all.steps / all.simulated;
        if steps > 0.0 { [steps / t, (all.steps - steps) / (all.simulated - t)] } else { [mean; 2] }
    }
}

impl Observer for Until<'_> {
    fn wants(&self, _step: UpcomingStep) -> Wants {
        Wants::ACCOUNT
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.stepped(step.t);
        Ok(())
    }
}
