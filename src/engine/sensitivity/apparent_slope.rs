//! What the tangents of a scene leave out: how the force of the air that canopies take along depends on the state.
//!
//! That force is smooth and small against W, so that its derivative along a direction is found by differences, and the
//! derivative of an implicit stage, which depends on it and on which it depends, by repeating the solve.

use super::difference::{PLACES, derivative};
use super::linearisation::Linearisation;
use crate::model::state::StateRef;
use crate::scene::Scene;

/// [-] Share of the scene's size, and of its speeds, by which differences move the state.
const SHARE: f64 = 1e-4;
/// [-] Relative change of a derivative below which it is found.
const SETTLED: f64 = 1e-13;
/// Solves after which the last one is taken; each one gains several digits.
const MOST: usize = 40;

/// The derivative of the force of that air at a state, for given accelerations.
pub(super) struct ApparentSlope<'a> {
    scene: &'a dyn Scene,
    at: StateRef<'a>,
    acceleration: &'a [f64],
    /// whether there is such air
    there: bool,
    /// whether the force depends on what is solved for
    coupled: bool,
    last: Vec<f64>,
    solves: usize,
}

fn largest(of: &[f64]) -> f64 {
    of.iter().fold(0.0, |most: f64, value| most.max(value.abs()))
}

impl<'a> ApparentSlope<'a> {
    pub(super) fn of(scene: &'a dyn Scene, at: StateRef<'a>, acceleration: &'a [f64]) -> Self {
        let there = scene.mass_parts() > 0;
        ApparentSlope { scene, at, acceleration, there, coupled: false, last: Vec::new(), solves: 0 }
    }

    /// Subtracts the derivative along dx + alpha g and dv + beta g from `b` `[n]`.
    pub(super) fn subtract(
        &mut self,
        [dx, dv]: [&[f64]; 2],
        own: [f64; 2],
        g: &[f64],
        linear: &Linearisation,
        b: &mut [f64],
    ) {
        if !self.there {
            return;
        }
        self.coupled = own != [0.0; 2];
        let along = |base: &[f64], share: f64| -> Vec<f64> { base.iter().zip(g).map(|(d, g)| d + share * g).collect() };
        let (dx, dv) = (along(dx, own[0]), along(dv, own[1]));
        // Sizes that such a scene has, so that no direction moves it far.
        let (size, speed) = (self.scene.size().max(1e-3), 1.0 + largest(self.at.v));
        let h = SHARE * f64::min(size / largest(&dx), speed / largest(&dv));
        if !h.is_finite() {
            return;
        }
        let forces = PLACES.map(|place| {
            let moved =
                |of: &[f64], by: &[f64]| -> Vec<f64> { of.iter().zip(by).map(|(a, d)| a + place * h * d).collect() };
            let (x, v) = (moved(self.at.x, &dx), moved(self.at.v, &dv));
            let mut force = vec![0.0; x.len()];
            self.scene.apparent_force(StateRef { t: self.at.t, x: &x, v: &v }, self.acceleration, &mut force);
            force
        });
        let slope: Vec<f64> = (0..dx.len()).map(|i| derivative(forces.each_ref().map(|force| force[i]), h)).collect();
        let mut picked = vec![0.0; b.len()];
        linear.pick(&slope, &mut picked);
        b.iter_mut().zip(&picked).for_each(|(b, slope)| *b -= slope);
    }

    /// Whether a solution is the last one.
    pub(super) fn settled(&mut self, found: &[f64]) -> bool {
        self.solves += 1;
        let change = found.iter().zip(&self.last).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
        let same = self.last.len() == found.len() && change <= SETTLED * largest(found);
        self.last.clear();
        self.last.extend_from_slice(found);
        !self.coupled || same || self.solves >= MOST
    }
}
