//! The loop over the steps: each is attempted (`attempt`), then accepted, added to the account and shown (`accept`), or
//! several are made in a block (`step_block`). Between steps a program or an event may change the scene (`change`).

mod accept;
mod attempt;
mod change;
mod locate;
mod pass_events;
mod scene_limits;
mod step_block;

use super::adaptive::corners;
use super::clock::Tick;
use super::error::RunError;
use super::event::{EventWatch, Fired};
use super::failure::Failure;
use super::ledger::Ledger;
use super::observer::{Energies, Observer, Occasion, Resumable};
use super::outcome::{Outcome, Status};
use super::run_spec::RunSpec;
use super::snapshot::Snapshot;
use super::step_policy::StepPolicy;
use super::watch::Watch;
use crate::integrate::Counters;
use crate::integrate::stepper::Stepper;
use crate::model::point::Point;
use crate::model::state::{State, StateRef};
use crate::model::stop::Stop;
use crate::scene::{Scene, event_times, sample_tables};
use crate::startup::{Phase, timed};
pub use accept::StepEnd;
pub use change::Changed;
use scene_limits::SceneLimits;
use std::sync::atomic::AtomicBool;

/// How many times its size a scene may spread before it counts as diverged.
const BLOW_UP: f64 = 1e4;

/// Runs a scene to its end, to a failure, or until `stop` is set.
///
/// # Errors
/// When the specification is out of range ([`RunSpec::check`]), the scheme cannot start or an observer cannot write. A
/// diverged or unsolvable run is not an error but an [`Outcome`].
pub fn run(
    scene: &dyn Scene,
    stepper: &mut Stepper<'_>,
    spec: &RunSpec,
    observers: &mut [&mut dyn Observer],
    stop: &AtomicBool,
) -> Result<Outcome, RunError> {
    run_from(scene, stepper, spec, scene.initial_state(), observers, stop)
}

/// Runs a scene from a state at t = 0 that is not its own.
///
/// # Errors
/// As [`run`].
pub fn run_from(
    scene: &dyn Scene,
    stepper: &mut Stepper<'_>,
    spec: &RunSpec,
    state: State,
    observers: &mut [&mut dyn Observer],
    stop: &AtomicBool,
) -> Result<Outcome, RunError> {
    let mut state = RunState::start(scene, stepper, spec, state)?;
    Run { scene, spec, stop: Stop::on(stop), interrupt: Stop::NEVER, state: &mut state }.begin(stepper, observers)
}

/// Continues from a snapshot of a run with the same scene, method and step. Every further step has the same bits as in
/// a run that was never stopped.
///
/// # Errors
/// As [`run`], and when the snapshot does not fit.
pub fn resume(
    scene: &dyn Scene,
    stepper: &mut Stepper<'_>,
    spec: &RunSpec,
    snapshot: Snapshot,
    observers: &mut [&mut dyn Observer],
    stop: &AtomicBool,
) -> Result<Outcome, RunError> {
    let mut state = RunState::restore(scene, stepper, spec, snapshot)?;
    Run { scene, spec, stop: Stop::on(stop), interrupt: Stop::NEVER, state: &mut state }.go_on(stepper, observers)
}

impl Run<'_> {
    /// Shows the state to observers, as the first of the run, and makes all steps.
    ///
    /// # Errors
    /// When a scheme cannot start again at an event, or an observer cannot write.
    pub fn begin(
        &mut self,
        stepper: &mut Stepper<'_>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<Outcome, RunError> {
        observers.iter_mut().try_for_each(|o| o.started(&self.state.from, self.state.row))?;
        self.show_events(0, observers)?;
        self.finish(stepper, observers)
    }

    /// The same for a run that goes on from a snapshot.
    ///
    /// # Errors
    /// As [`Run::begin`].
    pub fn go_on(
        &mut self,
        stepper: &mut Stepper<'_>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<Outcome, RunError> {
        observers.iter_mut().try_for_each(|o| o.resumed(&self.state.from, self.state.row))?;
        self.show_events(0, observers)?;
        self.finish(stepper, observers)
    }

    /// Makes all remaining steps.
    fn finish(&mut self, stepper: &mut Stepper<'_>, observers: &mut [&mut dyn Observer]) -> Result<Outcome, RunError> {
        let (mut status, mut ended_early) = (Status::Completed, false);
        while let Some(next) = self.next() {
            if observers.iter().any(|o| o.ends_run()) {
                ended_early = true;
                break;
            }
            let stopped = self.stop.asked();
            let occasion = match stopped {
                true => Occasion::Interrupted,
                false if next.t >= self.spec.end => Occasion::LastStep,
                false => Occasion::Step,
            };
            for o in observers.iter_mut() {
                o.resumable(&self.state.resumable(occasion, stepper))?;
            }
            if stopped {
                status = Status::Interrupted;
                break;
            }
            if self.step_block(stepper, observers)? {
                continue;
            }
            if let StepEnd::Failed(failed) = self.advance(stepper, observers)? {
                status = failed;
                break;
            }
        }
        for o in observers.iter_mut() {
            // A run that continues after a divergence shows all states.
            if matches!(status, Status::Diverged | Status::NotConverged) && !self.spec.keep_going {
                o.failed()?;
            }
            o.finished(&self.state.from)?;
        }
        if self.state.failure.is_some() && status == Status::Completed {
            status = Status::Diverged;
        }
        ended_early |= self.state.events.ended();
        Ok(Outcome { ended_early, ..self.state.outcome(status, stepper) })
    }

    /// The next step to attempt; `None` at the end.
    pub fn next(&self) -> Option<Tick> {
        if self.state.events.ended() {
            return None;
        }
        self.state.policy.next(self.state.steps, self.state.from.state.t)
    }

    /// The next step, of `h` [s] where a program gives it.
    pub fn next_of(&self, h: Option<f64>) -> Option<Tick> {
        match (&self.state.policy, h) {
            (StepPolicy::Free(steps), Some(h)) if !self.state.events.ended() => {
                Some(steps.tick(self.state.from.state.t, h))
            }
            _ => self.next(),
        }
    }

    /// Whether a scene of this extent [m] counts as diverged.
    fn has_left(&self, extent: f64) -> bool {
        extent.is_nan() || extent > self.state.limit
    }
}

