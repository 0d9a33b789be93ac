//! A new beginning where forces are not smooth in time: at the corner of a table, and where a spring has gone slack or
//! taut.
//!
//! The scheme drops what it carries, and the step is at least the one that follows from what acts now, however short
//! those before it were. As for the starting step of Hairer, Norsett & Wanner (1993, section II.4), a short explicit
//! step shows how fast accelerations change:
//! ```text
//! j = |a(t + s, x + s v + s^2/2 a, v + s a) - a| / s
//! h = sqrt(2 tol / (T j)),  of order 1  h = 2 tol / (T |a|)
//! ```
//! so that an error of j h^3/6 (order 1: a h^2/2) is about what a step of h in a run of T may make of the error tol.
//! The first step's error is estimated by halving it, so a beginning that is too large shrinks.

use super::attempt::AttemptContext;
use super::{Adaptive, FIRST, LARGEST};
use crate::model::point::Point;

/// [-] What the probing step may move of the tolerance.
const PROBE: f64 = 0.01;

impl Adaptive {
    /// Before an attempt from `from`, where the run begins anew there; `room` is overwritten then.
    pub fn begin(&mut self, bench: &mut AttemptContext<'_, '_>, from: &Point, room: &mut Point) {
        if !std::mem::take(&mut self.state.anew) {
            return;
        }
        bench.stepper.restart(from);
        let least = self.starting_step(bench, from, room);
        self.state.controller.restart(least);
    }

    /// [s] h; 0 where it is not a number, or nothing acts.
    fn starting_step(&self, bench: &mut AttemptContext<'_, '_>, from: &Point, room: &mut Point) -> f64 {
        let inverse_mass = bench.scene.inverse_mass();
        let (run, allowed) = (self.spec.end, self.state.motion.allowed(self.spec.tolerance, self.free));
        let a = |point: &Point, i: usize| inverse_mass[i] * point.forces.total[i];
        let n = inverse_mass.len();
        let now = (0..n).map(|i| a(from, i).powi(2)).sum::<f64>().sqrt();
        let next =
            self.corners.iter().find(|corner| **corner > from.state.t).map_or(run, |corner| corner - from.state.t);
        let probe = (2.0 * PROBE * allowed / now).sqrt().min(FIRST * run).min(0.5 * next);
        room.state.t = from.state.t + probe;
        for i in 0..n {
            room.state.x[i] = from.state.x[i] + probe * (from.state.v[i] + 0.5 * probe * a(from, i));
            room.state.v[i] = from.state.v[i] + probe * a(from, i);
        }
        bench.counters.evaluate(bench.scene, room.state.as_ref(), &mut room.forces);
        let change = (0..n).map(|i| (a(room, i) - a(from, i)).powi(2)).sum::<f64>().sqrt() / probe;
        let step = match self.spec.order {
            1 => 2.0 * allowed / (run * now),
            _ => (2.0 * allowed / (run * change)).sqrt(),
        };
        if step.is_finite() { step.min(LARGEST * run) } else { 0.0 }
    }
}
