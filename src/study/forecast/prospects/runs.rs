//! The runs that a forecast makes.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use super::{KnownBy, Prospect, Prospector, size};
use crate::drive::Status;
use crate::drive::clock::{FixedSteps, Step};
use crate::forecast::along;
use crate::forecast::estimate::Estimate;
use crate::forecast::sample::Sample;
use crate::forecast::{Candidate, ForecastSpec};
use crate::format_number::{figures, two_digits};
use crate::integrate::registry::Family;
use crate::output::gauges::MeasuredQuantity;
use crate::prepared_case::interval;
use crate::verify::coarser;
use crate::whole_run::{WholeRun, WholeRunSpec};
use crate::worth::{Shrinks, Worth};

/// Methods that are tried beside the case's own, the cheapest by the step first.
const OTHERS: [&str; 4] = ["velocity-verlet", "rk4", "dop853", "newmark"];
/// Steps of the part that another method is tried with at first, and how often its step is halved at most.
const COARSEST: f64 = 20.0;
const HALVED: u32 = 5;
/// [-] Another method is tried only where it may cost less than this share of the best so far.
const CHEAPER: f64 = 0.8;
/// How often the case's own step is halved, on paper, to reach the accuracy.
const FINER: i32 = 10;
/// Most units of work a step, as [`WholeRun::work`] counts it, where a method has made none.
const UNITS: f64 = 6.0;

/// The whole run of which a part was made.
pub(super) struct Course {
    pub whole: Estimate,
    pub told_by: KnownBy,
    /// [s] when it ends on the ground, where that is known
    pub landing: Option<f64>,
}

impl Prospector<'_, '_> {
    /// Makes a run to `end` [s] or to so much nominal cost [s]; none if it cannot start.
    pub(super) fn run(&self, candidate: &Candidate, step: Step, end: f64, most: f64) -> Option<WholeRun> {
        let ForecastSpec { scene, problem, budget, .. } = *self.spec;
        let every = interval(problem, scene);
        // Of the case's whole run, more than half of which is made, the rest is made too.
        let whole = end >= problem.time.end && candidate.method.info.name == problem.method.info.name;
        let half = step.fixed().filter(|_| whole).map_or(f64::INFINITY, |h| 0.5 * end / h);
        let spec = WholeRunSpec {
            scene,
            problem,
            every,
            end,
            method: &candidate.method,
            step,
            frames: Some(every),
            // A run in blocks of steps may come to no state that it could be resumed from.
            most_work: (2.0 * UNITS * most / self.costs.untried(&candidate.method, 1.0)).ceil().max(1.0) as u64,
            enough: Some(&|steps, counters| {
                let cost = self.costs.cost(steps, counters.into());
                cost > 2.0 * most || cost > most && steps < half
            }),
            interrupt: &AtomicBool::new(false),
        };
        // Runs that were made before have passed events.
        crate::scene::pass_events(scene, 0);
        let mut run = spec.run().ok()?;
        budget.charge(candidate.method.info.family, self.cost(&run), run.seconds);
        log::debug!(
            "tried {} {}: {} steps to t = {} s in {:.3} s, {:.3} s nominally",
            candidate.method.info.name,
            size(step),
            run.steps,
            figures(run.t_end, 4),
            run.seconds,
            self.cost(&run)
        );
        // A part is what was wanted.
        if run.status == Status::Interrupted {
            run.status = Status::Completed;
        }
        Some(run).filter(|run| run.steps > 0 || run.failed_at.is_some())
    }

    /// The whole run of which a part was made. Explicit steps cost the same all along a run; those of a long implicit
    /// one are tried along it.
    pub(super) fn course(&self, candidate: &Candidate, run: &WholeRun) -> Course {
        let ForecastSpec { problem, budget, .. } = *self.spec;
        let whole = self.whole(run);
        let implicit = candidate.method.info.family == Family::Implicit;
        let landing = Some(run.t_end).filter(|_| run.landed);
        let simple = Course { whole, told_by: KnownBy::Part, landing };
        budget.extend(whole.cpu_seconds);
        let left = run.t_end < run.whole_end(problem.time.end);
        let Some(h) = run.step.fixed().filter(|_| implicit && left) else { return simple };
        along::whole_run(self.spec, &self.costs, &candidate.method, h, run).map_or(simple, |(whole, landing)| Course {
            whole,
            told_by: KnownBy::Steps,
            landing,
        })
    }

