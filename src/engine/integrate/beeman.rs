//! Beeman's step (Beeman 1976, J. Comput. Phys. 20, 130-139), for steps of changing size. Order 3, one evaluation a
//! step, with dashpots too.
//!
//! With the acceleration's derivative over the step before, j_n = (a_n - a_{n-1})/h_before, and r = h/h_before:
//! ```text
//! x_{n+1} = x_n + h v_n + h^2/2 a_n + h^3/6 j_n
//! v~      = v_n + h a_n + h^2/2 j_n
//! a_{n+1} = M^-1 f(t_{n+1}, x_{n+1}, v~),      j_{n+1} = (a_{n+1} - a_n)/h
//! v_{n+1} = v_n + h a_n + h^2 [(2 r + 3) j_{n+1} + r j_n]/(6 (r + 1))
//! ```
//! The velocity is the integral of the parabola through the last three accelerations. The velocities v~ that forces
//! see are those of Adams-Bashforth 2: off by 5/12 h^3 a'', which leaves order 3. The first step has j = 0 and r = 0:
//! that of velocity Verlet without a second evaluation.
//!
//! Undamped, a motion turns by exp(s h - (s h)^4/24) a step: an oscillation decays by (w h)^4/24, up to w h = sqrt 3.
//! Damping that is strong in a step shortens that limit: 1.27 at damping ratio 0.1, 0.27 at 1.
//!
//! Where a_n jumps or has a corner, j_n does not tell of what follows. Besides, loads that jump between steps have
//! values at the ends of steps that give the trapezoidal rule their impulse. So steps near a corner of a table are made
//! as first ones, and so is that after a change of values by a program that changes a force.

use super::form::{StageForm, StepForm, sum, unit};
use super::updates::Product;
use super::{CarriedState, Counters, ErrorEstimate, Integrator, PairInfo, StepError, StepInput, StepReport};
use crate::model::point::Point;
use crate::model::state::StateRef;
use crate::model::system::System;
use multiversion::multiversion;

/// [-] A step that is longer than the one before by more than this starts anew: rounding in its j would count.
const LONGEST: f64 = 1e3;

/// Beeman's step; carries the derivative of the acceleration, and the velocities that forces saw.
#[derive(Clone, Debug, Default)]
pub struct Beeman {
    now: Change,
    next: Change,
    /// [N] forces before a change of values by a program; empty if there was none
    before: Vec<f64>,
    /// whether the next step is near a corner of a table
    near_corner: bool,
    /// whether the step attempted last began with other forces than the one before it ended with
    changed: bool,
}

/// What a step has left.
#[derive(Clone, Debug, Default)]
struct Change {
    /// [s] the step, 0 before the first
    h: f64,
    /// [m/s^3]
    j: Vec<f64>,
    /// [m/s] v~
    v: Vec<f64>,
}

/// Weights of j_n and j_{n+1} in a step.
#[derive(Clone, Copy, Debug)]
struct Weights {
    /// [s] the step
    h: f64,
    /// in x_{n+1} and v~
    predict: [f64; 2],
    /// in v_{n+1}, the new one first
    correct: [f64; 2],
}

impl Integrator<dyn System> for Beeman {
    fn start(&mut self, _system: &dyn System, at: &Point) -> Result<(), StepError> {
        let v = at.state.v.clone();
        self.now = Change { h: 0.0, j: vec![0.0; v.len()], v };
        self.next = self.now.clone();
        self.before.clear();
        self.changed = false;
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        self.changed = !self.before.is_empty() && self.before != from.forces.total;
        let (w, j, next) = (self.weights(h), &self.now.j, &mut self.next);
        let inverse_mass = system.inverse_mass();
        let (start, workers) = (&from.state, system.workers());
        let a = Product { inverse_mass, f: &from.forces.total };
        workers.both(&mut to.state.x, &mut next.v, |r, x, v| {
            predict([x, v], [&start.x[r.clone()], &start.v[r.clone()], &j[r.clone()]], a.of(r), w);
        });
        to.state.t = t_next;
        counters.evaluate(system, StateRef { t: t_next, x: &to.state.x, v: &next.v }, &mut to.forces);
        let a_next = Product { inverse_mass, f: &to.forces.total };
        workers.both(&mut to.state.v, &mut next.j, |r, v, j_next| {
            correct([v, j_next], [&start.v[r.clone()], &j[r.clone()]], [a.of(r.clone()), a_next.of(r)], w);
        });
        next.h = h;
        Ok(StepReport { forces_at_end: true, ..Default::default() })
    }

    fn accept(&mut self) {
        std::mem::swap(&mut self.now, &mut self.next);
        self.before.clear();
        self.changed = false;
    }

    fn restart(&mut self, _system: &dyn System, at: &Point) {
        self.now.h = 0.0;
        self.now.v.copy_from_slice(&at.state.v);
        self.before.clear();
        self.changed = false;
    }

    fn set_near_corner(&mut self, near: bool) {
        self.near_corner = near;
    }

    fn keep_over_change(&mut self, system: &dyn System, at: &Point) -> bool {
        if self.before.is_empty() {
            self.before.extend_from_slice(&at.forces.total);
        }
        // A support that has another velocity now is a corner.
        for dof in system.moved().iter().map(|dof| *dof as usize) {
            if self.now.v[dof] != at.state.v[dof] {
                (self.now.h, self.now.v[dof]) = (0.0, at.state.v[dof]);
            }
        }
        true
    }

