//! When a checkpoint is kept.

use super::checkpoint::Checkpoint;
use super::files::FilesProgress;
use super::recorder::RecorderState;
use super::schedule::Intervals;
use crate::case::fingerprint::Fingerprint;
use crate::drive::observer::{Occasion, Resumable};
use crate::process::Stopwatch;

/// How checkpoints are kept.
#[derive(Clone, Debug)]
pub struct CheckpointSpec {
    /// the case they are of
    pub case: Fingerprint,
    /// [s] of simulated time between them, > 0; without it one is kept only when the run is interrupted
    pub every: Option<f64>,
    /// measures what the run costs
    pub stopwatch: Stopwatch,
}

/// Keeps checkpoints.
#[derive(Debug)]
pub(super) struct CheckpointSchedule {
    case: Fingerprint,
    intervals: Option<Intervals>,
    stopwatch: Stopwatch,
}

impl CheckpointSchedule {
    pub(super) fn new(spec: CheckpointSpec) -> Self {
        let CheckpointSpec { case, every, stopwatch } = spec;
        CheckpointSchedule { case, intervals: every.map(Intervals::new), stopwatch }
    }

    /// The run begins at `t` [s], of which there is a checkpoint already.
    pub(super) fn skip(&mut self, t: f64) {
        if let Some(intervals) = &mut self.intervals {
            intervals.skip(t);
        }
    }

    /// Whether one is due at `t` [s].
    pub(super) fn due(&self, t: f64) -> bool {
        self.intervals.is_some_and(|mut intervals| intervals.reached(t))
    }

    /// A checkpoint, if one is due: at t = 0, at each interval, and before the last step, but only if the case asks for
    /// them; when interrupted in any case.
    pub(super) fn keep(&mut self, run: &Resumable<'_>, recorder: RecorderState) -> Option<Box<Checkpoint>> {
        let last = run.occasion == Occasion::LastStep;
        let asked = self.intervals.as_mut().is_some_and(|i| i.reached(run.at.state.t) || last);
        (asked || run.occasion == Occasion::Interrupted).then(|| {
            Box::new(Checkpoint {
                case: self.case.clone(),
                snapshot: run.snapshot(),
                recorder,
                // Known to the writing thread, once it has written what was sent so far.
                files: FilesProgress::default(),
                spent: self.stopwatch.read(),
            })
        })
    }
}
