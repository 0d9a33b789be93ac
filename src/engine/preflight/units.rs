//! Numbers that suggest a wrong unit.

use std::f64::consts::TAU;
use std::fmt;

use nalgebra::Vector3;

use crate::format_number::figures;
use crate::model::spec::{NetworkSpec, PendulumSpec};
use crate::warning::{Warning, WarningCode};

/// [m] Extent of a cloth above which millimetres are likely. The largest canopies are some 60 m across, roofs some 300
/// m.
const EXTENT: f64 = 500.0;

/// [kg] Mass of a scene with cloth above which grams are likely. The heaviest loads under parachutes weigh some 90 t.
const MASS: f64 = 1e5;

/// [m/s^2] Gravity above which mm/s^2 are likely. The sun's is 274.
const GRAVITY: f64 = 300.0;

/// [s] Step above which the motion in a step is checked.
const STEP: f64 = 1.0;

/// [-] Share of a pendulum's period above which a step is long.
const OF_PERIOD: f64 = 0.25;

/// A number that suggests a wrong unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UnlikelyValue {
    /// cloth so many metres across
    Extent(f64),
    /// a mass of so many kilograms
    Mass(f64),
    /// gravity of so many m/s^2
    Gravity(f64),
    /// a step in which something moves farther than the scene is across
    Step {
        /// [s]
        step: f64,
        /// [m] way in a step
        way: f64,
        /// [m] extent of the scene
        extent: f64,
        /// what moves so
        what: &'static str,
    },
    /// a step that is long against a pendulum's period
    OfPeriod {
        /// [s]
        step: f64,
        /// [s] period of small swings
        period: f64,
    },
}

/// Warnings about the units of a network; `step` [s] is the fixed step, if there is one.
pub fn network(spec: &NetworkSpec, step: Option<f64>) -> Vec<UnlikelyValue> {
    let cloth = !spec.mesh.triangles.is_empty();
    let extent = extent(&spec.mesh.nodes);
    let mass: f64 = spec.mass.iter().sum();
    let gravity = spec.gravity.map_or(0.0, |g| Vector3::from(g).norm());
    let mut doubts = Vec::new();
    doubts.extend((cloth && extent > EXTENT).then_some(UnlikelyValue::Extent(extent)));
    doubts.extend((cloth && mass > MASS).then_some(UnlikelyValue::Mass(mass)));
    doubts.extend((gravity > GRAVITY).then_some(UnlikelyValue::Gravity(gravity)));
    doubts.extend(step.filter(|step| *step >= STEP && extent > 0.0).and_then(|step| {
        let fastest = |list: &[[f64; 3]]| list.iter().map(|v| Vector3::from(*v).norm()).fold(0.0, f64::max);
        let ways = [
            (0.5 * gravity * step * step, "what falls freely"),
            (spec.fastest_wind() * step, "the wind"),
            (fastest(&spec.velocity) * step, "the fastest node"),
        ];
        let (way, what) = ways.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
        (way > extent).then_some(UnlikelyValue::Step { step, way, extent, what })
    }));
    doubts
}

/// Warnings about the units of a pendulum; `step` [s] is the fixed step, if there is one.
pub fn pendulum(spec: &PendulumSpec, step: Option<f64>) -> Vec<UnlikelyValue> {
    let period = TAU * (spec.length / spec.gravity).sqrt();
    let gravity = (spec.gravity > GRAVITY).then_some(UnlikelyValue::Gravity(spec.gravity));
    let long = step.filter(|step| *step > OF_PERIOD * period).map(|step| UnlikelyValue::OfPeriod { step, period });
    gravity.into_iter().chain(long).collect()
}

/// [m] Largest side of the box around some points.
fn extent(points: &[[f64; 3]]) -> f64 {
    let points = || points.iter().map(|x| Vector3::from(*x));
    let [low, high] = [points().reduce(|low, x| low.inf(&x)), points().reduce(|high, x| high.sup(&x))];
    low.zip(high).map_or(0.0, |(low, high)| (high - low).max())
}

impl fmt::Display for UnlikelyValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            UnlikelyValue::Extent(extent) => write!(
                f,
                "the cloth's mesh is {} m across, where the largest canopies have some 60 m; are its coordinates in millimetres?",
                figures(extent, 4)
            ),
            UnlikelyValue::Mass(mass) => write!(
                f,
                "the scene has a mass of {} kg, more than any load under a parachute; are masses in grams?",
                figures(mass, 4)
            ),
            UnlikelyValue::Gravity(gravity) => write!(
                f,
                "gravity is {} m/s^2, {} times that of the earth; is it in mm/s^2?",
                figures(gravity, 4),
                figures(gravity / 9.81, 3)
            ),
            UnlikelyValue::Step { step, way, extent, what } => write!(
                f,
                "the step of {} s is long for this scene: {what} covers {} m in it, and the scene is {} m across; are times in \
                 milliseconds?",
                figures(step, 4),
                figures(way, 3),
                figures(extent, 3)
            ),
            UnlikelyValue::OfPeriod { step, period } => write!(
                f,
                "the step of {} s is {} of the pendulum's period of {} s, which it cannot resolve; take a twentieth or less",
                figures(step, 4),
                figures(step / period, 3),
                figures(period, 3)
            ),
        }
    }
}

impl From<UnlikelyValue> for Warning {
    fn from(doubt: UnlikelyValue) -> Self {
        let code = match doubt {
            UnlikelyValue::Extent(_) => WarningCode::LargeExtent,
            UnlikelyValue::Mass(_) => WarningCode::LargeMass,
            UnlikelyValue::Gravity(_) => WarningCode::LargeGravity,
            UnlikelyValue::Step { .. } | UnlikelyValue::OfPeriod { .. } => WarningCode::LongStep,
        };
        Warning::new(code, doubt.to_string())
    }
}
