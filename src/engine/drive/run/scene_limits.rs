//! Limits on the motion of nodes in one step: motion beyond the scene's size is not credible.

use crate::model::state::State;
use crate::scene::Scene;

/// Size and mass of a scene, known before its first step.
#[derive(Clone, Copy)]
pub(super) struct SceneLimits {
    /// [m] the scene's size; 0 where it has none
    size: f64,
    /// [1/kg] largest inverse mass
    lightest: f64,
    /// whether a node is held; otherwise the scene as a whole may travel
    held: bool,
}

impl SceneLimits {
    pub(super) fn of(scene: &dyn Scene) -> Self {
        let lightest = scene.inverse_mass().iter().fold(0.0, |most: f64, inverse| most.max(*inverse));
        let held = scene.inverse_mass().contains(&0.0);
        SceneLimits { size: scene.size(), lightest, held }
    }

    /// Whether nodes with speeds up to this one [m/s] stay within the scene's size in a step `h` [s].
    pub(super) fn allows(&self, speed: f64, h: f64) -> bool {
        self.size == 0.0 || speed * h <= self.size
    }

    /// Whether no node moves farther than the scene's size in a step that ends with this kinetic energy [J].
    pub(super) fn holds(&self, from: &State, to: &State, kinetic: f64) -> bool {
        // No node is faster than with all of the kinetic energy; so the positions are seldom needed.
        let fastest = (2.0 * kinetic * self.lightest).sqrt();
        if self.allows(fastest, to.t - from.t) {
            return true;
        }
        let moved = |(from, to): (&[f64; 3], &[f64; 3])| [0, 1, 2].map(|c| to[c] - from[c]);
        let nodes = || from.x.as_chunks::<3>().0.iter().zip(to.x.as_chunks::<3>().0).map(moved);
        let mut together = [0.0; 3];
        if !self.held {
            let n = (from.x.len() / 3) as f64;
            nodes().for_each(|d| (0..3).for_each(|c| together[c] += d[c] / n));
        }
        let squares = nodes().map(|d| (0..3).map(|c| (d[c] - together[c]).powi(2)).sum::<f64>());
        squares.fold(0.0, f64::max) <= self.size * self.size
    }
}
