//! The longest step and the largest tolerance that reach an accuracy, found by runs that are compared with a reference.

use super::coarse_reference::{CoarseReference, MeasuredRun, RunBudget};
use super::estimate::Estimate;
use super::nominal::NominalCosts;
use super::{Candidate, tolerance_of};
use crate::drive::clock::Step;
use crate::format_number::two_digits;
use crate::integrate::registry::{Family, MethodChoice};
use crate::prepared_case::nominal_step;

/// [-] An implicit run is stopped at this multiple of [`Effort::most`]: its number of iterations is not known in
/// advance.
const SPENT: f64 = 3.0;
/// [-] Results of longer steps are extrapolated to steps that are at most this many times shorter.
pub(super) const REACH: f64 = 5.0;
/// [-] Largest number of runs to find a step, and to find a tolerance.
const RUNS: [usize; 2] = [6, 3];
/// [-] The next step aims at this share of the accuracy as its error.
const AIM: f64 = 0.7;
/// [-] No longer step is tried once the error exceeds this share of the accuracy.
const ENOUGH: f64 = 0.4;
/// [-] Share of the accuracy to aim at if the final run, or any run, was too expensive to make.
pub(super) const CAREFUL: f64 = 0.4;
/// [-] An error concluded from a part of a run must stay below this share of the accuracy.
pub(super) const FROM_PART: f64 = 0.6;
/// [-] Largest factor between the steps of two consecutive runs.
const CHANGE: f64 = 20.0;
/// [-] Longest step, as a share of the run.
pub(super) const LONGEST: f64 = 0.1;
/// [-] Smallest number of steps of a run that is compared.
const FEWEST: f64 = 4.0;
/// [s] If a step costs more than this, nominally, only the case's own method and Newmark's are tried.
const DEAR: f64 = 4e-3;
/// [-] Larger errors are limited by the size of the motion and say nothing about shorter steps.
pub(super) const SATURATED: f64 = 0.3;

/// What a step costs.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Effort {
    Cheap,
    /// an implicit step above [`DEAR`]
    Dear,
}

impl Effort {
    /// [s] Nominal cost limit of a run.
    fn most(self) -> f64 {
        match self {
            Effort::Cheap => 0.3,
            Effort::Dear => 0.12,
        }
    }
}

/// How an error is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum KnownBy {
    /// a run with that step to the end
    Run,
    /// a run with that step over a part of the time, and its error's growth there
    Part,
    /// runs with longer steps, and the order that they showed
    LongerSteps,
    /// its difference from a run with twice the step, and the method's order
    TwiceTheStep,
    /// local errors only
    LocalErrors,
}

/// The step for an accuracy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundStep {
    /// [s] the step
    pub step: f64,
    /// [-] its error; `None` where that is not known
    pub error: Option<f64>,
    /// how it is known
    pub known_by: KnownBy,
    /// [s] cost of the whole run without output: counted work times what its units cost
    pub seconds: f64,
    /// the whole run as far as it is known, without output
    pub run: Option<Estimate>,
}

/// The tolerance for an accuracy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundTolerance {
    /// [-] relative tolerance
    pub tolerance: f64,
    /// [-] its error; `None` where it was not tried
    pub error: Option<f64>,
    /// the whole run, without output; `None` where it was not tried
    pub run: Option<Estimate>,
}

impl FoundTolerance {
    /// The tolerance to ask for without a trial: the error is mostly within a factor of three of the tolerance.
    pub fn untried(accuracy: f64) -> FoundTolerance {
        FoundTolerance { tolerance: two_digits(accuracy / 3.0), error: None, run: None }
    }
}

/// A search on one scene.
pub struct Search<'a> {
    /// what errors are measured with
    pub reference: CoarseReference<'a>,
    /// what work costs
    pub costs: NominalCosts,
    /// [-] what is wanted
    pub accuracy: f64,
}

/// A step and what it delivered.
type Try = (f64, MeasuredRun);

