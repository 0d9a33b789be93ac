//! The reference solution that runs are compared with, and its own error.
//!
//! Two solutions by different schemes are computed as accurately as is affordable. Their difference is the error of the
//! reference, and no run is ranked below it. If explicit steps are affordable, the schemes are two embedded Runge-Kutta
//! pairs with tight tolerances that step onto every frame. Otherwise it is Newmark's trapezoidal rule with repeatedly
//! halved steps, extrapolated. Its error is a series in h^2 on smooth motion (Hairer, Norsett & Wanner 1993, section
//! II.8), so
//! ```text
//! T_j,k = T_j,k-1 + (T_j,k-1 - T_j-1,k-1) / (4^k - 1)
//! ```
//! gains two orders per column. Quantities have errors of their own (`reference_quantities`). What is
//! affordable is estimated from counted work, so the reference is the same on every machine.

use std::sync::atomic::{AtomicBool, Ordering};

use serde::{Deserialize, Serialize};

pub use super::error::ReferenceFailure;
use super::error::StudyError;
use super::experiment::{Event, Start};
use super::frames::{Distance, Frames, Motion, Sampler};
use super::prepared_case::{PreparedCase, reference_tolerance};
use super::ranking::ReferenceQuantity;
use super::reference_quantities::{Measuring, SolvedQuantities, are_wanted};
use crate::analysis::critical::CostLimits;
use crate::analysis::spectrum::Spectrum;
use crate::analysis::taut::AllTaut;
use crate::drive::clock::Step;
use crate::drive::{Outcome, Status};
use crate::integrate::Counters;
use crate::integrate::registry::MethodChoice;
use crate::model::stop::Stop;
use crate::process::Stopwatch;

/// [-] Difference at which the reference is good enough.
const WANTED: f64 = 1e-9;
/// [-] Smallest stated difference, about the rounding of the frames: a scheme may be exact on a scene.
const ROUNDING: f64 = 1e-13;
/// [-] Difference above which two solutions do not agree.
const NOT_AGREED: f64 = 0.1;
/// Tolerances of the finer and the coarser solution, tried in turn.
const TOLERANCES: [[f64; 2]; 3] = [[1e-10, 1e-9], [1e-11, 1e-11], [1e-13, 1e-12]];
/// The two pairs.
const PAIRS: [&str; 2] = ["dop853", "dormand-prince"];
/// [s] What a reference may cost if the study has no budget, by the nominal figures below.
pub const ALLOWANCE: f64 = 300.0;
/// The accepted steps of the explicit solutions may take this multiple of the allowance together: their cost was
/// estimated with the longest steps of the first solution.
const PATIENCE: f64 = 4.0;
/// Steps of an explicit solution in which quantities are measured: a sine over a few periods has its peak within a
/// millionth.
const SAMPLES: f64 = 16384.0;
/// Share of the allowance that one solution may cost for that.
const FOR_SAMPLES: f64 = 0.125;
/// [-] Error of quantities at which extrapolated solutions are good enough.
const QUANTITIES_WANTED: f64 = 1e-5;
/// Most columns of the extrapolation.
const COLUMNS: usize = 2;
/// Tolerance of Newton's iteration for a reference.
const NEWTON: f64 = 1e-12;

/// The reference of a variant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// its frames
    pub frames: Frames,
    /// what it is worth
    pub account: ReferenceReport,
}

impl Reference {
    /// Refuses a reference whose two solutions do not agree.
    fn checked(self) -> Result<Self, ReferenceFailure> {
        let error = self.account.error;
        if error <= NOT_AGREED { Ok(self) } else { Err(ReferenceFailure::NotAgreed(error)) }
    }
}

/// How a reference was made and what it is worth.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReferenceReport {
    /// the two solutions in words
    pub how: String,
    /// [-] their difference: root mean square over frames and nodes, over that of the motion
    pub error: f64,
    /// [-] largest difference over the largest motion
    pub error_max: f64,
    /// how far the scene moves
    pub motion: Motion,
    /// work of all its runs
    pub counters: Counters,
    /// [s] processor time of all its runs
    pub cpu_seconds: Option<f64>,
    /// the quantities that are asked for, else the numbers of the report
    #[serde(default)]
    pub quantities: Vec<ReferenceQuantity>,
}

