//! Displacement over time and phase diagrams.
//!
//! Displacements are from the position before the initial displacement, so an oscillator that begins displaced swings
//! about 0. Those of a pendulum's bob are from its lowest position. A pendulum alone shows its angle from there, theta
//! = atan2(x, -z), and theta' = (x vz - z vx)/(x^2 + z^2).

use super::PlotError;
use super::chart::{Marker, Stroke};
use super::curve::{Curve, Plane, Sample};
use super::difference::minus;
use super::panel::Panel;
use super::results::{ProbePath, ProbeSample, Run};
use super::series::{Group, groups, main_direction, subject};
use super::view::{Direction, Results, View};
use crate::model::gauge::PeakRule;
use std::f64::consts::TAU;

/// Up to this many node paths of a group are drawn as usual lines; more are drawn as hair lines.
const FEW: usize = 4;

/// The quantity taken from a sample.
#[derive(Clone, Copy, Debug)]
enum Quantity {
    Along(Direction),
    Angle,
}

/// Displacement over time, or rate over displacement.
pub(super) fn panel(results: &Results, view: &View, plane: Plane) -> Result<Panel, PlotError> {
    let groups = groups(results, view)?;
    let quantity = Quantity::of(&groups, view);
    let mut curves = Vec::new();
    let looks = results.looks();
    for (number, group) in groups.iter().enumerate() {
        let look = looks.as_ref().and_then(|looks| looks.get(results.number_of(group.run)?)).copied();
        let (color, marker) = look.unwrap_or((number, Marker::None));
        let stroke = if group.tracks.len() > FEW { Stroke::Thin } else { Stroke::Normal };
        for (i, track) in group.tracks.iter().enumerate() {
            let samples = quantity.samples(track, view);
            let samples = match &results.base {
                Some(base) => minus(samples, &quantity.samples(same_node(base, track)?, &View::default())),
                None => samples,
            };
            let label = if i == 0 { group.label.clone() } else { String::new() };
            let (ending, marked, peak) = (group.run.ending, i < FEW, Some(PeakRule::LargestMagnitude));
            let marker = if i == 0 { marker } else { Marker::None };
            curves.push(Curve { ending, label, color, stroke, marked, marker, peak, samples });
        }
    }
    let word = if plane == Plane::Phase { quantity.phase_name() } else { quantity.name() };
    let title = results.title(&format!("{word}{}", quantity.subject(&groups)));
    let (value, rate) = (results.axis(&quantity.label()), results.axis(&quantity.rate_label()));
    let axes = match plane {
        Plane::Time => ["time t [s]".to_owned(), value],
        Plane::Phase => [value, rate],
    };
    // The derivative of a difference between its points would mostly show how far the velocities of a scheme are from
    // the derivatives of its positions.
    let cubic = plane == Plane::Time || results.base.is_none();
    let unit = quantity.unit().to_owned();
    Ok(Panel { title, axes, unit, rank: 0, plane, cubic, curves })
}

/// The path of the same node in another run.
fn same_node<'a>(base: &'a Run, track: &ProbePath) -> Result<&'a ProbePath, PlotError> {
    let same = |other: &&ProbePath| other.node == track.node && other.probe == track.probe;
    // Another name for the probe of a node makes no other node.
    let found = base.tracks.iter().find(same).or_else(|| base.tracks.iter().find(|other| other.node == track.node));
    found.ok_or_else(|| {
        let mut there: Vec<String> = base.tracks.iter().map(|t| t.node.to_string()).collect();
        there.dedup();
        PlotError::Unmatched {
            folder: base.folder.clone(),
            missing: format!("probed node {}", track.node),
            there,
            choose: "--nodes or --probe",
        }
    })
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

    fn phase_name(self) -> &'static str {
        match self {
            Quantity::Along(_) => "velocity over displacement",
            Quantity::Angle => "angular velocity over angle",
        }
    }

    fn unit(self) -> &'static str {
        match self {
            Quantity::Along(_) => "m",
            Quantity::Angle => "rad",
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
    fn samples(self, track: &ProbePath, view: &View) -> Vec<Sample> {
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
        track.moments.iter().map(sample).filter(|s| view.sees(s.t)).collect()
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
