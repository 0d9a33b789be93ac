//! The cost of a long implicit run, from a few of its own steps at states along a coarse run.
//!
//! A canopy that opens needs many iterations a step, and few once it descends, so a run costs no multiple of its
//! beginning. Long steps of the case's own method are no way ahead: where they are solved at all, they cost as much as
//! the run. Backward Euler with a wide tolerance, each step solved roughly, comes to the end for some hundred
//! iterations. It is far from accurate, but it passes through every stage of the run.

use super::ForecastSpec;
use super::estimate::Estimate;
use super::nominal::NominalCosts;
use super::sample::{Sample, sample_steps, settled};
use super::states::SampledStates;
use super::work::Work;
use crate::drive::clock::{FixedSteps, Step, Tolerance};
use crate::experiment::Experiment;
use crate::integrate::Counters;
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::{Family, MethodChoice};
use crate::process::Stopwatch;
use crate::scene::pass_events;
use crate::whole_run::WholeRun;

/// [-] Tolerance of the coarse run, relative and absolute, and of Newton's iteration in it.
const ROUGH: Tolerance = Tolerance { relative: 0.9, absolute: 0.009 };
const SOLVED: f64 = 0.03;
/// States that steps are tried from at most.
const STATES: usize = 8;
/// Steps of backward Euler after which a rough state is at rest in its stiff motions, steps of the case's own method
/// that are not counted, because they come from another one, and steps that are.
const DAMPED: u64 = 6;
const SETTLE: u64 = 2;
const COUNTED: u64 = 4;
/// Iterations a step beyond which a rough state is taken to be still far from the motion of the case's own method.
const FAR: f64 = 8.0;
/// Iterations of a step of a trial at most.
const MOST: u32 = 12;
/// [-] Share of the budget for the coarse run, and for the trials besides it.
const COARSE: f64 = 0.25;
const TRIALS: f64 = 0.35;

/// What a step costs at a time.
#[derive(Clone, Copy, Debug)]
struct Pace {
    /// [s]
    t: f64,
    /// of one step
    step: Sample,
}

/// The whole run with fixed steps of `h` [s] of which `own` is the first part, and where it lands [s], if the coarse
/// run does. `None` where no step could be tried.
pub(super) fn whole_run(
    spec: &ForecastSpec<'_>,
    costs: &NominalCosts,
    method: &MethodChoice,
    h: f64,
    own: &WholeRun,
) -> Option<(Estimate, Option<f64>)> {
    let ForecastSpec { scene, problem, budget, .. } = *spec;
    let clock = Stopwatch::default();
    let began = clock.seconds();
    let [most, trials] = [COARSE, TRIALS].map(|share| budget.nominal(Family::Implicit, share * budget.left()));
    let rough = MethodChoice::with_defaults("backward-euler").ok()?;
    let mut solver: SolverSpec = problem.solver;
    solver.newton.relative = solver.newton.relative.max(SOLVED);
    pass_events(scene, 0);
    let mut spent = 0.0;
    let probe = Experiment::new(scene, &rough, solver, Step::Adaptive(ROUGH), problem.time.end);
    let probe = Experiment { ends_by_event: problem.time.to_ground, ..probe };
    let mut enough = |steps: u64, counters: Counters| {
        spent = costs.cost(steps as f64, counters.into());
        spent > most
    };
    let way = SampledStates::until(probe, &mut enough);
    let landing = Some(way.reached).filter(|reached| way.landed && *reached > own.t_end);
    let end = landing.unwrap_or(problem.time.end);
    let states = way.beyond(own.t_end, STATES);
    // A rough state far from any motion is given up soon.
    let mut quick = problem.solver;
    quick.newton.max_iterations = quick.newton.max_iterations.min(MOST);
    let fixed = |method| Experiment::new(scene, method, quick, Step::Fixed(h), end);
    let [damping, run] = [fixed(&rough), fixed(method)];
    let [mut damper, mut stepper] = [damping.stepper().ok()?, run.stepper().ok()?];
    let mut paces = vec![Pace { t: own.t_end, step: late(own) }];
    let mut tried = 0.0;
    for state in in_halves(&states) {
        if tried > trials {
            break;
        }
        pass_events(scene, 0);
        let Ok((at, damped)) = settled(damping, &mut damper, DAMPED, state) else { continue };
        tried += costs.cost(damped.steps, damped.work);
        pass_events(scene, 0);
        let Ok(made) = sample_steps(run, &mut stepper, SETTLE, COUNTED, &at) else { continue };
        tried += costs.cost(made.steps, made.work);
        let step = made.each();
        let [seconds, iterations] = [step.seconds, step.work.newton_iterations];
        log::debug!("a step at t = {:.4e} s: {seconds:.4e} s, {iterations:.1} iterations", at.t);
        paces.push(Pace { t: at.t, step });
    }
    let near = |pace: &Pace| pace.t <= own.t_end || pace.step.work.newton_iterations <= FAR;
    let settled = paces.iter().filter(|pace| near(pace)).count() > 2;
    if settled {
        paces.retain(near);
    }
    paces.sort_by(|a, b| a.t.total_cmp(&b.t));
    spent += tried;
    pass_events(scene, 0);
    budget.charge(Family::Implicit, spent, clock.seconds() - began);
    log::debug!(
        "steps along a run to t = {:.4e} s: {:.3} s, {:.3} s nominally",
        way.reached,
        clock.seconds() - began,
        spent
    );
    if paces.len() < 2 {
        return None;
    }
    let steps = FixedSteps::new(h, end).count() as f64;
    let made =
        Sample { steps: own.steps as f64, simulated: own.t_end, seconds: own.seconds, work: own.counters.into() };
    let left = mean(&paces, end).times((steps - made.steps).max(0.0));
    let whole = Sample {
        steps,
        simulated: end,
        seconds: made.seconds + left.seconds,
        work: Work::each(|kind| kind(&made.work) + kind(&left.work)),
    };
    // Steps from rough states need more iterations than those of the run itself.
    Some((Estimate { doubtful: !settled, ..Estimate::from_one(&whole, end, steps) }, landing))
}

