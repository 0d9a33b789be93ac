//! States along a whole run. Other methods are tried from them, because a step at the end of a run may cost more than
//! one at its start.

use crate::drive::Snapshot;
use crate::experiment::{Event, Experiment, Start};
use crate::process::Stopwatch;

/// States kept at most.
const MOST: usize = 16;
/// [byte] they may take.
const MOST_BYTES: usize = 64 << 20;

/// States on the way of a run.
#[derive(Clone, Debug, Default)]
pub struct SampledStates {
    states: Vec<Snapshot>,
    /// [s] how far the run came
    pub reached: f64,
}

impl SampledStates {
    /// Makes a run until its end, its failure, or `budget` [s] of processor time, and writes nothing. Empty if the run
    /// cannot start.
    pub fn follow(run: Experiment<'_>, budget: f64) -> SampledStates {
        let most = (MOST_BYTES / (48 * run.scene.n_dof()).max(1)).clamp(2, MOST);
        let (mut states, mut every) = (Vec::<Snapshot>::new(), 1);
        let clock = Stopwatch::default();
        let deadline = clock.seconds() + budget;
        let outcome = run.run(Start::Initial, None, &mut |event, _| match event {
            Event::Boundary(run) => {
                let due = |states: &[Snapshot], every| states.last().is_none_or(|last| run.step >= last.step + every);
                if due(&states, every) && states.len() >= most {
                    let mut even = false;
                    states.retain(|_| {
                        even = !even;
                        even
                    });
                    every *= 2;
                }
                if due(&states, every) {
                    states.push(run.snapshot());
                }
                false
            }
            // Reading the clock takes some time, compared with the smallest step.
            Event::Step(step) => {
                let look = step.step < 8 || step.step.is_multiple_of(8);
                look && clock.seconds() >= deadline
            }
            _ => false,
        });
        SampledStates { states, reached: outcome.map_or(0.0, |outcome| outcome.t_end) }
    }

    /// At most `count` states: for each of `count` equal parts of the run the one nearest to its middle, each once.
    pub fn states(&self, count: usize) -> Vec<Snapshot> {
        let nearest = |part: usize| {
            let middle = self.reached * (part as f64 + 0.5) / count as f64;
            let off = |state: &Snapshot| (state.t - middle).abs();
            (0..self.states.len()).min_by(|a, b| off(&self.states[*a]).total_cmp(&off(&self.states[*b])))
        };
        let mut chosen: Vec<usize> = (0..count).filter_map(nearest).collect();
        chosen.dedup();
        chosen.into_iter().map(|i| self.states[i].clone()).collect()
    }
}
