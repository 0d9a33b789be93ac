//! A run from its start, as far as its allowance takes it.

use super::sample::{Attempted, Sample, SampleError, work};
use super::timing::Clock;
use crate::integrate::stepper::Stepper;
use crate::scene::Scene;
use crate::study::experiment::{Event, Experiment, Flow, Start};

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
    let clock = Clock::default();
    let start = clock.seconds();
    let deadline = start + tried.allowance;
    // Steps made and the time [s] then, at the last two powers of two.
    let (mut made, mut marks) = (0_u64, [(0_u64, 0.0); 2]);
    let experiment = Experiment { single_steps: 0, ..tried.experiment(scene) };
    let outcome = experiment.run_with(stepper, Start::Initial, None, &mut |event, _| {
        let Event::Step(step) = event else { return Flow::Continue };
        made += 1;
        if made.is_power_of_two() {
            marks = [marks[1], (made, step.t)];
        }
        let look = made < 16 || made.is_multiple_of(16);
        Flow::stop_if(look && clock.seconds() >= deadline)
    })?;
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
    let (steps, t) = (marks[0].0 as f64, marks[0].1);
    let pace = match steps > 0.0 {
        true => [steps / t, (sample.steps - steps) / (sample.simulated - t)],
        false => [sample.pace(); 2],
    };
    Ok(Beginning { sample, pace })
}