/// The last one, then those in the middle of what is left: where trials end early, they still stand for the whole run.
fn in_halves<T: Copy>(all: &[T]) -> Vec<T> {
    let (mut every, mut order) = (all.len().next_power_of_two(), Vec::new());
    while every > 0 {
        let new = |back: &usize| back.is_multiple_of(every) && (*back == 0 || !back.is_multiple_of(2 * every));
        let first = every == all.len().next_power_of_two();
        order.extend((0..all.len()).filter(new).filter(|back| *back != 0 || first));
        every /= 2;
    }
    order.into_iter().filter_map(|back| all.iter().rev().nth(back).copied()).collect()
}

/// A step in the later part of a run that was made.
fn late(own: &WholeRun) -> Sample {
    let steps = (own.steps - own.late.steps).max(1) as f64;
    let all = Sample { steps: own.steps as f64, work: own.counters.into(), ..Sample::default() }.each();
    Sample { seconds: (own.seconds - own.late.seconds).max(0.0) / steps, ..all }
}

/// The mean from the first pace until `end` [s]: a number falls or grows by equal shares in equal times between two
/// paces, and stays as in the last beyond it.
fn mean(paces: &[Pace], end: f64) -> Sample {
    let from = paces.first().map_or(end, |pace| pace.t);
    let sum = |of: &dyn Fn(&Sample) -> f64| {
        let between = |pair: &[Pace]| (pair[1].t - pair[0].t) * logarithmic(of(&pair[0].step), of(&pair[1].step));
        let last = paces.last().map_or(0.0, |last| (end - last.t) * of(&last.step));
        (paces.windows(2).map(between).sum::<f64>() + last) / (end - from).max(f64::MIN_POSITIVE)
    };
    Sample {
        steps: 1.0,
        simulated: 0.0,
        seconds: sum(&|s| s.seconds),
        work: Work::each(|kind| sum(&|s| kind(&s.work))),
    }
}

/// The logarithmic mean of two numbers; the mean where one of them is 0.
fn logarithmic(a: f64, b: f64) -> f64 {
    let ratio = b / a;
    if a <= 0.0 || b <= 0.0 || (ratio - 1.0).abs() < 1e-6 { 0.5 * (a + b) } else { (b - a) / ratio.ln() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_visited_in_halves() {
        assert_eq!(in_halves(&[0, 1, 2, 3, 4]), [4, 0, 2, 3, 1]);
        assert_eq!(in_halves(&[7]), [7]);
        assert!(in_halves::<u8>(&[]).is_empty());
    }

    /// A pace that falls to a half in 2 s, and stays: the area below it over the time.
    #[test]
    fn paces_are_weighed_by_the_time_around_them() {
        let pace = |t: f64, seconds: f64| Pace { t, step: Sample { seconds, ..Sample::default() } };
        let found = mean(&[pace(0.0, 2.0), pace(2.0, 1.0)], 10.0);
        let falling = 2.0 / 2.0_f64.ln();
        assert!((found.seconds - (falling + 8.0) / 10.0).abs() < 1e-12, "{found:?}");
    }
}
