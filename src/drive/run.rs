//! The loop.

use super::clock::{FixedSteps, Tick};
use super::error::RunError;
use super::failure::{Failure, Scenery, Wreck};
use super::ledger::Ledger;
use super::observer::{LedgerRow, Observer, Occasion, Resumable, StepView};
use super::snapshot::Snapshot;
use super::watch::{Sight, Trouble, Watch, Watched};
use crate::integrate::registry::MethodInfo;
use crate::integrate::stepper::{Attempt, Stepper};
use crate::integrate::{Counters, StepError, StepReport};
use crate::model::point::Point;
use crate::model::state::State;
use crate::scene::Scene;
use crate::solve::LinearStats;
use std::sync::atomic::{AtomicBool, Ordering};

/// How many times its size a scene may spread before it counts as blown up.
const BLOW_UP: f64 = 1e4;

/// What to run.
#[derive(Clone, Copy, Debug)]
pub struct RunSpec {
    /// [s] end of the run
    pub end: f64,
    /// [s] fixed step
    pub step: f64,
    /// go on past a blow-up until a value stops being finite
    pub keep_going: bool,
    /// the method, for reports
    pub method: &'static MethodInfo,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// reached its end
    #[default]
    Completed,
    /// a state was not finite or left the scene
    Diverged,
    /// an implicit step could not be solved
    NotConverged,
    /// stopped from outside
    Interrupted,
}

/// The result of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// how it ended
    pub status: Status,
    /// accepted steps
    pub steps: u64,
    /// [s] time of the last good state
    pub t_end: f64,
    /// work done
    pub counters: Counters,
    /// [-] largest numerical energy over the largest energy exchanged
    pub energy_error: f64,
    /// [-] largest energy made by the scheme over all energy that was there or was put in
    pub energy_made: f64,
    /// warning that the run gave on its way
    pub doubt: Option<String>,
    /// the account at the last good state
    pub ledger: LedgerRow,
    /// what went wrong, if anything did
    pub failure: Option<Failure>,
    /// the linear solver's account, for implicit methods
    pub linear: Option<LinearStats>,
}

