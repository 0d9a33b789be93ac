//! Steps as large as a tolerance allows, for every scheme.
//!
//! The error is controlled per unit of time: a step of h [s] in a run of T may make h/T of the tolerance, so that
//! errors which only add up come to the tolerance at the end, whatever the steps were. The estimates are in
//! [`estimate`], the choice of the next step in [`controller`]. An attempt that is too far off, not finite or cannot be
//! solved is dropped, which restores everything; a step below the floor ends the run with a diagnosis.
//!
//! The tolerance is on the root mean square over the free degrees of freedom. What errors really come to is not known
//! in a run; local errors are shared out so that on swinging pendulums and cloths the result lies within a factor of
//! ten of the tolerance (most within three; `tests/claims/tolerance.rs`): their norms add up to about three times what
//! they do themselves, and damping forgets them ([`memory`]). Motion that multiplies errors, such as buckling, is
//! beyond any of this.
//!
//! Where a force or its slope jumps (a spring that goes slack), the error per unit of time does not fall with the step.
//! After three attempts such a step is kept once it makes a hundredth of the tolerance in itself; all of these together
//! may make half of it.
//!
//! Steps end at the corners of load and wind tables and at the end of the run (those of schemes with an estimate of
//! their own at frames, too). They end where a spring goes slack or taut as well, if what that changes within the step
//! is no small part of the tolerance (`branch`). After either the run begins anew (`restart`). A run that does not
//! go on any more ends with a diagnosis.

mod attempt;
mod branch;
pub mod controller;
pub mod estimate;
mod floor;
pub mod memory;
mod progress;
mod restart;

pub use attempt::{Bench, Dropped, Kept};
use controller::{Controller, Judged};
use estimate::{Bends, LocalError, Motion, Quadrature};
use memory::Memory;
use progress::Progress;
use serde::{Deserialize, Serialize};

use super::clock::Tolerance;
use crate::integrate::stepper::Stepper;
use crate::integrate::{Carried, PairInfo, StepError};
use crate::model::point::Point;
use crate::scene::Scene;

/// First step, as a share of the run.
const FIRST: f64 = 1e-3;
/// Largest step, as a share of the run: no scheme sees what happens within a step.
const LARGEST: f64 = 0.1;
/// Smallest step, as a share of the run, but for rounding of the time.
const SMALLEST: f64 = 1e-13;
/// The norms of all local errors, added up, over what the errors come to: they change direction, and partly cancel.
/// About what was measured on swinging pendulums and cloths (`tests/claims/tolerance.rs`).
const CANCELLED: f64 = 3.0;
/// [-] of the tolerance that a step across a jump may make.
const SHARE: f64 = 0.01;
/// [-] of the tolerance that any step may make: what is left of short steps is rounding, and a longer one is the way
/// out.
const TRIFLE: f64 = 1e-6;
/// Attempts after which a step counts as one across a jump.
const PATIENCE: u32 = 3;
/// [-] of the tolerance that all of these steps and trifles may make together.
const ALL_JUMPS: f64 = 0.5;
/// Order up to which the parabola through three accelerations estimates the error.
const ORDER_OF_PARABOLA: u32 = 2;

/// What carries over from step to step; part of a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AdaptiveState {
    controller: Controller,
    motion: Motion,
    before: Quadrature,
    memory: Memory,
    /// [-] of the tolerance, spent on jumps
    jumps: f64,
    /// [s] where a step is to end because a force changes its law there
    event: Option<f64>,
    /// whether the next step begins anew
    anew: bool,
    progress: Progress,
    /// attempts that were dropped
    pub rejected: u64,
}

impl AdaptiveState {
    /// Whether the next step begins anew: the scheme is to drop what it carries.
    pub fn begins_anew(&self) -> bool {
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
    /// whether the scheme's errors all pull one way, so that none of them cancel or are forgotten
    pub coherent: bool,
}

/// One attempt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// [s] step
    pub h: f64,
    /// [s] time at its end
    pub t: f64,
    /// whether a corner of a table, the end or a change of a force's law lies there
    at_corner: bool,
}

