//! Curves of runs and the part of them a chart should show.

use super::chart::{Line, Marker, Stroke};
use super::results::RunEnd;
use crate::drive::Status;
use crate::model::gauge::PeakRule;

/// A failed run counts as diverged in a chart if it went farther than this many times its typical distance from its
/// start.
const WRECK: f64 = 100.0;
/// [-] A range narrower than this share of its numbers is rounding.
const ROUNDING: f64 = 1e-12;
/// [-] Values closer together than this share of them are a constant: what iterations leave.
const CONSTANT: f64 = 1e-9;
/// Marks of a method along its curve.
const MARKS: usize = 7;
/// Number of typical distances to show of a diverged run; the rest is cut off at the frame.
const SHOWN: f64 = 10.0;

/// A quantity at a time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// [s]
    pub t: f64,
    /// the quantity
    pub value: f64,
    /// its derivative by time; NaN where it is not known
    pub rate: f64,
}

/// What is drawn over what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Plane {
    /// value over time
    Time,
    /// rate over value
    Phase,
}

/// A curve of a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Curve {
    /// how its run ended
    pub ending: RunEnd,
    /// entry of the legend; empty = that of the curve before
    pub label: String,
    /// number in the palette
    pub color: usize,
    /// how it is drawn
    pub stroke: Stroke,
    /// whether an early end has a mark
    pub marked: bool,
    /// mark of its method, a few times along it
    pub marker: Marker,
    /// which of its values is its peak, if that is marked
    pub peak: Option<PeakRule>,
    /// in the order of time
    pub samples: Vec<Sample>,
}

impl Plane {
    pub(super) fn point(self, sample: &Sample) -> (f64, f64) {
        match self {
            Plane::Time => (sample.t, sample.value),
            Plane::Phase => (sample.value, sample.rate),
        }
    }

    /// Derivatives at the ends of the piece between two samples, which lasts h, by its share of h. Its value is the
    /// cubic with the values and rates of both; its rate in a phase diagram is the derivative of that cubic.
    fn tangents(self, a: &Sample, b: &Sample) -> [(f64, f64); 2] {
        let (h, d) = (b.t - a.t, b.value - a.value);
        match self {
            Plane::Time => [(h, h * a.rate), (h, h * b.rate)],
            Plane::Phase => {
                let bend = [6.0 * d / h - 4.0 * a.rate - 2.0 * b.rate, 2.0 * a.rate + 4.0 * b.rate - 6.0 * d / h];
                [(h * a.rate, bend[0]), (h * b.rate, bend[1])]
            }
        }
    }
}

impl Curve {
    fn failed(&self) -> bool {
        matches!(self.ending.status, Status::Diverged | Status::NotConverged)
    }

    /// The points before divergence was found.
    fn trusted(&self, plane: Plane) -> impl Iterator<Item = (f64, f64)> {
        let end = if self.failed() { self.ending.time } else { f64::INFINITY };
        let points = self.samples.iter().filter(move |s| s.t <= end).map(move |s| plane.point(s));
        points.filter(|(x, y)| x.is_finite() && y.is_finite())
    }

    /// Lower and upper end of a coordinate. The last steps before divergence is found may be meaningless, and beside
    /// their 1e31 J all others would be a flat line. So the range is limited to a multiple of the median distance from
    /// the start.
    fn range(&self, plane: Plane, coordinate: fn((f64, f64)) -> f64) -> Option<(f64, f64)> {
        let values: Vec<f64> = self.trusted(plane).map(coordinate).collect();
        let start = *values.first()?;
        let (low, high) = values.iter().fold((start, start), |(l, h), v| (l.min(*v), h.max(*v)));
        let mut distances: Vec<f64> = values.iter().map(|v| (v - start).abs()).filter(|d| *d > 0.0).collect();
        distances.sort_unstable_by(f64::total_cmp);
        let typical = distances.get(distances.len().saturating_sub(1) / 2).copied().unwrap_or(0.0);
        if !self.failed() || (high - start).max(start - low) <= WRECK * typical {
            return Some((low, high));
        }
        Some((low.max(start - SHOWN * typical), high.min(start + SHOWN * typical)))
    }

