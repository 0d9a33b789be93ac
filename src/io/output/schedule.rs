//! When frames, rows of the history and checkpoints are due: at multiples of an interval, for any steps.

use super::checkpoint::Checkpoint;
use super::files::FilesProgress;
use super::recorder::RecorderState;
use crate::case::fingerprint::Fingerprint;
use crate::case::spec::RowEvery;
use crate::drive::observer::{Occasion, Resumable, States, UpcomingStep};
use crate::process::Stopwatch;

/// [-] share of a step; a frame this close to the end of a step shows that end
const COINCIDENT: f64 = 1e-9;

/// A time within a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeInStep {
    /// [s] time of the frame, k * every
    pub time: f64,
    /// [-] share of the step that lies before it
    pub fraction: f64,
}

/// Where in a step a frame lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrameDue {
    /// within the step
    Between(TimeInStep),
    /// at the end of the step
    End,
}

/// Frame times k * every; not accumulated, so they do not drift.
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    every: Option<f64>,
    next: u64,
}

impl Schedule {
    /// Frames after `start` [s]; `every` [s] is positive and finite, or absent for none between first and last.
    pub fn new(every: Option<f64>, start: f64) -> Self {
        let next = every.map_or(0, |every| first_after(start + tolerance(start, start), every));
        Self { every, next }
    }

    /// A schedule whose next frame has number `next`, as [`Schedule::position`] gave it.
    pub fn at(every: Option<f64>, next: u64) -> Self {
        Self { every, next }
    }

    /// Number of the next frame time.
    pub fn position(&self) -> u64 {
        self.next
    }

    /// The states of a step that the next frame needs: both ends if it lies within the step.
    pub fn states(mut self, step: UpcomingStep) -> States {
        match self.next_in(step.from, step.t) {
            Some(FrameDue::Between(_)) => States::BothEnds,
            Some(FrameDue::End) => States::End,
            None => States::None,
        }
    }

    /// The next frame in the step from `from` to `to` [s], if there is one left.
    pub fn next_in(&mut self, from: f64, to: f64) -> Option<FrameDue> {
        let every = self.every?;
        let slack = tolerance(from, to);
        let time = self.next as f64 * every;
        // In this form a time that is NaN is never due.
        let due = time <= to + slack;
        if !due {
            return None;
        }
        self.next = self.next.saturating_add(1);
        if time >= to - slack {
            // Further frames at the same end would be equal.
            self.next = self.next.max(first_after(to + slack, every));
            return Some(FrameDue::End);
        }
        Some(FrameDue::Between(TimeInStep { time, fraction: ((time - from) / (to - from)).clamp(0.0, 1.0) }))
    }
}

/// When checkpoints are due: at the end of the first step that reaches each multiple of the interval, and at the start.
#[derive(Clone, Copy, Debug)]
pub struct Intervals {
    every: f64,
    next: u64,
}

impl Intervals {
    /// From t = 0, every `every` [s], positive and finite.
    pub fn new(every: f64) -> Self {
        Self { every, next: 0 }
    }

    /// Skips all that is due up to `t` [s].
    pub fn skip(&mut self, t: f64) {
        self.next = first_after(t + tolerance(t, t), self.every);
    }

    /// Whether one is due at `t` [s]; the next is due at the next multiple.
    pub fn reached(&mut self, t: f64) -> bool {
        let due = self.next as f64 * self.every <= t + tolerance(t, t);
        if due {
            self.skip(t);
        }
        due
    }
}

/// When a run writes checkpoints.
#[derive(Clone, Debug)]
pub struct CheckpointSpec {
    /// the case they are of
    pub case: Fingerprint,
    /// [s] of simulated time between them, > 0; without it one is kept only when the run is interrupted
    pub every: Option<f64>,
    /// measures the cost of the run
    pub stopwatch: Stopwatch,
}

/// Makes the checkpoints of a run when they are due.
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
    pub(super) fn checkpoint_if_due(
        &mut self,
        run: &Resumable<'_>,
        recorder: impl FnOnce() -> RecorderState,
    ) -> Option<Box<Checkpoint>> {
        let last = run.occasion == Occasion::LastStep;
        let asked = self.intervals.as_mut().is_some_and(|i| i.reached(run.at.state.t) || last);
        (asked || run.occasion == Occasion::Interrupted).then(|| {
            Box::new(Checkpoint {
                case: self.case.clone(),
                snapshot: run.snapshot(),
                recorder: recorder(),
                // Set by the writing thread, after it has written all that was sent before.
                files: FilesProgress::default(),
                spent: self.stopwatch.read(),
            })
        })
    }
}

