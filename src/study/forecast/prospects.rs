//! What the case's own run and others cost, and what their numbers are worth, from runs that are made: whole ones where
//! that is affordable, else their first part.
//!
//! 1. The case's own run is made until it has done so much counted work. What is left costs as much a step as its later
//!    part.
//! 2. The same part is run with twice and four times the step: the three runs say what the numbers are worth
//!    ([`crate::worth`]).
//! 3. Other methods are run over the same part, from long steps to short ones, while that may be cheaper. Their errors
//!    are their differences from the case's own run and its own error.
//!
//! What is made is decided by counted work, so that the same case gets the same answer on every machine.

mod runs;
mod words;

use runs::Course;
use std::collections::BTreeMap;

use serde::Serialize;

use super::estimate::Estimate;
use super::nominal::NominalCosts;
use super::{Candidate, ForecastSpec};
use crate::analysis::critical::CriticalStep;
use crate::beside::Beside;
use crate::drive::clock::Step;
use crate::format_number::{figures, two_digits};
use crate::frames::Distance;
use crate::output::gauges::MeasuredQuantity;
use crate::verify::coarser;
use crate::whole_run::WholeRun;
use crate::worth::Shrinks;

/// [-] Share of the budget for the case's own run; those with longer steps get as much work each as it took.
const OWN: f64 = 0.3;
/// [-] Most that a run with half the step costs, over the run itself.
const FINER_COST: f64 = 3.0;
/// Fewest steps of a part of a run from which something is concluded.
const FEWEST: u64 = 8;
/// [-] Shortest part of a run from which something is said of its numbers.
const PART: f64 = 0.05;
/// Prospects that are told.
const TOLD: usize = 3;

/// How the errors of a prospect are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum KnownBy {
    /// runs over the whole time
    Run,
    /// runs over the first part
    Part,
    /// runs with longer steps
    LongerSteps,
    /// not: the cost follows from steps along a coarse run
    Steps,
    /// not: the cost follows from single steps and counts
    Counts,
}

/// What a number of a run is worth, as far as it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ErrorForecast {
    /// in the unit of the quantity; null where it is not known
    pub error: Option<f64>,
    /// [-] over the value; null where it has none
    pub share: Option<f64>,
}

/// A run that may be made.
#[derive(Clone, Debug, Serialize)]
pub struct Prospect {
    /// name in a case
    pub method: &'static str,
    /// [s] fixed step; null for adaptive steps
    pub step: Option<f64>,
    /// [-] relative tolerance; null for fixed steps
    pub tolerance: Option<f64>,
    /// [s] processor time, output included
    pub cpu_seconds: f64,
    /// by name of the quantity
    pub errors: BTreeMap<String, ErrorForecast>,
    /// how the errors are known
    pub known_by: KnownBy,
    /// the quantity that takes most of the accuracy that is wanted, and its share of it; none where no error is known
    #[serde(skip)]
    pub worst: Option<(String, f64)>,
    /// [s] nominal cost
    #[serde(skip)]
    nominal: f64,
    /// the whole run
    #[serde(skip)]
    pub estimate: Estimate,
}

/// What is known of the runs of a case.
#[derive(Clone, Debug, Serialize)]
pub struct Prospects {
    /// the case's own run
    pub this_case: Prospect,
    /// the cheapest runs within the accuracy, the cheapest first
    pub recommended: Vec<Prospect>,
    /// the accuracy, in words
    pub within: String,
    /// [-] part of the run that was made
    pub part: f64,
    /// [s] when the run ends on the ground: as in the case's own run, or in the coarse one along which its steps were
    /// tried; null where neither came to it, and where runs go on to `time.end`
    pub landing: Option<f64>,
    /// the runs of the case's own method, in words
    #[serde(skip)]
    pub runs: String,
}

