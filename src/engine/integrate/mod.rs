//! Time integration: one file per scheme, all on the same residual M a = f(t, x, v).
//!
//! A scheme *attempts* a step from one [`Point`] to another; the driver accepts or drops it. To drop a step, do not
//! accept it: the next attempt overwrites `to`, and what the scheme carries from step to step (an algorithmic
//! acceleration, a derivative) changes in [`Integrator::accept`] only. Every run starts from a_0 = M^-1 f(0, x0, v0).
//!
//! # How to add a scheme
//! 1. Write `integrate/<name>.rs` and declare it below. A Runge-Kutta method is a tableau: an explicit one as in
//!    `rk4.rs`, with an estimate as in `dormand_prince.rs`, a diagonally implicit one as in `esdirk4.rs`. One of the
//!    Newmark family only fills a [`stage::StageMap`] ([`implicit::ImplicitScheme`]). Another explicit scheme
//!    implements [`Integrator`] for `dyn System` and reads like its equations: start from a copy of
//!    `improved_euler_pec.rs`, whose helpers (`updates`) advance states and integrate the work of the stages, or of
//!    `beeman.rs` where forces lag behind the state and steps of different size follow each other.
//! 2. Register it in [`registry`]: name, order, parameters with ranges, stability, source, and the properties of its
//!    step on linear scenes ([`linear_step`], which limits and diagnoses use instead of names). The case format, the
//!    JSON Schema, `canopy-fem methods` and every test that loops over methods read that entry; those of
//!    `analysis/limit` check on oscillators what it says of the step.
//! 3. `tests/claims/recurrence` needs its amplification recurrence on an oscillator: for a Runge-Kutta method that is a
//!    polynomial in `tests/common/polynomials.rs`, and its tableau meets the conditions in `order_conditions.rs`.
//!    `tests/claims/oscillator.rs` needs its leading error term, `tests/claims/energy_oscillator.rs` its energy a step,
//!    `tests/api/counters.rs` its work, and an explicit scheme a line of known limits in `analysis/limit`.
//!    `tests/claims/order.rs` and `tolerance.rs` measure its order and its errors with tolerances. Each of them fails
//!    with a message if the entry is missing; `tests/api/case/faults.rs`, the README's table and its count of methods
//!    name all methods.
//! 4. Run `cargo test --release --lib limit`, `--test claims` and `--test api`.
//!
//! A scheme that solves several times per step shares one [`implicit::Implicit`] engine where all stages have the same
//! W (`dirk.rs`), and owns one per stage otherwise: an engine carries one kept factor and one first guess from step to
//! step. `check` counts one solve per step where it makes no trial runs.
//!
//! A scheme that goes along springs needs [`SpringGraph`](crate::model::system::SpringGraph): as a graph, as `kang.rs`
//! does, or one by one, as `xpbd.rs` and `vbd.rs` do. What it does not know of a scene it refuses in
//! [`Integrator::fits`].
//!
//! A scheme whose forces depend on both ends of a step gives its engine a system that has them, as
//! `energy_momentum.rs` does.
//!
//! # A scheme of a program's own
//! A program that only uses the library takes methods from the [`registry`], or writes a [`registry::MethodInfo`] of
//! its own ([`registry::MethodChoice::of`], `examples/own_scheme.rs`):
//! * What `to` holds when an attempt begins is arbitrary, except that its vectors have their lengths.
//! * A stage between the ends of a step is a [`State`](crate::model::state::State) and
//!   [`Forces`](crate::model::forces::Forces) that [`Integrator::start`] makes, a clone of `at.state` and
//!   `system.new_forces()`. All vectors are `[n_dof]`; `inverse_mass` is 0 at held degrees of freedom, which so stay.
//! * `linear` is [`PLAIN`](linear_step::LinearStep::PLAIN) for a Runge-Kutta method,
//!   [`PARTITIONED`](linear_step::LinearStep::PARTITIONED) where positions and velocities have different formulas, and
//!   [`DISSIPATIVE`](linear_step::LinearStep::DISSIPATIVE) where every step removes energy from an oscillation.
//!   The search for the largest stable step goes by it.
//! * `evaluations` counts calls of [`Counters::evaluate`] a step. The pass of the driver
//!   ([`StepReport::forces_at_end`]) is not among them, so a scheme that uses `from.forces` evaluates the forces at the
//!   end of its step itself; `order` is what adaptive steps rely on.
//! * What goes over from step to step changes in [`Integrator::accept`] only, is reset in [`Integrator::restart`], and
//!   is in [`Integrator::save`] and [`Integrator::restore`]; a scheme without such a thing needs none of the four. With
//!   [`Integrator::keep_over_change`] it goes over a change of values by a program, too; without, it starts again.
//! * Blocks of steps and estimates of its own error ([`Integrator::pair`]) are optional.
//!
//! Nothing here depends on a force: schemes use the traits of [`crate::model::system`].

