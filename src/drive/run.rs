//! The loop.

mod stride;

use super::adaptive::{Bench, Dropped, Kept};
use super::clock::Tick;
use super::error::RunError;
use super::failure::{Failure, Scenery, Wreck};
use super::ledger::Ledger;
use super::observer::{LedgerRow, Observer, Occasion, Resumable, StepView};
use super::outcome::{Outcome, RunSpec, Status};
use super::pace::Pace;
use super::snapshot::Snapshot;
use super::watch::{Sight, Trouble, Watch, Watched};
use crate::integrate::stepper::{Attempt, Stepper};
use crate::integrate::{Counters, StepError, StepReport};
use crate::model::point::Point;
use crate::model::state::State;
use crate::scene::Scene;
use crate::startup::{Phase, timed};
use std::sync::atomic::{AtomicBool, Ordering};

/// How many times its size a scene may spread before it counts as blown up.
const BLOW_UP: f64 = 1e4;

/// Runs a scene to its end, to a failure, or until `stop` is set.
///
/// # Errors
/// When the scheme cannot start or an observer cannot write. A diverged or unsolvable run is not an error but an
/// [`Outcome`].
pub fn run(
    scene: &dyn Scene,
    stepper: &mut Stepper<'_>,
    spec: RunSpec<'_>,
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
    spec: RunSpec<'_>,
    state: State,
    observers: &mut [&mut dyn Observer],
    stop: &AtomicBool,
) -> Result<Outcome, RunError> {
    let run = Run::start(scene, stepper, spec, state)?;
    for o in observers.iter_mut() {
        o.started(&run.from, run.row)?;
    }
    go_on(run, stepper, observers, stop)
}

/// Goes on from a snapshot of a run with the same scene, method and step: every further step has the bits it has in a run
/// that was never stopped.
///
/// # Errors
/// As [`run`], and when the snapshot does not fit.
pub fn resume(
    scene: &dyn Scene,
    stepper: &mut Stepper<'_>,
    spec: RunSpec<'_>,
    snapshot: Snapshot,
    observers: &mut [&mut dyn Observer],
    stop: &AtomicBool,
) -> Result<Outcome, RunError> {
    let run = Run::restore(scene, stepper, spec, snapshot)?;
    for o in observers.iter_mut() {
        o.resumed(&run.from, run.row)?;
    }
    go_on(run, stepper, observers, stop)
}

fn go_on(
    mut run: Run<'_>,
    stepper: &mut Stepper<'_>,
    observers: &mut [&mut dyn Observer],
    stop: &AtomicBool,
) -> Result<Outcome, RunError> {
    let mut status = Status::Completed;
    while let Some(next) = run.next() {
        let stopped = stop.load(Ordering::Relaxed);
        let occasion = match stopped {
            true => Occasion::Interrupted,
            false if next.t >= run.spec.end => Occasion::LastStep,
            false => Occasion::Step,
        };
        for o in observers.iter_mut() {
            o.resumable(&run.resumable(occasion, stepper))?;
        }
        if stopped {
            status = Status::Interrupted;
            break;
        }
        if run.stride(stepper, observers)? {
            continue;
        }
        if let Err(stopped) = run.advance(stepper, observers)? {
            status = stopped;
            break;
        }
    }
    for o in observers.iter_mut() {
        o.finished(&run.from)?;
    }
    if run.failure.is_some() && status == Status::Completed {
        status = Status::Diverged;
    }
    Ok(run.outcome(status, stepper))
}

/// What of a kept step is taken: all of it or its second half, which the scheme still has to accept; or its first half, which it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    First,
    Last,
}

/// Whether the state is the new one, or an adaptive step was taken back because it cannot be right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Taken {
    Over,
    Back,
}

