//! Diagonally implicit Runge-Kutta methods with an explicit first stage and one gamma for all others, whose last stage
//! is the result (stiffly accurate; Hairer & Wanner 1996, section IV.6).
//!
//! With y = (x, v) and the slopes k_i = (v_i, a_i), a_i = M^-1 f(t_i, x_i, v_i):
//! ```text
//! y_i     = y_n + h sum_{j<i} a_ij k_j + gamma h k_i,     t_i = t_n + c_i h
//! y_{n+1} = y_s,     e = h sum_i (b_i - b^_i) k_i
//! ```
//! A stage is a step of backward Euler of the length gamma h from y_n + h sum a_ij k_j. All stages have the same
//! W = M + gamma h C + (gamma h)^2 K, so that one kept factor serves all of them. The first stage is y_n itself,
//! whose slope is known.

use super::backward_euler::BackwardEuler;
use super::form::{StepForm, of_tableau};
use super::forward::left_to_engine;
use super::implicit::{Implicit, StageAttempt};
use super::runge_kutta::{Slope, Stage, advance, weighted};
use super::updates::{acceleration, power};
use super::{
    CarriedState, Counters, ErrorEstimate, Integrator, LawChange, PairInfo, StageWork, StepError, StepInput, StepReport,
};
use crate::assembly::TangentSystem;
use crate::integrate::implicit::SolverSpec;
use crate::model::point::Point;
use crate::solve::LinearStats;

/// A tableau with its estimate. The last row are the weights of the result.
#[derive(Clone, Copy, Debug)]
pub(super) struct DirkTableau {
    /// [-] gamma
    pub gamma: f64,
    /// stages after the first, which is y_n
    pub stages: &'static [Stage],
    /// [-] weights of the estimate
    pub estimate: &'static [f64],
    /// how the estimate compares with the error
    pub info: PairInfo,
}

/// The method of a tableau. From step to step it carries the factor of its engine.
pub(super) struct Dirk {
    tableau: &'static DirkTableau,
    engine: Implicit<BackwardEuler>,
    slopes: Vec<Slope>,
    /// where a stage starts, with the forces of the stage before
    start: Point,
    /// [m/s^2] first guess of a_i
    guess: Vec<f64>,
}

impl Dirk {
    pub(super) fn new(tableau: &'static DirkTableau, solver: SolverSpec) -> Self {
        let (slopes, guess, start) = (Vec::new(), Vec::new(), Point::default());
        Dirk { tableau, engine: Implicit::new(BackwardEuler, solver), slopes, start, guess }
    }

    /// [-] Weights of the result, with gamma last.
    fn weight(&self, slope: usize) -> f64 {
        let last = self.tableau.stages.last();
        last.map_or(0.0, |stage| stage.a.get(slope).copied().unwrap_or(self.tableau.gamma))
    }
}

