//! States sampled along a whole run. Other methods are tried from them, because a step at the end of a run may cost
//! more than one at its start.

use super::timing::Clock;
use crate::drive::Snapshot;
use crate::drive::clock::{Step, Tolerance};
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::MethodChoice;
use crate::scene::Scene;
use crate::study::experiment::{Event, Experiment, Flow, Start};

/// States kept at most.
const KEPT: usize = 16;
/// [byte] they may take.
const ROOM: usize = 64 << 20;

/// A cheap run whose states are sampled.
#[derive(Clone, Copy, Debug)]
pub struct Probe<'a> {
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

/// States on the way of a run.
#[derive(Clone, Debug, Default)]
pub struct SampledStates {
    states: Vec<Snapshot>,
    /// [s] how far the probe came
    pub reached: f64,
}

impl SampledStates {
    /// Runs a probe until its end, its failure or the end of its budget, and writes nothing. Empty if the probe cannot
    /// start.
    pub fn follow(scene: &dyn Scene, probe: Probe<'_>) -> SampledStates {
        let Probe { method, solver, end, tolerance, budget } = probe;
        let experiment = Experiment::new(scene, method, solver, Step::Adaptive(tolerance), end);
        let most = (ROOM / (48 * scene.n_dof()).max(1)).clamp(2, KEPT);
        let (mut states, mut every) = (Vec::<Snapshot>::new(), 1);
        let clock = Clock::default();
        let deadline = clock.seconds() + budget;
        let run = experiment.run(Start::Initial, None, &mut |event, _| match event {
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
                Flow::Continue
            }
            // A clock is read in less time than the smallest step takes, but not in no time.
            Event::Step(step) => {
                let look = step.step < 8 || step.step.is_multiple_of(8);
                Flow::stop_if(look && clock.seconds() >= deadline)
            }
            _ => Flow::Continue,
        });
        SampledStates { states, reached: run.map_or(0.0, |outcome| outcome.t_end) }
    }

    /// At most `count` states, each the one nearest to the middle of its part of the way.
    pub fn states(&self, count: usize) -> Vec<Snapshot> {
        let mut chosen: Vec<usize> = Vec::new();
        for part in 0..count {
            let middle = self.reached * (part as f64 + 0.5) / count as f64;
            let off = |i: &usize| (self.states[*i].t - middle).abs();
            if let Some(nearest) = (0..self.states.len()).min_by(|a, b| off(a).total_cmp(&off(b))) {
                chosen.push(nearest);
            }
        }
        chosen.dedup();
        chosen.into_iter().map(|i| self.states[i].clone()).collect()
    }
}