    fn force_velocities(&self) -> Option<&[f64]> {
        Some(&self.now.v)
    }

    fn lags(&self, system: &dyn System) -> bool {
        system.velocity_dependent()
    }

    /// What Adams-Bashforth 2 is off by: 5/12 h^3 of the third derivatives of x and v, in steps of one size.
    fn pair(&self) -> Option<PairInfo> {
        Some(PairInfo { leading: (1.0 / 24.0) / (5.0 / 12.0) })
    }

    fn embedded_error(&mut self, step: StepInput<'_, dyn System>, to: &Point, out: ErrorEstimate<'_>) {
        let [new, _] = self.weights(step.h).correct;
        for (i, (x, v)) in out.x.iter_mut().zip(out.v).enumerate() {
            *x = new * step.h * self.next.j[i];
            *v = to.state.v[i] - self.next.v[i];
        }
    }

    /// It begins with a_n and j_n besides x and v.
    fn form(&self, h: f64, _: bool) -> Option<StepForm> {
        let Weights { predict, correct, .. } = self.weights(h);
        let [x, v, a, j, g] = [0, 1, 2, 3, 4].map(unit);
        let next_x = sum(&[(1.0, &x), (h, &v), (0.5 * h * h, &a), (predict[0], &j)]);
        let predicted = sum(&[(1.0, &v), (h, &a), (predict[1], &j)]);
        let next_j = sum(&[(1.0 / h, &g), (-1.0 / h, &a)]);
        let next_v = sum(&[(1.0, &v), (h, &a), (correct[0], &next_j), (correct[1], &j)]);
        let stages = vec![StageForm { c: 1.0, x: next_x.clone(), v: predicted }];
        let start = vec![[0.0, 0.0, 1.0], [0.0; 3]];
        Some(StepForm { start, stages, next: vec![next_x, next_v, g, next_j] })
    }

    fn save(&self) -> CarriedState {
        let Change { h, j, v } = self.now.clone();
        let vectors = [j, v].into_iter().chain(Some(self.before.clone()).filter(|before| !before.is_empty()));
        CarriedState { vectors: vectors.collect(), made_with: h, ..CarriedState::default() }
    }

    fn restore(&mut self, carried: &CarriedState) -> Result<(), StepError> {
        self.now.h = carried.made_with;
        self.before.clear();
        if carried.vectors.len() < 3 {
            return carried.take_into(&mut [&mut self.now.j, &mut self.now.v]);
        }
        self.before.resize(self.now.j.len(), 0.0);
        carried.take_into(&mut [&mut self.now.j, &mut self.now.v, &mut self.before])
    }
}

impl Beeman {
    /// The weights of the next step of `h`.
    fn weights(&self, h: f64) -> Weights {
        if self.near_corner || self.changed || h > LONGEST * self.now.h {
            return Weights::first(h);
        }
        let (second, r) = (h * h, h / self.now.h);
        let part = second / (6.0 * (r + 1.0));
        Weights { h, predict: [h * second / 6.0, 0.5 * second], correct: [(2.0 * r + 3.0) * part, r * part] }
    }
}

impl Weights {
    /// Those of a first step of `h`.
    fn first(h: f64) -> Self {
        Weights { h, predict: [0.0; 2], correct: [0.5 * h * h, 0.0] }
    }
}

/// x_{n+1} and v~ from x_n, v_n and j_n.
#[multiversion(targets("x86_64+avx+avx2"))]
fn predict([x, v]: [&mut [f64]; 2], [x_n, v_n, j]: [&[f64]; 3], p: Product<'_>, w: Weights) {
    let (h, half, [of_x, of_v]) = (w.h, 0.5 * w.h * w.h, w.predict);
    let accelerations = p.f.iter().zip(p.inverse_mass);
    let from = x_n.iter().zip(v_n).zip(j).zip(accelerations);
    for ((x, v), (((x_n, v_n), j), (f, inverse_mass))) in x.iter_mut().zip(v).zip(from) {
        let a = inverse_mass * f;
        *x = x_n + h * v_n + half * a + of_x * j;
        *v = v_n + h * a + of_v * j;
    }
}

/// v_{n+1} and j_{n+1} from v_n and j_n.
#[multiversion(targets("x86_64+avx+avx2"))]
fn correct([v, j_next]: [&mut [f64]; 2], [v_n, j]: [&[f64]; 2], [p, p_next]: [Product<'_>; 2], w: Weights) {
    let (h, per_step, [new, old]) = (w.h, 1.0 / w.h, w.correct);
    let forces = p.f.iter().zip(p_next.f).zip(p.inverse_mass);
    let from = v_n.iter().zip(j).zip(forces);
    for ((v, j_next), ((v_n, j), ((f, f_next), inverse_mass))) in v.iter_mut().zip(j_next).zip(from) {
        let (a, a_next) = (inverse_mass * f, inverse_mass * f_next);
        *j_next = (a_next - a) * per_step;
        *v = v_n + h * a + new * *j_next + old * j;
    }
}
