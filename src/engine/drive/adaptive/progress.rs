//! Whether a run makes progress. Even with steps above the floor it might need too many of them to end.

use serde::{Deserialize, Serialize};

/// Number of steps within which a run must advance by [`LEAST`].
pub(super) const STEPS: u32 = 10_000;
/// [-] of the run: at this rate it would take 1e12 steps.
const LEAST: f64 = 1e-8;

/// Part of a checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Progress {
    /// [s] time when the count began
    since: f64,
    /// accepted steps from then
    steps: u32,
}

impl Progress {
    /// After an accepted step that ended at `t` [s] of a run of `run` [s]: the time [s] that the last [`STEPS`] took,
    /// if it is too little. The count begins again where a step ends at the row of a table: tables are finite, so such
    /// steps come to an end.
    pub(super) fn stalls(&mut self, t: f64, at_row: bool, run: f64) -> Option<f64> {
        self.steps += 1;
        if self.steps < STEPS && !at_row {
            return None;
        }
        let gone = t - self.since;
        *self = Progress { since: t, steps: 0 };
        (!at_row && gone < LEAST * run).then_some(gone)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of steps of `h` [s] after which a run of 1 s counts as stalled.
    fn stalls_after(h: f64, rows: bool) -> Option<u32> {
        let mut progress = Progress::default();
        (1..=3 * STEPS).find(|&i| progress.stalls(f64::from(i) * h, rows && i % 1000 == 0, 1.0).is_some())
    }

    #[test]
    fn steps_of_a_rounding_end_and_steps_of_any_sense_do_not() {
        assert_eq!(stalls_after(5e-13, false), Some(STEPS));
        assert_eq!(stalls_after(2e-12, false), None);
        assert_eq!(stalls_after(5e-13, true), None);
    }
}