/// Makes the runs.
pub struct Prospector<'s, 'a> {
    /// what is asked
    pub spec: &'s ForecastSpec<'a>,
    /// what work costs
    pub costs: NominalCosts,
    /// [s] what start-up and writing results cost a run of so many steps
    pub besides: &'s dyn Fn(f64) -> f64,
}

/// Why there are no prospects.
#[derive(Clone, Debug)]
pub enum NoProspects {
    /// the case's own run fails
    Fails {
        /// when and why
        why: String,
        /// what is known of the runs that another one was compared with
        instead: Option<Box<Prospects>>,
    },
    /// a part of it costs too much
    TooDear,
}

impl Prospector<'_, '_> {
    /// Makes the runs and judges them.
    ///
    /// # Errors
    /// Where the case's own run fails, or is too expensive to be begun.
    pub fn prospects(&self) -> Result<Prospects, NoProspects> {
        let problem = self.spec.problem;
        let own = Candidate { method: problem.method.clone(), limit: self.limit_of(problem.method.info.name) };
        let step = match problem.time.step {
            Step::Fixed(h) => Step::Fixed(h.min(problem.time.end)),
            adaptive @ Step::Adaptive(_) => adaptive,
        };
        let failed = match self.from(&own, step) {
            Err(NoProspects::Fails { why, .. }) => why,
            other => return other,
        };
        // What would run instead: a stable step or a quarter of it, or a method that dissipates.
        let stable = own.limit.map_or(0.0, |limit| limit.safe());
        let shorter = match step {
            Step::Fixed(h) if stable > 0.0 && stable < h => Step::Fixed(two_digits(stable)),
            step => coarser(step, -2),
        };
        let implicit = self.candidate("backward-euler").cloned().map(|candidate| (candidate, step));
        let instead = std::iter::once((own, shorter)).chain(implicit);
        let instead = instead.into_iter().find_map(|(candidate, step)| self.from(&candidate, step).ok());
        Err(NoProspects::Fails { why: failed, instead: instead.map(Box::new) })
    }