/// A run in progress: its scene and specification, and its state.
pub struct Run<'a> {
    /// what moves
    pub scene: &'a dyn Scene,
    /// its steps, method and solver
    pub spec: &'a RunSpec,
    /// set to stop the run early
    pub stop: Stop<'a>,
    /// ends the search for a cause, besides the flag that ends the run
    pub interrupt: Stop<'a>,
    /// where it is
    pub state: &'a mut RunState,
}

/// The state of a run. After a step, `from` is the accepted point and `to` the one before it. The struct borrows
/// nothing, so it can be stored beside its scene and scheme.
pub struct RunState {
    policy: StepPolicy,
    /// the accepted point
    pub from: Point,
    /// the point before it
    pub to: Point,
    /// work so far
    pub counters: Counters,
    account_passes: u64,
    /// energies so far
    pub ledger: Ledger,
    watch: Watch,
    /// energies at `from`
    pub row: Energies,
    /// the account before a program changed values at this state
    before_change: Option<(Ledger, Energies)>,
    /// number of accepted steps
    pub steps: u64,
    /// events of the scene that are passed
    passed: usize,
    /// those that wait, and those that have happened
    events: EventWatch,
    /// [s] corners of tables, ascending, without events at which schemes start again
    corners: Vec<f64>,
    /// [m] extent beyond which the scene counts as diverged
    limit: f64,
    scene_limits: SceneLimits,
    /// why the run has stopped
    pub failure: Option<Failure>,
    new_doubt: Option<String>,
    doubt: Option<String>,
    blocks: step_block::StepBlocks,
}

/// [s] The corners of tables so far known, ascending, without times at which a scene passes an event.
fn corners_of_tables(scene: &dyn Scene) -> Vec<f64> {
    let mut all = corners(scene, f64::INFINITY, std::iter::empty());
    all.retain(|t| event_times(scene).binary_search_by(|event| event.total_cmp(t)).is_err());
    all
}

/// The initial state of a run.
struct RunStart {
    from: Point,
    policy: StepPolicy,
    ledger: Ledger,
    watch: Watch,
    row: Energies,
    events: EventWatch,
}

impl RunState {
    /// A run before its first step, from a state at t = 0. Starts the scheme.
    pub fn start(scene: &dyn Scene, stepper: &mut Stepper<'_>, spec: &RunSpec, state: State) -> Result<Self, RunError> {
        spec.check()?;
        let needed = scene.n_dof();
        if let Some(found) = [state.x.len(), state.v.len()].into_iter().find(|n| *n != needed) {
            return Err(RunError::OtherState { found, needed });
        }
        sample_tables(scene, spec.steps_of_one_size());
        let (mut policy, passed) = StepPolicy::at(scene, stepper, spec, None, state.t);
        let mut events = EventWatch::open(scene, Vec::new(), spec.ends_by_event);
        events.happen(scene, state.as_ref(), policy.slack(state.t));
        // A state at a time within a step is no end of one.
        policy.end_at(scene, events.times(scene).filter(|t| *t > state.t));
        if let Some(closed) = scene.touches().and_then(|touches| touches.closed(state.as_ref())) {
            return Err(RunError::Closed(closed));
        }
        let mut from = Point { state, forces: scene.new_forces() };
        let mut counters = Counters::default();
        timed(Phase::Forces, || counters.evaluate(scene, from.state.as_ref(), &mut from.forces));
        stepper.set_end(spec.whole);
        stepper.start(&from)?;
        let ledger = Ledger::open(scene, &from);
        let row = ledger.first();
        let watch = Watch::open(scene, spec.method.info, &row);
        Ok(RunState {
            counters,
            passed,
            ..RunState::new_at(scene, RunStart { from, policy, ledger, watch, row, events })
        })
    }