/// What a reference is made with.
pub struct ReferenceBuilder<'a> {
    /// the variant
    pub prepared: &'a PreparedCase,
    /// [s] what it may cost, by nominal figures
    pub allowance: f64,
    /// set when the user interrupts
    pub stop: &'a AtomicBool,
    /// called with each run before it begins
    pub tell: &'a dyn Fn(&str),
}

/// What the runs of a reference measure and have cost.
#[derive(Default)]
struct ReferenceCost {
    /// whether quantities are measured
    quantities: bool,
    counters: Counters,
    /// [s] of the present way, by nominal figures
    seconds: f64,
}

impl ReferenceBuilder<'_> {
    /// Makes the reference.
    ///
    /// # Errors
    /// When the user interrupts, nothing moves, or neither way leads to two solutions that agree.
    pub fn make(&self) -> Result<Reference, StudyError> {
        let watch = Stopwatch::start(Default::default());
        let mut spent = ReferenceCost { quantities: are_wanted(self.prepared)?, ..ReferenceCost::default() };
        let explicit = self.explicit(&mut spent);
        let found = match explicit {
            Ok(found) => Ok(found),
            Err(_) if self.interrupted() => return Err(StudyError::InterruptedReference),
            Err(explicit) => {
                spent.seconds = 0.0;
                self.extrapolated(&mut spent).map_err(|implicit| StudyError::NoReference { explicit, implicit })
            }
        };
        if self.interrupted() {
            return Err(StudyError::InterruptedReference);
        }
        let mut found = found?;
        if found.frames.motion.squares == 0.0 {
            return Err(StudyError::NothingMoves);
        }
        found.account.motion = found.frames.motion;
        found.account.counters = spent.counters;
        found.account.cpu_seconds = watch.read().cpu;
        Ok(found)
    }

    fn interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// By the two pairs.
    fn explicit(&self, spent: &mut ReferenceCost) -> Result<Reference, ReferenceFailure> {
        let [fine, coarse] = PAIRS.map(|name| MethodChoice::with_defaults(name).ok());
        let (Some(fine), Some(coarse)) = (fine, coarse) else {
            return Err(ReferenceFailure::Failed(format!("{} and {} are not in the registry", PAIRS[0], PAIRS[1])));
        };
        let every = if spent.quantities { self.sampled(&fine) } else { self.prepared.every };
        let seconds = self.nominal_explicit(&fine, every);
        if seconds > self.allowance {
            return Err(ReferenceFailure::TooLong { seconds, allowance: self.allowance });
        }
        let mut best: Option<Reference> = None;
        for [tight, wide] in TOLERANCES {
            let tolerance = |relative: f64| Step::Adaptive(reference_tolerance(&*self.prepared.scene, relative));
            let both = self.solve(&fine, tolerance(tight), every, spent);
            let both = both.and_then(|a| Ok((a, self.solve(&coarse, tolerance(wide), every, spent)?)));
            let ((a, of_a), (b, of_b)) = match both {
                Ok(both) => both,
                Err(ReferenceFailure::TooLong { .. }) if best.is_some() => break,
                Err(why) => return Err(why),
            };
            let how = format!("{} at tolerance {tight:e} against {} at {wide:e}", PAIRS[0], PAIRS[1]);
            let mut found = agreed(a, &b, how)?;
            found.account.quantities = of_a.beside(&of_b);
            let better = best.as_ref().is_none_or(|best| found.account.error < best.account.error);
            // Once tighter tolerances gain little, more of them only add rounding errors.
            let gained = best.as_ref().is_none_or(|best| found.account.error < 0.3 * best.account.error);
            if better {
                best = Some(found);
            }
            if !gained || best.as_ref().is_some_and(|best| best.account.error <= WANTED) {
                break;
            }
        }
        best.ok_or(ReferenceFailure::NotAgreed(f64::INFINITY)).and_then(Reference::checked)
    }

    /// [s] A part of the interval of the frames with which a solution has steps enough for its quantities.
    fn sampled(&self, method: &MethodChoice) -> f64 {
        let affordable = FOR_SAMPLES * self.allowance / self.prepared.nominal_step(method);
        let parts = affordable.min(SAMPLES) * self.prepared.every / self.prepared.end();
        self.prepared.every / 2f64.powi(parts.max(1.0).log2() as i32)
    }

    /// [s] Lower bound on the cost of the finer explicit solution: steps at the stability limit, or of `every` [s].
    fn nominal_explicit(&self, method: &MethodChoice, every: f64) -> f64 {
        let scene = &*self.prepared.scene;
        let state = scene.initial_state();
        let effort = CostLimits { stop: Stop::on(self.stop), ..CostLimits::FULL };
        let _all_taut = AllTaut::of(scene);
        let limit = Spectrum::with(scene, state.as_ref(), effort).critical_step(method).step;
        let longest = every.min(if limit > 0.0 { limit } else { f64::INFINITY });
        self.prepared.end() / longest * self.prepared.nominal_step(method)
    }

    /// Newmark's trapezoidal rule, extrapolated.
    fn extrapolated(&self, spent: &mut ReferenceCost) -> Result<Reference, ReferenceFailure> {
        let newmark = MethodChoice::with_defaults("newmark").map_err(|e| ReferenceFailure::Failed(e.to_string()))?;
        let steps = |j: i32| 2f64.powi(j) * (self.prepared.end() / self.prepared.every).ceil();
        let seconds = |j: i32| self.prepared.nominal_step(&newmark) * steps(j);
        let mut row: Vec<Frames> = Vec::new();
        let mut measured: Vec<SolvedQuantities> = Vec::new();
        let mut quantities = Vec::new();
        let (mut best, mut total, mut failed): (Option<Reference>, f64, Option<ReferenceFailure>) = (None, 0.0, None);
        for j in 0..24 {
            total += seconds(j);
            if total > self.allowance {
                break;
            }
            let h = self.prepared.every / 2f64.powi(j);
            let newest = match self.solve(&newmark, Step::Fixed(h), self.prepared.every, spent) {
                Ok((frames, numbers)) => {
                    quantities = numbers.after(measured.first(), measured.get(1));
                    measured.insert(0, numbers);
                    frames
                }
                Err(why) if self.interrupted() => return Err(why),
                Err(why) => {
                    // A finer step may be solvable, but the row of coarser ones cannot be continued.
                    (row, measured, failed) = (Vec::new(), Vec::new(), Some(why));
                    continue;
                }
            };
            let mut next = vec![newest];
            for (k, coarser) in row.iter().enumerate().take(COLUMNS) {
                let finer = next.get(k).map(|finer| extrapolate(finer, coarser, k as i32 + 1));
                next.extend(finer);
            }
            if let (Some(last), Some(before)) = (next.last(), row.last()) {
                let how = format!(
                    "newmark at steps down to {h:.3e} s, extrapolated {} times, against the same without the last step",
                    next.len() - 1
                );
                let found = agreed(last.clone(), before, how)?;
                if best.as_ref().is_none_or(|best| found.account.error < best.account.error) {
                    best = Some(found);
                }
            }
            row = next;
            let settled = |of: &ReferenceQuantity| of.error.is_some_and(|error| error <= QUANTITIES_WANTED);
            if best.as_ref().is_some_and(|best| best.account.error <= WANTED) && quantities.iter().all(settled) {
                break;
            }
        }
        if let Some(best) = &mut best {
            best.account.quantities = quantities;
        }
        let too_long = ReferenceFailure::TooLong { seconds: seconds(0) + seconds(1), allowance: self.allowance };
        best.ok_or(failed.unwrap_or(too_long)).and_then(Reference::checked)
    }

    /// Frames and quantities of one run to the end; steps end at multiples of `every` [s] where the scheme allows it.
    fn solve(
        &self,
        method: &MethodChoice,
        step: Step,
        every: f64,
        spent: &mut ReferenceCost,
    ) -> Result<(Frames, SolvedQuantities), ReferenceFailure> {
        let told = match step {
            Step::Fixed(h) => format!("{} at step {h:.3e} s", method.info.name),
            Step::Adaptive(tolerance) => format!("{} at tolerance {:e}", method.info.name, tolerance.relative),
        };
        (self.tell)(&told);
        let mut sampler = Sampler::keeping(&*self.prepared.scene, self.prepared.every);
        let failed = |why: String| ReferenceFailure::Failed(format!("{told}: {why}"));
        let measuring = spent.quantities.then(|| Measuring::new(self.prepared)).transpose();
        let mut measuring = measuring.map_err(|why| failed(why.to_string()))?;
        let mut experiment = self.prepared.experiment(method, step);
        (experiment.interrupt, experiment.frames_every) = (Stop::on(self.stop), Some(every));
        experiment.solver.newton.relative = experiment.solver.newton.relative.min(NEWTON);
        let nominal = self.prepared.nominal_step(method);
        let mut left = ((PATIENCE * self.allowance - spent.seconds) / nominal).max(1.0) as u64;
        let mut stepper = experiment.stepper().map_err(|why| failed(why.to_string()))?;
        let more = measuring.iter_mut().flat_map(Measuring::observers);
        let run = experiment.run_beside(&mut stepper, Start::Initial, Some(&mut sampler), more, &mut |event, _| {
            if let Event::Step(_) = event {
                left = left.saturating_sub(1);
            }
            left == 0 || self.interrupted()
        });
        let Outcome { status, counters, failure, steps, t_end, .. } = run.map_err(|e| failed(e.to_string()))?;
        spent.counters = spent.counters.plus(counters);
        let earlier = spent.seconds;
        spent.seconds += nominal * steps as f64;
        match status {
            Status::Completed => {
                let numbers = measuring.map(|measuring| measuring.done(t_end / steps.max(1) as f64));
                Ok((sampler.into_frames(), numbers.unwrap_or_default()))
            }
            Status::Interrupted if self.interrupted() => Err(ReferenceFailure::Failed("interrupted".to_owned())),
            Status::Interrupted => {
                let whole = nominal * steps as f64 * self.prepared.end() / t_end;
                Err(ReferenceFailure::TooLong { seconds: earlier + whole, allowance: self.allowance })
            }
            Status::Diverged | Status::NotConverged => {
                let why = failure.map_or_else(String::new, |failure| format!(": {}", failure.cause));
                Err(ReferenceFailure::Failed(format!("{told} failed{why}")))
            }
        }
    }
}

