//! What is kept of a series of values from step to step: its largest and smallest value, its end, its means.
//!
//! What is steady is judged over the last tenth of the run, wherever it ends. A run that ends on the ground does not
//! know its end beforehand, so the beginning of its last tenth is read from samples that were kept on the way.

use serde::{Deserialize, Serialize};

use super::thinned::{Between, Sample, Samples};
use crate::model::gauge::PeakRule;
use crate::model::quantity::Statistic;

/// [-] Share of a run at its end that the steady value is a mean of, and over which it must not change.
const LAST_PART: f64 = 0.1;
/// [-] Relative change over that part below which a value is steady.
const STEADY: f64 = 0.01;
/// Values of that part that are compared, equal times apart.
const LATE_VALUES: u8 = 8;

/// A series of values so far; part of a checkpoint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SeriesSoFar {
    /// the value with the largest magnitude, or the largest value
    pub peak: f64,
    /// [s] its time
    pub peak_time: f64,
    /// by how much the parabola through it and its neighbours is above it: about what falls between two steps
    pub missed: f64,
    /// the value before the peak, until its other neighbour is known
    rise: Option<f64>,
    /// smallest value
    pub min: f64,
    /// newest value
    pub last: f64,
    /// [s] its time
    pub t: f64,
    /// [s] time of the first value
    first: f64,
    /// integral over time
    integral: f64,
    samples: Samples,
}

impl Default for SeriesSoFar {
    fn default() -> Self {
        SeriesSoFar {
            peak: f64::NAN,
            peak_time: f64::NAN,
            missed: 0.0,
            rise: None,
            min: f64::NAN,
            last: f64::NAN,
            t: f64::NAN,
            first: f64::NAN,
            integral: 0.0,
            samples: Samples::default(),
        }
    }
}

/// [s] When the last part of a run that ended at `end` [s] begins.
pub(super) fn late_from(end: f64) -> f64 {
    (1.0 - LAST_PART) * end
}

impl SeriesSoFar {
    /// Adds the value at `t` [s] of a run that is planned to `end` [s], by the trapezoidal rule. A value that is not
    /// finite is left out.
    pub fn note(&mut self, t: f64, value: f64, rule: PeakRule, end: f64) {
        if !value.is_finite() {
            return;
        }
        let more = match rule {
            PeakRule::Largest => value > self.peak,
            PeakRule::LargestMagnitude => value.abs() > self.peak.abs(),
        };
        if more || self.peak.is_nan() {
            (self.peak, self.peak_time, self.missed) = (value, t, 0.0);
            self.rise = Some(self.last);
        } else if let Some(before) = self.rise.take().filter(|_| t > self.t) {
            let [rise, fall] = [self.peak - before, self.peak - value];
            let missed = (rise - fall).powi(2) / (8.0 * (rise + fall).abs());
            self.missed = if missed.is_finite() { missed } else { 0.0 };
        }
        self.min = self.min.min(value);
        if self.first.is_nan() {
            self.first = t;
        }
        let (from, begun) = ([self.t, self.last], t > self.t);
        let at = |time: f64| {
            let value = chord(from, [t, value], time);
            let more = if begun { 0.5 * (from[1] + value) * (time - from[0]) } else { 0.0 };
            Sample { value, integral: self.integral + more }
        };
        self.samples.take(t, end, at);
        self.integral = at(t).integral;
        (self.t, self.last) = (t, value);
    }

    /// The value at `time` [s], between the newest one and `value` at `t` [s].
    pub fn at(&self, time: f64, t: f64, value: f64) -> f64 {
        chord([self.t, self.last], [t, value], time)
    }

    /// Mean over time; the value itself where there is one only.
    pub fn mean(&self) -> f64 {
        if self.t > self.first { self.integral / (self.t - self.first) } else { self.last }
    }

    /// The series at a time [s] that is not after its newest value.
    fn before(&self, time: f64) -> Sample {
        self.samples.at(time, self.t, Sample { value: self.last, integral: self.integral })
    }

