//! Schemes that a [`KickDriftScheme`] describes: a single step and a block of steps are made the same way.

use super::form::{StageForm, StepForm, sum, unit};
use super::updates::{Product, add_product};
use super::{CarriedState, Counters, Integrator, StepError, StepInput, StepReport};
use crate::model::point::Point;
use crate::model::step_block::{KickDriftScheme, StepSummary};
use crate::model::system::{KickDriftBlock, System, longest_block};

/// Such a scheme.
#[derive(Clone, Copy, Debug)]
pub struct KickDrift {
    /// the description of a step of a size [s], for forces that depend on velocity or not
    pub step: fn(h: f64, velocity_dependent: bool) -> KickDriftScheme,
    /// whether the forces at the end of a step are those at the velocities of its middle
    pub lags: bool,
}

impl KickDrift {
    /// The scheme, before its first step.
    pub fn scheme(self) -> KickDriftSteps {
        KickDriftSteps { scheme: self, last: 0.0, attempted: 0.0, middle: Vec::new(), size: 0 }
    }
}

/// The steps of such a scheme. Between them it carries only how long the last one was, where forces lag: after a change
/// of values they are found again at the velocities of its middle, v - l M^-1 f with the forces before the change.
#[derive(Clone, Debug)]
pub struct KickDriftSteps {
    scheme: KickDrift,
    /// [s] size of the last accepted step, 0 before the first, and of the last attempt
    last: f64,
    attempted: f64,
    /// [m/s] velocities of the middle of the last step, after a change of values `[n_dof]`; else empty
    middle: Vec<f64>,
    /// degrees of freedom
    size: usize,
}

impl Integrator<dyn System> for KickDriftSteps {
    fn start(&mut self, _system: &dyn System, at: &Point) -> Result<(), StepError> {
        (self.last, self.size) = (0.0, at.state.v.len());
        self.middle.clear();
        Ok(())
    }

    fn attempt(
        &mut self,
        step: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        self.advance(step, to, &mut [], counters);
        Ok(StepReport { forces_at_end: true, ..Default::default() })
    }

    fn advance_block(
        &mut self,
        step: StepInput<'_, dyn System>,
        to: &mut Point,
        summaries: &mut [StepSummary],
        counters: &mut Counters,
    ) -> bool {
        debug_assert!(summaries.last().is_none_or(|last| last.t == step.t_next));
        let makes_blocks = longest_block(step.system) >= 2 && !summaries.is_empty();
        if makes_blocks {
            self.advance(step, to, summaries, counters);
        }
        makes_blocks
    }

    fn accept(&mut self) {
        self.last = self.attempted;
        self.middle.clear();
    }

    fn keep_over_change(&mut self, system: &dyn System, at: &Point) -> bool {
        let end = (self.scheme.step)(self.last, true).end.unwrap_or(0.0);
        if self.scheme.lags && self.middle.is_empty() {
            self.middle.resize(at.state.v.len(), 0.0);
            let kick = Product { inverse_mass: system.inverse_mass(), f: &at.forces.total };
            add_product(&mut self.middle, &at.state.v, -end, kick);
        }
        true
    }

    fn force_velocities(&self) -> Option<&[f64]> {
        Some(&*self.middle).filter(|middle| !middle.is_empty())
    }

    fn lags(&self, system: &dyn System) -> bool {
        self.scheme.lags && system.velocity_dependent()
    }

    /// Where forces lag, the step begins with those at x_n and the velocities of the middle before; else with those of
    /// the state.
    fn form(&self, h: f64, velocity_dependent: bool) -> Option<StepForm> {
        let KickDriftScheme { begin, drift, end, .. } = (self.scheme.step)(h, velocity_dependent);
        let (x_n, v_n, end) = (unit(0), unit(1), end.unwrap_or(0.0));
        let [a, next_a] = [unit(2), unit(3)];
        let v_h = sum(&[(1.0, &v_n), (begin, &a)]);
        let x = sum(&[(1.0, &x_n), (drift, &v_h)]);
        let v = sum(&[(1.0, &v_h), (end, &next_a)]);
        if self.scheme.lags {
            let stages = vec![StageForm { c: 1.0, x: x.clone(), v: v_h }];
            return Some(StepForm { start: vec![[0.0, 0.0, 1.0]], stages, next: vec![x, v, next_a] });
        }
        let mut stages = vec![StageForm { c: 0.0, x: x_n, v: v_n.clone() }];
        if end != 0.0 {
            stages.push(StageForm { c: 1.0, x: x.clone(), v: sum(&[(1.0, &v_n), (begin + end, &a)]) });
        }
        Some(StepForm { start: Vec::new(), stages, next: vec![x, v] })
    }

    fn save(&self) -> CarriedState {
        let vectors = if self.middle.is_empty() { Vec::new() } else { vec![self.middle.clone()] };
        let made_with = if self.scheme.lags { self.last } else { 0.0 };
        CarriedState { vectors, made_with, relative: !self.middle.is_empty(), ..CarriedState::default() }
    }

    fn restore(&mut self, carried: &CarriedState) -> Result<(), StepError> {
        self.middle.clear();
        self.last = carried.made_with;
        match carried.vectors.as_slice() {
            [middle] if carried.relative && self.scheme.lags && middle.len() == self.size => {
                self.middle.extend_from_slice(middle);
                Ok(())
            }
            _ => carried.take_into(&mut []),
        }
    }
}

impl KickDriftSteps {
    fn advance(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn System>,
        to: &mut Point,
        summaries: &mut [StepSummary],
        counters: &mut Counters,
    ) {
        to.state.t = t_next;
        self.attempted = h;
        let scheme = (self.scheme.step)(h, system.velocity_dependent());
        counters.advance(system, to, KickDriftBlock { scheme, from }, summaries);
    }
}
