//! The engine of Newmark, HHT, generalised alpha and backward Euler, and of the stages of diagonally implicit methods:
//! one stage map, one Newton iteration, one linear solver.
//!
//! The unknown is the displacement z of the step, over the free degrees of freedom, so that digits do not depend on
//! where the origin is. An iteration takes one force pass and one solve, with W = cm M + cc C + ck K of the iterate, or
//! with a reused matrix (`factor_cache`).
//!
//! # Values that a program changes at t_n
//! The forces jump from f- to f+ there. A step weighs f_n+ with f_{n+1}: both have the new values, so a force that is
//! constant within the step acts with its whole weight, (1 - af) + af = 1, and its impulse is exact. The carried a_n
//! becomes a_n + M^-1 (f_n+ - f_n-). It keeps its lag behind the true acceleration, which the dissipation of HHT and
//! generalised alpha rests on. On linear scenes the matrix of a step on (x - K^-1 F, v, a) stays as it is. With a =
//! M^-1 f+ instead, as after a restart, the lag is lost in every step, and the dissipation with it. The extrapolation
//! of the first guess goes on from the new a_n with the change of the step before.

use super::balance::{go_on, is_nearer_to_expected};
use super::equations::{DofData, Equations, Guess, LinearState, StepStart, Workspace, scales};
use super::factor_cache::FactorCache;
use super::form::{Carry, StepForm, of_map};
use super::stage::{NewmarkParameters, StageMap};
use super::tangents::Tangents;
pub use super::tangents::{Factor, cached_factor, refusal};
use super::updates::{acceleration, accumulate};
use super::{CarriedState, Counters, Integrator, LawChange, StepError, StepInput, StepReport, Trend};
use crate::assembly::TangentSystem;
use crate::model::point::Point;
use crate::model::workers::Workers;
use crate::solve::newton::{Newton, NewtonFailure, NewtonSpec};
use crate::solve::{Accuracy, LinearChoice, LinearError, LinearStats};
use std::ops::Range;

/// [-] Relative residual of a solve for a filtered error, of which only the size matters.
const FILTER_RELATIVE: f64 = 1e-3;

/// The trapezoidal rule, which carries the true acceleration and is of order 2 from its first step on. HHT and
/// generalised alpha need an acceleration that lags behind by a share of a step. After a restart no step has produced
/// one; the true acceleration instead would be an error of order h in a, in the first step and the next.
const TRAPEZOIDAL: NewmarkParameters = NewmarkParameters { beta: 0.25, gamma: 0.5 };

/// A scheme of the family: its stage map.
pub trait ImplicitScheme: Send {
    /// The map for a step of size `h` [s].
    fn map(&self, h: f64) -> StageMap;
}

/// How implicit steps are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct SolverSpec {
    /// Newton's iteration
    pub newton: NewtonSpec,
    /// linear solver
    pub linear: LinearChoice,
}

/// A scheme with its solver; carries the algorithmic acceleration.
pub struct Implicit<M> {
    scheme: M,
    spec: SolverSpec,
    /// [m/s^2] a_n, carried from step to step `[n_dof]`; a_n - M^-1 f_n if `relative`
    a: Vec<f64>,
    /// [m/s^2] its accelerations are a_n - a_{n-1} if `relative`
    trend: Trend,
    /// whether a program has changed values since the last accepted step
    relative: bool,
    /// whether the next step is the first after a restart
    anew: bool,
    /// [s] size of the step that produced a_n; 0 before the first
    made_with: f64,
    /// [s] size of the last attempt
    attempted: f64,
    /// [s] when the run ends
    end: f64,
    solver: Option<Solver>,
}

/// How a scheme of several stages has one of them attempted.
#[derive(Clone, Copy)]
pub(super) struct StageAttempt<'a> {
    /// [m/s^2] first guess of the acceleration at its end `[n_dof]`
    pub acceleration: &'a [f64],
    /// whether it goes on with the factor of the stage before, in the same step
    pub continues: bool,
}