    /// The prospects beside a run of this method with this step.
    fn from(&self, candidate: &Candidate, step: Step) -> Result<Prospects, NoProspects> {
        let ForecastSpec { problem, budget, .. } = *self.spec;
        let own_limit = candidate.limit.map_or(f64::INFINITY, |limit| limit.safe());
        let family = candidate.method.info.family;
        let most = budget.nominal(family, OWN * budget.left());
        if most < self.costs.untried(&candidate.method, FEWEST as f64) {
            return Err(NoProspects::TooDear);
        }
        let own = self.run(candidate, step, problem.time.end, most).ok_or(NoProspects::TooDear)?;
        if let Some(time) = own.failed_at {
            return Err(NoProspects::Fails { why: format!("fails at t = {time:.3e} s: {}", own.note), instead: None });
        }
        let (part, end) = (own.t_end, own.whole_end(problem.time.end));
        let Course { whole, told_by, landing } = self.course(candidate, &own);
        if part < PART * end && !budget.thorough() {
            let estimate = whole.with((self.besides)(whole.steps));
            let found = Prospects::without_errors(self.spec, self.costs, told_by, estimate);
            return Ok(Prospects { part: part / landing.unwrap_or(end), landing, ..found });
        }
        // Beside a whole run to the ground others come to the ground too, a little earlier or later.
        let to = if own.landed { problem.time.end } else { part };
        let came = |run: &WholeRun| (run.t_end >= part || run.landed) && run.failed_at.is_none();
        let stable = |step: Step| step.fixed().is_none_or(|h| h < own_limit && FEWEST as f64 * h <= part);
        let beside = |times: f64| {
            let left = if budget.thorough() { f64::INFINITY } else { budget.nominal(family, budget.left()) };
            left.min(times * self.cost(&own))
        };
        let mut longer: Vec<WholeRun> = Vec::new();
        for times in 1..=2 {
            let step = coarser(step, times);
            let wide = step.tolerance().is_some_and(|tolerance| tolerance.relative >= 1.0);
            let run = if stable(step) && !wide { self.run(candidate, step, to, beside(1.0)) } else { None };
            match run.filter(came) {
                Some(run) => longer.push(run),
                None => break,
            }
        }
        // Where no longer step runs, a shorter one says as much.
        let finer = match longer.is_empty() && budget.left() > 0.0 {
            true => self.run(candidate, coarser(step, -1), to, beside(FINER_COST)),
            false => None,
        };
        let finer = finer.filter(came);
        let order = candidate.method.order();
        let shrinks = match step {
            Step::Fixed(_) => Shrinks::with_steps(order),
            Step::Adaptive(_) => Shrinks::with_tolerance(order),
        };
        let worths = Beside { coarser: [longer.first(), longer.get(1)], finer: finer.as_ref() };
        let worths = worths.worth(own.numbers(), shrinks, own.t_end / own.steps.max(1) as f64).quantities;
        let known_by = if part < end { KnownBy::Part } else { KnownBy::Run };
        let this_case =
            self.prospect(candidate, (&own, whole), known_by, &|quantity| worths.get(&quantity.name)?.error);
        let mut all = vec![this_case.clone()];
        let error_of = |run: &WholeRun, quantity: &MeasuredQuantity| {
            let own_error = worths.get(&quantity.name)?.error?;
            let off = match own.value(&quantity.name) {
                Some(value) => (run.value(&quantity.name)? - value).abs(),
                None => between(&own, run)?,
            };
            Some(off + own_error)
        };
        for run in &longer {
            let estimate = like(run, &own, whole, self.whole(run));
            all.push(self.prospect(candidate, (run, estimate), known_by, &|quantity| error_of(run, quantity)));
        }
        all.extend(self.finer(candidate, &this_case, (&own, whole), shrinks, &worths));
        self.others(candidate.method.info.name, &own, &mut all, &error_of);
        let within = |prospect: &Prospect| prospect.worst.as_ref().is_some_and(|(_, share)| *share <= 1.0);
        let mut recommended: Vec<Prospect> = all.into_iter().filter(within).collect();
        recommended.sort_by(|a, b| a.nominal.total_cmp(&b.nominal));
        // Of each method the cheapest.
        let mut told: Vec<Prospect> = Vec::new();
        for prospect in recommended {
            if told.len() < TOLD && told.iter().all(|known| known.method != prospect.method) {
                told.push(prospect);
            }
        }
        let made = finer.iter().chain(std::iter::once(&own)).chain(&longer);
        let made: Vec<String> = made.map(|run| size(run.step)).collect();
        let kind = if step.fixed().is_some() { "steps" } else { "tolerances" };
        let (within, runs) = (self.spec.accuracy.to_string(), format!("{kind} {}", made.join(", ")));
        let part = (part / landing.unwrap_or(end)).min(1.0);
        Ok(Prospects { this_case, recommended: told, within, part, landing, runs })
    }

    fn limit_of(&self, name: &str) -> Option<CriticalStep> {
        self.candidate(name)?.limit
    }

    fn candidate(&self, name: &str) -> Option<&Candidate> {
        self.spec.candidates.iter().find(|candidate| candidate.method.info.name == name)
    }

    /// [s] Nominal cost of a run that was made.
    fn cost(&self, run: &WholeRun) -> f64 {
        self.costs.cost(run.steps as f64, run.counters.into())
    }

