//! Where a scene was stiffest and softest on the way of a run.

use crate::analysis::critical::step_by_bounds;
use crate::drive::observer::AcceptedStep;
use crate::model::state::{State, StateRef};
use crate::scene::{BoundBuffer, Scene};

/// Number of states of a run that are measured.
const LOOKS: u64 = 64;
/// [-] Measures that differ by no more than this share are the same. Of states with the same the last is kept: the
/// start is known already, and what the measure cannot see, such as a motion across springs that have come under
/// tension, another state may show.
const ROUNDING: f64 = 1e-7;

/// Now and then a measure of the critical step, from one pass over the elements.
pub(super) struct Evidence<'a> {
    scene: &'a dyn Scene,
    every: u64,
    room: BoundBuffer,
    /// [s] least and largest measure, and where
    seen: [(f64, State); 2],
}

impl<'a> Evidence<'a> {
    pub fn new(scene: &'a dyn Scene, steps: u64) -> Self {
        let start = scene.initial_state();
        let seen = [(f64::INFINITY, start.clone()), (f64::NEG_INFINITY, start)];
        // Odd, so that a motion that alternates is seen on both sides.
        Evidence { scene, every: steps.div_ceil(LOOKS) | 1, room: BoundBuffer::default(), seen }
    }

    pub fn look(&mut self, at: StateRef<'_>) {
        let now = step_by_bounds(self.scene, at, &mut self.room);
        let [(least, stiffest), (largest, softest)] = &mut self.seen;
        if now < (1.0 + ROUNDING) * *least {
            *least = least.min(now);
            stiffest.copy_from(at);
        }
        if now > (1.0 - ROUNDING) * *largest {
            *largest = largest.max(now);
            softest.copy_from(at);
        }
    }

    pub fn stepped(&mut self, step: &AcceptedStep<'_>) {
        if let Some(end) = step.end.filter(|_| step.step.is_multiple_of(self.every)) {
            self.look(end.state.as_ref());
        }
    }

    pub fn extremes(self) -> [State; 2] {
        self.seen.map(|(_, state)| state)
    }
}
