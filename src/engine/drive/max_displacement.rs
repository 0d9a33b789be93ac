//! The largest displacement at the end of a run.

use crate::drive::observer::{AcceptedStep, ObserveError, Observer, Point, UpcomingStep, Wants};
use crate::scene::Scene;

/// The largest displacement of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Displacement {
    /// the node with it, user's number
    pub node: usize,
    /// [m] the largest displacement
    pub distance: f64,
}

/// Observer of the largest displacement at the end of a run.
pub struct MaxDisplacement<'a> {
    scene: &'a dyn Scene,
    /// what was found
    pub found: Displacement,
}

impl<'a> MaxDisplacement<'a> {
    /// Of this scene.
    pub fn new(scene: &'a dyn Scene) -> Self {
        MaxDisplacement { scene, found: Displacement::default() }
    }
}

impl Observer for MaxDisplacement<'_> {
    fn accepted(&mut self, _step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        Ok(())
    }

    fn wants(&self, _step: UpcomingStep) -> Wants {
        Wants::ACCOUNT
    }

    fn finished(&mut self, last: &Point) -> Result<(), ObserveError> {
        let reference = self.scene.reference();
        let (mut x, mut v) = (vec![[0.0; 3]; reference.len()], vec![[0.0; 3]; reference.len()]);
        self.scene.trace(last.state.as_ref(), &mut x, &mut v);
        for (node, (x, o)) in x.iter().zip(reference).enumerate() {
            let d = (0..3).map(|c| (x[c] - o[c]).powi(2)).sum::<f64>().sqrt();
            if d > self.found.distance {
                self.found = Displacement { node, distance: d };
            }
        }
        Ok(())
    }
}