/// Runs a scene to its end, to a failure, or until `stop` is set.
///
/// # Errors
/// When the scheme cannot start or an observer cannot write. A diverged or unsolvable run is not an error but an
/// [`Outcome`].
pub fn run(
    scene: &dyn Scene,
    stepper: &mut Stepper<'_>,
    spec: RunSpec,
    observers: &mut [&mut dyn Observer],
    stop: &AtomicBool,
) -> Result<Outcome, RunError> {
    let run = Run::start(scene, stepper, spec)?;
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
    spec: RunSpec,
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
    let clock = FixedSteps::new(run.spec.step, run.spec.end);
    let mut status = Status::Completed;
    for k in run.steps + 1..=clock.count() {
        let stopped = stop.load(Ordering::Relaxed);
        let occasion = match stopped {
            true => Occasion::Interrupted,
            false if k == clock.count() => Occasion::LastStep,
            false => Occasion::Step,
        };
        for o in observers.iter_mut() {
            o.resumable(&run.resumable(occasion, stepper))?;
        }
        if stopped {
            status = Status::Interrupted;
            break;
        }
        match run.step(stepper, k, clock.tick(k)) {
            Ok(report) => {
                let view = StepView {
                    step: k,
                    from: &run.to,
                    to: &run.from,
                    ledger: run.row,
                    newton_iterations: report.newton_iterations,
                    residual: report.residual,
                };
                let doubt = run.new_doubt.take();
                for o in observers.iter_mut() {
                    o.accepted(view)?;
                    if let Some(doubt) = &doubt {
                        o.doubted(doubt);
                    }
                }
                run.doubt = doubt.or(run.doubt);
            }
            Err(stopped) => {
                status = stopped;
                break;
            }
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

/// State of the loop. After a step `from` is the accepted point and `to` the one before it.
struct Run<'a> {
    scene: &'a dyn Scene,
    spec: RunSpec,
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
}

impl<'a> Run<'a> {
    fn start(scene: &'a dyn Scene, stepper: &mut Stepper<'_>, spec: RunSpec) -> Result<Self, RunError> {
        let mut from = Point { state: scene.initial_state(), forces: scene.new_forces() };
        let mut counters = Counters::default();
        counters.evaluate(scene, from.state.as_ref(), &mut from.forces);
        stepper.start(&from)?;
        let (ledger, row) = Ledger::open(scene, &from);
        let watch = Watch::open(scene, spec.method, &row);
        let to = from.clone();
        let (limit, new_doubt, doubt) = (limit(scene), None, None);
        Ok(Run {
            scene,
            spec,
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
        })
    }

    fn restore(
        scene: &'a dyn Scene,
        stepper: &mut Stepper<'_>,
        spec: RunSpec,
        snapshot: Snapshot,
    ) -> Result<Self, RunError> {
        spec.passes(scene, &snapshot)?;
        let Snapshot { step, t, x, v, carried, counters, ledger, row, watch, failure } = snapshot;
        let mut from = Point { state: State { t, x, v }, forces: scene.new_forces() };
        // Counted when the step that led here was made.
        scene.evaluate(from.state.as_ref(), &mut from.forces);
        stepper.start(&from)?;
        stepper.restore(&carried)?;
        let watch = Watch::restore(scene, spec.method, watch);
        let to = from.clone();
        let (limit, new_doubt, doubt) = (limit(scene), None, None);
        Ok(Run { scene, spec, from, to, counters, ledger, watch, row, steps: step, limit, failure, new_doubt, doubt })
    }

    fn resumable<'b>(&'b self, occasion: Occasion, stepper: &'b Stepper<'_>) -> Resumable<'b> {
        let Run { from: at, row, counters, ledger, failure, steps, .. } = self;
        let (row, counters, failure) = (*row, *counters, failure.as_ref());
        Resumable { occasion, step: *steps, at, row, counters, ledger, watch: self.watch.account(), failure, stepper }
    }

    /// Attempts step `k`; on success the points have changed places.
    fn step(&mut self, stepper: &mut Stepper<'_>, k: u64, Tick { h, t }: Tick) -> Result<StepReport, Status> {
        let attempt = Attempt { from: &self.from, h, t_next: t };
        let report = match stepper.attempt(attempt, &mut self.to, &mut self.counters) {
            Ok(report) => report,
            Err(error) => {
                let worst = match &error {
                    StepError::Newton(failure) => stepper.dof_of_unknown(failure.worst()),
                    _ => 0,
                };
                self.failure = Some(self.scenery(k, h, t).not_converged(&error, worst));
                return Err(Status::NotConverged);
            }
        };
        if !report.forces_at_end {
            // The ledger and observers want them; the scheme does not, so they are not counted.
            self.scene.evaluate(self.to.state.as_ref(), &mut self.to.forces);
        }
        let before = (self.ledger, self.watch);
        let row = self.ledger.step(self.scene, &self.from, &self.to, &report);
        let finite = is_finite(&row) && self.to.forces.total.iter().all(|f| f.is_finite());
        let extent = self.scene.extent(self.to.state.as_ref());
        let left = !finite || extent.is_nan() || extent > self.limit;
        match self.look(Tick { h, t }, k, &row, &report, if left { Some(finite) } else { None }) {
            Sight::Calm => {}
            Sight::Doubt(gain) => self.new_doubt = Some(self.scenery(k, h, t).doubt(gain)),
            Sight::Trouble(trouble) => {
                self.diverged(k, Tick { h, t }, trouble, row, left);
                if !finite || !self.spec.keep_going {
                    (self.ledger, self.watch) = before;
                    return Err(Status::Diverged);
                }
            }
        }
        stepper.accept();
        std::mem::swap(&mut self.from, &mut self.to);
        self.row = row;
        self.steps = k;
        Ok(report)
    }

    /// What the watch makes of a step; `left` says of a state that has left the scene whether it is finite.
    fn look(
        &mut self,
        Tick { h, .. }: Tick,
        step: u64,
        after: &LedgerRow,
        report: &StepReport,
        left: Option<bool>,
    ) -> Sight {
        if left == Some(false) {
            return Sight::Trouble(Trouble::NotFinite);
        }
        let (scene, from, to, before) = (self.scene, &self.from, &self.to, &self.row);
        let sight = self.watch.step(Watched { scene, from, to, before, after, report, step, h });
        match (sight, left) {
            (Sight::Calm | Sight::Doubt(_), Some(_)) => {
                let share = self.watch.share(to, after, step);
                Sight::Trouble(Trouble::Spread { times: BLOW_UP, share, error: self.ledger.energy_error() })
            }
            _ => sight,
        }
    }

    fn diverged(&mut self, k: u64, Tick { h, t }: Tick, trouble: Trouble, after: LedgerRow, left: bool) {
        if self.failure.is_none() {
            let wreck = Wreck { trouble, to: &self.to, before: self.row, after, gain: self.watch.gain() };
            self.failure = Some(self.scenery(k, h, t).diverged(&wreck));
        }
        if let Some(failure) = self.failure.as_mut().filter(|_| left) {
            failure.blow_up_time.get_or_insert(t);
        }
    }

    fn scenery(&self, step: u64, h: f64, t: f64) -> Scenery<'_> {
        let Run { scene, from, .. } = self;
        Scenery { scene: *scene, method: self.spec.method, from, step, h, t, end: self.spec.end }
    }

    fn outcome(self, status: Status, stepper: &Stepper<'_>) -> Outcome {
        Outcome {
            status,
            steps: self.steps,
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

/// [m] extent beyond which a scene counts as blown up
fn limit(scene: &dyn Scene) -> f64 {
    let size = scene.size();
    if size > 0.0 { BLOW_UP * size } else { f64::INFINITY }
}

fn is_finite(row: &LedgerRow) -> bool {
    (row.kinetic + row.elastic + row.gravity + row.external_work + row.dissipated).is_finite()
}