/// State of the loop. After a step `from` is the accepted point and `to` the one before it.
struct Run<'a> {
    scene: &'a dyn Scene,
    spec: RunSpec<'a>,
    pace: Pace,
    from: Point,
    to: Point,
    counters: Counters,
    ledger: Ledger,
    watch: Watch,
    row: LedgerRow,
    steps: u64,
    /// [m] extent beyond which the scene counts as blown up
    limit: f64,
    failure: Option<Failure>,
    new_doubt: Option<String>,
    doubt: Option<String>,
    strides: stride::Strides,
}

impl<'a> Run<'a> {
    fn start(
        scene: &'a dyn Scene,
        stepper: &mut Stepper<'_>,
        spec: RunSpec<'a>,
        state: State,
    ) -> Result<Self, RunError> {
        let mut from = Point { state, forces: scene.new_forces() };
        let mut counters = Counters::default();
        timed(Phase::Forces, || counters.evaluate(scene, from.state.as_ref(), &mut from.forces));
        stepper.start(&from)?;
        let (ledger, row) = Ledger::open(scene, &from);
        let watch = Watch::open(scene, spec.method.info, &row);
        let (to, pace) = (from.clone(), Pace::of(scene, stepper, spec, None));
        let (limit, new_doubt, doubt, strides) = (limit(scene), None, None, Default::default());
        Ok(Run {
            scene,
            spec,
            pace,
            from,
            to,
            counters,
            ledger,
            watch,
            row,
            steps: 0,
            limit,
            failure: None,
            new_doubt,
            doubt,
            strides,
        })
    }

    fn restore(
        scene: &'a dyn Scene,
        stepper: &mut Stepper<'_>,
        spec: RunSpec<'a>,
        snapshot: Snapshot,
    ) -> Result<Self, RunError> {
        spec.passes(scene, &snapshot)?;
        let Snapshot { step: steps, t, x, v, carried, counters, ledger, row, watch, failure, adaptive } = snapshot;
        let mut from = Point { state: State { t, x, v }, forces: scene.new_forces() };
        // Counted when the step that led here was made.
        timed(Phase::Forces, || scene.evaluate(from.state.as_ref(), &mut from.forces));
        stepper.start(&from)?;
        stepper.restore(&carried)?;
        let watch = Watch::restore(scene, spec.method.info, watch);
        let (to, pace) = (from.clone(), Pace::of(scene, stepper, spec, adaptive));
        let (limit, new_doubt, doubt, strides) = (limit(scene), None, None, Default::default());
        Ok(Run {
            scene,
            spec,
            pace,
            from,
            to,
            counters,
            ledger,
            watch,
            row,
            steps,
            limit,
            failure,
            new_doubt,
            doubt,
            strides,
        })
    }

