//! The largest strain of cloth in a run.

use super::at_rest::passes_multiple;
use super::observer::{AcceptedStep, Energies, ObserveError, Observer, Point, UpcomingStep, Wants};
use crate::analysis::cloth::StrainedCloth;
use crate::scene::Scene;

/// Looks at the strains of a run.
const LOOKS: f64 = 100.0;

/// The observer that keeps the most strained part of cloth in a run, at a hundred times.
pub struct ClothStrain<'a> {
    scene: &'a dyn Scene,
    /// [s] time between two looks
    every: f64,
    /// whether the cloth starts so, as where a case is not of cloth
    from_start: bool,
    /// the most strained part seen, if none was strained so at the start
    pub most: Option<StrainedCloth>,
}

impl<'a> ClothStrain<'a> {
    /// Of a scene in a run to `end` [s].
    pub fn new(scene: &'a dyn Scene, end: f64) -> Self {
        ClothStrain { scene, every: end / LOOKS, from_start: false, most: None }
    }
}

impl Observer for ClothStrain<'_> {
    fn started(&mut self, at: &Point, _ledger: Energies) -> Result<(), ObserveError> {
        self.from_start = StrainedCloth::of(self.scene, at.state.as_ref()).is_some();
        Ok(())
    }

    fn wants(&self, step: UpcomingStep) -> Wants {
        let looks = !self.from_start && !self.scene.triangles().is_empty();
        Wants::end_if(looks && passes_multiple(self.every, [step.from, step.t]))
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        let end = step.end.filter(|_| !self.from_start && passes_multiple(self.every, [step.from, step.t]));
        let seen = end.and_then(|end| StrainedCloth::of(self.scene, end.state.as_ref()));
        if let Some(seen) = seen.filter(|seen| self.most.is_none_or(|most| seen.strain > most.strain)) {
            self.most = Some(seen);
        }
        Ok(())
    }
}
