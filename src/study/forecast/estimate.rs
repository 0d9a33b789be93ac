//! The cost of a whole run, estimated from a few real steps sampled along it.

use super::sample::{Sample, StartSample};
use super::work::Work;

/// [-] If the numbers of steps per second of parts of a run differ by more, the estimate is doubtful.
const UNEVEN: f64 = 3.0;

/// Whether paces [1/s] differ by more than figures are worth.
fn differ(paces: impl Iterator<Item = f64>) -> bool {
    let [least, most] = paces.fold([f64::INFINITY, 0.0], |[a, b]: [f64; 2], pace| [a.min(pace), b.max(pace)]);
    most > UNEVEN * least
}

/// The source of an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// real steps of this method on this scene
    Steps,
    /// the cost of one tangent, and iterations as another method needs them
    Counts,
}

/// The estimated cost of a run.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// what it rests on
    pub basis: Basis,
    /// whether it may be wrong by more than a few times: adaptive steps that change along the run, which was not made
    /// to its end, or fixed steps that were tried from rough states alone, which cost more
    pub doubtful: bool,
    /// [-] accepted steps to the end
    pub steps: f64,
    /// [s] mean step
    pub mean_step: f64,
    /// [s] processor time a step, without output
    pub step_seconds: f64,
    /// [s] processor time of the whole run, start-up and output included
    pub cpu_seconds: f64,
    /// [-] counted work
    #[serde(flatten)]
    pub work: Work,
}

impl Estimate {
    /// A run to `end` [s] in `steps` steps of one size, or else in as many as the samples need; each sample stands for
    /// an equal part of the run. `None` without samples.
    pub fn of(samples: &[Sample], end: f64, steps: Option<u64>) -> Option<Estimate> {
        if samples.is_empty() {
            return None;
        }
        let share = 1.0 / samples.len() as f64;
        let total = |of: &dyn Fn(&Sample) -> f64| -> f64 {
            let part = |s: &Sample| match steps {
                Some(steps) => of(s) / s.steps * steps as f64,
                None => of(s) / s.simulated * end,
            };
            samples.iter().map(|s| share * part(s)).sum()
        };
        let made = steps.map_or_else(|| total(&|s| s.steps), |steps| steps as f64).max(1.0);
        let seconds = total(&|s| s.seconds);
        Some(Estimate {
            basis: Basis::Steps,
            doubtful: steps.is_none() && differ(samples.iter().map(Sample::pace)),
            steps: made,
            mean_step: end / made,
            step_seconds: seconds / made,
            cpu_seconds: seconds,
            work: Work::each(|kind| total(&|s| kind(&s.work))),
        })
    }

    /// An adaptive run to `end` [s] that was made from its start, samples standing for equal parts of what is left;
    /// without them it goes on as it did last.
    pub fn begun(made: &StartSample, later: &[Sample], end: f64) -> Estimate {
        let StartSample { sample: first, pace } = *made;
        let rest = (end - first.simulated).max(0.0);
        let last = Estimate::from_one(&first, rest, pace[1] * rest);
        let left = if rest > 0.0 { Estimate::of(later, rest, None).unwrap_or(last) } else { last };
        let paces = pace.into_iter().chain(later.iter().map(Sample::pace));
        let add = |own: f64, left: f64| if rest > 0.0 { own + left } else { own };
        let whole = Sample {
            steps: add(first.steps, left.steps),
            simulated: end,
            seconds: add(first.seconds, left.cpu_seconds),
            work: Work::each(|kind| add(kind(&first.work), kind(&left.work))),
        };
        Estimate { doubtful: rest > 0.0 && differ(paces), ..Estimate::from_one(&whole, end, whole.steps) }
    }

    /// A run to `end` [s] in `steps` steps like those of a sample.
    pub fn from_one(sample: &Sample, end: f64, steps: f64) -> Estimate {
        let share = steps / sample.steps;
        Estimate {
            basis: Basis::Steps,
            doubtful: false,
            steps,
            mean_step: end / steps,
            step_seconds: sample.seconds / sample.steps,
            cpu_seconds: sample.seconds * share,
            work: sample.work.times(share),
        }
    }

    /// The same with the processor time [s] of start-up and of results written.
    #[must_use]
    pub fn with(self, seconds: f64) -> Estimate {
        Estimate { cpu_seconds: self.cpu_seconds + seconds, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run that is dear in one half and cheap in the other costs the mean of fixed steps, but of adaptive ones the
    /// mean a second simulated.
    #[test]
    fn parts_of_a_run_count_by_the_time_they_stand_for() {
        let dear = Sample { steps: 2.0, simulated: 1.0, seconds: 4.0, work: Work::each(|_| 6.0) };
        let cheap = Sample { steps: 1.0, simulated: 2.0, seconds: 1.0, work: Work::each(|_| 2.0) };
        let fixed = Estimate::of(&[dear, cheap], 10.0, Some(10)).expect("samples");
        assert_eq!((fixed.steps, fixed.cpu_seconds, fixed.work.force_evaluations), (10.0, 15.0, 25.0));
        let adaptive = Estimate::of(&[dear, cheap], 10.0, None).expect("samples");
        assert_eq!((adaptive.steps, adaptive.cpu_seconds, adaptive.mean_step), (12.5, 22.5, 0.8));
        assert!(Estimate::of(&[], 1.0, None).is_none());
        assert!(adaptive.doubtful && !fixed.doubtful);
    }

    /// Steps that were made count as they are, samples for the rest only, and a pace that changes makes a doubt unless
    /// the end was seen.
    #[test]
    fn a_run_that_was_begun_goes_on_as_later_samples_do() {
        let sample = Sample { steps: 100.0, simulated: 1.0, seconds: 10.0, work: Work::each(|_| 100.0) };
        let begun = StartSample { sample, pace: [50.0, 150.0] };
        let later = Sample { steps: 1.0, simulated: 0.1, seconds: 0.2, work: Work::each(|_| 2.0) };
        let run = Estimate::begun(&begun, &[later], 10.0);
        assert!((run.steps - 190.0).abs() < 1e-9 && (run.cpu_seconds - 28.0).abs() < 1e-9, "{run:?}");
        assert!((run.work.force_evaluations - 280.0).abs() < 1e-9 && run.doubtful);
        let run = Estimate::begun(&begun, &[], 10.0);
        assert!((run.steps - 1450.0).abs() < 1e-9 && !run.doubtful, "{run:?}");
        let whole = Estimate::begun(&begun, &[], 1.0);
        assert_eq!((whole.steps, whole.cpu_seconds, whole.doubtful), (100.0, 10.0, false));
    }
}
