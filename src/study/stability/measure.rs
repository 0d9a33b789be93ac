//! One run of a method with one step: its length, its verdict, and the states at which the scene was stiffest.
//!
//! A run has to be long enough for an instability just beyond the limit to grow from the tiny displacement that the run
//! starts with to a size that cannot be overlooked. How fast it grows follows from one step of the scheme on the
//! oscillator that sets the limit. A run makes as many steps as that growth takes, at least as many as the case itself
//! would, and no more than a number of force passes (or implicit steps) that depends on the size of the scene alone. A
//! run beyond the predicted limit that is cut short by this, and holds, settles nothing.

use super::classify::{EnergyClassifier, STAYS, Verdict};
use super::perturbation::Start;
use super::row::RunRow;
use super::{Kind, StabilitySpec, dear};
use crate::analysis::critical::CriticalStep;
use crate::analysis::critical::step_by_bounds;
use crate::analysis::limit::{growth, swing};
use crate::analysis::spectrum::Spectrum;
use crate::drive::clock::Step;
use crate::drive::{Explain, Failure, Outcome, Status};
use crate::experiment::{self, Event, Experiment};
use crate::integrate::registry::MethodChoice;
use crate::model::state::State;
use crate::model::stop::Stop;
use crate::scene::BoundBuffer;
use std::sync::atomic::{AtomicBool, Ordering};

/// [-] Logarithm of the growth that a run leaves room for: by e^45 even a motion of which the displacement at the start
/// holds hardly anything becomes far larger than any stable motion.
pub(super) const E_FOLDS: f64 = 45.0;
/// [-] Share by which a step lies beyond the predicted limit if its growth is to show in a run.
const BEYOND: f64 = 0.015;
/// Degree-of-freedom passes of an explicit run, and most passes of one.
pub(super) const PASSES: [f64; 2] = [8e6, 2e5];
/// Degree-of-freedom steps of an implicit run of a method with a predicted limit, and most steps of one: growth a
/// percent beyond a limit takes a thousand steps where damping slows it. A run takes a second or two.
const SOLVES: [f64; 2] = [4e6, 1e5];
/// The same where no growth is waited for.
const UNLIMITED_SOLVES: [f64; 2] = [6e4, 1e3];
/// Fewest steps of a run: explicit, implicit.
const FEWEST: [f64; 2] = [400.0, 20.0];
/// [-] Share of its limit at which a scheme is asked whether it swings the energy of an oscillation.
const NEAR: f64 = 0.98;
/// [-] A scheme whose energy swings by less than this factor there does not swing it.
const CALM: f64 = 1.5;
/// A motion counts as kept up if its energy is this many times that of the run with a shorter step, and more than this
/// share of the supplied energy.
const LIVELY: [f64; 2] = [30.0, 1e-3];
/// Factor between the lengths of runs that can be compared.
const ALIKE: f64 = 2.5;

/// Why a method's measurement ends before its time.
#[derive(Debug)]
pub(super) enum StopReason {
    /// the budget is spent
    OutOfBudget,
    /// the user has had enough
    Interrupted,
    /// the method does not go with the scene
    Refused(String),
}

/// Where a search begins if nothing is predicted: velocity Verlet's limit, else a bound on it, else a part of the run.
pub(super) fn reference(spec: &StabilitySpec<'_>, spectrum: &mut Spectrum<'_>) -> f64 {
    let usable = |step: &f64| *step > 0.0 && step.is_finite();
    let verlet = MethodChoice::with_defaults("velocity-verlet").ok();
    let verlet = verlet.map(|method| spectrum.critical_step(&method).step);
    let bound = step_by_bounds(spec.scene, spec.scene.initial_state().as_ref(), &mut BoundBuffer::default());
    verlet.filter(usable).or(Some(bound).filter(usable)).unwrap_or(spec.end / 1000.0)
}

/// A state to start from.
#[derive(Clone, Copy)]
pub(super) struct From<'a> {
    pub start: Start,
    pub state: &'a State,
}

