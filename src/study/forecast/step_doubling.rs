//! The step for an accuracy where no reference is affordable: the difference of an implicit run from one with twice the
//! step, divided by 2^p - 1 with the order p, estimates its error.

use super::coarse_reference::{CoarseReference, MeasuredRun, RunBudget};
use super::nominal::NominalCosts;
use super::search::{CAREFUL, FROM_PART, FoundStep, KnownBy, LONGEST, REACH, SATURATED, nice};
use super::{Candidate, ForecastSpec};
use crate::drive::clock::Step;

/// [s] What all runs are expected to cost together, nominally.
const RUNS: f64 = 2.0;
/// [-] A run is stopped at this multiple of its expected work: its number of iterations is not known in advance.
const SPENT: f64 = 3.0;
/// Steps that are tried.
const TRIES: usize = 5;
/// Steps of both runs over those of the one with the smaller step.
const BOTH: f64 = 1.5;
/// [-] A step longer than this share of the last one is not tried.
const SHORTER: f64 = 0.9;

/// The step for the accuracy, searched downwards from the longest possible one; `None` if no run is affordable or none
/// is conclusive.
pub(super) fn by_step_doubling(
    spec: &ForecastSpec<'_>,
    costs: NominalCosts,
    candidate: &Candidate,
) -> Option<FoundStep> {
    let (method, whole) = (&candidate.method, spec.problem.time.end);
    let order = f64::from(method.order());
    let cost = |h: f64| BOTH * costs.untried(method, whole / h);
    let mut h = nice(candidate.limit?.safe().min(LONGEST * whole), whole);
    let (mut left, mut found) = (RUNS.min(spec.budget.left()), None);
    for _ in 0..TRIES {
        if cost(h) > left {
            break;
        }
        left -= cost(h);
        spec.budget.spend(cost(h));
        let budget = RunBudget { steps: u64::MAX, work: Some((costs, SPENT * cost(h))) };
        let Some((made, error)) = differing(spec, candidate, h, budget) else {
            h = nice(h / 3.0, whole);
            continue;
        };
        let good = error <= FROM_PART * spec.accuracy;
        let aim = (CAREFUL * spec.accuracy / error).powf(1.0 / order);
        let step = if good { h } else { nice(aim * h, whole) };
        let error = error * (step / h).powf(order);
        let run = Some(made.whole_run(whole, (whole / step).ceil()));
        let seconds = costs.as_made(method, &made, whole / step);
        let known_by = KnownBy::TwiceTheStep;
        found = (h <= REACH * step).then_some(FoundStep { step, error: Some(error), known_by, seconds, run });
        // If the step itself is too expensive, the shortest affordable one is tried.
        let next = nice(step.max(h * cost(h) / left), whole);
        if step >= h || next > SHORTER * h {
            break;
        }
        h = next;
    }
    found
}

/// A run and its error, estimated from a run with twice the step. `None` if one of them fails or exceeds its budget, or
/// if they differ by much.
fn differing(spec: &ForecastSpec<'_>, candidate: &Candidate, h: f64, budget: RunBudget) -> Option<(MeasuredRun, f64)> {
    let method = &candidate.method;
    let (reference, made) = CoarseReference::by(spec, method, Step::Fixed(h), budget)?;
    let twice = reference.measure(method, Step::Fixed(2.0 * h), budget)?;
    let times = 2_f64.powi(method.order() as i32) - 1.0;
    (twice.error <= SATURATED).then_some((made, twice.error / times))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::spectrum::Spectrum;
    use crate::case::Case;
    use crate::forecast::cost::tangent_cost;
    use crate::forecast::memory::Baseline;
    use crate::forecast::nominal::Budget;
    use crate::simulation::build_scene;
    use std::path::Path;

    /// Without any other reference the estimated error is that of the run, within a factor of three, and below the
    /// accuracy.
    #[test]
    fn a_run_with_twice_the_step_estimates_the_error() {
        let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/cases");
        let end = [("time.end".to_owned(), "0.2".to_owned())];
        let case = Case::from_file(&assets.join("cloth-k100.json"), &end).expect("a case");
        let (mut problem, _) = case.split();
        let scene = build_scene(problem.take_system(), 1).expect("a scene");
        let tangent = tangent_cost(&*scene, problem.solver, 1e6).expect("a tangent");
        let candidates: Vec<Candidate> = problem
            .method
            .among_all()
            .filter(|method| method.info.name == "newmark")
            .map(|method| Candidate {
                limit: Some(Spectrum::of(&*scene, scene.initial_state().as_ref()).critical_step(&method)),
                method,
            })
            .collect();
        let fields = (&problem.output).into();
        for accuracy in [1e-2, 1e-3] {
            let (scene, problem, baseline) = (&*scene, &problem, Baseline::now());
            let budget = &Budget::of(scene, problem);
            let spec = ForecastSpec { scene, problem, fields, candidates: &candidates, accuracy, baseline, budget };
            let found =
                by_step_doubling(&spec, NominalCosts::new(scene, Some(&tangent)), &candidates[0]).expect("affordable");
            let budget = RunBudget { steps: u64::MAX, work: None };
            let method = &candidates[0].method;
            let (exact, _) = CoarseReference::by(&spec, method, Step::Fixed(1e-4), budget).expect("a reference");
            let made = exact.measure(method, Step::Fixed(found.step), budget).expect("a run").error;
            let told = found.error.expect("estimated");
            assert!(made <= accuracy, "--step {}: {made:e} for {accuracy:e}", found.step);
            assert!(told < 3.0 * made && made < 3.0 * told, "--step {}: {made:e}, {told:e} estimated", found.step);
        }
    }
}
