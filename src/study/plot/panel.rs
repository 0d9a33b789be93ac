//! From curves to a chart: titles, ranges, logarithmic axes, marks of early ends.

use super::PlotError;
use super::chart::{Align, Axis, Chart, Line, Marker, Note, Scale, Stroke};
use super::curve::{Curve, Plane, limits, times};
use crate::format_number::figures;

/// Most curves of a chart whose peaks are marked: more texts would cover each other.
const MARKED: usize = 3;
/// [-] Room beyond a marked peak for its text, as a share of the range; and at the other end.
const ROOM: [f64; 2] = [0.14, 0.04];

/// [-] A text as a share of the axes: nearer peaks have one.
const NEAR: [f64; 2] = [0.3, 0.06];

/// Curves that share a chart.
pub(super) struct Panel {
    /// title of the chart
    pub title: String,
    /// labels of its axes
    pub axes: [String; 2],
    /// unit of its values
    pub unit: String,
    /// order among panels of which only some are drawn, the first ones
    pub rank: u8,
    /// what is drawn over what
    pub plane: Plane,
    /// whether curves with rates are cubics between their points
    pub cubic: bool,
    /// the curves
    pub curves: Vec<Curve>,
}

/// A chart, and the points that a logarithmic axis cannot show.
pub(super) struct PanelChart {
    /// the chart
    pub chart: Chart,
    /// number of points that are left out
    pub left_out: usize,
    /// number of all points
    pub all: usize,
}

impl Panel {
    /// Whether it has no point at all.
    pub(super) fn is_empty(&self) -> bool {
        self.curves.iter().all(|curve| curve.samples.is_empty())
    }

    /// Its chart; `scales` are those of the horizontal and of the vertical axis.
    ///
    /// # Errors
    /// No point above 0 on a logarithmic axis.
    pub(super) fn chart(self, scales: [Scale; 2]) -> Result<PanelChart, PlotError> {
        let Panel { title, axes: [x, y], unit, plane, cubic, curves, .. } = self;
        let across = match plane {
            Plane::Time => times(&curves),
            Plane::Phase => limits(&curves, plane, |p| p.0),
        };
        let up = limits(&curves, plane, |p| p.1);
        // Each axis fits its points if it is logarithmic: a diverged run makes no other flat there.
        let axis = |label, scale, range: Option<(f64, f64)>| Axis {
            label,
            scale,
            range: range.filter(|_| scale == Scale::Linear),
        };
        let peaks = marked_peaks(&curves, plane);
        let up = up.or_else(|| with_room(&curves, &peaks).filter(|_| scales[1] == Scale::Linear));
        let (x, y) = (axis(x, scales[0], across), axis(y, scales[1], up));
        // A mark at the edge of a phase diagram would be at a state that the run never had.
        let held = y.range.filter(|_| plane == Plane::Time);
        let marks = curves.iter().filter_map(|curve| curve.end_mark(plane, held));
        let mut lines: Vec<Line> = curves.iter().map(|curve| curve.line(plane, cubic)).chain(marks).collect();
        lines.extend(peaks.iter().map(|peak| ring(*peak)));
        let notes = notes(&peaks, &unit, times(&curves).unwrap_or_default(), y.range.unwrap_or_default());
        let points = || curves.iter().flat_map(|c| &c.samples).map(|s| plane.point(s));
        let finite = || points().filter(|(x, y)| x.is_finite() && y.is_finite());
        let shown =
            |(x, y): &(f64, f64)| [x, y].into_iter().zip(scales).all(|(v, scale)| scale == Scale::Linear || *v > 0.0);
        let all = finite().count();
        let left_out = all - finite().filter(shown).count();
        if left_out == all && all > 0 {
            let largest = |of: fn((f64, f64)) -> f64| finite().map(of).fold(f64::NEG_INFINITY, f64::max);
            let flat = scales[1] == Scale::Log && largest(|p| p.1) <= 0.0;
            let (axis, largest) = if flat { (y.label, largest(|p| p.1)) } else { (x.label, largest(|p| p.0)) };
            return Err(PlotError::NothingPositive { title, axis, points: all, largest });
        }
        Ok(PanelChart { chart: Chart { title, x, y, lines, notes, ..Chart::default() }, left_out, all })
    }
}

/// A peak: time, value, and the number in the palette of its curve.
type MarkedPeak = (f64, f64, usize);

/// The peaks to mark, where they are few.
fn marked_peaks(curves: &[Curve], plane: Plane) -> Vec<MarkedPeak> {
    let peaks = curves.iter().filter_map(|curve| curve.peak().map(|(t, value)| (t, value, curve.color)));
    let peaks: Vec<MarkedPeak> = peaks.collect();
    if plane == Plane::Time && curves.len() <= MARKED { peaks } else { Vec::new() }
}

/// The range of all values with room for the texts of peaks; `None` without peaks.
fn with_room(curves: &[Curve], peaks: &[MarkedPeak]) -> Option<(f64, f64)> {
    peaks.first()?;
    let values = curves.iter().flat_map(|curve| &curve.samples).map(|sample| sample.value).filter(|v| v.is_finite());
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let room = |end: f64| if peaks.iter().any(|peak| peak.1 == end) { ROOM[0] } else { ROOM[1] };
    let span = high - low;
    (span > 0.0).then(|| (low - room(low) * span, high + room(high) * span))
}

fn ring((t, value, color): MarkedPeak) -> Line {
    let (points, color) = (vec![(t, value)], Some(color));
    Line { points, stroke: Stroke::None, marker: Marker::Ring, color, ..Line::default() }
}

/// The texts of peaks, where each has room in a chart of these ranges.
fn notes(peaks: &[MarkedPeak], unit: &str, (first, last): (f64, f64), (low, high): (f64, f64)) -> Vec<Note> {
    let middle = f64::midpoint(first, last);
    let near = |a: &MarkedPeak, b: &MarkedPeak| {
        (a.0 - b.0).abs() < NEAR[0] * (last - first) && (a.1 - b.1).abs() < NEAR[1] * (high - low)
    };
    let mut placed: Vec<MarkedPeak> = Vec::new();
    for peak in peaks {
        if !placed.iter().any(|other| near(other, peak)) {
            placed.push(*peak);
        }
    }
    placed.into_iter().map(|peak| note(peak, unit, middle)).collect()
}

/// Value and time of a peak, on the side where the chart is wider; below a negative one.
fn note((t, value, _): MarkedPeak, unit: &str, middle: f64) -> Note {
    let unit = if unit == "-" || unit.is_empty() { String::new() } else { format!(" {unit}") };
    let align = match (t > middle, value < 0.0) {
        (false, false) => Align::Right,
        (true, false) => Align::Left,
        (false, true) => Align::RightBelow,
        (true, true) => Align::LeftBelow,
    };
    Note { at: (t, value), text: format!("{}{unit} at {} s", figures(value, 4), figures(t, 4)), align }
}