/// Buffers of the steps, allocated at the start of a run.
struct Solver {
    workers: Workers,
    newton: Newton,
    linear: LinearState,
    dofs: DofData,
    workspace: Workspace,
    /// the unknowns `[n]`
    z: Vec<f64>,
    /// [m/s^2] a_n, scaled to the size of the step `[n_dof]`
    a: Vec<f64>,
    /// [m/s^2] a_n and a_{n-1} with the present forces, after a program has changed values `[n_dof]`
    kept: [Vec<f64>; 2],
    /// [m/s^2] accelerations at the step's end if they change linearly `[n_dof]`
    expected: Vec<f64>,
    /// whether the last attempt kept its first guess
    guessed_well: bool,
    /// whether it has found pairs near each other that have no place in the pattern
    outgrown: bool,
}

impl<M: ImplicitScheme> Implicit<M> {
    /// A scheme with its solver settings.
    pub fn new(scheme: M, spec: SolverSpec) -> Self {
        Implicit {
            scheme,
            spec,
            a: Vec::new(),
            trend: Trend::default(),
            relative: false,
            anew: false,
            made_with: 0.0,
            attempted: 0.0,
            end: f64::INFINITY,
            solver: None,
        }
    }

    /// Attempts a stage of a step; see [`StageAttempt`].
    ///
    /// # Errors
    /// When Newton's iteration does not converge.
    pub(super) fn attempt_stage(
        &mut self,
        step: StepInput<'_, dyn TangentSystem>,
        stage: StageAttempt<'_>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        self.attempt_with(step, Some(stage), to, counters)
    }

