//! The largest stable step of every method on a scene: predicted from the spectrum at t = 0, and measured by bisection
//! over real runs of the real scene.
//!
//! ```text
//! predicted   Spectrum::critical_step: the scene's outer motions, and one real step of the scheme on an oscillator
//! measured    [h, H]: runs at h held, runs at H did not; H/h - 1 is half a percent where the prediction is confirmed
//! ```
//! Runs begin at the scene's own start, a little displaced so that what is unstable shows in a scene at rest too; a
//! scene whose own motion is linear is measured from small motion where its own start gives another limit
//! (`perturbation`). Near its limit an explicit scheme may swing many times the energy there is and yet be stable, and
//! an instability of a percent needs hundreds of steps to grow out of rounding. `classify` says how the two are told
//! apart, `measure` how long the runs are, `explain` why a measured limit differs from the predicted one. Nothing here
//! reads a clock but the budget, which only leaves methods out.

mod classify;
mod explain;
mod measure;
mod output;
mod perturbation;
mod region;
mod row;
mod search;

pub use classify::Verdict;
pub use output::{FILES, Folder, csv, table};
pub use perturbation::Start;
pub use row::{AsGiven, KnownBy, Prediction, Row, RunRow, Stability, Status};

use crate::StudyError;
use crate::analysis::critical::{CostLimits, CriticalStep};
use crate::analysis::spectrum::Spectrum;
use crate::analysis::taut::AllTaut;
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::{Family, MethodChoice};
use crate::model::state::State;
use crate::model::stop::Stop;
use crate::scene::Scene;
use measure::{From, MethodRuns, StopReason};
use std::cell::OnceCell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// What to study.
pub struct StabilitySpec<'a> {
    /// the scene, at its initial state
    pub scene: &'a dyn Scene,
    /// methods with their parameters, in the order of the rows
    pub methods: &'a [MethodChoice],
    /// how implicit steps are solved
    pub solver: SolverSpec,
    /// [s] end of the case
    pub end: f64,
    /// time on the clock after which no run is begun; methods that are not finished then are left out
    pub budget: Option<Duration>,
}

/// A run that is about to begin.
#[derive(Clone, Copy, Debug)]
pub struct RunStart<'a> {
    /// number of the method, counted from 0
    pub index: usize,
    /// its name
    pub method: &'a str,
    /// number of the run, counted from 1
    pub run: usize,
    /// [s] its step
    pub step: f64,
    /// steps it is to make
    pub steps: u64,
}

/// Predicts and measures every method; `begins` hears of every run. What cannot be measured is a row that says so.
///
/// # Errors
/// What the template engine refuses.
pub fn study(
    spec: &StabilitySpec<'_>,
    begins: &mut dyn FnMut(RunStart<'_>),
    stop: &AtomicBool,
) -> Result<Vec<Row>, StudyError> {
    let started = Instant::now();
    let state = spec.scene.initial_state();
    let effort = CostLimits { stop: Stop::on(stop), ..CostLimits::FULL };
    let all_taut = AllTaut::of(spec.scene);
    let mut spectrum = Spectrum::with(spec.scene, state.as_ref(), effort);
    let limits: Vec<CriticalStep> = spec.methods.iter().map(|method| spectrum.critical_step(method)).collect();
    let reference = measure::reference(spec, &mut spectrum);
    drop(all_taut);
    let over = || spec.budget.is_some_and(|budget| started.elapsed() >= budget);
    let common = Common {
        spec,
        reference,
        given: perturbation::seeded(spec.scene, state.clone()),
        at_rest: perturbation::at_rest(spec.scene, &state),
        small: OnceCell::new(),
        stop,
    };
    let mut rows = Vec::with_capacity(spec.methods.len());
    for (index, (method, critical)) in spec.methods.iter().zip(limits).enumerate() {
        // What a search that was cut short has found is no prediction.
        let critical = if spectrum.stopped() { CriticalStep::none() } else { critical };
        let mut row = Row::new(method, Prediction::of(spec.scene, method, critical));
        if spectrum.stopped() {
            row.halted(StopReason::Interrupted, None);
            rows.push(row);
            continue;
        }
        let name = row.method.clone();
        let mut run = 0;
        let mut before = |step: f64, steps: u64| {
            if over() {
                return Err(StopReason::OutOfBudget);
            }
            run += 1;
            begins(RunStart { index, method: &name, run, step, steps });
            Ok(())
        };
        common.measure(&mut row, method, critical, &mut before)?;
        rows.push(row);
    }
    Ok(rows)
}

/// What the measurements of all methods share.
struct Common<'a> {
    spec: &'a StabilitySpec<'a>,
    /// [s] where a search begins if nothing is predicted
    reference: f64,
    /// the scene's own start, a little displaced
    given: State,
    /// whether that is one of small motion already
    at_rest: bool,
    /// the start of small motion, if the scene's own motion is linear; sought when it is needed first
    small: OnceCell<Option<State>>,
    stop: &'a AtomicBool,
}