/// Runs of one method.
pub(super) struct MethodRuns<'a> {
    pub spec: &'a StabilitySpec<'a>,
    pub method: &'a MethodChoice,
    pub critical: CriticalStep,
    pub kind: Kind,
    /// [-] share of the energy supplied that must not stay
    pub stays: f64,
    interrupt: &'a AtomicBool,
    /// where runs start
    pub from: From<'a>,
    /// what was run, in this order
    pub trials: Vec<Trial>,
}

/// A run and what is kept of it.
#[derive(Clone, Debug)]
pub(super) struct Trial {
    pub row: RunRow,
    /// where the scene was stiffest, and where it was softest
    pub extremes: [State; 2],
}

impl<'a> MethodRuns<'a> {
    pub(super) fn new(
        spec: &'a StabilitySpec<'a>,
        method: &'a MethodChoice,
        critical: CriticalStep,
        from: From<'a>,
        interrupt: &'a AtomicBool,
    ) -> Self {
        let [calm, swings] = STAYS;
        let kind = Kind::of(method, critical);
        let step = match kind {
            Kind::Near(limit) => Some(NEAR * limit),
            Kind::Somewhere => Some(0.01 / critical.rates.frequency).filter(|h| h.is_finite()),
            Kind::Unlimited => None,
        };
        let swing = step.and_then(|h| swing(method, critical.rates, h));
        let stays = if swing.is_some_and(|swing| swing < CALM) { calm } else { swings };
        MethodRuns { spec, method, critical, kind, stays, interrupt, from, trials: Vec::new() }
    }