    /// Attempts a step of a system that need not outlive it.
    ///
    /// # Errors
    /// When Newton's iteration does not converge.
    pub(super) fn attempt_step<'s>(
        &mut self,
        step: StepInput<'s, dyn TangentSystem + 's>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        self.attempt_with(step, None, to, counters)
    }

    /// [m/s^2] The acceleration at the end of the last attempt `[n_dof]`.
    pub(super) fn acceleration_at_end(&self) -> &[f64] {
        self.solver.as_ref().map_or(&[], |s| &s.workspace.a_next)
    }

    /// [`Integrator::start`] for a system that need not outlive it.
    ///
    /// # Errors
    /// When matrices or solvers cannot be set up.
    pub(super) fn start_with(&mut self, system: &dyn TangentSystem, at: &Point) -> Result<(), StepError> {
        let tangents = Tangents::new(system, self.spec.newton.strategy, self.spec.linear)?;
        let (n, unknowns) = (system.n_dof(), tangents.dof.len());
        let zero = || vec![0.0; n];
        self.a = at.forces.total.iter().zip(system.inverse_mass()).map(|(f, m)| m * f).collect();
        self.solver = Some(Solver {
            workers: system.workers().clone(),
            newton: Newton::new(self.spec.newton, unknowns, system.workers()),
            linear: LinearState { tangents, cache: FactorCache::new(n), mass_weight: None },
            dofs: DofData::of(system),
            workspace: Workspace::new(at, system.touches().is_some()),
            z: vec![0.0; unknowns],
            a: zero(),
            kept: [zero(), zero()],
            expected: zero(),
            guessed_well: true,
            outgrown: false,
        });
        self.trend = Trend { before: zero(), straight: false };
        (self.made_with, self.attempted, self.anew, self.relative) = (0.0, 0.0, false, false);
        Ok(())
    }

    fn attempt_with<'s>(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'s, dyn TangentSystem + 's>,
        stage: Option<StageAttempt<'_>>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        let Some(s) = &mut self.solver else {
            return Err(StepError::NotStarted);
        };
        let own = self.scheme.map(h);
        let bridge = self.anew && own.lag() != 0.0;
        let map = if bridge { StageMap::newmark(TRAPEZOIDAL, h) } else { own };
        to.state.t = t_next;
        s.workers.copy(&mut to.state.x, &from.state.x);
        s.workers.copy(&mut to.state.v, &from.state.v);
        if self.relative {
            let [a, before] = &mut s.kept;
            acceleration(system, a, &from.forces.total);
            accumulate(a, 1.0, &self.a);
            before.copy_from_slice(a);
            accumulate(before, -1.0, &self.trend.before);
        }
        let (a, before) = match &s.kept {
            [a, before] if self.relative => (a, before),
            _ => (&self.a, &self.trend.before),
        };
        let lag = LaggedAcceleration { h, made_with: self.made_with, a };
        let guess = match stage {
            None => {
                lag.carry_over(map, from, system, &mut s.a);
                first_guess(&s.workers, (before.as_slice(), self.trend.straight), lag, &mut s.expected)
            }
            Some(StageAttempt { acceleration, .. }) => {
                s.expected.copy_from_slice(acceleration);
                s.a.copy_from_slice(acceleration);
                Guess::Trend
            }
        };
        let continues = stage.is_some_and(|stage| stage.continues);
        self.attempted = h;
        s.linear.mass_weight = None;
        let scales = scales(system, from, &s.a, map, &mut s.workspace.residual);
        let x = &from.state.x;
        let most = |range: Range<usize>| x[range].iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let largest = s.workers.fold(x.len(), 0.0, most, f64::max);
        let start =
            StepStart { largest, from, a: &s.a, expected: &s.expected, h, end: self.end, force_scale: scales.residual };
        let (dofs, workspace, linear) = (&s.dofs, &mut s.workspace, &mut s.linear);
        let mut equations = Equations { system, map, start, to, guess, dofs, workspace, linear, counters };
        if equations.linear.tangents.outgrown(system) {
            equations.linear.cache.outgrow();
        }
        if !continues {
            equations.rebuild_factor()?;
        }
        equations.guess(&mut s.z);
        let cache = &equations.linear.cache;
        let mut frozen = if continues { cache.attempted_history() } else { cache.history_for(equations.weights()) };
        let solved = s.newton.solve(&mut equations, &mut s.z, scales, &mut frozen);
        s.guessed_well = equations.guess == guess;
        s.linear.cache.set_history(frozen);
        let iterations = solved.as_ref().map_or_else(NewtonFailure::iterations, |report| report.iterations);
        counters.newton_iterations += u64::from(iterations);
        let report = solved?;
        let rubbing = system.touches().is_some_and(|touches| touches.is_rubbing());
        s.outgrown = rubbing || s.linear.tangents.outgrown(system);
        if bridge {
            lag_behind(own.lag(), a, (&to.forces.total, system.inverse_mass()), &mut s.workspace.a_next);
        }
        Ok(StepReport {
            newton_iterations: report.iterations,
            residual: report.residual,
            work: None,
            forces_at_end: true,
        })
    }
}