/// Hears of a run's step [s] and number of steps before it begins.
type Before<'a> = dyn FnMut(f64, u64) -> Result<(), StopReason> + 'a;

impl Common<'_> {
    /// Measures from the scene's own start; where that differs from what theory says of a linear scene, and the scene's
    /// own motion is linear, from small motion.
    fn measure(
        &self,
        row: &mut Row,
        method: &MethodChoice,
        critical: CriticalStep,
        before: &mut Before<'_>,
    ) -> Result<(), StudyError> {
        row.start = if self.at_rest { Start::SmallMotion } else { Start::AsGiven };
        let given = From { start: row.start, state: &self.given };
        let Some(mut runs) = self.search(row, method, critical, given, before) else { return Ok(()) };
        if row.differs && !self.at_rest && row.prediction.step != Some(0.0) {
            let small = self.small.get_or_init(|| perturbation::small_motion(self.spec, self.reference, self.stop));
            if self.stop.load(Ordering::Relaxed) {
                row.halted(StopReason::Interrupted, Some(&runs));
                return Ok(());
            }
            if let Some(state) = small {
                row.set_aside();
                let small = From { start: Start::SmallMotion, state };
                let Some(found) = self.search(row, method, critical, small, before) else { return Ok(()) };
                runs = found;
            }
        }
        explain::explain(row, &runs)
    }

    fn search<'b>(
        &'b self,
        row: &mut Row,
        method: &'b MethodChoice,
        critical: CriticalStep,
        from: From<'b>,
        before: &mut Before<'_>,
    ) -> Option<MethodRuns<'b>> {
        let mut runs = MethodRuns::new(self.spec, method, critical, from, self.stop);
        let found = search::largest(runs.kind, self.reference, self.spec.end, &mut |h| runs.holds(h, &mut *before));
        row.runs.extend(runs.trials.iter().map(|trial| trial.row));
        match found {
            Ok(bracket) => {
                row.measured(&runs, bracket);
                Some(runs)
            }
            Err(halt) => {
                row.halted(halt, Some(&runs));
                None
            }
        }
    }
}

/// What is searched for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// a limit predicted at a step [s] above 0
    Near(f64),
    /// a method with a limit, for which none or no step at all is predicted
    Somewhere,
    /// a method without limit on linear scenes
    Unlimited,
}

impl Kind {
    fn of(method: &MethodChoice, critical: CriticalStep) -> Self {
        match (crate::analysis::critical::has_limit(method), critical.step) {
            (false, _) => Kind::Unlimited,
            (true, step) if step > 0.0 && step.is_finite() => Kind::Near(step),
            (true, _) => Kind::Somewhere,
        }
    }
}

/// Whether a step is dear: a sparse factorisation or several.
fn dear(method: &MethodChoice) -> bool {
    method.info.family == Family::Implicit
}
