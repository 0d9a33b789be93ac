//! The largest strain of cloth in a run.

use super::at_rest::passes_multiple;
use super::observer::{AcceptedStep, ObserveError, Observer, UpcomingStep, Wants};
use crate::analysis::cloth::StrainedCloth;
use crate::scene::Scene;

/// Looks at the strains of a run.
const LOOKS: f64 = 100.0;

/// The observer that keeps the most strained part of cloth in a run, at a hundred times.
pub struct ClothStrain<'a> {
    scene: &'a dyn Scene,
    /// [s] time between two looks
    every: f64,
    /// the most strained part seen
    pub most: Option<StrainedCloth>,
}

impl<'a> ClothStrain<'a> {
    /// Of a scene in a run to `end` [s].
    pub fn new(scene: &'a dyn Scene, end: f64) -> Self {
        ClothStrain { scene, every: end / LOOKS, most: None }
    }
}

impl Observer for ClothStrain<'_> {
    fn wants(&self, step: UpcomingStep) -> Wants {
        Wants::end_if(passes_multiple(self.every, [step.from, step.t]) && !self.scene.triangles().is_empty())
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        let end = step.end.filter(|_| passes_multiple(self.every, [step.from, step.t]));
        let seen = end.and_then(|end| StrainedCloth::of(self.scene, end.state.as_ref()));
        if let Some(seen) = seen.filter(|seen| self.most.is_none_or(|most| seen.strain > most.strain)) {
            self.most = Some(seen);
        }
        Ok(())
    }
}