pub mod backward_euler;
mod balance;
pub mod beeman;
pub mod central_difference;
mod counters;
mod dirk;
pub mod dop853;
pub mod dormand_prince;
pub mod energy_momentum;
mod equations;
pub mod esdirk4;
pub mod euler_cromer;
pub mod euler_richardson;
pub mod explicit_euler;
mod factor_cache;
pub mod form;
mod forward;
pub mod generalized_alpha;
pub mod hht;
pub mod implicit;
pub mod improved_euler;
pub mod improved_euler_pec;
pub mod kang;
pub mod kick_drift;
pub mod linear_step;
pub mod multirate;
pub mod newmark;
#[cfg(test)]
mod order_conditions;
pub mod registry;
pub mod rk4;
mod runge_kutta;
mod springs;
pub mod stage;
pub mod stepper;
pub(crate) mod tangents;
mod updates;
pub mod vbd;
pub mod velocity_verlet;
pub mod xpbd;

pub use counters::Counters;
pub use factor_cache::CachedFactor;
pub(crate) use updates::reeling_work;

use crate::assembly::PatternError;
use crate::format_number::figures;
use crate::model::abilities::{NearFrom, Passage};
use crate::model::point::Point;
use crate::model::step_block::StepSummary;
use crate::solve::newton::NewtonFailure;
use crate::solve::{LinearError, LinearStats};

/// One step to attempt.
#[derive(Debug)]
pub struct StepInput<'a, S: ?Sized> {
    /// the system
    pub system: &'a S,
    /// start of the step; its forces are those at its state
    pub from: &'a Point,
    /// [s] step size
    pub h: f64,
    /// [s] time at the end, `from.state.t + h` up to rounding
    pub t_next: f64,
}

/// What an attempted step reports.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepReport {
    /// Newton iterations, 0 for explicit schemes
    pub newton_iterations: u32,
    /// [-] final residual over its scale, 0 for explicit schemes
    pub residual: f64,
    /// work integrated by the scheme itself; `None` = the ledger takes 1/2 (f_n + f_{n+1}) . (x_{n+1} - x_n)
    pub work: Option<StageWork>,
    /// whether `to.forces` are the forces at `to.state`; if not, the driver evaluates them, in a pass that is not
    /// counted as the scheme's
    pub forces_at_end: bool,
}

/// Work of a step, integrated from the terms' powers as one more unknown of the scheme.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct StageWork {
    /// [J] work of the external terms
    pub external: f64,
    /// [J] energy taken by the dissipative terms
    pub dissipated: f64,
}

/// What a scheme carries from step to step besides the state, to be saved in a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct CarriedState {
    /// vectors over all degrees of freedom, in an order the scheme defines
    pub vectors: Vec<Vec<f64>>,
    /// [s] the step that made them, for schemes that scale them to another; 0 where that does not matter
    pub made_with: f64,
    /// whether the next step is the first after [`Integrator::restart`]
    pub anew: bool,
    /// whether what is carried is relative to the forces of the point ([`Integrator::keep_over_change`])
    pub relative: bool,
    /// [W] power of external and dissipative forces where the scheme evaluated them last
    pub power: StageWork,
    /// what only the first guess of the next step depends on
    pub trend: Trend,
    /// the factor that an implicit scheme keeps; its state is in the last two vectors
    pub factor: Option<CachedFactor>,
    /// from where pairs that may touch were found, which an implicit scheme has a pattern for
    pub near: Option<NearFrom>,
}

/// The change of accelerations from step to step.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Trend {
    /// [m/s^2] accelerations before the last step; empty before the first
    pub before: Vec<f64>,
    /// whether the accelerations of the last step were closer to a linear extrapolation than to a constant
    pub straight: bool,
}