    /// Mean over the last tenth of a run that ended at `end` [s]; NaN for a series that ended before.
    pub fn late_mean(&self, end: f64) -> f64 {
        let begins = late_from(end).max(self.first);
        let before = if begins > self.first { self.before(begins).integral } else { 0.0 };
        if self.t > begins { (self.integral - before) / (self.t - begins) } else { f64::NAN }
    }

    /// Values at equal times of the last tenth of a run that ended at `end` [s]; none unless all of them were measured.
    pub fn late_values(&self, end: f64) -> Vec<f64> {
        let begins = late_from(end);
        let time = |number| begins + LAST_PART * end * f64::from(number) / f64::from(LATE_VALUES);
        let measured = self.first <= begins && time(LATE_VALUES - 1) <= self.t;
        (0..LATE_VALUES).filter(|_| measured).map(|number| self.before(time(number)).value).collect()
    }

    /// The statistic of a run that ended at `end` [s]; `None` for [`Statistic::At`], which has to be caught on the way.
    pub fn statistic(&self, which: Statistic, end: f64) -> Option<f64> {
        Some(match which {
            Statistic::Peak => self.peak,
            Statistic::PeakTime => self.peak_time,
            Statistic::Min => self.min,
            Statistic::Last => self.last,
            Statistic::Mean => self.mean(),
            Statistic::Steady => self.late_mean(end),
            Statistic::At(_) => return None,
        })
    }

    /// [-] The weights of the values of this series, measured at `times` [s], in a statistic of a run that ended at
    /// `end` [s]: those of a peak or a least value are those of its step.
    pub fn weights(&self, which: Statistic, (times, values): (&[f64], &[f64]), end: f64) -> Vec<f64> {
        let whole = |place: Option<usize>| {
            let mut weights = vec![0.0; times.len()];
            place.into_iter().for_each(|place| weights[place] = 1.0);
            weights
        };
        match which {
            Statistic::Peak | Statistic::PeakTime => whole(times.iter().position(|t| *t == self.peak_time)),
            Statistic::Min => whole(values.iter().position(|value| *value == self.min)),
            Statistic::Last => whole(times.len().checked_sub(1)),
            Statistic::At(time) => chord_weights(times, time),
            Statistic::Mean if self.t > self.first => {
                scaled(&integral_weights(times, self.t), 1.0 / (self.t - self.first))
            }
            Statistic::Mean => whole(times.len().checked_sub(1)),
            Statistic::Steady => self.late_weights(times, end),
        }
    }

    /// Those of [`SeriesSoFar::late_mean`].
    fn late_weights(&self, times: &[f64], end: f64) -> Vec<f64> {
        let begins = late_from(end).max(self.first);
        let mut weights = integral_weights(times, self.t);
        if begins > self.first
            && let Some(Between { times: [start, stop], share: s, .. }) = self.samples.around(begins, self.t)
        {
            // The cubic of the samples between two of them.
            let h = stop - start;
            let (s2, s3) = (s * s, s * s * s);
            let parts = [
                (1.0 - 3.0 * s2 + 2.0 * s3, integral_weights(times, start)),
                (3.0 * s2 - 2.0 * s3, integral_weights(times, stop)),
                (h * (s - 2.0 * s2 + s3), chord_weights(times, start)),
                (h * (s3 - s2), chord_weights(times, stop)),
            ];
            for (share, part) in parts {
                weights.iter_mut().zip(&part).for_each(|(weight, part)| *weight -= share * part);
            }
        }
        scaled(&weights, 1.0 / (self.t - begins))
    }

    /// Whether it changed by less than 1 % over the last tenth of a run that ended at `end` [s].
    pub fn is_steady(&self, end: f64) -> bool {
        let begins = late_from(end).max(self.first);
        self.t > begins && (self.last - self.before(begins).value).abs() <= STEADY * self.last.abs()
    }
}

