//! Samples of a series at equal times, as few for a long run as for a short one.
//!
//! Sample k is taken at k times their interval. Where all places are taken, every other sample is given up and the
//! interval is doubled. So the last tenth of a run holds at least eight of them, wherever the run ends, and its steady
//! value needs no knowledge of that end beforehand.

use serde::{Deserialize, Serialize};

/// Most samples that are kept.
const PLACES: usize = 160;
/// Intervals in a run that comes to its planned end: its last tenth begins at one of the samples.
const INTERVALS: f64 = 80.0;
/// How many times finer the first interval is, a power of two: a run may end after this share of its time.
const FINER: f64 = 1024.0;

/// A series at a time, with its integral over time up to there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Sample {
    pub value: f64,
    pub integral: f64,
}

/// The samples so far; part of a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Samples {
    /// [s] time between two; 0 before the first one
    every: f64,
    taken: Vec<Sample>,
}

impl Samples {
    /// Takes the samples that are due up to `t` [s], in a run that is planned to `end` [s].
    pub(super) fn take(&mut self, t: f64, end: f64, at: impl Fn(f64) -> Sample) {
        if self.taken.is_empty() {
            self.every = end / INTERVALS / FINER;
        }
        // Once in a run, and once after a resumption.
        if self.taken.capacity() < PLACES {
            self.taken.reserve_exact(PLACES - self.taken.len());
        }
        // Each turn takes a sample or doubles the interval, after which half of the places are free.
        loop {
            let time = self.taken.len() as f64 * self.every;
            if time > t || self.every.is_nan() || self.every <= 0.0 {
                return;
            }
            if self.taken.len() < PLACES {
                self.taken.push(at(time));
                continue;
            }
            let mut even = false;
            self.taken.retain(|_| {
                even = !even;
                even
            });
            self.every *= 2.0;
        }
    }

    /// The series at `time` [s], before `now`, its newest sample at `t` [s]: the value on the chord, the integral on
    /// the cubic through the integrals with the values as slopes.
    pub(super) fn at(&self, time: f64, t: f64, now: Sample) -> Sample {
        let Some(Between { number, times: [start, end], share: s }) = self.around(time, t) else { return now };
        let Some(&from) = self.taken.get(number) else { return now };
        let to = self.taken.get(number + 1).copied().unwrap_or(now);
        let h = end - start;
        if h <= 0.0 {
            return from;
        }
        let (d, p0, p1) = (to.integral - from.integral, h * from.value, h * to.value);
        let integral = from.integral + s * (p0 + s * ((3.0 * d - 2.0 * p0 - p1) + s * (p0 + p1 - 2.0 * d)));
        Sample { value: from.value + s * (to.value - from.value), integral }
    }

    /// Where `time` [s] is between two samples, the newest of them at `t` [s]; `None` before there is any.
    pub(super) fn around(&self, time: f64, t: f64) -> Option<Between> {
        let number = ((time / self.every) as usize).min(self.taken.len().checked_sub(1)?);
        let start = number as f64 * self.every;
        let end = if number + 1 < self.taken.len() { start + self.every } else { t };
        let share = if end > start { ((time - start) / (end - start)).min(1.0) } else { 0.0 };
        Some(Between { number, times: [start, end], share })
    }
}

/// A time between two samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Between {
    /// number of the first one
    pub number: usize,
    /// [s] their times
    pub times: [f64; 2],
    /// [-] where the time is, from the first to the second
    pub share: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// v = 3 t^2 with its integral t^3, a cubic: what is between the samples is exact, in steps of any size.
    #[test]
    fn any_time_is_known_from_few_samples() {
        let of = |t: f64| Sample { value: 3.0 * t * t, integral: t.powi(3) };
        for (steps, until) in [(1, 10.0), (7, 10.0), (5000, 10.0), (5000, 0.003), (5000, 3.7)] {
            let mut samples = Samples::default();
            for step in 0..=steps {
                samples.take(until * f64::from(step) / f64::from(steps), 10.0, of);
            }
            assert!(samples.taken.len() <= PLACES && samples.taken.capacity() == PLACES);
            assert!(samples.taken.len() >= 24, "{until}: {}", samples.taken.len());
            for share in [0.0, 0.123, 0.9, 0.99, 1.0] {
                let (time, scale) = (share * until, until.powi(3));
                let found = samples.at(time, until, of(until));
                assert!((found.integral - time.powi(3)).abs() < 1e-14 * scale, "{steps} {until} {share}: {found:?}");
            }
        }
    }

    /// The beginning of the last tenth of a run that comes to its end is a sample, whatever the end.
    #[test]
    fn the_last_tenth_of_a_planned_run_begins_at_a_sample() {
        for end in [1.0, 0.3, 7.1, 1e4 / 3.0] {
            let mut samples = Samples::default();
            (0..=1000).for_each(|k| {
                samples.take(end * f64::from(k) / 1000.0, end, |value| Sample { value, integral: 0.0 });
            });
            let place = 0.9 * end / samples.every;
            assert!((place - place.round()).abs() < 1e-9, "{end}: {place}");
        }
    }

    #[test]
    fn a_run_without_a_time_has_no_samples() {
        for end in [0.0, f64::NAN] {
            let mut samples = Samples::default();
            samples.take(0.0, end, |_| Sample { value: 1.0, integral: 0.0 });
            assert!(samples.taken.is_empty());
            let now = Sample { value: 2.0, integral: 3.0 };
            assert_eq!(samples.at(0.0, 0.0, now), now);
        }
    }
}
