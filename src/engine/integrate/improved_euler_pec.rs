//! Improved Euler in the thesis text's reading, "never corrected" (Hanna 1988): predict, evaluate, correct. Order 2,
//! one evaluation a step.
//!
//! With y = (x, v) and d_n the derivative evaluated at the *predicted* state of step n (d_0 at the initial state):
//! ```text
//! y~_{n+1} = y_n + h d_n,      d_{n+1} = (v~, M^-1 f(t_{n+1}, x~, v~))
//! y_{n+1} = y_n + h/2 (d_n + d_{n+1})
//! ```
//! On linear problems the predicted states follow Adams-Bashforth 2 exactly. The forces at the corrected state are
//! never evaluated by the scheme.
//!
//! Where a program changes values at t_n, d_n goes on with the forces at the corrected state added that the new values
//! make more there: so d_n and d_{n+1} both have them, and the impulse of a constant force is exact.

use super::form::{StageForm, StepForm, sum, unit};
use super::updates::{Product, acceleration, accumulate, accumulate_product, add_scaled, power_of_forces, weigh};
use super::{CarriedState, Counters, Integrator, StageWork, StepError, StepInput, StepReport};
use crate::model::point::Point;
use crate::model::state::State;
use crate::model::system::System;

/// The derivative at a predicted state.
#[derive(Clone, Debug, Default)]
struct Derivative {
    x: Vec<f64>,
    v: Vec<f64>,
    power: StageWork,
}

/// Improved Euler, PEC; carries the derivative of the last predicted state.
#[derive(Clone, Debug, Default)]
pub struct ImprovedEulerPec {
    /// less that of the corrected state if `relative`
    now: Derivative,
    /// that with the present values, after a change of values
    kept: Derivative,
    relative: bool,
    next: Derivative,
    predicted: State,
}

impl Integrator<dyn System> for ImprovedEulerPec {
    fn start(&mut self, system: &dyn System, at: &Point) -> Result<(), StepError> {
        let mut a = vec![0.0; at.state.v.len()];
        acceleration(system, &mut a, &at.forces.total);
        self.now = Derivative { x: at.state.v.clone(), v: a, power: power_of_forces(system, &at.forces) };
        (self.next, self.kept) = (self.now.clone(), self.now.clone());
        self.predicted = at.state.clone();
        self.relative = false;
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        if self.relative {
            let Derivative { x, v, power } = &mut self.kept;
            x.copy_from_slice(&self.now.x);
            // A support may have another velocity now.
            for &dof in system.moved() {
                x[dof as usize] = from.state.v[dof as usize];
            }
            acceleration(system, v, &from.forces.total);
            accumulate(v, 1.0, &self.now.v);
            *power = power_of_forces(system, &from.forces);
            power.add(1.0, self.now.power);
        }
        let now = if self.relative { &self.kept } else { &self.now };
        let (n, p) = (&from.state, &mut self.predicted);
        p.t = t_next;
        add_scaled(&mut p.x, &n.x, h, &now.x);
        add_scaled(&mut p.v, &n.v, h, &now.v);
        counters.evaluate(system, p.as_ref(), &mut to.forces);
        self.next.x.copy_from_slice(&p.v);
        acceleration(system, &mut self.next.v, &to.forces.total);
        self.next.power = power_of_forces(system, &to.forces);

        to.state.t = t_next;
        add_scaled(&mut to.state.x, &n.x, 0.5 * h, &now.x);
        accumulate(&mut to.state.x, 0.5 * h, &self.next.x);
        add_scaled(&mut to.state.v, &n.v, 0.5 * h, &now.v);
        accumulate(&mut to.state.v, 0.5 * h, &self.next.v);
        let mut work = weigh([(0.5 * h, now.power), (0.5 * h, self.next.power)]);
        for forces in [&from.forces, &to.forces] {
            work.external += 0.5 * h * system.reeling_power([n.t, t_next], &forces.tallies);
        }
        Ok(StepReport { work: Some(work), forces_at_end: false, ..Default::default() })
    }

    fn accept(&mut self) {
        std::mem::swap(&mut self.now, &mut self.next);
        self.relative = false;
    }

    fn restart(&mut self, system: &dyn System, at: &Point) {
        self.now.x.copy_from_slice(&at.state.v);
        acceleration(system, &mut self.now.v, &at.forces.total);
        self.now.power = power_of_forces(system, &at.forces);
        self.relative = false;
    }

    fn keep_over_change(&mut self, system: &dyn System, at: &Point) -> bool {
        if !self.relative {
            let less = Product { inverse_mass: system.inverse_mass(), f: &at.forces.total };
            accumulate_product(&mut self.now.v, -1.0, less);
            self.now.power.add(-1.0, power_of_forces(system, &at.forces));
            self.relative = true;
        }
        true
    }

    /// Its slope d_n = (v~, a~) is carried.
    fn form(&self, h: f64, _: bool) -> Option<StepForm> {
        let [x, v, d_x, d_v, a] = [0, 1, 2, 3, 4].map(unit);
        let predicted = sum(&[(1.0, &v), (h, &d_v)]);
        let stage = StageForm { c: 1.0, x: sum(&[(1.0, &x), (h, &d_x)]), v: predicted.clone() };
        let half = 0.5 * h;
        let next_x = sum(&[(1.0, &x), (half, &d_x), (half, &predicted)]);
        let next_v = sum(&[(1.0, &v), (half, &d_v), (half, &a)]);
        let start = vec![[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        (!self.relative).then(|| StepForm { start, stages: vec![stage], next: vec![next_x, next_v, predicted, a] })
    }

    fn save(&self) -> CarriedState {
        let Derivative { x, v, power } = self.now.clone();
        CarriedState { vectors: vec![x, v], power, relative: self.relative, ..CarriedState::default() }
    }

    fn restore(&mut self, carried: &CarriedState) -> Result<(), StepError> {
        (self.relative, self.now.power) = (carried.relative, carried.power);
        carried.take_into(&mut [&mut self.now.x, &mut self.now.v])
    }
}