/// The value at `time` on the chord between two points of time and value; the second one's where it is not later.
fn chord([from, last]: [f64; 2], [t, value]: [f64; 2], time: f64) -> f64 {
    if t > from { last + (value - last) * (time - from) / (t - from) } else { value }
}

fn scaled(weights: &[f64], by: f64) -> Vec<f64> {
    weights.iter().map(|weight| by * weight).collect()
}

/// [-] The weights of values at `times` [s] in the value at `time` [s], on the chord between two of them.
fn chord_weights(times: &[f64], time: f64) -> Vec<f64> {
    let mut weights = vec![0.0; times.len()];
    let after = times.partition_point(|t| *t < time).min(times.len().saturating_sub(1));
    match after.checked_sub(1).map(|before| (before, times[before])) {
        Some((before, from)) if times[after] > from => {
            let share = (time - from) / (times[after] - from);
            (weights[before], weights[after]) = (1.0 - share, share);
        }
        _ => weights.iter_mut().skip(after).take(1).for_each(|weight| *weight = 1.0),
    }
    weights
}

/// [s] Those in the integral up to `time` [s], by the trapezoidal rule.
fn integral_weights(times: &[f64], time: f64) -> Vec<f64> {
    let mut weights = vec![0.0; times.len()];
    let mut last = 0;
    for (place, pair) in times.windows(2).enumerate().take_while(|(_, pair)| pair[1] <= time) {
        let half = 0.5 * (pair[1] - pair[0]);
        weights[place] += half;
        weights[place + 1] += half;
        last = place + 1;
    }
    let rest = times.get(last).map_or(0.0, |t| time - t);
    if rest > 0.0 && last + 1 < times.len() {
        weights[last] += 0.5 * rest;
        chord_weights(times, time).iter().zip(&mut weights).for_each(|(share, weight)| *weight += 0.5 * rest * share);
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every statistic is the sum of the values with their weights: of a run that comes to its end, and of one that
    /// ends early, between two samples.
    #[test]
    fn statistics_are_sums_with_weights() {
        for (planned, until) in [(10.0, 10.0), (10.0, 3.7), (100.0, 10.0), (10.0, 0.4)] {
            let mut series = SeriesSoFar::default();
            let times: Vec<f64> = (0..=700).map(|k| until * f64::from(k) / 700.0).collect();
            let values: Vec<f64> = times.iter().map(|t| (3.0 * t).sin() + 0.2 * t).collect();
            times.iter().zip(&values).for_each(|(t, value)| series.note(*t, *value, PeakRule::Largest, planned));
            let all = [Statistic::Peak, Statistic::Min, Statistic::Last, Statistic::Mean, Statistic::Steady];
            for which in all {
                let weights = series.weights(which, (&times, &values), until);
                let sum: f64 = weights.iter().zip(&values).map(|(weight, value)| weight * value).sum();
                let value = series.statistic(which, until).expect("a value");
                assert!((sum - value).abs() < 1e-12, "{which:?} to {until}: {sum} for {value}");
            }
            let weights = series.weights(Statistic::At(0.123), (&times, &values), until);
            let sum: f64 = weights.iter().zip(&values).map(|(weight, value)| weight * value).sum();
            assert!((sum - (0.369_f64.sin() + 0.0246)).abs() < 3e-4, "{sum}");
        }
    }

    /// v = t^2 over ten seconds, in steps that do not meet the beginning of the last part.
    #[test]
    fn means_are_those_of_the_trapezoidal_rule() {
        let mut series = SeriesSoFar::default();
        let (n, end) = (7, 10.0);
        let times: Vec<f64> = (0..=n).map(|k| end * f64::from(k) / f64::from(n)).collect();
        times.iter().for_each(|t| series.note(*t, t * t, PeakRule::Largest, end));
        let trapezoids: f64 =
            times.windows(2).map(|pair| 0.5 * (pair[0].powi(2) + pair[1].powi(2)) * (pair[1] - pair[0])).sum();
        assert!((series.mean() - trapezoids / end).abs() < 1e-12);
        // On the last step the value goes from a = (60/7)^2 to 100; its last part is the chord from t = 9 s.
        let a = times[6].powi(2);
        let at_9 = a + (100.0 - a) * (9.0 - times[6]) / (10.0 - times[6]);
        assert!((series.late_mean(end) - 0.5 * (at_9 + 100.0)).abs() < 1e-12);
        assert_eq!((series.peak, series.peak_time, series.min, series.last), (100.0, 10.0, 0.0, 100.0));
    }

    /// v = 1 - exp(-t) of a run that is planned to 100 s and ends early: the mean over its own last tenth, and whether
    /// it is steady there, as a fall with drag is that lands.
    #[test]
    fn a_run_that_ends_early_is_judged_by_its_own_end() {
        let v = |t: f64| 1.0 - (-t).exp();
        for (end, steady) in [(0.01, false), (2.0, false), (6.3, true), (99.0, true)] {
            let mut series = SeriesSoFar::default();
            let steps = 4000;
            let times = (0..=steps).map(|k| end * f64::from(k) / f64::from(steps));
            times.for_each(|t| series.note(t, v(t), PeakRule::Largest, 100.0));
            let exact = 1.0 + ((-end).exp() - (-0.9 * end).exp()) / (0.1 * end);
            let error = (series.late_mean(end) / exact - 1.0).abs();
            assert!(error < 2e-5, "{end}: {} {exact}", series.late_mean(end));
            assert_eq!(series.is_steady(end), steady, "{end}");
            let values = series.late_values(end);
            let wrong = values.iter().enumerate().map(|(k, value)| value - v(end * (0.9 + 0.0125 * k as f64)));
            assert!(values.len() == 8 && wrong.fold(0.0, |a: f64, b| a.max(b.abs())) < 2e-3, "{end}: {values:?}");
        }
    }

    /// A sine has its largest value between two samples.
    #[test]
    fn what_a_peak_misses_is_that_of_a_parabola() {
        let mut series = SeriesSoFar::default();
        let h = 0.02;
        for k in 0..40 {
            let t = h * f64::from(k);
            series.note(t, (std::f64::consts::TAU * t).sin(), PeakRule::Largest, 1.0);
        }
        let missed = 1.0 - series.peak;
        assert!(missed > 1e-3 && (series.missed / missed - 1.0).abs() < 0.02, "{missed} {}", series.missed);
    }

    /// The values on the way to the end do not depend on the steps, but for what a chord misses.
    #[test]
    fn late_values_are_those_of_the_same_times() {
        let line = |n: u32| {
            let mut series = SeriesSoFar::default();
            (0..=n).map(|k| f64::from(k) / f64::from(n)).for_each(|t| series.note(t, t, PeakRule::Largest, 1.0));
            series.late_values(1.0)
        };
        let wanted = (0..8).map(|k| 0.9 + 0.1 * f64::from(k) / 8.0);
        for values in [line(3), line(1000)] {
            assert!(values.len() == 8 && wanted.clone().zip(values).all(|(a, b)| (a - b).abs() < 1e-12));
        }
        let mut cut_short = SeriesSoFar::default();
        cut_short.note(0.95, 1.0, PeakRule::Largest, 1.0);
        assert_eq!(cut_short.late_values(1.0), [0.0; 0]);
    }

    #[test]
    fn one_value_is_its_own_mean() {
        let mut series = SeriesSoFar::default();
        series.note(0.0, -3.0, PeakRule::LargestMagnitude, 1.0);
        series.note(0.0, f64::NAN, PeakRule::LargestMagnitude, 1.0);
        assert_eq!((series.mean(), series.peak, series.min), (-3.0, -3.0, -3.0));
        assert!(series.late_mean(1.0).is_nan() && !series.is_steady(1.0));
    }
}