    /// The whole run of which a part was made, if it goes on as it did last.
    pub(super) fn whole(&self, run: &WholeRun) -> Estimate {
        let end = run.whole_end(self.spec.problem.time.end);
        let late = run.late;
        let [steps, t, seconds] =
            [(run.steps - late.steps) as f64, run.t_end - late.t, (run.seconds - late.seconds).max(0.0)];
        let made =
            Sample { steps: run.steps as f64, simulated: run.t_end, seconds: run.seconds, work: run.counters.into() };
        let (all, more) = match run.step {
            Step::Fixed(h) => {
                let all = FixedSteps::new(h, end).count() as f64;
                (all, (all - made.steps).max(0.0) * seconds / steps.max(1.0))
            }
            Step::Adaptive(_) => {
                let left = (end - run.t_end).max(0.0);
                (made.steps + left * steps / t, left * seconds / t)
            }
        };
        let estimate = Estimate::from_one(&made, end, all.max(1.0));
        if run.t_end >= end { estimate } else { Estimate { cpu_seconds: run.seconds + more, ..estimate } }
    }

    /// The case's own method with a shorter step, where its own is not within the accuracy.
    pub(super) fn finer(
        &self,
        candidate: &Candidate,
        own: &Prospect,
        (run, whole): (&WholeRun, Estimate),
        shrinks: Shrinks,
        worths: &BTreeMap<String, Worth>,
    ) -> Option<Prospect> {
        let (_, most) = own.worst.as_ref().filter(|(_, share)| *share > 1.0)?;
        let times = (1..=FINER).find(|times| most / shrinks.by.powi(*times) <= 1.0)?;
        let less = shrinks.by.powi(-times);
        let finer = coarser(run.step, -times);
        let error = |quantity: &MeasuredQuantity| Some(worths.get(&quantity.name)?.error? * less);
        let found = self.prospect(candidate, (run, whole), KnownBy::LongerSteps, &error);
        // Steps as long as those of the run, so many times more of them.
        let more = match run.step {
            Step::Fixed(_) => 2.0_f64.powi(times),
            Step::Adaptive(_) => 10.0_f64.powf(f64::from(times) / f64::from(candidate.method.order() + 1)),
        };
        Some(Prospect {
            step: finer.fixed(),
            tolerance: finer.tolerance().map(|tolerance| tolerance.relative),
            cpu_seconds: found.cpu_seconds * more,
            nominal: found.nominal * more,
            ..found
        })
    }

    /// Other methods over the same part, as far as they may be cheaper than what is known.
    pub(super) fn others(
        &self,
        base: &str,
        own: &WholeRun,
        all: &mut Vec<Prospect>,
        error: &dyn Fn(&WholeRun, &MeasuredQuantity) -> Option<f64>,
    ) {
        let ForecastSpec { problem, budget, .. } = *self.spec;
        let (part, end) = (own.t_end, own.whole_end(problem.time.end));
        let to = if own.landed { problem.time.end } else { part };
        let known_by = if part < end { KnownBy::Part } else { KnownBy::Run };
        for name in OTHERS.into_iter().filter(|name| *name != base) {
            let Some(candidate) = self.candidate(name) else { continue };
            let mut h = two_digits(candidate.step_limit().min(part / COARSEST).min(end));
            for _ in 0..=HALVED {
                let within = |of: &&Prospect| of.worst.as_ref().is_some_and(|(_, share)| *share <= 1.0);
                let best = all.iter().filter(within).map(|of| of.nominal).fold(f64::INFINITY, f64::min);
                let whole = self.costs.untried(&candidate.method, end / h);
                // Beyond a run that is not within the accuracy only what it costs matters.
                let dearest = CHEAPER * best.min(20.0 * all.first().map_or(f64::INFINITY, |own| own.nominal));
                let left = budget.nominal(candidate.method.info.family, budget.left());
                let most =
                    (2.0 * whole.min(dearest) * part / end).min(if budget.thorough() { f64::INFINITY } else { left });
                let dear = whole > dearest || self.costs.untried(&candidate.method, part / h) > left;
                if h <= 0.0 || h.is_nan() || dear {
                    break;
                }
                let made = self.run(candidate, Step::Fixed(h), to, most);
                let came = |run: &WholeRun| (run.t_end >= part || run.landed) && run.failed_at.is_none();
                if let Some(run) = made.filter(came) {
                    let whole = self.whole(&run);
                    let found = self.prospect(candidate, (&run, whole), known_by, &|quantity| error(&run, quantity));
                    let good = within(&&found);
                    all.push(found);
                    if good {
                        break;
                    }
                }
                h = two_digits(0.5 * h);
            }
        }
    }
}
