//! The largest displacement at the end of a run.

use crate::drive::observer::{AcceptedStep, ObserveError, Observer, Point, UpcomingStep, Wants};
use crate::model::observables::Observables;
use crate::model::state::StateRef;
use crate::scene::Scene;

/// The largest displacement of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Displacement {
    /// the node with it, user's number
    pub node: usize,
    /// [m] the largest displacement
    pub distance: f64,
}

impl Displacement {
    /// The largest of a state; of equal ones that of the first node.
    pub fn of(picture: &dyn Observables, at: StateRef<'_>) -> Self {
        let reference = picture.reference();
        let (mut x, mut v) = (vec![[0.0; 3]; reference.len()], vec![[0.0; 3]; reference.len()]);
        picture.trace(at, &mut x, &mut v);
        let mut found = Displacement::default();
        for (node, (x, o)) in x.iter().zip(reference).enumerate() {
            let distance = (0..3).map(|c| (x[c] - o[c]).powi(2)).sum::<f64>().sqrt();
            if distance > found.distance {
                found = Displacement { node, distance };
            }
        }
        found
    }
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
        self.found = Displacement::of(self.scene, last.state.as_ref());
        Ok(())
    }
}