/// What a program has changed of how forces depend on the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LawChange {
    /// factors of loads, or the wind
    Loads,
    /// rest lengths of springs
    RestLengths,
    /// on which nodes forces depend: the matrix has another pattern
    Pattern,
}

/// How the estimate of an embedded pair compares with the error that the scheme itself makes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairInfo {
    /// [-] approximate error of a step over its estimate and over w h, for oscillations of w [rad/s] in small steps of
    /// h [s]. The run continues with the more accurate solution, whose error is one order smaller than the estimate
    pub leading: f64,
}

/// Buffers for an error estimate.
#[derive(Debug)]
pub struct ErrorEstimate<'a> {
    /// [m] of the positions
    pub x: &'a mut [f64],
    /// [m/s] of the velocities
    pub v: &'a mut [f64],
}

/// Why a scheme cannot start or a step cannot be made.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum StepError {
    /// Newton's iteration did not converge; such a step is never accepted.
    #[error("{0}")]
    Newton(#[from] NewtonFailure),
    /// The linear solver cannot be set up.
    #[error(transparent)]
    Linear(#[from] LinearError),
    /// The matrix cannot be set up.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// An explicit step has led through what contact should have kept apart.
    #[error("{} touch: they have passed the gap of {} m within the step", .0.pair, figures(.0.gap, 3))]
    Passed(Passage),
    /// [`Integrator::start`] was not called.
    #[error("a step was requested before the scheme was started")]
    NotStarted,
    /// The saved state belongs to another scheme or scene.
    #[error("the saved state of the scheme holds {found} vectors where {expected} of length {length} are needed")]
    Carried {
        /// vectors found
        found: usize,
        /// vectors needed
        expected: usize,
        /// their length
        length: usize,
    },
}

/// A time integration scheme for systems with the interface `S`.
pub trait Integrator<S: ?Sized>: Send {
    /// Whether it can make steps of a system.
    ///
    /// # Errors
    /// What of the system it does not know.
    fn fits(&self, _system: &S) -> Result<(), stepper::Unfit> {
        Ok(())
    }

    /// Sizes all buffers and makes the carried state from the first point (a_0 = M^-1 f_0).
    ///
    /// # Errors
    /// When matrices or solvers cannot be set up.
    fn start(&mut self, system: &S, at: &Point) -> Result<(), StepError>;

    /// Computes a step into `to`. Allocates nothing (LU factorisations excepted).
    ///
    /// # Errors
    /// When an implicit step does not converge.
    fn attempt(
        &mut self,
        step: StepInput<'_, S>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError>;

    /// Makes several steps of one size into `to`, one for each entry of `summaries`, which has its time; `step.t_next`
    /// is that of the last. Their bits are those of steps attempted and accepted one by one. Returns `false`, and `to`
    /// is undefined, if the scheme or the system cannot make blocks. Allocates nothing after the first.
    fn advance_block(
        &mut self,
        step: StepInput<'_, S>,
        to: &mut Point,
        summaries: &mut [StepSummary],
        counters: &mut Counters,
    ) -> bool {
        let _ = (step, to, summaries, counters);
        false
    }

    /// Accepts the last attempt, or the last block of steps: updates the carried state.
    fn accept(&mut self) {}

    /// Drops the carried state and starts again at a point, as [`Integrator::start`] does, because forces are not
    /// smooth across its time. Allocates nothing.
    fn restart(&mut self, _system: &S, _at: &Point) {}

    /// Says whether a corner of a table lies in the next step, in the one after it or in the two before it, if all have
    /// its size. Called before every step that is not adaptive, for schemes that use how forces have changed before.
    fn set_near_corner(&mut self, _near: bool) {}

    /// Makes what is carried independent of the values of forces, some of which a program has just changed: `at` still
    /// has the forces of the values before. They jump there by df, and with them the true acceleration by M^-1 df,
    /// while position and velocity do not. So a scheme that carries an acceleration a keeps its difference to the
    /// forces, a - M^-1 f, and adds it to the new ones. Called again before the next accepted step, it changes nothing,
    /// so that a value may be set any number of times. Returns `false` where a scheme cannot do that: it is then
    /// started again with the new forces.
    fn keep_over_change(&mut self, _system: &S, _at: &Point) -> bool {
        false
    }

    /// [m/s] The velocities `[n_dof]` at which the forces of the accepted point are to be found again after
    /// [`Integrator::keep_over_change`]; `None` where they are those of its state.
    fn force_velocities(&self) -> Option<&[f64]> {
        None
    }

    /// After [`Integrator::keep_over_change`] and with the new forces at `at`: finds again what was found from the
    /// system at the start and is different now, as factors of its matrix.
    ///
    /// # Errors
    /// As [`Integrator::start`].
    fn laws_changed(&mut self, _system: &S, _at: &Point, _change: LawChange) -> Result<(), StepError> {
        Ok(())
    }

    /// [s] Says when the run ends: what serves many steps is worth more where many are to come.
    fn set_end(&mut self, _end: f64) {}

    /// Drops what [`Integrator::save`] leaves out, so that this run goes on as one does that is restored from it.
    fn drop_unsaved(&mut self) {}

    /// Whether the forces of an accepted point belong to velocities other than its state's. A checkpoint then holds
    /// them, as they cannot be evaluated again.
    fn lags(&self, _system: &S) -> bool {
        false
    }

    /// Whether its steps are short enough for the contact of a scene that it is stable on without.
    fn knows_contact(&self) -> bool {
        true
    }

    /// The carried state, for a checkpoint.
    fn save(&self) -> CarriedState {
        CarriedState::default()
    }

    /// The same into one that was saved before. Allocates nothing where a scheme carries vectors of its own.
    fn save_into(&self, to: &mut CarriedState) {
        *to = self.save();
    }

    /// Restores the carried state; called after [`Integrator::start`].
    ///
    /// # Errors
    /// When the saved state does not fit.
    fn restore(&mut self, carried: &CarriedState) -> Result<(), StepError> {
        carried.take_into(&mut [])
    }

    /// Damps an estimate `e` [m/s] `[n_dof]` of the local error of the step attempted last as the scheme damps the
    /// motion itself: e <- W^-1 cm M e with that step's W = cm M + cc C + ck K. Without it, motion that an implicit
    /// step rightly does not resolve would count (w h)^2 times too much (Shampine & Baca 1984; Hairer & Wanner 1996,
    /// Eq. IV.8.19). Explicit schemes leave e.
    ///
    /// # Errors
    /// When the factorised W cannot be solved with.
    fn filter_error(&mut self, _e: &mut [f64], _system: &S, _counters: &mut Counters) -> Result<(), StepError> {
        Ok(())
    }

    /// Relation of the embedded estimate to the error of the scheme; `None` for schemes without one.
    fn pair(&self) -> Option<PairInfo> {
        None
    }

    /// Writes the estimate that the embedded pair makes of the step attempted last, which ended at `to`. It falls as
    /// h^p in steps of h by a scheme of order p, as the error at the end of a run does; the error of the step itself
    /// falls as h^(p+1) ([`PairInfo`]). Schemes without a pair leave `out`.
    fn embedded_error(&mut self, _step: StepInput<'_, S>, _to: &Point, _out: ErrorEstimate<'_>) {}

    /// The next step of `h` [s] as a [general linear method](form), from what the scheme carries now; `None` for
    /// schemes whose derivatives are not known so. `velocity_dependent` says whether a force depends on velocity.
    fn form(&self, _h: f64, _velocity_dependent: bool) -> Option<form::StepForm> {
        None
    }

    /// [m/s^2] Accelerations M^-1 f of a stage of the step attempted last `[n_dof]`, where the scheme has found them
    /// and the step does not end there.
    fn stage_acceleration(&self, _stage: usize) -> Option<&[f64]> {
        None
    }

    /// Degree of freedom of an unknown; the same number for schemes without unknowns.
    fn dof_of_unknown(&self, unknown: usize) -> usize {
        unknown
    }

    /// The linear solver's account, for implicit schemes.
    fn linear_stats(&self) -> Option<LinearStats> {
        None
    }
}

impl CarriedState {
    /// Copies the saved vectors into `targets`.
    ///
    /// # Errors
    /// When their number or a length differs.
    pub fn take_into(&self, targets: &mut [&mut Vec<f64>]) -> Result<(), StepError> {
        let length = targets.first().map_or(0, |t| t.len());
        let fits = self.vectors.len() == targets.len() && self.vectors.iter().all(|v| v.len() == length);
        if !fits {
            return Err(StepError::Carried { found: self.vectors.len(), expected: targets.len(), length });
        }
        for (target, saved) in targets.iter_mut().zip(&self.vectors) {
            target.copy_from_slice(saved);
        }
        Ok(())
    }
}
