//! Steps as large as a tolerance allows, for every scheme.
//!
//! The error is controlled per unit of time: a step of h [s] in a run of T may make h/T of the tolerance. Errors that
//! add up then reach the tolerance at the end, for any sizes of steps. The estimates are in [`estimate`], the choice of
//! the next step in [`controller`]. An attempt is dropped if its error is too large, if it is not finite, or if it
//! cannot be solved; the state before it is restored. A step below the floor ends the run with a diagnosis.
//!
//! The tolerance is on the root mean square over the free degrees of freedom. The true error of a run is not known
//! while it runs. The allowed local errors are chosen so that on swinging pendulums and cloths the result is within a
//! factor of ten of the tolerance (mostly within three; `tests/claims/tolerance.rs`). The sum of their norms is about
//! three times the norm of their sum, and damping reduces them ([`memory`]). Motion that amplifies errors, such as
//! buckling, is not covered.
//!
//! Where a force or its slope jumps (a spring that goes slack), the error per unit of time does not fall with the step.
//! After three attempts such a step is accepted if its own error is at most a hundredth of the tolerance. All such
//! steps together may use half of the tolerance.
//!
//! Steps end at the corners of load and wind tables and at the end of the run (and at frames, for schemes with an
//! embedded pair). They also end where a spring goes slack or taut, if its effect within the step is not small compared
//! with the tolerance (`branch`). After such a time the step size is chosen anew (`restart`). A run that makes no
//! progress ends with a diagnosis.

mod attempt;
mod branch;
pub mod controller;
pub mod estimate;
mod floor;
pub mod memory;
mod progress;
mod restart;

pub use attempt::{AdaptiveStep, AttemptContext, DropReason};
use controller::{Controller, RatedAttempt};
use estimate::{AccelerationDerivatives, LocalError, MotionScale, Quadrature};
use memory::Memory;
use progress::Progress;
use serde::{Deserialize, Serialize};

use super::clock::Tolerance;
use crate::integrate::stepper::Stepper;
use crate::integrate::{CarriedState, PairInfo, StepError};
use crate::model::point::Point;
use crate::model::spec::ascending;
use crate::scene::Scene;

/// First step, as a share of the run.
const FIRST: f64 = 1e-3;
/// Largest step, as a share of the run: schemes do not see changes within a step.
const LARGEST: f64 = 0.1;
/// Smallest step, as a share of the run, unless rounding of the time needs a larger one.
const SMALLEST: f64 = 1e-13;
/// Sum of the norms of all local errors over the norm of their sum: they change direction, and partly cancel. Measured
/// on swinging pendulums and cloths (`tests/claims/tolerance.rs`).
const CANCELLED: f64 = 3.0;
/// [-] Share of the tolerance that a step across a jump may use.
const SHARE: f64 = 0.01;
/// [-] Share of the tolerance that any step may use: the error of very short steps is rounding, and only a longer step
/// helps.
const TRIFLE: f64 = 1e-6;
/// Attempts after which a step counts as one across a jump.
const PATIENCE: u32 = 3;
/// [-] Share of the tolerance that all such steps may use together.
const ALL_JUMPS: f64 = 0.5;
/// Order up to which the parabola through three accelerations estimates the error.
const ORDER_OF_PARABOLA: u32 = 2;

/// What is kept from step to step; part of a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AdaptiveState {
    controller: Controller,
    motion: MotionScale,
    before: Quadrature,
    memory: Memory,
    /// [-] of the tolerance, spent on jumps
    jumps: f64,
    /// [s] where a step is to end because a force changes its law there
    event: Option<f64>,
    /// whether the next step is the first after a time at which forces are not smooth
    anew: bool,
    progress: Progress,
    /// attempts that were dropped
    pub rejected: u64,
}

impl AdaptiveState {
    /// Whether the next step is a restart: the scheme must then drop what it carries.
    pub fn restarts(&self) -> bool {
        self.anew
    }
}

/// What a run is made of.
#[derive(Clone, Copy, Debug)]
pub struct AdaptiveSpec {
    /// [s] end of the run
    pub end: f64,
    /// [s] steps end at multiples of this, too, where frames are taken
    pub frames_every: Option<f64>,
    /// error it may make
    pub tolerance: Tolerance,
    /// [-] order of the scheme with its parameters
    pub order: u32,
    /// whether all errors of the scheme have the same sign, so that they neither cancel nor decay
    pub coherent: bool,
}

/// A step to attempt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedStep {
    /// [s] step
    pub h: f64,
    /// [s] time at its end
    pub t: f64,
    /// whether a corner of a table, the end, an event or a change of a force's law lies there
    pub(super) at_corner: bool,
}

/// Information on an error estimate.
#[derive(Clone, Copy, Debug)]
struct EstimateInfo {
    derivatives: AccelerationDerivatives,
    /// [-] the most the next step may grow
    most_growth: f64,
    /// of an estimate that the scheme's own pair made
    pair: Option<PairInfo>,
}