impl Integrator<dyn TangentSystem> for Dirk {
    fn start(&mut self, system: &(dyn TangentSystem + 'static), at: &Point) -> Result<(), StepError> {
        let zero = vec![0.0; at.state.x.len()];
        let count = self.tableau.stages.len() + 1;
        self.slopes = vec![Slope { x: zero.clone(), v: zero.clone() }; count];
        (self.start, self.guess) = (at.clone(), zero);
        self.engine.start(system, at)
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn TangentSystem>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        let (n, DirkTableau { gamma, stages, .. }) = (&from.state, *self.tableau);
        let (mut work, times) = (StageWork::default(), [n.t, t_next]);
        let mut report = StepReport { forces_at_end: true, ..Default::default() };
        self.start.forces.copy_from(&from.forces);
        acceleration(system, &mut self.guess, &from.forces.total);
        work.add(h * self.weight(0), power(system, times, &from.forces));
        if let Some(first) = self.slopes.first_mut() {
            first.x.copy_from_slice(&n.v);
            first.v.copy_from_slice(&self.guess);
        }
        for (i, stage) in (1..).zip(stages) {
            let (before, _) = self.slopes.split_at(i);
            advance(&mut self.start.state.x, &n.x, h, stage.a, before, |k| &k.x);
            advance(&mut self.start.state.v, &n.v, h, stage.a, before, |k| &k.v);
            self.start.state.t = n.t + (stage.c - gamma) * h;
            let t = if stage.c == 1.0 { t_next } else { n.t + stage.c * h };
            let step = StepInput { system, from: &self.start, h: gamma * h, t_next: t };
            let how = StageAttempt { acceleration: &self.guess, continues: i > 1 };
            let made = self.engine.attempt_stage(step, how, to, counters)?;
            report.newton_iterations += made.newton_iterations;
            report.residual = report.residual.max(made.residual);
            let slope = &mut self.slopes[i];
            slope.x.copy_from_slice(&to.state.v);
            slope.v.copy_from_slice(self.engine.acceleration_at_end());
            self.guess.copy_from_slice(&slope.v);
            work.add(h * self.weight(i), power(system, times, &to.forces));
            self.start.forces.copy_from(&to.forces);
        }
        Ok(StepReport { work: Some(work), ..report })
    }

    left_to_engine!();

    fn form(&self, h: f64, _: bool) -> Option<StepForm> {
        let row = |stage: &Stage| (stage.c, stage.a.iter().copied().chain([self.tableau.gamma]).collect());
        let stages: Vec<_> = std::iter::once((0.0, Vec::new())).chain(self.tableau.stages.iter().map(row)).collect();
        let b = stages.last().map_or_else(Vec::new, |(_, row)| row.clone());
        Some(of_tableau(h, &stages, &b))
    }

    fn stage_acceleration(&self, stage: usize) -> Option<&[f64]> {
        self.slopes.get(stage).map(|slope| slope.v.as_slice())
    }

    fn laws_changed(
        &mut self,
        system: &(dyn TangentSystem + 'static),
        at: &Point,
        change: LawChange,
    ) -> Result<(), StepError> {
        self.engine.laws_changed(system, at, change)
    }

    fn pair(&self) -> Option<PairInfo> {
        Some(self.tableau.info)
    }

    fn embedded_error(&mut self, step: StepInput<'_, dyn TangentSystem>, _: &Point, out: ErrorEstimate<'_>) {
        let (e, slopes) = (self.tableau.estimate, &self.slopes);
        weighted(out.x, step.h, e, slopes, |k| &k.x);
        weighted(out.v, step.h, e, slopes, |k| &k.v);
    }
}

#[cfg(test)]
mod tests {
    use super::super::esdirk4;
    use super::super::order_conditions::{dot, has_order, tall};
    use super::*;

    /// a_ij with gamma on the diagonal; the first stage is y_n.
    fn rows(tableau: &DirkTableau) -> Vec<Vec<f64>> {
        let stage = |stage: &Stage| stage.a.iter().copied().chain([tableau.gamma]).collect();
        std::iter::once(Vec::new()).chain(tableau.stages.iter().map(stage)).collect()
    }

    #[test]
    fn esdirk4_meets_the_order_conditions() {
        let tableau = &esdirk4::TABLEAU;
        let owned = rows(tableau);
        let rows: Vec<&[f64]> = owned.iter().map(Vec::as_slice).collect();
        let b = rows[rows.len() - 1];
        has_order(&rows, b, 4);
        assert_eq!(tableau.estimate.len(), b.len());
        let coarser: Vec<f64> = b.iter().zip(tableau.estimate).map(|(b, e)| b - e).collect();
        has_order(&rows, &coarser, 3);
        let leading = (tall(&rows, b, 5) - 1.0 / 120.0) / tall(&rows, tableau.estimate, 4);
        assert!((tableau.info.leading / leading.abs() - 1.0).abs() < 2e-3, "{leading}");
    }

    /// Stages are of order 2: sum a_ij = c_i and sum a_ij c_j = c_i^2/2.
    #[test]
    fn stages_of_esdirk4_are_of_order_two() {
        let tableau = &esdirk4::TABLEAU;
        let times: Vec<f64> = std::iter::once(0.0).chain(tableau.stages.iter().map(|stage| stage.c)).collect();
        for (row, c) in rows(tableau).iter().zip(&times).skip(1) {
            assert!((row.iter().sum::<f64>() - c).abs() < 1e-14, "at {c}: {row:?}");
            assert!((dot(row, &times) - 0.5 * c * c).abs() < 1e-14, "at {c}: {row:?}");
        }
    }

    /// With z = -1/s, y_i (s + gamma) = s y_n - sum_{j<i} a_ij y_j: R is the last stage, and 0 at s = 0.
    #[test]
    fn esdirk4_forgets_what_is_infinitely_fast() {
        let tableau = &esdirk4::TABLEAU;
        let of = |s: f64| {
            let mut stages = vec![1.0];
            for Stage { a, .. } in tableau.stages {
                stages.push((s - dot(a, &stages)) / (s + tableau.gamma));
            }
            stages[stages.len() - 1]
        };
        assert!(of(0.0).abs() < 1e-13, "{}", of(0.0));
        assert!((of(10.0) - (-0.1_f64).exp()).abs() < 1e-8, "{}", of(10.0));
    }
}
