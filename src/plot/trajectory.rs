//! Displacement over time and phase diagrams.
//!
//! Displacements are from the position before the initial displacement, so an oscillator that begins displaced swings
//! about 0. Those of a pendulum's bob are from its lowest position. A pendulum alone shows its angle from there, theta
//! = atan2(x, -z), and theta' = (x vz - z vx)/(x^2 + z^2).

use super::PlotError;
use super::chart::{Axis, Chart, Stroke};
use super::curve::{AxisLimits, Curve, TimedPoint, limits, times};
use super::results::{ProbePath, ProbeSample, Run};
use super::series::title;
use super::series::{Group, groups, main_direction, subject};
use super::view::{Direction, View};
use std::f64::consts::TAU;

/// Up to this many node paths of a group are drawn as usual lines; more are drawn as hair lines.
const FEW: usize = 4;

/// The motion of a quantity over time.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// [s]
    t: f64,
    /// [m] or [rad]
    value: f64,
    /// [m/s] or [rad/s]
    rate: f64,
}

/// The quantity taken from a sample.
#[derive(Clone, Copy, Debug)]
enum Quantity {
    Along(Direction),
    Angle,
}

/// Displacement over time.
pub(super) fn displacement(runs: &[Run], view: &View) -> Result<Chart, PlotError> {
    let groups = groups(runs, view)?;
    let quantity = Quantity::of(&groups, view);
    let drawn = GroupedCurves::new(&groups, |track| {
        quantity.samples(track, view).map(|s| TimedPoint { t: s.t, at: (s.t, s.value) }).collect()
    });
    let limits = AxisLimits { x: times(&drawn.curves), y: limits(&drawn.curves, |p| p.1) };
    let title = title(runs, &format!("{}{}", quantity.name(), quantity.subject(&groups)));
    let axes = [Axis::linear("time t [s]"), Axis::linear(quantity.label())];
    drawn.chart(title, axes, limits, limits.y)
}

/// Rate over displacement.
pub(super) fn phase(runs: &[Run], view: &View) -> Result<Chart, PlotError> {
    let groups = groups(runs, view)?;
    let quantity = Quantity::of(&groups, view);
    let drawn = GroupedCurves::new(&groups, |track| {
        quantity.samples(track, view).map(|s| TimedPoint { t: s.t, at: (s.value, s.rate) }).collect()
    });
    let limits = AxisLimits { x: limits(&drawn.curves, |p| p.0), y: limits(&drawn.curves, |p| p.1) };
    let title = title(runs, &format!("phase{}", quantity.subject(&groups)));
    let axes = [Axis::linear(quantity.label()), Axis::linear(quantity.rate_label())];
    // A mark at the edge of a phase diagram would be at a state that the run never had.
    drawn.chart(title, axes, limits, None)
}

impl Quantity {
    fn of(groups: &[Group<'_>], view: &View) -> Self {
        match view.axis {
            Some(direction) => Quantity::Along(direction),
            None if groups.iter().all(|g| g.run.pendulum) => Quantity::Angle,
            None => Quantity::Along(main_direction(groups, view)),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Quantity::Along(_) => "displacement",
            Quantity::Angle => "angle",
        }
    }

    /// The name of the node; a pendulum has one bob only.
    fn subject(self, groups: &[Group<'_>]) -> String {
        match self {
            Quantity::Along(_) => subject(groups),
            Quantity::Angle => String::new(),
        }
    }

    fn label(self) -> String {
        match self {
            Quantity::Along(d) => format!("displacement in {} [m]", d.name()),
            Quantity::Angle => "angle θ [rad]".to_owned(),
        }
    }

    fn rate_label(self) -> String {
        match self {
            Quantity::Along(d) => format!("velocity in {} [m/s]", d.name()),
            Quantity::Angle => "angular velocity dθ/dt [rad/s]".to_owned(),
        }
    }

    /// This quantity along a node path, at the times of the view.
    fn samples(self, track: &ProbePath, view: &View) -> impl Iterator<Item = Sample> {
        let mut turns = 0.0;
        let mut before: Option<f64> = None;
        let sample = move |m: &ProbeSample| match self {
            Quantity::Along(d) => {
                let c = d.index();
                Sample { t: m.t, value: m.x[c] - track.reference[c], rate: m.v[c] }
            }
            Quantity::Angle => {
                let ([x, _, z], [vx, _, vz]) = (m.x, m.v);
                let angle = x.atan2(-z);
                // The arc between two frames is taken as the shorter one, so the angle of a rotating bob keeps
                // increasing.
                turns -= before.map_or(0.0, |b| ((angle - b) / TAU).round());
                before = Some(angle);
                Sample { t: m.t, value: angle + turns * TAU, rate: (x * vz - z * vx) / (x * x + z * z) }
            }
        };
        let samples: Vec<Sample> = track.moments.iter().map(sample).filter(|s| view.sees(s.t)).collect();
        samples.into_iter()
    }
}

/// Curves in the order of their groups.
struct GroupedCurves<'a> {
    groups: &'a [Group<'a>],
    curves: Vec<Curve>,
}

impl<'a> GroupedCurves<'a> {
    fn new(groups: &'a [Group<'a>], points: impl Fn(&ProbePath) -> Vec<TimedPoint>) -> Self {
        let of_group = |g: &'a Group<'a>| {
            g.tracks.iter().map(|t| Curve { ending: g.run.ending, points: points(t) }).collect::<Vec<_>>()
        };
        GroupedCurves { groups, curves: groups.iter().flat_map(of_group).collect() }
    }

    /// `held` is the range for marks of ends, see [`Curve::end_mark`].
    fn chart(
        self,
        title: String,
        [x, y]: [Axis; 2],
        limits: AxisLimits,
        held: Option<(f64, f64)>,
    ) -> Result<Chart, PlotError> {
        let (mut lines, mut marks) = (Vec::new(), Vec::new());
        let mut curves = self.curves.iter();
        for (color, group) in self.groups.iter().enumerate() {
            let stroke = if group.tracks.len() > FEW { Stroke::Thin } else { Stroke::Normal };
            for (i, curve) in curves.by_ref().take(group.tracks.len()).enumerate() {
                lines.push(curve.line(if i == 0 { &group.label } else { "" }, color, stroke));
                marks.extend(curve.end_mark(color, held).filter(|_| i < FEW));
            }
        }
        lines.extend(marks);
        if lines.iter().all(|l| l.points.is_empty()) {
            return Err(PlotError::NotThere("no frame of the runs is within --from and --to".to_owned()));
        }
        let (x, y) = (Axis { range: limits.x, ..x }, Axis { range: limits.y, ..y });
        Ok(Chart { title, x, y, lines, ..Chart::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The angle of a bob that rotates at 2 rad/s keeps increasing, and its rate is that of the circle.
    #[test]
    fn angles_count_on() {
        let at = |i: u8| {
            let (t, theta) = (0.1 * f64::from(i), 0.2 * f64::from(i));
            let (sin, cos) = theta.sin_cos();
            ProbeSample { t, x: [3.0 * sin, 0.0, -3.0 * cos], v: [6.0 * cos, 0.0, 6.0 * sin] }
        };
        let track =
            ProbePath { probe: "bob".into(), node: 0, reference: [0.0; 3], moments: (0..100).map(at).collect() };
        for sample in Quantity::Angle.samples(&track, &View::default()) {
            assert!((sample.value - 2.0 * sample.t).abs() < 1e-12, "{sample:?}");
            assert!((sample.rate - 2.0).abs() < 1e-14, "{sample:?}");
        }
    }
}