    fn prospect(
        &self,
        candidate: &Candidate,
        (run, estimate): (&WholeRun, Estimate),
        known_by: KnownBy,
        error: &dyn Fn(&MeasuredQuantity) -> Option<f64>,
    ) -> Prospect {
        let estimate = estimate.with((self.besides)(estimate.steps));
        let (mut errors, mut worst, mut known) = (BTreeMap::new(), None, true);
        // A part of a run says nothing of its end, where other numbers are asked for too.
        let wanted = || run.quantities.iter().filter(|quantity| quantity.wanted);
        let early =
            run.t_end < run.whole_end(self.spec.problem.time.end) && wanted().any(|quantity| !quantity.at_end());
        for quantity in wanted() {
            if early && quantity.at_end() {
                errors.insert(quantity.name.clone(), ErrorForecast::default());
                continue;
            }
            let error = error(quantity).filter(|error| error.is_finite());
            let share = error.map(|error| quantity.value.map_or(error, |value| error / value.abs()));
            errors.insert(quantity.name.clone(), ErrorForecast { error, share: share.filter(|x| x.is_finite()) });
            let allowed = self.spec.accuracy.allows(quantity).unwrap_or(f64::INFINITY);
            match error.map(|error| if error == 0.0 { 0.0 } else { error / allowed }) {
                Some(share) if worst.as_ref().is_none_or(|(_, most)| share > *most) => {
                    worst = Some((quantity.name.clone(), share));
                }
                Some(_) => {}
                None => known = false,
            }
        }
        let nominal = self.costs.cost(estimate.steps, estimate.work);
        Prospect {
            method: candidate.method.info.name,
            step: run.step.fixed(),
            tolerance: run.step.tolerance().map(|tolerance| tolerance.relative),
            cpu_seconds: estimate.cpu_seconds,
            errors,
            known_by,
            worst: worst.filter(|_| known),
            nominal,
            estimate,
        }
    }
}

impl Candidate {
    /// [s] Longest step, with a margin; infinite without a limit, 0 where it is not known.
    fn step_limit(&self) -> f64 {
        self.limit.map_or(0.0, |limit| limit.safe())
    }
}

/// The whole run of which the same part was made as of another one, whose whole cost is known.
fn like(run: &WholeRun, own: &WholeRun, whole: Estimate, alone: Estimate) -> Estimate {
    let times = run.seconds / own.seconds.max(f64::MIN_POSITIVE);
    let cpu_seconds = if own.seconds > 0.0 { whole.cpu_seconds * times } else { alone.cpu_seconds };
    Estimate { cpu_seconds, ..alone }
}

/// [-] Of the motion, between two runs.
fn between(own: &WholeRun, run: &WholeRun) -> Option<f64> {
    let (a, b) = own.frames.as_ref().zip(run.frames.as_ref())?;
    Some(Distance::between(a, b).over(a.motion)?[0])
}

/// A step or a tolerance.
fn size(step: Step) -> String {
    match step {
        Step::Fixed(h) => format!("{} s", figures(h, 3)),
        Step::Adaptive(tolerance) => format!("{:e}", tolerance.relative),
    }
}

impl Prospects {
    /// What is known where no run was long enough to say what its numbers are worth.
    pub fn without_errors(spec: &ForecastSpec<'_>, costs: NominalCosts, known_by: KnownBy, estimate: Estimate) -> Self {
        let step = spec.problem.time.step;
        let this_case = Prospect {
            method: spec.problem.method.info.name,
            step: step.fixed().map(|h| h.min(spec.problem.time.end)),
            tolerance: step.tolerance().map(|tolerance| tolerance.relative),
            cpu_seconds: estimate.cpu_seconds,
            errors: BTreeMap::new(),
            known_by,
            worst: None,
            nominal: costs.cost(estimate.steps, estimate.work),
            estimate,
        };
        let within = spec.accuracy.to_string();
        Prospects { this_case, recommended: Vec::new(), within, part: 0.0, landing: None, runs: String::new() }
    }

    /// Whether the case's own run is one of this method and step.
    pub(super) fn is_of(&self, candidate: &Candidate, step: Step) -> bool {
        let own = &self.this_case;
        own.method == candidate.method.info.name
            && own.step == step.fixed()
            && own.tolerance == step.tolerance().map(|tolerance| tolerance.relative)
    }
}
