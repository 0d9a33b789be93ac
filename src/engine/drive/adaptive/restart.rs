//! Restart where forces are not smooth in time: at the corner of a table, and where a spring has gone slack or taut.
//!
//! The scheme drops what it carries. The step follows from the forces that act now, even if those before it were very
//! short. As for the starting step of Hairer, Norsett & Wanner (1993, section II.4), a short explicit step shows how
//! fast accelerations change:
//! ```text
//! j = |a(t + s, x + s v + s^2/2 a, v + s a) - a| / s
//! h = sqrt(2 tol / (T j)),  of order 1  h = 2 tol / (T |a|)
//! ```
//! so that an error of j h^3/6 (order 1: a h^2/2) is about the share of the allowed error tol for a step of h in a run
//! of T. The error of the first step is estimated from two half steps, so a first step that is too large is reduced.

use super::attempt::AttemptContext;
use super::{Adaptive, FIRST, LARGEST};
use crate::model::point::Point;

/// [-] Motion in the trial step, as a share of the tolerance.
const PROBE: f64 = 0.01;

impl Adaptive {
    /// Called before an attempt from `from`. If the run restarts there, `buffer` is overwritten.
    pub fn begin(&mut self, context: &mut AttemptContext<'_, '_>, from: &Point, buffer: &mut Point) {
        if !std::mem::take(&mut self.state.anew) {
            return;
        }
        context.stepper.restart(from);
        let least = self.starting_step(context, from, buffer);
        self.state.controller.restart(least);
    }

    /// [s] h; 0 where it is not a number, or no force acts.
    fn starting_step(&self, context: &mut AttemptContext<'_, '_>, from: &Point, buffer: &mut Point) -> f64 {
        let inverse_mass = context.scene.inverse_mass();
        let (run, allowed) = (self.spec.end, self.state.motion.allowed(self.spec.tolerance, self.free));
        let a = |point: &Point, i: usize| inverse_mass[i] * point.forces.total[i];
        let n = inverse_mass.len();
        let now = (0..n).map(|i| a(from, i).powi(2)).sum::<f64>().sqrt();
        let next =
            self.corners.iter().find(|corner| **corner > from.state.t).map_or(run, |corner| corner - from.state.t);
        let probe = (2.0 * PROBE * allowed / now).sqrt().min(FIRST * run).min(0.5 * next);
        buffer.state.t = from.state.t + probe;
        for i in 0..n {
            buffer.state.x[i] = from.state.x[i] + probe * (from.state.v[i] + 0.5 * probe * a(from, i));
            buffer.state.v[i] = from.state.v[i] + probe * a(from, i);
        }
        context.counters.evaluate(context.scene, buffer.state.as_ref(), &mut buffer.forces);
        let change = (0..n).map(|i| (a(buffer, i) - a(from, i)).powi(2)).sum::<f64>().sqrt() / probe;
        let step = match self.spec.order {
            1 => 2.0 * allowed / (run * now),
            _ => (2.0 * allowed / (run * change)).sqrt(),
        };
        if step.is_finite() { step.min(LARGEST * run) } else { 0.0 }
    }
}