/// The stepping of one run.
pub struct Adaptive {
    spec: AdaptiveSpec,
    /// [s] corners within the run, ascending, and its end
    corners: Vec<f64>,
    /// positions at t = 0
    start: Vec<f64>,
    /// number of free degrees of freedom
    free: f64,
    error: LocalError,
    /// C e, where there is damping
    product: Vec<f64>,
    /// [N s], then [m/s], the impulses of changes of force laws within a step, where there are such forces
    kick: Vec<f64>,
    /// the motion before the last accepted step
    motion_before: MotionScale,
    /// what the scheme carried at the start of the last two half steps
    carried: CarriedState,
    /// end of the whole step and of its second half, made when first needed
    pair: Option<Box<[Point; 2]>>,
    state: AdaptiveState,
}

/// The number of free degrees of freedom; 1 where all are held for a time, so that a tolerance is never 0.
fn free_count(scene: &dyn Scene) -> f64 {
    scene.inverse_mass().iter().filter(|m| **m > 0.0).count().max(1) as f64
}

/// [s] The corners of a scene within a run, those of `more` too, and the end of the run.
pub(super) fn corners(scene: &dyn Scene, end: f64, more: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut corners = scene.events().map_or_else(Vec::new, |events| events.corners());
    let known = corners.len();
    corners.extend(more);
    if corners.len() > known {
        corners = ascending(corners);
    }
    corners.retain(|t| *t > 0.0 && *t < end);
    corners.push(end);
    corners
}

impl Adaptive {
    /// A run from t = 0.
    pub fn new(scene: &dyn Scene, spec: AdaptiveSpec) -> Self {
        let first = scene.initial_state();
        let motion = MotionScale::default().with_state(&first.x, first.as_ref());
        let state = AdaptiveState { controller: Controller::new(FIRST * spec.end), motion, ..AdaptiveState::default() };
        Self::restore(scene, spec, state)
    }

    /// A run that continues from a saved state.
    pub fn restore(scene: &dyn Scene, spec: AdaptiveSpec, state: AdaptiveState) -> Self {
        let corners = corners(scene, spec.end, std::iter::empty());
        let start = scene.initial_state().x;
        let error = LocalError::new(start.len());
        let free = free_count(scene);
        let product = vec![0.0; if scene.velocity_dependent() { start.len() } else { 0 }];
        let kick =
            vec![0.0; if scene.springs().is_some_and(|springs| springs.has_branches()) { start.len() } else { 0 }];
        let (motion_before, carried) = (state.motion, CarriedState::default());
        Adaptive { spec, corners, start, free, error, product, kick, motion_before, carried, pair: None, state }
    }

    /// Ends steps at `times` [s] too, and at what began with an event of the scene.
    pub fn end_at(&mut self, scene: &dyn Scene, times: impl Iterator<Item = f64>) {
        self.corners = corners(scene, self.spec.end, times);
    }

    /// Takes an attempt back that was good, to make a shorter one from the same state: `saved` is what was kept before
    /// it. If it was made in two halves, the scheme has already accepted the first.
    ///
    /// # Errors
    /// When the scheme cannot restore what it carried, which does not happen.
    pub fn rewind(&mut self, saved: &AdaptiveState, first_half: Option<&mut Stepper<'_>>) -> Result<(), StepError> {
        self.state = saved.clone();
        first_half.map_or(Ok(()), |stepper| stepper.restore(&self.carried))
    }

    /// After supports were released: counts the free degrees of freedom again.
    pub fn recount(&mut self, scene: &dyn Scene) {
        self.free = free_count(scene);
    }

    /// What is kept for the next step.
    pub fn state(&self) -> &AdaptiveState {
        &self.state
    }

    /// [s] Smallest step to try from time `t` [s].
    pub fn floor(&self, t: f64) -> f64 {
        (SMALLEST * self.spec.end).max(64.0 * f64::EPSILON * t)
    }

    /// The next step to try from time `t` [s], or `None` at the end.
    pub fn next(&self, t: f64) -> Option<PlannedStep> {
        let met = |corner: f64| corner - t <= 4.0 * f64::EPSILON * corner;
        let corner = self.corners.iter().copied().find(|corner| !met(*corner))?;
        let corner = self.state.event.filter(|event| !met(*event)).map_or(corner, |event| event.min(corner));
        let frame = self.spec.frames_every.and_then(|every| {
            let passed = (t / every).floor();
            [1.0, 2.0].map(|more| (passed + more) * every).into_iter().find(|frame| !met(*frame))
        });
        // A frame at a corner counts as that corner, in spite of rounding.
        let frame = frame.filter(|frame| corner - frame > 4.0 * f64::EPSILON * corner);
        let (at_corner, corner) = (frame.is_none(), frame.unwrap_or(corner));
        let (rest, asked) = (corner - t, self.state.controller.step().min(LARGEST * self.spec.end));
        if asked >= rest * (1.0 - 1e-9) {
            return Some(PlannedStep { h: rest, t: corner, at_corner });
        }
        // Two equal steps to the corner instead of a large and a tiny one.
        let t_next = t + if 2.0 * asked > rest { 0.5 * rest } else { asked };
        Some(PlannedStep { h: t_next - t, t: t_next, at_corner: false })
    }

