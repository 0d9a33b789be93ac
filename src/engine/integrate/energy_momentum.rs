//! The energy-momentum method: the midpoint rule with a discrete gradient of every elastic energy (Greenspan 1984 for
//! bars; Simo & Tarnow 1992 for continua; Gonzalez 1996 for any energy). Order 2 without dissipation, else 1.
//!
//! ```text
//! x_{n+1} - x_n = h v,   M (v_{n+1} - v_n) = h f,      v = (v_n + v_{n+1})/2
//! f = elastic forces as means over the step + all others in its middle
//! ```
//! Elastic forces balance one another, turn nothing, and do exactly the work that their energies lose
//! ([`TangentSystem::mean_forces`]). So a step of any size keeps momentum, angular momentum and energy of a free
//! elastic body; a load changes them by its own work and moment, and damping takes energy only. Momentum is exact to
//! rounding. Of the residual r that Newton's iteration leaves, angular momentum misses h/2 z x r and energy
//! h/2 f . (h M^-1 r).
//!
//! With z = x - x_n for the middle x of the step, v = z/(h/2) and M (v - v_n)/(h/2) = f: a step of backward Euler of
//! half the size, under the mean forces. Its engine solves it; the tangent is not symmetric, so that a symmetric
//! approximation with a kept factor is tried first.
//!
//! On an oscillator it is the trapezoidal rule, with dissipation chi
//! ```text
//! (1 + (1 + chi) a) l^2 - 2 (1 - a) l + 1 + (1 - chi) a = 0,      a = (w h/2)^2
//! ```
//! for the factor l of a step: in small steps damping by chi w h/4 of the critical one, and most at w h = 4/chi, where
//! |l| = (2 - chi)/(2 + chi). Beyond it damping falls again, as that of a dashpot. It acts inside of elements, so no
//! rigid motion is damped.

use super::backward_euler::BackwardEuler;
use super::forward::left_to_engine;
use super::implicit::{Implicit, SolverSpec};
use super::updates::{Product, add_product, add_scaled, power};
use super::{CarriedState, Counters, Integrator, LawChange, StageWork, StepError, StepInput, StepReport};
use crate::assembly::{MeanSystem, TangentSystem};
use crate::model::point::Point;
use crate::model::system::StepMean;
use crate::solve::LinearStats;

/// The method, with what its engine carries from step to step.
pub struct EnergyMomentum {
    /// [-] chi in [0, 1]
    dissipation: f64,
    engine: Implicit<BackwardEuler>,
    /// the middle of the step, with the mean forces
    middle: Point,
}

impl EnergyMomentum {
    /// With the dissipation chi [-] in [0, 1].
    pub fn new(dissipation: f64, solver: SolverSpec) -> Self {
        EnergyMomentum { dissipation, engine: Implicit::new(BackwardEuler, solver), middle: Point::default() }
    }

    fn mean<'a>(&self, system: &'a dyn TangentSystem, half: f64) -> MeanSystem<'a> {
        MeanSystem { system, mean: StepMean { half, dissipation: self.dissipation } }
    }
}

impl Integrator<dyn TangentSystem> for EnergyMomentum {
    fn start(&mut self, system: &(dyn TangentSystem + 'static), at: &Point) -> Result<(), StepError> {
        self.middle = at.clone();
        self.engine.start_with(&self.mean(system, 0.0), at)
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn TangentSystem>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        let half = 0.5 * h;
        let mean = self.mean(system, half);
        let step =
            StepInput { system: &mean as &dyn TangentSystem, from, h: half, t_next: 0.5 * (from.state.t + t_next) };
        let report = self.engine.attempt_step(step, &mut self.middle, counters)?;
        let Point { state, forces } = &self.middle;
        to.state.t = t_next;
        // Positions by the expression of the mean forces, so that their work is exact.
        let workers = system.workers();
        workers.set(&mut to.state.x, |r, to| add_scaled(to, &state.x[r.clone()], half, &state.v[r]));
        // Velocities by the forces, so that momentum does not depend on how far Newton's iteration went.
        let kick = Product { inverse_mass: system.inverse_mass(), f: &forces.total };
        workers.set(&mut to.state.v, |r, to| add_product(to, &from.state.v[r.clone()], h, kick.of(r)));
        let mut work = StageWork::default();
        work.add(h, power(system, [from.state.t, t_next], forces));
        Ok(StepReport { work: Some(work), forces_at_end: false, ..report })
    }

    left_to_engine!();

    fn laws_changed(
        &mut self,
        system: &(dyn TangentSystem + 'static),
        at: &Point,
        change: LawChange,
    ) -> Result<(), StepError> {
        if change == LawChange::Pattern {
            return self.start(system, at);
        }
        self.engine.laws_changed(system, at, change)
    }
}