    fn resumable<'b>(&'b self, occasion: Occasion, stepper: &'b Stepper<'_>) -> Resumable<'b> {
        let Run { from: at, row, counters, ledger, failure, steps, .. } = self;
        let (row, counters, failure) = (*row, *counters, failure.as_ref());
        let watch = self.watch.account();
        let adaptive = self.pace.state();
        Resumable { occasion, step: *steps, at, row, counters, ledger, watch, failure, stepper, adaptive }
    }

    /// The next step, or the next to try; `None` at the end.
    fn next(&self) -> Option<Tick> {
        self.pace.next(self.steps, self.from.state.t)
    }

    /// Goes on to the next accepted state, which may take several attempts.
    fn advance(
        &mut self,
        stepper: &mut Stepper<'_>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<Result<(), Status>, RunError> {
        while let Some(tick) = self.next() {
            let kept = match &mut self.pace {
                Pace::Fixed(_) => self.fixed_step(stepper, tick).map(Kept::Single),
                Pace::Adaptive(_) => match self.adaptive_step(stepper) {
                    Ok(Some(kept)) => Ok(kept),
                    Ok(None) => continue,
                    Err(stopped) => Err(stopped),
                },
            };
            return match kept {
                Err(stopped) => Ok(Err(stopped)),
                Ok(Kept::Single(report)) => match self.take(stepper, Part::Last, &report, observers)? {
                    Ok(Taken::Back) => continue,
                    Ok(Taken::Over) => Ok(Ok(())),
                    Err(stopped) => Ok(Err(stopped)),
                },
                Ok(Kept::Halves([first, second])) => match self.take(stepper, Part::First, &first, observers)? {
                    Ok(Taken::Back) => continue,
                    Ok(Taken::Over) => {
                        if let Pace::Adaptive(pace) = &mut self.pace
                            && let Some(end) = pace.second()
                        {
                            std::mem::swap(&mut self.to, end);
                        }
                        Ok(self.take(stepper, Part::Last, &second, observers)?.map(|_| ()))
                    }
                    Err(stopped) => Ok(Err(stopped)),
                },
            };
        }
        Ok(Ok(()))
    }

    fn fixed_step(&mut self, stepper: &mut Stepper<'_>, tick: Tick) -> Result<StepReport, Status> {
        let attempt = Attempt { from: &self.from, h: tick.h, t_next: tick.t };
        let report = match stepper.attempt(attempt, &mut self.to, &mut self.counters) {
            Ok(report) => report,
            Err(error) => {
                self.failure = Some(self.scenery(tick).not_converged(&error, worst_of(&error, stepper)));
                return Err(Status::NotConverged);
            }
        };
        if !report.forces_at_end {
            // The ledger and observers want them; the scheme does not, so they are not counted.
            self.scene.evaluate(self.to.state.as_ref(), &mut self.to.forces);
        }
        Ok(report)
    }

    /// One attempt; `None` when it is dropped and a smaller one is left to try.
    fn adaptive_step(&mut self, stepper: &mut Stepper<'_>) -> Result<Option<Kept>, Status> {
        let Pace::Adaptive(pace) = &mut self.pace else { return Ok(None) };
        let Some(trial) = pace.next(self.from.state.t) else { return Ok(None) };
        let bench = Bench { scene: self.scene, stepper: &mut *stepper, counters: &mut self.counters };
        let dropped = match pace.attempt(bench, trial, &self.from, &mut self.to) {
            Ok(kept) => return Ok(Some(kept)),
            Err(dropped) => dropped,
        };
        let floor = pace.floor(self.from.state.t);
        if pace.next(self.from.state.t).is_some_and(|next| next.h >= floor) {
            return Ok(None);
        }
        let scenery = self.scenery(Tick { h: trial.h, t: trial.t });
        self.failure = Some(match &dropped {
            Dropped::Error(worst) => scenery.at_the_floor(*worst, floor),
            Dropped::Unsolved(error) => scenery.not_converged(error, worst_of(error, stepper)),
        });
        Err(Status::NotConverged)
    }

    /// Takes the step that ended in `to`: accounts for it and shows it; then the points have changed places.
    fn take(
        &mut self,
        stepper: &mut Stepper<'_>,
        part: Part,
        report: &StepReport,
        observers: &mut [&mut dyn Observer],
    ) -> Result<Result<Taken, Status>, RunError> {
        let tick = Tick { h: self.to.state.t - self.from.state.t, t: self.to.state.t };
        let before = (self.ledger, self.watch);
        let row = self.ledger.step(self.scene, &self.from, &self.to, report);
        let finite = is_finite(&row) && self.scene.workers().all_finite(&self.to.forces.total);
        let extent = self.scene.extent(self.to.state.as_ref());
        let left = !finite || extent.is_nan() || extent > self.limit;
        match self.look(tick, &row, report, if left { Some(finite) } else { None }) {
            Sight::Calm => {}
            Sight::Doubt(gain) => {
                self.new_doubt = Some(self.scenery(tick).doubt(gain, self.spec.explain_doubts));
            }
            Sight::Trouble(trouble) => {
                let adaptive = matches!(self.pace, Pace::Adaptive(_));
                if let Pace::Adaptive(pace) = &mut self.pace
                    && tick.h > 10.0 * pace.floor(self.from.state.t)
                {
                    (self.ledger, self.watch) = before;
                    pace.take_back(tick.h, (part == Part::First).then_some(stepper))?;
                    return Ok(Ok(Taken::Back));
                }
                self.diverged(tick, trouble, row, left);
                if !finite || !self.spec.keep_going || adaptive {
                    (self.ledger, self.watch) = before;
                    return Ok(Err(Status::Diverged));
                }
            }
        }
        if part == Part::Last {
            stepper.accept();
        }
        std::mem::swap(&mut self.from, &mut self.to);
        self.row = row;
        self.steps += 1;
        let view = StepView {
            step: self.steps,
            from: &self.to,
            to: &self.from,
            ledger: row,
            newton_iterations: report.newton_iterations,
            residual: report.residual,
        };
        let doubt = self.new_doubt.take();
        for o in observers.iter_mut() {
            o.accepted(view)?;
            if let Some(doubt) = &doubt {
                o.doubted(doubt);
            }
        }
        self.doubt = doubt.or(self.doubt.take());
        Ok(Ok(Taken::Over))
    }

    /// What the watch makes of a step; `left` says of a state that has left the scene whether it is finite.
    fn look(&mut self, tick: Tick, after: &LedgerRow, report: &StepReport, left: Option<bool>) -> Sight {
        if left == Some(false) {
            return Sight::Trouble(Trouble::NotFinite);
        }
        let (scene, from, to, before) = (self.scene, &self.from, &self.to, &self.row);
        let step = self.steps + 1;
        let sight = self.watch.step(Watched { scene, from, to, before, after, report, step, h: tick.h });
        match (sight, left) {
            (Sight::Calm | Sight::Doubt(_), Some(_)) => {
                let share = self.watch.share(to, after, step);
                Sight::Trouble(Trouble::Spread { times: BLOW_UP, share, error: self.ledger.energy_error() })
            }
            _ => sight,
        }
    }

    fn diverged(&mut self, tick: Tick, trouble: Trouble, after: LedgerRow, left: bool) {
        if self.failure.is_none() {
            let wreck = Wreck { trouble, to: &self.to, before: self.row, after, gain: self.watch.gain() };
            self.failure = Some(self.scenery(tick).diverged(&wreck));
        }
        if let Some(failure) = self.failure.as_mut().filter(|_| left) {
            failure.blow_up_time.get_or_insert(tick.t);
        }
    }

    fn scenery(&self, Tick { h, t }: Tick) -> Scenery<'_> {
        let Run { scene, from, .. } = self;
        Scenery { scene: *scene, method: self.spec.method, from, step: self.steps + 1, h, t, end: self.spec.end }
    }

    fn outcome(self, status: Status, stepper: &Stepper<'_>) -> Outcome {
        Outcome {
            status,
            steps: self.steps,
            rejected_steps: self.pace.state().map_or(0, |state| state.rejected),
            t_end: self.from.state.t,
            counters: self.counters,
            energy_error: self.ledger.energy_error(),
            energy_made: self.watch.share(&self.from, &self.row, self.steps),
            doubt: self.doubt,
            ledger: self.row,
            failure: self.failure,
            linear: stepper.linear_stats(),
        }
    }
}

/// The degree of freedom with the largest residual of a step that could not be solved.
fn worst_of(error: &StepError, stepper: &Stepper<'_>) -> usize {
    match error {
        StepError::Newton(failure) => stepper.dof_of_unknown(failure.worst()),
        _ => 0,
    }
}

/// [m] extent beyond which a scene counts as blown up
fn limit(scene: &dyn Scene) -> f64 {
    let size = scene.size();
    if size > 0.0 { BLOW_UP * size } else { f64::INFINITY }
}

fn is_finite(row: &LedgerRow) -> bool {
    (row.kinetic + row.elastic + row.gravity + row.external_work + row.dissipated).is_finite()
}