    /// Where the second half step ended, after [`AdaptiveStep::Halves`].
    pub fn second(&mut self) -> Option<&mut Point> {
        self.pair.as_deref_mut().map(|[_, second]| second)
    }

    /// Tries a step from one point to another.
    ///
    /// # Errors
    /// The reason for which it is dropped. The scheme is then in its earlier state, and the next step to try is
    /// smaller.
    pub fn attempt(
        &mut self,
        mut context: AttemptContext<'_, '_>,
        planned: PlannedStep,
        from: &Point,
        to: &mut Point,
    ) -> Result<AdaptiveStep, DropReason> {
        let known = self.spec.order <= ORDER_OF_PARABOLA && !context.stepper.lags();
        let by_parabola = known && self.state.before.is_ready();
        let tried = if let Some(pair) = context.stepper.pair() {
            self.by_pair(&mut context, planned, pair, from, to)
        } else if by_parabola {
            self.single(&mut context, planned, from, to)
        } else {
            self.halves(&mut context, planned, from, to)
        };
        if let Err(dropped) = &tried {
            self.state.rejected += 1;
            if matches!(dropped, DropReason::Unsolved(_)) {
                self.state.controller.unsolved(planned.h);
            }
        } else if planned.at_corner {
            self.forget_history();
        }
        tried
    }

    /// Clears what the next step would use of the steps before, because forces are not smooth here.
    pub fn forget_history(&mut self) {
        self.state.controller.end_smooth_interval();
        self.state.before.forget();
        (self.state.event, self.state.anew) = (None, true);
    }

    /// A program has changed values, and the forces of `at` are still those before: keeps the history of the estimate,
    /// as the scheme keeps what it carries. A step that is too long for the new forces is found by its error.
    pub fn keep_over_change(&mut self, at: &Point, inverse_mass: &[f64]) {
        self.state.before.keep_over_change(at, inverse_mass);
    }

    /// After an accepted step that ended at `t` [s]: the time [s] of the last steps, if it is too short to count as
    /// progress.
    pub fn stalls(&mut self, t: f64) -> Option<f64> {
        let at_row = self.corners.binary_search_by(|corner| corner.total_cmp(&t)).is_ok();
        self.state.progress.stalls(t, at_row, self.spec.end)
    }

    /// Takes back a step of `h` [s] whose error was small enough, but whose state is not credible. The next step is a
    /// tenth of it. If it was the first of two halves, the scheme has already accepted it.
    ///
    /// # Errors
    /// When the scheme cannot restore what it carried, which does not happen.
    pub fn take_back(&mut self, h: f64, first_half: Option<&mut Stepper<'_>>) -> Result<(), StepError> {
        self.state.rejected += 1;
        self.state.before.forget();
        (self.state.event, self.state.anew) = (None, false);
        self.state.motion = self.motion_before;
        self.state.controller.refuse(h);
        first_half.map_or(Ok(()), |stepper| stepper.restore(&self.carried))
    }

    /// Decides from the error estimate whether the step is accepted, and sets the size of the next.
    fn judge(&mut self, planned: PlannedStep, info: EstimateInfo, end: &Point) -> Result<(), DropReason> {
        let AdaptiveState { controller, motion, before, jumps, memory, .. } = &mut self.state;
        let EstimateInfo { derivatives, most_growth, pair } = info;
        let moved = motion.with_derivatives(derivatives);
        let AdaptiveSpec { end: run, tolerance, order, coherent, .. } = self.spec;
        let off = moved.deviation(planned.h, &self.error, end.state.as_ref(), tolerance, self.free);
        let share = if coherent { 1.0 } else { CANCELLED * memory.forgetting(run) };
        // Across a jump the extrapolated solution is no better than the estimate, so the shares of the tolerance are
        // those of the estimate.
        let own = off.ratio * pair.map_or(1.0, |pair| pair.leading * moved.phase_increment(planned.h));
        let per_time = own * (run / planned.h) / share;
        let rated = RatedAttempt { h: planned.h, error: per_time, order, most_growth };
        if per_time <= 1.0 {
            controller.accept(rated);
        } else if controller.dropped() >= PATIENCE && off.ratio <= SHARE && *jumps + off.ratio <= ALL_JUMPS {
            *jumps += off.ratio;
            before.forget();
            controller.accept(RatedAttempt { error: 1.0, ..rated });
        } else if off.ratio <= TRIFLE && *jumps + off.ratio <= ALL_JUMPS {
            *jumps += off.ratio;
            controller.accept(RatedAttempt { error: 0.5, ..rated });
        } else {
            controller.too_large(rated);
            return Err(DropReason::Error(off));
        }
        self.motion_before = moved;
        *motion = moved.with_state(&self.start, end.state.as_ref());
        Ok(())
    }
}