    /// A run at a snapshot. Starts the scheme.
    pub fn restore(
        scene: &dyn Scene,
        stepper: &mut Stepper<'_>,
        spec: &RunSpec,
        snapshot: Snapshot,
    ) -> Result<Self, RunError> {
        spec.check()?;
        spec.passes(scene, &snapshot)?;
        sample_tables(scene, spec.steps_of_one_size());
        let Snapshot { step: steps, t, x, v, forces, carried, counters, ledger, row, .. } = snapshot;
        let Snapshot { before_change, watch, failure, doubt, adaptive, fired, .. } = snapshot;
        let (mut policy, passed) = StepPolicy::at(scene, stepper, spec, adaptive, t);
        let events = EventWatch::open(scene, fired, spec.ends_by_event);
        policy.end_at(scene, events.times(scene));
        let mut from = Point { state: State { t, x, v }, forces: scene.new_forces() };
        if let (Some(touches), Some(near)) = (scene.touches(), &carried.near) {
            touches.restore(near);
        }
        // Already counted in the step that led to this state.
        timed(Phase::Forces, || scene.evaluate(from.state.as_ref(), &mut from.forces));
        stepper.set_end(spec.whole);
        stepper.start(&from)?;
        stepper.restore(&carried)?;
        let lagging = forces.filter(|_| stepper.lags());
        match lagging {
            Some(forces) if forces.fits(&from.forces) => from.forces = forces,
            Some(forces) if forces.total.len() != from.forces.total.len() => return Err(RunError::OtherForces),
            lagging => {
                // A place for forces from outside has come, or gone: found again at their velocities.
                if let Some(forces) = &lagging {
                    from.forces.total.copy_from_slice(&forces.total);
                    stepper.keep_over_change(&from);
                }
                if let Some(v) = stepper.force_velocities() {
                    scene.evaluate(StateRef { v, ..from.state.as_ref() }, &mut from.forces);
                }
                lagging.iter().for_each(|forces| from.forces.take_sums(forces));
            }
        }
        let watch = Watch::restore(scene, spec.method.info, watch);
        Ok(RunState {
            counters,
            steps,
            before_change,
            passed,
            failure,
            doubt,
            ..RunState::new_at(scene, RunStart { from, policy, ledger, watch, row, events })
        })
    }

    /// Before its first step.
    fn new_at(scene: &dyn Scene, start: RunStart) -> Self {
        let RunStart { from, policy, ledger, watch, row, events } = start;
        let size = scene.size();
        RunState {
            corners: corners_of_tables(scene),
            policy,
            to: from.clone(),
            from,
            counters: Counters::default(),
            account_passes: 0,
            ledger,
            watch,
            row,
            before_change: None,
            steps: 0,
            passed: 0,
            events,
            limit: if size > 0.0 { BLOW_UP * size } else { f64::INFINITY },
            scene_limits: SceneLimits::of(scene),
            failure: None,
            new_doubt: None,
            doubt: None,
            blocks: step_block::StepBlocks::default(),
        }
    }

    /// Whether a corner of a table lies in a step, in the two steps before it, or in the one after it, all of one size.
    fn near_corner(&self, Tick { h, t }: Tick) -> bool {
        let slack = self.policy.slack(t);
        let next = self.corners.partition_point(|corner| *corner < t - 3.0 * h - slack);
        self.corners.get(next).is_some_and(|corner| *corner <= t + h + slack)
    }

    /// Number of events of the scene that are passed.
    pub fn passed(&self) -> usize {
        self.passed
    }

    /// The events that have happened.
    pub fn fired(&self) -> &[Fired] {
        self.events.fired()
    }

    /// What a snapshot is made of.
    pub fn resumable<'b>(&'b self, occasion: Occasion, stepper: &'b Stepper<'_>) -> Resumable<'b> {
        let RunState { from: at, row, counters, ledger, failure, doubt, steps, .. } = self;
        let (row, counters, failure, doubt) = (*row, *counters, failure.as_ref(), doubt.as_ref());
        let watch = self.watch.account();
        let (adaptive, before_change, step) = (self.policy.state(), self.before_change, *steps);
        let fired = self.events.fired();
        Resumable {
            occasion,
            step,
            at,
            row,
            counters,
            ledger,
            before_change,
            watch,
            failure,
            doubt,
            stepper,
            adaptive,
            fired,
        }
    }

    /// A copy of all that a run needs to continue from here.
    pub fn snapshot(&self, stepper: &Stepper<'_>) -> Snapshot {
        self.resumable(Occasion::Step, stepper).snapshot()
    }

    /// The outcome of a run that ends here.
    pub fn outcome(&self, status: Status, stepper: &Stepper<'_>) -> Outcome {
        Outcome {
            status,
            steps: self.steps,
            rejected_steps: self.policy.state().map_or(0, |state| state.rejected),
            t_end: self.from.state.t,
            ended_early: false,
            fired: self.events.fired().to_vec(),
            unmet: self.events.unmet(),
            counters: self.counters,
            account_passes: self.account_passes,
            energy_error: self.ledger.energy_error(self.steps),
            energy_made: self.watch.gain_share(&self.from, &self.row, self.steps),
            doubt: self.doubt.clone(),
            ledger: self.row,
            failure: self.failure.clone(),
            linear: stepper.linear_stats(),
        }
    }
}
