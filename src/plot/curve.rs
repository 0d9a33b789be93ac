//! Curves of runs and the part of them a chart should show.

use super::chart::{Line, Marker, Stroke};
use super::results::RunEnd;
use crate::drive::Status;

/// A failed run counts as diverged in a chart if it went farther than this many times its typical distance from its
/// start.
const WRECK: f64 = 100.0;
/// Number of typical distances to show of a diverged run; the rest is cut off at the frame.
const SHOWN: f64 = 10.0;

/// A curve of a run; every point with its time.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    /// how its run ended
    pub ending: RunEnd,
    /// its points
    pub points: Vec<TimedPoint>,
}

/// A point with its time.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimedPoint {
    /// [s]
    pub t: f64,
    /// horizontal and vertical value
    pub at: (f64, f64),
}

/// Lower and upper end of both axes; `None` if the chart fits them.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisLimits {
    /// of the horizontal axis
    pub x: Option<(f64, f64)>,
    /// of the vertical axis
    pub y: Option<(f64, f64)>,
}

impl Curve {
    fn failed(&self) -> bool {
        matches!(self.ending.status, Status::Diverged | Status::NotConverged)
    }

    /// The points before divergence was found.
    fn trusted(&self) -> impl Iterator<Item = (f64, f64)> {
        let end = if self.failed() { self.ending.time } else { f64::INFINITY };
        self.points.iter().filter(move |p| p.t <= end && p.at.0.is_finite() && p.at.1.is_finite()).map(|p| p.at)
    }

    /// Lower and upper end of a coordinate. The last steps before divergence is found may be meaningless, and beside
    /// their 1e31 J all others would be a flat line. So the range is limited to a multiple of the median distance from
    /// the start.
    fn range(&self, coordinate: fn((f64, f64)) -> f64) -> Option<(f64, f64)> {
        let values: Vec<f64> = self.trusted().map(coordinate).collect();
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

    /// The curve as a line.
    pub(super) fn line(&self, label: &str, color: usize, stroke: Stroke) -> Line {
        let points = self.points.iter().map(|p| p.at).collect();
        Line { label: label.to_owned(), points, stroke, color: Some(color), ..Line::default() }
    }

    /// A cross at the last point of a run that did not reach its end. In a chart over time it stays at the frame's edge
    /// if the line has left the frame: `held` is the vertical range for it.
    pub(super) fn end_mark(&self, color: usize, held: Option<(f64, f64)>) -> Option<Line> {
        let (x, y) = self.trusted().last().filter(|_| self.ending.status != Status::Completed)?;
        let points = vec![(x, held.map_or(y, |(low, high)| y.max(low).min(high)))];
        Some(Line { points, stroke: Stroke::None, marker: Marker::Cross, color: Some(color), ..Line::default() })
    }
}

/// The range of one coordinate to show. Failed runs must not make the others flat: the range is that of the other runs,
/// extended by its length on both sides. Without other runs, it is the range of the failed runs before they diverged.
/// `None` if no run failed: the chart then fits its points.
pub(super) fn limits(curves: &[Curve], coordinate: fn((f64, f64)) -> f64) -> Option<(f64, f64)> {
    let range = |failed: bool| {
        let ranges = curves.iter().filter(|c| c.failed() == failed).filter_map(|c| c.range(coordinate));
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
    (margin > 0.0).then_some((low - margin, high + margin))
}

/// First and last time of all curves, for an axis of time.
pub(super) fn times(curves: &[Curve]) -> Option<(f64, f64)> {
    let times = curves.iter().flat_map(|c| c.points.iter().map(|p| p.t));
    let (first, last) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(t), h.max(t)));
    (first < last).then_some((first, last))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(status: Status, values: &[f64]) -> Curve {
        let points = (0u8..).zip(values).map(|(i, v)| TimedPoint { t: f64::from(i), at: (f64::from(i), *v) }).collect();
        Curve { ending: RunEnd { status, time: 3.0 }, points }
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
        assert_eq!(limits(std::slice::from_ref(&good), y), None);
        near(limits(&[good.clone(), mild.clone()], y), (-1.5, 2.0));
        near(limits(&[good.clone(), wild], y), (-3.0, 3.0));
        near(limits(std::slice::from_ref(&mild), y), (-1.5, 2.0));
        let mark = mild.end_mark(1, Some((-1.0, 1.0))).expect("it failed");
        assert_eq!(mark.points, [(3.0, 1.0)]);
        assert_eq!(good.end_mark(0, None), None);
    }

    /// A single diverged run leaves room for the motion before, also after a long rest; a run that only grew is shown
    /// whole.
    #[test]
    fn wrecks_do_not_squeeze_themselves() {
        let y = |at: (f64, f64)| at.1;
        let alone = |status, values: &[f64]| {
            let points = values.iter().map(|v| TimedPoint { t: 0.0, at: (0.0, *v) }).collect();
            Curve { ending: RunEnd { status, time: 3.0 }, points }.range(y).expect("points")
        };
        let swing = [5.0, 6.0, 5.0, 4.0, 5.0, 6.0, 3e8, -5e31];
        assert_eq!(alone(Status::Diverged, &swing), (-5.0, 15.0), "ten times 1 to either side of 5");
        assert_eq!(alone(Status::Diverged, &[0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 1.0, -1e9]), (-10.0, 2.0));
        assert_eq!(alone(Status::Diverged, &[0.0, 1.0, 2.0, 4.0, 50.0, 200.0]), (0.0, 200.0), "not beyond 100 times 2");
        assert_eq!(alone(Status::Completed, &swing), (-5e31, 3e8), "what is sound is shown whole");
        assert_eq!(alone(Status::Diverged, &[7.0]), (7.0, 7.0));
    }
}
