//! Ends a run whose scene has come to rest.

use super::observer::{AcceptedStep, ObserveError, Observer, Point, UpcomingStep, Wants};
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// When a scene counts as at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RestSpec {
    /// [m/s] no degree of freedom is faster
    pub speed: f64,
    /// [s] time between two looks; nor would the forces there make one faster within this time
    pub every: f64,
}

/// The observer that looks at multiples of a time. What it decides by is a state alone, so a run that is resumed ends
/// where an uninterrupted one does.
pub struct AtRest<'a> {
    scene: &'a dyn Scene,
    spec: RestSpec,
    reached: bool,
}

impl<'a> AtRest<'a> {
    /// Of this scene.
    pub fn new(scene: &'a dyn Scene, spec: RestSpec) -> Self {
        AtRest { scene, spec, reached: false }
    }

    /// Whether a multiple of the interval lies in a step.
    fn looks(&self, from: f64, t: f64) -> bool {
        // A step that ends at a multiple up to rounding reaches it.
        let looks = |t: f64| (t / self.spec.every * (1.0 + 1e-12)).floor();
        looks(t) > looks(from)
    }

    fn is_at_rest(&self, at: &Point) -> bool {
        let RestSpec { speed, every } = self.spec;
        let dofs = at.state.v.iter().zip(&at.forces.total).zip(self.scene.inverse_mass());
        // A support that moves is no rest; a number that is not finite neither.
        dofs.into_iter().all(|((v, f), inverse)| v.abs() <= speed && (f * inverse).abs() * every <= speed)
    }
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