    pub(super) fn stop(&self) -> Stop<'a> {
        Stop::on(self.interrupt)
    }

    /// Steps of a run at step `h` [s].
    pub(super) fn steps(&self, h: f64) -> u64 {
        let n = self.spec.scene.n_dof().max(1) as f64;
        let (cap, fewest) = match dear(self.method) {
            true => {
                let [all, most] = if let Kind::Near(_) = self.kind { SOLVES } else { UNLIMITED_SOLVES };
                ((all / n).min(most), FEWEST[1])
            }
            false => {
                let passes = self.method.info.evaluations[usize::from(self.spec.scene.velocity_dependent())].max(1);
                ((PASSES[0] / n).min(PASSES[1]) / f64::from(passes), FEWEST[0])
            }
        };
        let shown = match self.kind {
            Kind::Near(limit) => {
                self.e_folds((1.0 + BEYOND) * limit).filter(|rate| *rate > 0.0).map(|rate| E_FOLDS / rate)
            }
            _ => None,
        };
        let wanted = (self.spec.end / h).max(shown.unwrap_or(0.0)).max(fewest);
        // A number of steps that is not finite becomes the largest.
        wanted.min(cap.max(fewest)).ceil() as u64
    }

    /// [-] E-folds a step of the motion that sets the prediction, at step `h` [s]; below 0 it dies out.
    pub(super) fn e_folds(&self, h: f64) -> Option<f64> {
        growth(self.method, self.critical.rates, h).map(f64::ln)
    }

    /// [-] E-folds of that motion in a run at step `h` [s]; infinite where no step can be made.
    pub(super) fn folds(&self, h: f64) -> f64 {
        self.e_folds(h).map_or(f64::INFINITY, |rate| rate * self.steps(h) as f64)
    }

    /// Whether a run at step `h` [s] that held says that the step is stable: beyond the predicted limit it has to be
    /// long enough for growth to be seen. Of methods without a predicted limit nothing is known that a run could be too
    /// short for.
    pub(super) fn settles(&self, h: f64) -> bool {
        let Kind::Near(limit) = self.kind else { return true };
        let folds = self.folds(h);
        h <= limit || folds <= 0.0 || folds >= E_FOLDS
    }

    /// [s] Bounds on the limit from the runs so far: the largest step that is known to hold, and the smallest that
    /// failed.
    pub(super) fn between(&self) -> [Option<f64>; 2] {
        let known = |h: &f64| self.critical.step > 0.0 && self.settles(*h);
        [self.held().filter(known).max_by(f64::total_cmp), self.failed()]
    }

    /// [s] The largest step that held below the least that failed.
    pub(super) fn longest(&self) -> Option<f64> {
        self.held().max_by(f64::total_cmp)
    }

    fn failed(&self) -> Option<f64> {
        let failed = self.trials.iter().map(|trial| trial.row).filter(|row| !row.verdict.is_stable());
        failed.map(|row| row.step).min_by(f64::total_cmp)
    }

    fn held(&self) -> impl Iterator<Item = f64> {
        let failed = self.failed().unwrap_or(f64::INFINITY);
        let held = self.trials.iter().map(|trial| trial.row).filter(|row| row.verdict.is_stable());
        held.map(|row| row.step).filter(move |h| *h < failed)
    }

    /// Whether a run at step `h` [s] holds; `before` is asked for leave to begin it.
    pub(super) fn holds(
        &mut self,
        h: f64,
        before: &mut dyn FnMut(f64, u64) -> Result<(), StopReason>,
    ) -> Result<bool, StopReason> {
        let steps = self.steps(h);
        before(h, steps)?;
        // Near its limit the energy of an explicit scheme swings by more than the watch of a run allows; small motion
        // is below what the watch sees.
        let swings = self.kind != Kind::Unlimited || self.from.start == Start::SmallMotion;
        let (outcome, classifier) = self.run(h, steps, swings, Explain::Nothing)?;
        if self.interrupt.load(Ordering::Relaxed) {
            return Err(StopReason::Interrupted);
        }
        let verdict = match outcome.status {
            Status::NotConverged => Verdict::NotConverged,
            Status::Diverged if !swings => Verdict::Diverged,
            Status::Diverged if outcome.steps < steps => Verdict::NotFinite,
            _ => classifier.energy(),
        };
        let lively = classifier.lively();
        let verdict =
            if verdict.is_stable() && self.kept_up(lively, h, outcome.t_end) { Verdict::MotionStays } else { verdict };
        let row = RunRow {
            start: self.from.start,
            step: h,
            steps,
            made: outcome.steps,
            t_end: outcome.t_end,
            peak: classifier.peak,
            lively,
            verdict,
        };
        self.trials.push(Trial { row, extremes: classifier.evidence.extremes() });
        Ok(verdict.is_stable())
    }

    /// Whether a motion goes on that the next shorter stable step, over a comparable time, does not show.
    fn kept_up(&self, lively: f64, h: f64, t_end: f64) -> bool {
        let held = self.trials.iter().map(|trial| trial.row).filter(|row| row.step < h && row.verdict.is_stable());
        let below = held
            .max_by(|a, b| a.step.total_cmp(&b.step))
            .filter(|row| row.t_end * ALIKE > t_end && row.t_end < t_end * ALIKE);
        below.is_some_and(|row| lively > LIVELY[0] * row.lively && lively > LIVELY[1])
    }

    fn run(
        &self,
        h: f64,
        steps: u64,
        keep_going: bool,
        explain: Explain,
    ) -> Result<(Outcome, EnergyClassifier<'a>), StopReason> {
        let end = steps as f64 * h;
        let run = Experiment::new(self.spec.scene, self.method, self.spec.solver, Step::Fixed(h), end);
        let experiment = Experiment { keep_going, explain, interrupt: self.stop(), ..run };
        let mut classifier = EnergyClassifier::new(self, steps);
        let start = experiment::Start::State(self.from.state.clone());
        let outcome = experiment.run(start, None, &mut |event, _| match event {
            Event::Started(at, ledger) => {
                classifier.started(at, ledger);
                false
            }
            Event::Step(step) => {
                let settled = step.ends().is_some_and(|ends| classifier.stepped(&step, ends));
                settled || self.interrupt.load(Ordering::Relaxed)
            }
            _ => false,
        });
        Ok((outcome.map_err(|e| StopReason::Refused(e.to_string()))?, classifier))
    }

    /// Why a run at step `h` [s] fails, in the words of `solve`.
    pub(super) fn failure(&self, h: f64) -> Option<Failure> {
        self.run(h, self.steps(h), false, Explain::Failures).ok().and_then(|(outcome, _)| outcome.failure)
    }

    /// The run at exactly this step.
    pub(super) fn trial(&self, h: f64) -> Option<&Trial> {
        self.trials.iter().find(|trial| trial.row.step == h)
    }
}