impl Search<'_> {
    /// Whether a method is worth trying.
    pub fn tries(&self, candidate: &Candidate, own: &str) -> bool {
        let info = candidate.method.info;
        let stable = candidate.limit.is_some_and(|limit| limit.step > 0.0);
        stable && (self.effort(candidate) == Effort::Cheap || [own, "newmark"].contains(&info.name))
    }

    /// The longest step that reaches the accuracy; `None` if it would cost more than `dearest` [s], or cannot be found.
    pub fn step(&self, candidate: &Candidate, dearest: f64) -> Option<FoundStep> {
        let CoarseReference { span, whole, .. } = self.reference;
        let method = &candidate.method;
        let mut longest = candidate.limit?.safe().min(LONGEST * whole).min(span / FEWEST);
        let known = method.info.family != Family::Implicit;
        if known && self.costs.untried(method, whole / longest) > dearest {
            return None;
        }
        let most = self.most(candidate);
        let shortest = span / most;
        let guess =
            self.reference.period() / std::f64::consts::TAU * self.accuracy.powf(1.0 / f64::from(method.order()));
        // If the wanted step is too expensive, two longer ones give the order.
        let from = if guess < shortest { 2.0 * shortest } else { guess };
        let mut h = nice(if from.is_finite() { from.min(longest) } else { longest }, whole);
        let mut tries: Vec<Try> = Vec::new();
        for _ in 0..RUNS[0] {
            let Some(made) = self.reference.measure(method, Step::Fixed(h), self.budget(candidate, 2.0 * most)) else {
                longest = h / 2.0;
                h = nice(h / 3.0, whole);
                if h < shortest { break } else { continue }
            };
            tries.push((h, made));
            let aim = self.aim();
            let next = (h * (aim * self.accuracy / made.error).powf(1.0 / order(&tries, method.order())))
                .clamp(h / CHANGE, h * CHANGE)
                .min(longest);
            let good = made.error <= self.bound();
            if good && (made.error >= ENOUGH * self.bound() || next < 1.1 * h) {
                break;
            }
            if !good && self.cost(method, (h, made), next) > dearest {
                return None;
            }
            if next < shortest && h <= 1.01 * shortest {
                break;
            }
            let new = nice(next.max(shortest), whole);
            if tries.iter().any(|(step, _)| *step == new) {
                break;
            }
            h = new;
        }
        self.judge(&tries, method).filter(|found| found.seconds <= dearest)
    }

    /// The longest step that reached the accuracy, otherwise the step extrapolated from the runs.
    fn judge(&self, tries: &[Try], method: &MethodChoice) -> Option<FoundStep> {
        let whole = self.reference.whole;
        let good = tries.iter().filter(|(_, made)| made.error <= self.bound());
        if let Some(&(step, made)) = good.max_by(|a, b| a.0.total_cmp(&b.0)) {
            let known_by = if self.reference.seen() < 1.0 { KnownBy::Part } else { KnownBy::Run };
            return Some(self.found(method, (step, made), step, made.error, known_by));
        }
        let [_, .., (h, made)] = tries else { return None };
        let (h, made) = (*h, *made);
        if made.error > SATURATED {
            return None;
        }
        let p = order(tries, method.order());
        let step = nice(h * (CAREFUL * self.accuracy / made.error).powf(1.0 / p).min(1.0), whole);
        (h <= REACH * step)
            .then(|| self.found(method, (h, made), step, made.error * (step / h).powf(p), KnownBy::LongerSteps))
    }

    /// A step, from a run with it or with a longer one.
    fn found(&self, method: &MethodChoice, from: Try, step: f64, error: f64, known_by: KnownBy) -> FoundStep {
        let run = Some(from.1.whole_run(self.reference.whole, (self.reference.whole / step).ceil()));
        FoundStep { step, error: Some(error), known_by, seconds: self.cost(method, from, step), run }
    }

    /// Largest number of steps of a run that is compared.
    fn most(&self, candidate: &Candidate) -> f64 {
        let step = self.nominal(candidate);
        self.effort(candidate).most() / step
    }

    /// [s] Nominal cost of a step before any was made. For implicit methods it includes the solution of the equations,
    /// mostly with a kept matrix.
    fn nominal(&self, Candidate { method, .. }: &Candidate) -> f64 {
        match method.info.family {
            Family::Implicit => self.costs.untried(method, 1.0),
            Family::Explicit | Family::MatrixFree => nominal_step(self.reference.spec.scene, method),
        }
    }

    fn effort(&self, candidate: &Candidate) -> Effort {
        let dear = candidate.method.info.family == Family::Implicit && self.nominal(candidate) > DEAR;
        if dear { Effort::Dear } else { Effort::Cheap }
    }

    /// The budget of a run of `steps` steps; implicit ones may need more iterations than expected.
    fn budget(&self, candidate: &Candidate, steps: f64) -> RunBudget {
        let most = SPENT * self.effort(candidate).most();
        let implicit = candidate.method.info.family == Family::Implicit;
        RunBudget { steps: steps as u64, work: implicit.then_some((self.costs, most)) }
    }

    /// The tolerance to ask for, its error and its run. It is the accuracy itself, or smaller if that does not reach
    /// it.
    pub fn tolerance(&self, candidate: &Candidate, found: &FoundStep) -> FoundTolerance {
        let untried = FoundTolerance::untried(self.accuracy);
        let CoarseReference { span, whole, .. } = self.reference;
        let steps = span / found.step;
        if steps > 2.0 * self.most(candidate) {
            return untried;
        }
        let most = 4.0 * steps + 4.0 * self.reference.frames_compared() as f64 + 100.0;
        let mut tolerance = self.accuracy;
        for _ in 0..RUNS[1] {
            let step = Step::Adaptive(tolerance_of(tolerance));
            let Some(made) = self.reference.measure(&candidate.method, step, self.budget(candidate, most)) else {
                break;
            };
            if made.error <= self.bound() {
                let run = made.whole_run(whole, made.sample.steps * whole / span);
                return FoundTolerance { tolerance, error: Some(made.error), run: Some(run) };
            }
            tolerance = two_digits(tolerance * (self.aim() * self.accuracy / made.error).max(0.05));
        }
        FoundTolerance { tolerance: tolerance.min(untried.tolerance), ..untried }
    }

    fn aim(&self) -> f64 {
        AIM * self.bound() / self.accuracy
    }

    /// [-] The largest acceptable error.
    fn bound(&self) -> f64 {
        if self.reference.seen() < 1.0 { FROM_PART * self.accuracy } else { self.accuracy }
    }

    /// [s] Cost of the whole run with steps of `step` [s], from the work of another run.
    fn cost(&self, method: &MethodChoice, (_, made): Try, step: f64) -> f64 {
        self.costs.as_made(method, &made, self.reference.whole / step)
    }
}