    /// The curve as a line; a `cubic` one where the rates are known.
    pub(super) fn line(&self, plane: Plane, cubic: bool) -> Line {
        let cubic = cubic && !self.samples.iter().all(|s| s.rate.is_nan());
        let pairs = self.samples.windows(2).map(|pair| match pair {
            [a, b] => plane.tangents(a, b),
            _ => [(f64::NAN, f64::NAN); 2],
        });
        Line {
            label: self.label.clone(),
            points: self.samples.iter().map(|s| plane.point(s)).collect(),
            stroke: self.stroke,
            tangents: if cubic { pairs.collect() } else { Vec::new() },
            color: Some(self.color),
            marker: self.marker,
            marks: if self.marker == Marker::None { 0 } else { MARKS },
            ..Line::default()
        }
    }

    /// Time and value of its peak: the first of equal ones. `None` of a run that failed, and of a constant.
    pub(super) fn peak(&self) -> Option<(f64, f64)> {
        let rule = self.peak.filter(|_| !self.failed())?;
        let size = |value: f64| if rule == PeakRule::LargestMagnitude { value.abs() } else { value };
        let finite = || self.samples.iter().filter(|sample| sample.value.is_finite());
        let peak = finite().rev().max_by(|a, b| size(a.value).total_cmp(&size(b.value)))?;
        let moves = !is_constant(&self.samples);
        moves.then_some((peak.t, peak.value))
    }

    /// A cross at the last point of a run that did not reach its end. In a chart over time it stays at the frame's edge
    /// if the line has left the frame: `held` is the vertical range for it.
    pub(super) fn end_mark(&self, plane: Plane, held: Option<(f64, f64)>) -> Option<Line> {
        let (x, y) = self.trusted(plane).last().filter(|_| self.marked && self.ending.status != Status::Completed)?;
        let points = vec![(x, held.map_or(y, |(low, high)| y.max(low).min(high)))];
        Some(Line { points, stroke: Stroke::None, marker: Marker::Cross, color: Some(self.color), ..Line::default() })
    }
}

/// Whether values are one value but for rounding.
pub(super) fn is_constant(samples: &[Sample]) -> bool {
    let ends = |(low, high): (f64, f64), value: f64| (low.min(value), high.max(value));
    let finite = samples.iter().map(|sample| sample.value).filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), ends);
    high - low <= CONSTANT * low.abs().max(high.abs())
}

/// The range of one coordinate to show. Failed runs must not make the others flat: the range is that of the other runs,
/// extended by its length on both sides. Without other runs, it is the range of the failed runs before they diverged.
/// `None` if no run failed: the chart then fits its points.
pub(super) fn limits(curves: &[Curve], plane: Plane, coordinate: fn((f64, f64)) -> f64) -> Option<(f64, f64)> {
    let range = |failed: bool| {
        let ranges = curves.iter().filter(|c| c.failed() == failed).filter_map(|c| c.range(plane, coordinate));
        ranges.reduce(|(l, h), (low, high)| (l.min(low), h.max(high)))
    };
    let failed = range(true)?;
    let (low, high) = match range(false) {
        Some((low, high)) if high > low => {
            let span = high - low;
            (low.min(failed.0.max(low - span)), high.max(failed.1.min(high + span)))
        }
        _ => failed,
    };
    let margin = 0.04 * (high - low);
    (margin > ROUNDING * low.abs().max(high.abs())).then_some((low - margin, high + margin))
}