/// The finer of two solutions with their difference.
fn agreed(fine: Frames, coarse: &Frames, how: String) -> Result<Reference, ReferenceFailure> {
    let motion = fine.motion;
    if motion.squares == 0.0 {
        return Ok(Reference { account: ReferenceReport { how, motion, ..ReferenceReport::default() }, frames: fine });
    }
    let difference = Distance::between(&fine, coarse).over(motion);
    let [error, error_max] = difference
        .filter(|difference| difference.iter().all(|e| e.is_finite()))
        .ok_or(ReferenceFailure::NotAgreed(f64::INFINITY))?
        .map(|e| e.max(ROUNDING));
    Ok(Reference {
        account: ReferenceReport { how, error, error_max, motion, ..ReferenceReport::default() },
        frames: fine,
    })
}

/// T + (T - coarser)/(4^k - 1), frame by frame.
fn extrapolate(finer: &Frames, coarser: &Frames, k: i32) -> Frames {
    let part = 1.0 / (4f64.powi(k) - 1.0);
    let mut frames = finer.clone();
    for (x, c) in frames.positions.iter_mut().zip(&coarser.positions) {
        for (x, c) in x.iter_mut().zip(c) {
            *x += part * (*x - c);
        }
    }
    frames
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Case;

    /// What was made of a reference is lost with it: nothing says that the study goes on from there.
    #[test]
    fn an_interrupted_reference_starts_again() {
        let case = format!("{}/../../assets/cases/spring-pendulum.json", env!("CARGO_MANIFEST_DIR"));
        let case = Case::from_file(case.as_ref(), &[]).expect("a good case");
        let prepared = PreparedCase::of(case.into_problem(), 1).expect("a scene");
        let builder =
            ReferenceBuilder { prepared: &prepared, allowance: 60.0, stop: &AtomicBool::new(true), tell: &|_| {} };
        let error = builder.make().expect_err("interrupted");
        assert!(matches!(error, StudyError::InterruptedReference) && error.exit_status() == 130, "{error}");
        assert!(error.to_string().contains("nothing is kept"), "{error}");
    }
}