/// The order of convergence between the last two runs, at most that of the method.
fn order(tries: &[Try], nominal: u32) -> f64 {
    let nominal = f64::from(nominal);
    let [.., (h0, before), (h1, after)] = tries else { return nominal };
    let seen = (before.error / after.error).ln() / (h0 / h1).ln();
    if seen.is_finite() { seen.clamp((0.5 * nominal).min(1.0), nominal) } else { nominal }
}

/// [s] A step of two digits in [0.9 h, h], rounded; one that divides the run is preferred.
pub(super) fn nice(h: f64, whole: f64) -> f64 {
    let most = two_digits(h);
    let unit = 10_f64.powf(most.log10().floor() - 1.0);
    let even = |step: &f64| {
        let steps = whole / step;
        (steps - steps.round()).abs() < 1e-9 * steps
    };
    let below = (0..10).map(|i| two_digits(most - f64::from(i) * unit)).take_while(|step| *step >= 0.9 * most);
    below.into_iter().find(even).unwrap_or(most)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps to type are never above what was found, hardly below, and divide the run where they can.
    #[test]
    fn a_step_to_type_divides_the_run_where_it_can() {
        for (h, whole, typed) in [(0.0526, 20.0, 0.05), (3.7e-5, 0.1, 3.7e-5), (0.0021, 10.0, 0.002), (0.3, 1.0, 0.3)] {
            assert_eq!(nice(h, whole), typed, "{h} of {whole}");
        }
    }

    #[test]
    fn the_order_is_that_of_the_last_runs_and_no_better_than_the_methods() {
        let run = |h: f64, error: f64| (h, MeasuredRun { error, ..MeasuredRun::default() });
        assert_eq!(order(&[run(0.1, 1e-2)], 2), 2.0);
        assert_eq!(order(&[run(0.1, 1.0), run(0.1, 4e-2), run(0.05, 2e-2)], 2), 1.0);
        assert_eq!(order(&[run(0.1, 1.0), run(0.05, 1e-3)], 4), 4.0);
    }
}
