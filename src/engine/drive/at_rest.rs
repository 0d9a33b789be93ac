//! Ends a run whose scene has come to rest.

use super::observer::{AcceptedStep, ObserveError, Observer, Point, UpcomingStep, Wants};
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// [-] Relative difference of times that are the same.
const ROUNDING: f64 = 1e-12;

/// When a scene counts as at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RestSpec {
    /// [m/s] no degree of freedom is faster
    pub speed: f64,
    /// [s] time between two looks; nor would the forces there make one faster within this time
    pub every: f64,
}

/// The observer that looks at multiples of a time, once nothing is to come any more: no event, and no change of a load,
/// of the wind, of the base, of a rest length or of a canopy. What it decides by is a state alone, so a run that is
/// resumed ends where an uninterrupted one does.
pub struct AtRest<'a> {
    scene: &'a dyn Scene,
    spec: RestSpec,
    /// [s] last time before the end of the run until which something changes
    settled: f64,
    reached: bool,
}

impl<'a> AtRest<'a> {
    /// Of this scene in a run to `end` [s].
    pub fn new(scene: &'a dyn Scene, spec: RestSpec, end: f64) -> Self {
        AtRest { scene, spec, settled: scene.events().map_or(0.0, |events| events.settled_after(end)), reached: false }
    }

    /// Whether a multiple of the interval lies in a step that ends after all changes: at its end an event is still to
    /// come.
    fn looks(&self, from: f64, t: f64) -> bool {
        t > self.settled * (1.0 + ROUNDING) && passes_multiple(self.spec.every, [from, t])
    }

    fn is_at_rest(&self, at: &Point) -> bool {
        let RestSpec { speed, every } = self.spec;
        let dofs = at.state.v.iter().zip(&at.forces.total).zip(self.scene.inverse_mass());
        // A support that moves is no rest; a number that is not finite neither.
        dofs.into_iter().all(|((v, f), inverse)| v.abs() <= speed && (f * inverse).abs() * every <= speed)
    }
}

/// Whether a multiple of an interval [s] lies in a step between two times [s].
pub(super) fn passes_multiple(every: f64, [from, t]: [f64; 2]) -> bool {
    // A step that ends at a multiple up to rounding reaches it.
    let passed = |t: f64| (t / every * (1.0 + ROUNDING)).floor();
    passed(t) > passed(from)
}

impl Observer for AtRest<'_> {
    fn wants(&self, step: UpcomingStep) -> Wants {
        Wants::end_if(self.looks(step.from, step.t))
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        let seen = step.end.filter(|_| self.looks(step.from, step.t));
        self.reached |= seen.is_some_and(|end| self.is_at_rest(end));
        Ok(())
    }

    fn ends_run(&self) -> bool {
        self.reached
    }
}