impl<M: ImplicitScheme> Integrator<dyn TangentSystem> for Implicit<M> {
    fn start(&mut self, system: &(dyn TangentSystem + 'static), at: &Point) -> Result<(), StepError> {
        self.start_with(system, at)
    }

    fn attempt(
        &mut self,
        step: StepInput<'_, dyn TangentSystem>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        self.attempt_with(step, None, to, counters)
    }

    fn accept(&mut self) {
        if let Some(s) = &mut self.solver {
            // The first step has no predecessor to compare with.
            let straight =
                self.made_with == 0.0 || is_nearer_to_expected(&s.workers, &s.expected, &s.a, &s.workspace.a_next);
            self.trend.straight = straight && s.guessed_well;
            s.workers.copy(&mut self.trend.before, if self.relative { &s.kept[0] } else { &self.a });
            std::mem::swap(&mut self.a, &mut s.workspace.a_next);
            s.linear.cache.accept();
            // As in a run that goes on from a checkpoint.
            if std::mem::take(&mut s.outgrown) {
                s.linear.cache.outgrow();
            }
            self.made_with = self.attempted;
            (self.anew, self.relative) = (false, false);
        }
    }

    /// a = M^-1 f, as before the first step.
    fn restart(&mut self, system: &dyn TangentSystem, at: &Point) {
        acceleration(system, &mut self.a, &at.forces.total);
        self.trend.straight = false;
        (self.made_with, self.anew, self.relative) = (0.0, true, false);
    }

    fn keep_over_change(&mut self, system: &dyn TangentSystem, at: &Point) -> bool {
        if !self.relative && self.solver.is_some() {
            for (before, a) in self.trend.before.iter_mut().zip(&self.a) {
                *before = a - *before;
            }
            for ((a, f), m) in self.a.iter_mut().zip(&at.forces.total).zip(system.inverse_mass()) {
                *a -= m * f;
            }
            self.relative = true;
        }
        true
    }

    /// A factor is kept as long as the iteration converges with it; only another pattern needs another matrix.
    fn laws_changed(
        &mut self,
        system: &(dyn TangentSystem + 'static),
        at: &Point,
        change: LawChange,
    ) -> Result<(), StepError> {
        if change != LawChange::Pattern {
            self.solver.iter_mut().for_each(|s| s.linear.cache.outlive_laws());
            return Ok(());
        }
        let (a, trend) = (std::mem::take(&mut self.a), std::mem::take(&mut self.trend));
        let flags = (self.made_with, self.attempted, self.anew, self.relative);
        let made = self.start_with(system, at);
        (self.a, self.trend, (self.made_with, self.attempted, self.anew, self.relative)) = (a, trend, flags);
        made
    }

    fn form(&self, h: f64, _: bool) -> Option<StepForm> {
        let own = self.scheme.map(h);
        let bridge = self.anew && own.lag() != 0.0;
        let map = if bridge { StageMap::newmark(TRAPEZOIDAL, h) } else { own };
        let kept = self.made_with == 0.0 || self.made_with == h || map.am == 0.0 && map.af == 0.0;
        let carry = Carry { ratio: if kept { 1.0 } else { h / self.made_with }, lag: bridge.then(|| own.lag()) };
        (!self.relative).then(|| of_map(map, carry))
    }

    fn set_end(&mut self, end: f64) {
        self.end = end;
    }

    fn drop_unsaved(&mut self) {
        self.solver.iter_mut().for_each(|s| s.linear.cache.drop_unsaved());
    }

    fn save(&self) -> CarriedState {
        let mut vectors = vec![self.a.clone()];
        let factor = self.solver.as_ref().and_then(|s| s.linear.cache.save(&mut vectors));
        let &Implicit { made_with, anew, relative, .. } = self;
        CarriedState {
            vectors,
            made_with,
            anew,
            relative,
            trend: self.trend.clone(),
            factor,
            ..CarriedState::default()
        }
    }

    fn restore(&mut self, carried: &CarriedState) -> Result<(), StepError> {
        (self.made_with, self.anew, self.relative) = (carried.made_with, carried.anew, carried.relative);
        if carried.trend.before.len() == self.trend.before.len() {
            self.trend.clone_from(&carried.trend);
        }
        match (&mut self.solver, &carried.factor) {
            (Some(s), Some(factor)) => {
                let [x, v] = s.linear.cache.state_vectors();
                carried.take_into(&mut [&mut self.a, x, v])?;
                s.linear.cache.restore(*factor);
                Ok(())
            }
            (solver, _) => {
                solver.iter_mut().for_each(|s| s.linear.cache.forget());
                carried.take_into(&mut [&mut self.a])
            }
        }
    }

    fn filter_error(&mut self, e: &mut [f64], _: &dyn TangentSystem, counters: &mut Counters) -> Result<(), StepError> {
        let Some(s) = &mut self.solver else { return Ok(()) };
        let Some(weight) = s.linear.mass_weight else { return Ok(()) };
        if !e.iter().all(|e| e.is_finite()) {
            return Ok(());
        }
        for (&dof, b) in s.linear.tangents.dof.iter().zip(&mut s.z) {
            *b = weight * (s.dofs.mass[dof as usize] * e[dof as usize]);
        }
        s.linear.tangents.set_accuracy(Accuracy::to(FILTER_RELATIVE));
        match s.linear.tangents.solve(&mut s.z, counters) {
            // If conjugate gradients fail, the unfiltered estimate is too large, never too small.
            Err(LinearError::Indefinite { .. } | LinearError::Stalled { .. }) => return Ok(()),
            solved => solved?,
        }
        for (&dof, b) in s.linear.tangents.dof.iter().zip(&s.z) {
            e[dof as usize] = *b;
        }
        Ok(())
    }

    fn dof_of_unknown(&self, unknown: usize) -> usize {
        let dof = self.solver.as_ref().and_then(|s| s.linear.tangents.dof.get(unknown));
        dof.map_or(0, |&dof| dof as usize)
    }

    fn linear_stats(&self) -> Option<LinearStats> {
        self.solver.as_ref().and_then(|s| s.linear.tangents.stats())
    }
}

/// The acceleration that HHT and generalised alpha would have carried out of a step made by another scheme: a = M^-1
/// f_{n+1} - lag (M^-1 f_{n+1} - a_n), where a_n is the true one at its start. All slices `[n_dof]`.
fn lag_behind(lag: f64, a_n: &[f64], (f, inverse_mass): (&[f64], &[f64]), a: &mut [f64]) {
    for (((a, a_n), f), m) in a.iter_mut().zip(a_n).zip(f).zip(inverse_mass) {
        let now = m * f;
        *a = now - lag * (now - a_n);
    }
}

/// The first guess of a step, from the accelerations [m/s^2] before the last step and whether they changed linearly
/// there; `expected` [m/s^2] becomes the accelerations for a linear change `[n_dof]`.
fn first_guess(
    workers: &Workers,
    (before, straight): (&[f64], bool),
    lag: LaggedAcceleration<'_>,
    expected: &mut [f64],
) -> Guess {
    if lag.made_with > 0.0 {
        go_on(workers, lag.h / lag.made_with, before, lag.a, expected);
    }
    if lag.made_with > 0.0 && straight { Guess::Trend } else { Guess::ConstantAcceleration }
}

/// The acceleration a scheme carries into a step of `h` [s].
#[derive(Clone, Copy)]
struct LaggedAcceleration<'a> {
    h: f64,
    made_with: f64,
    a: &'a [f64],
}

impl LaggedAcceleration<'_> {
    /// Writes the acceleration for a step of this size into `out` [m/s^2]. HHT and generalised alpha carry an
    /// acceleration that lags behind the state by a share of the step. The difference a - M^-1 f is proportional to the
    /// step that produced it, and is scaled to the next step's size. Otherwise every change of the step would make an
    /// error of order h in a.
    fn carry_over(&self, map: StageMap, from: &Point, system: &dyn TangentSystem, out: &mut [f64]) {
        let &LaggedAcceleration { h, made_with, a } = self;
        if made_with == 0.0 || made_with == h || map.am == 0.0 && map.af == 0.0 {
            return system.workers().copy(out, a);
        }
        let ratio = h / made_with;
        let (f, inverse_mass) = (&from.forces.total, system.inverse_mass());
        system.workers().set(out, |r, out| {
            for ((out, a), (f, m)) in out.iter_mut().zip(&a[r.clone()]).zip(f[r.clone()].iter().zip(&inverse_mass[r])) {
                let now = m * f;
                *out = now + ratio * (a - now);
            }
        });
    }
}
