//! States along a whole run. Other methods are tried from them, because a step at the end of a run may cost more than
//! one at its start.

use crate::drive::Snapshot;
use crate::experiment::{Event, Experiment, Start};
use crate::integrate::Counters;
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
    /// whether it ended on the ground there
    pub landed: bool,
}

impl SampledStates {
    /// Makes a run until its end, its failure, or `budget` [s] of processor time, and writes nothing. Empty if the run
    /// cannot start.
    pub fn follow(run: Experiment<'_>, budget: f64) -> SampledStates {
        let clock = Stopwatch::default();
        let deadline = clock.seconds() + budget;
        // Reading the clock takes some time, compared with the smallest step.
        Self::until(run, &mut |step, _| (step < 8 || step.is_multiple_of(8)) && clock.seconds() >= deadline)
    }

    /// The same until `enough` says so, which is given the steps and the work so far.
    pub fn until(run: Experiment<'_>, enough: &mut dyn FnMut(u64, Counters) -> bool) -> SampledStates {
        let most = (MOST_BYTES / (48 * run.scene.n_dof()).max(1)).clamp(2, MOST);
        let (mut states, mut every) = (Vec::<Snapshot>::new(), 1);
        let to_ground = run.ends_by_event;
        let outcome = run.run(Start::Initial, None, &mut |event, _| {
            let Event::Boundary(run) = event else { return false };
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
            enough(run.step, run.counters)
        });
        let (reached, landed) = outcome.map_or((0.0, false), |outcome| (outcome.t_end, outcome.landed()));
        SampledStates { states, reached, landed: landed && to_ground }
    }

    /// At most `count` states after a time [s], evenly among those that were kept.
    pub fn beyond(&self, t: f64, count: usize) -> Vec<&Snapshot> {
        let later: Vec<&Snapshot> = self.states.iter().filter(|state| state.t > t).collect();
        let every = later.len().div_ceil(count.max(1)).max(1);
        // The last one stands for the rest of the run.
        later.iter().rev().step_by(every).rev().copied().collect()
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