/// When rows of the history are due.
#[derive(Clone, Copy, Debug)]
pub enum RowSchedule {
    /// every so many steps
    Steps(u64),
    /// once in each interval of time
    Time(Intervals),
}

impl RowSchedule {
    /// From t = 0.
    pub fn of(every: RowEvery) -> Self {
        match every {
            RowEvery::Steps(steps) => RowSchedule::Steps(steps),
            RowEvery::Time(every) => RowSchedule::Time(Intervals::new(every)),
        }
    }

    /// Skips all that is due up to `t` [s].
    pub fn skip(&mut self, t: f64) {
        if let RowSchedule::Time(intervals) = self {
            intervals.skip(t);
        }
    }

    /// Whether the end of step number `step`, at `t` [s], has a row.
    pub fn due(&mut self, step: u64, t: f64) -> bool {
        match self {
            RowSchedule::Steps(every) => step.is_multiple_of(*every),
            RowSchedule::Time(intervals) => intervals.reached(t),
        }
    }
}

/// The first k with k * every beyond `time`; a cast of a float saturates, and a negative time counts as 0.
fn first_after(time: f64, every: f64) -> u64 {
    ((time / every).floor() as u64).saturating_add(1)
}

/// [s] Difference below which two times are equal: a share of a step, but at least the rounding error of the time.
pub fn tolerance(from: f64, to: f64) -> f64 {
    (COINCIDENT * (to - from).abs()).max(8.0 * f64::EPSILON * to.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(schedule: &mut Schedule, from: f64, to: f64) -> Vec<FrameDue> {
        std::iter::from_fn(|| schedule.next_in(from, to)).collect()
    }

    /// One frame a step, several in a step, none in a step; rounding of k * every and n * h does not lose one.
    #[test]
    fn frames_fall_where_they_should() {
        let mut schedule = Schedule::new(Some(0.1), 0.0);
        assert_eq!(all(&mut schedule, 0.0, 0.05), []);
        assert_eq!(all(&mut schedule, 0.05, 0.1), [FrameDue::End]);
        let wide = all(&mut schedule, 0.1, 0.3);
        use FrameDue::{Between, End};
        assert!(matches!(wide[..], [Between(at), End] if at.time == 0.2 && (at.fraction - 0.5).abs() < 1e-15));
        let mut many = Schedule::new(Some(1e-12), 0.0);
        let mut t = 0.0;
        for k in 0..1000 {
            let to = t + 1e-12;
            assert_eq!(all(&mut many, t, to), [FrameDue::End], "step {k}");
            t = to;
        }
    }

    /// A frame within a step needs the states at both of its ends, one at its end that state alone.
    #[test]
    fn states_that_frames_need() {
        let step = |k: u64| UpcomingStep { step: k + 1, from: 0.25 * k as f64, t: 0.25 * (k + 1) as f64 };
        // The first step of which a state is needed, and which.
        let first = |every: Option<f64>| {
            let needed = (0..5).map(|k| Schedule::new(every, 0.0).states(step(k)));
            needed.enumerate().find(|(_, states)| *states != States::None)
        };
        let found = [0.1, 0.25, 0.6, 1.0, 1.1, 2.0].map(|every| first(Some(every)));
        let (both, end) = (|k| Some((k, States::BothEnds)), |k| Some((k, States::End)));
        assert_eq!(found, [both(0), end(0), both(2), end(3), both(4), None]);
        assert_eq!(first(None), None);
    }

    /// A run that starts later has its next frame after that time, and none twice.
    #[test]
    fn later_start() {
        let mut schedule = Schedule::new(Some(0.1), 0.3);
        assert_eq!(all(&mut schedule, 0.3, 0.35), []);
        assert_eq!(all(&mut schedule, 0.35, 0.4), [FrameDue::End]);
        assert_eq!(all(&mut Schedule::new(None, 0.0), 0.0, 1e9), []);
    }
}
