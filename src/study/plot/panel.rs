//! From curves to a chart: titles, ranges, logarithmic axes, marks of early ends.

use super::PlotError;
use super::chart::{Axis, Chart, Line, Scale};
use super::curve::{Curve, Plane, limits, times};

/// Curves that share a chart.
pub(super) struct Panel {
    /// title of the chart
    pub title: String,
    /// labels of its axes
    pub axes: [String; 2],
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
        let Panel { title, axes: [x, y], plane, cubic, curves } = self;
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
        let (x, y) = (axis(x, scales[0], across), axis(y, scales[1], up));
        // A mark at the edge of a phase diagram would be at a state that the run never had.
        let held = y.range.filter(|_| plane == Plane::Time);
        let marks = curves.iter().filter_map(|curve| curve.end_mark(plane, held));
        let lines: Vec<Line> = curves.iter().map(|curve| curve.line(plane, cubic)).chain(marks).collect();
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
        Ok(PanelChart { chart: Chart { title, x, y, lines, ..Chart::default() }, left_out, all })
    }
}