/// What is known of an attempt's error besides the error.
#[derive(Clone, Copy, Debug)]
struct Guess {
    bends: Bends,
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
    /// [N s], then [m/s], what changes of forces' laws do within a step, where there are such forces
    kick: Vec<f64>,
    /// the motion without the step that was kept last
    motion_before: Motion,
    /// what the scheme carried where the last halves began
    carried: Carried,
    /// end of the whole step and of its second half, made when first needed
    pair: Option<Box<[Point; 2]>>,
    state: AdaptiveState,
}

impl Adaptive {
    /// A run from t = 0.
    pub fn new(scene: &dyn Scene, spec: AdaptiveSpec) -> Self {
        let first = scene.initial_state();
        let motion = Motion::default().at(&first.x, first.as_ref());
        let state = AdaptiveState { controller: Controller::new(FIRST * spec.end), motion, ..AdaptiveState::default() };
        Self::restore(scene, spec, state)
    }

    /// A run that goes on.
    pub fn restore(scene: &dyn Scene, spec: AdaptiveSpec, state: AdaptiveState) -> Self {
        let mut corners = scene.corners();
        corners.retain(|t| *t > 0.0 && *t < spec.end);
        corners.push(spec.end);
        let start = scene.initial_state().x;
        let error = LocalError::new(start.len());
        let free = scene.inverse_mass().iter().filter(|m| **m > 0.0).count() as f64;
        let product = vec![0.0; if scene.velocity_dependent() { start.len() } else { 0 }];
        let kick = vec![0.0; if scene.has_branches() { start.len() } else { 0 }];
        let (motion_before, carried) = (state.motion, Carried::default());
        Adaptive { spec, corners, start, free, error, product, kick, motion_before, carried, pair: None, state }
    }

    /// What carries over to the next step.
    pub fn state(&self) -> &AdaptiveState {
        &self.state
    }

    /// [s] below which no step is tried from time `t` [s]
    pub fn floor(&self, t: f64) -> f64 {
        (SMALLEST * self.spec.end).max(64.0 * f64::EPSILON * t)
    }

    /// The next step to try from time `t` [s], or `None` at the end.
    pub fn next(&self, t: f64) -> Option<Trial> {
        let met = |corner: f64| corner - t <= 4.0 * f64::EPSILON * corner;
        let corner = self.corners.iter().copied().find(|corner| !met(*corner))?;
        let corner = self.state.event.filter(|event| !met(*event)).map_or(corner, |event| event.min(corner));
        let frame = self.spec.frames_every.and_then(|every| {
            let passed = (t / every).floor();
            [1.0, 2.0].map(|more| (passed + more) * every).into_iter().find(|frame| !met(*frame))
        });
        // A frame at a corner is that corner, whatever rounding says.
        let frame = frame.filter(|frame| corner - frame > 4.0 * f64::EPSILON * corner);
        let (at_corner, corner) = (frame.is_none(), frame.unwrap_or(corner));
        let (rest, asked) = (corner - t, self.state.controller.step().min(LARGEST * self.spec.end));
        if asked >= rest * (1.0 - 1e-9) {
            return Some(Trial { h: rest, t: corner, at_corner });
        }
        // Two equal steps to the corner rather than a large and a tiny one.
        let t_next = t + if 2.0 * asked > rest { 0.5 * rest } else { asked };
        Some(Trial { h: t_next - t, t: t_next, at_corner: false })
    }

    /// Where the second half step ended, after [`Kept::Halves`].
    pub fn second(&mut self) -> Option<&mut Point> {
        self.pair.as_deref_mut().map(|[_, second]| second)
    }