/// First and last time of all curves, for an axis of time.
pub(super) fn times(curves: &[Curve]) -> Option<(f64, f64)> {
    let times = curves.iter().flat_map(|c| c.samples.iter().map(|s| s.t));
    let (first, last) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(t), h.max(t)));
    (first < last).then_some((first, last))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(status: Status, values: &[f64]) -> Curve {
        let sample = |(i, v): (u8, &f64)| Sample { t: f64::from(i), value: *v, rate: f64::NAN };
        let (label, samples) = (String::new(), (0u8..).zip(values).map(sample).collect());
        let ending = RunEnd { status, time: 3.0 };
        Curve { ending, label, marked: true, samples, ..Curve::default() }
    }

    /// A diverged run leaves room for the others, and points after the divergence do not count.
    #[test]
    fn failed_runs_do_not_squeeze_others() {
        let good = curve(Status::Completed, &[0.0, 1.0, -1.0, 1.0, 0.0, 1.0]);
        let mild = curve(Status::Diverged, &[0.0, 1.0, -1.5, 2.0, 1e9, f64::NAN]);
        let wild = curve(Status::Diverged, &[0.0, 1.0, -1e6, 1e7, 1e9, f64::INFINITY]);
        let y = |at: (f64, f64)| at.1;
        let near = |found: Option<(f64, f64)>, (low, high): (f64, f64)| {
            let margin = 0.04 * (high - low);
            let (l, h) = found.expect("limits");
            assert!((l - low + margin).abs() < 1e-12 && (h - high - margin).abs() < 1e-12, "{l} {h}");
        };
        assert_eq!(limits(std::slice::from_ref(&good), Plane::Time, y), None);
        near(limits(&[good.clone(), mild.clone()], Plane::Time, y), (-1.5, 2.0));
        near(limits(&[good.clone(), wild], Plane::Time, y), (-3.0, 3.0));
        near(limits(std::slice::from_ref(&mild), Plane::Time, y), (-1.5, 2.0));
        let mark = mild.end_mark(Plane::Time, Some((-1.0, 1.0))).expect("it failed");
        assert_eq!(mark.points, [(3.0, 1.0)]);
        assert_eq!(good.end_mark(Plane::Time, None), None);
    }

    /// The first of equal peaks is marked, by its magnitude where that is asked for; a constant and a failed run have
    /// none.
    #[test]
    fn peaks_are_marked() {
        let peak = |status, values: &[f64], rule| Curve { peak: Some(rule), ..curve(status, values) }.peak();
        let good = |values: &[f64], rule| peak(Status::Completed, values, rule);
        assert_eq!(good(&[0.0, 2.0, -3.0, 2.0], PeakRule::Largest), Some((1.0, 2.0)));
        assert_eq!(good(&[0.0, 2.0, -3.0, f64::NAN], PeakRule::LargestMagnitude), Some((2.0, -3.0)));
        assert_eq!(good(&[4.0, 4.0 + 1e-12, 4.0], PeakRule::Largest), None);
        assert_eq!(peak(Status::Diverged, &[0.0, 1.0], PeakRule::Largest), None);
    }

    /// A single diverged run leaves room for the motion before, also after a long rest; a run that only grew is shown
    /// whole.
    #[test]
    fn wrecks_do_not_squeeze_themselves() {
        let y = |at: (f64, f64)| at.1;
        let alone = |status, values: &[f64]| {
            let samples = values.iter().map(|v| Sample { t: 0.0, value: *v, rate: f64::NAN }).collect();
            Curve { samples, ..curve(status, &[]) }.range(Plane::Time, y).expect("points")
        };
        let swing = [5.0, 6.0, 5.0, 4.0, 5.0, 6.0, 3e8, -5e31];
        assert_eq!(alone(Status::Diverged, &swing), (-5.0, 15.0), "ten times 1 to either side of 5");
        assert_eq!(alone(Status::Diverged, &[0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 1.0, -1e9]), (-10.0, 2.0));
        assert_eq!(alone(Status::Diverged, &[0.0, 1.0, 2.0, 4.0, 50.0, 200.0]), (0.0, 200.0), "not beyond 100 times 2");
        assert_eq!(alone(Status::Completed, &swing), (-5e31, 3e8), "what is sound is shown whole");
        assert_eq!(alone(Status::Diverged, &[7.0]), (7.0, 7.0));
    }
}