    /// Tries a step from one point to another.
    ///
    /// # Errors
    /// Why it is dropped; the scheme is then where it was, and the next step that is asked for is smaller.
    pub fn attempt(
        &mut self,
        mut bench: Bench<'_, '_>,
        trial: Trial,
        from: &Point,
        to: &mut Point,
    ) -> Result<Kept, Dropped> {
        let by_parabola = self.spec.order <= ORDER_OF_PARABOLA && self.state.before.is_ready();
        let tried = if let Some(pair) = bench.stepper.pair() {
            self.by_pair(&mut bench, trial, pair, from, to)
        } else if by_parabola {
            self.single(&mut bench, trial, from, to)
        } else {
            self.halves(&mut bench, trial, from, to)
        };
        if let Err(dropped) = &tried {
            self.state.rejected += 1;
            if matches!(dropped, Dropped::Unsolved(_)) {
                self.state.controller.unsolved(trial.h);
            }
        } else if trial.at_corner {
            self.begin_anew();
        }
        tried
    }

    /// The next step knows nothing of those before: forces are not smooth here.
    pub fn begin_anew(&mut self) {
        self.state.controller.end_stretch();
        self.state.before.forget();
        (self.state.event, self.state.anew) = (None, true);
    }

    /// After a step that was kept and ended at `t` [s]: how little [s] the last steps went on, if that is no progress.
    pub fn stalls(&mut self, t: f64) -> Option<f64> {
        let at_row = self.corners.binary_search_by(|corner| corner.total_cmp(&t)).is_ok();
        self.state.progress.stalls(t, at_row, self.spec.end)
    }

    /// Takes back a step of `h` [s] that was kept by its error, but cannot be right: the next one is to be a tenth of
    /// it. Whether it was the first of two halves decides whether the scheme has gone on already.
    ///
    /// # Errors
    /// When what the scheme carried does not fit, which it does.
    pub fn take_back(&mut self, h: f64, first_half: Option<&mut Stepper<'_>>) -> Result<(), StepError> {
        self.state.rejected += 1;
        self.state.before.forget();
        (self.state.event, self.state.anew) = (None, false);
        self.state.motion = self.motion_before;
        self.state.controller.refuse(h);
        first_half.map_or(Ok(()), |stepper| stepper.restore(&self.carried))
    }

    /// Whether the step with the error that has just been estimated is kept, and what the next one is to be.
    fn judge(&mut self, trial: Trial, guess: Guess, end: &Point) -> Result<(), Dropped> {
        let AdaptiveState { controller, motion, before, jumps, memory, .. } = &mut self.state;
        let Guess { bends, most_growth, pair } = guess;
        let moved = motion.bent(bends);
        let AdaptiveSpec { end: run, tolerance, order, coherent, .. } = self.spec;
        let off = moved.deviation(trial.h, &self.error, end.state.as_ref(), tolerance, self.free);
        let share = if coherent { 1.0 } else { CANCELLED * memory.forgetting(run) };
        // Across a jump the finer solution is no better than the estimate, so shares of the tolerance are those of the
        // estimate.
        let own = off.ratio * pair.map_or(1.0, |pair| pair.leading * moved.turn(trial.h));
        let per_time = own * (run / trial.h) / share;
        let judged = Judged { h: trial.h, error: per_time, order, most_growth };
        if per_time <= 1.0 {
            controller.accept(judged);
        } else if controller.dropped() >= PATIENCE && off.ratio <= SHARE && *jumps + off.ratio <= ALL_JUMPS {
            *jumps += off.ratio;
            before.forget();
            controller.accept(Judged { error: 1.0, ..judged });
        } else if off.ratio <= TRIFLE && *jumps + off.ratio <= ALL_JUMPS {
            *jumps += off.ratio;
            controller.accept(Judged { error: 0.5, ..judged });
        } else {
            controller.too_large(judged);
            return Err(Dropped::Error(off));
        }
        self.motion_before = moved;
        *motion = moved.at(&self.start, end.state.as_ref());
        Ok(())
    }
}
