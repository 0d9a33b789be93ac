//! What step and mesh add to the scatter: runs at the medians of all distributions with other steps and finer meshes.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::analysis::warnings::limit_at_start;
use crate::case::Case;
use crate::drive::clock::{Step, Tolerance};
use crate::error::StudyError;
use crate::model::stop::Stop;
use crate::prepared_case::PreparedCase;
use crate::require::{ErrorOf, Variants};
use crate::sweep::SweepRow;
use crate::verify::coarser;
use crate::worth::{Runs, Shrinks};

/// A run beside the sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Beside {
    /// at the medians
    Median,
    /// there with another step
    Step {
        /// how many times it is doubled, or the tolerance is ten times as wide
        times: i32,
        /// of the method
        order: u32,
        /// whether it is a tolerance
        adaptive: bool,
    },
    /// there with a finer mesh, in words
    Mesh(String),
}

/// A run beside a case, and the keys that it changes there.
pub(in crate::sweep) type Changed = (Beside, Vec<(String, Value)>);

/// Runs beside a case at the medians: what each is, and the keys that it changes there. There are none by steps where
/// keys of the steps are drawn, and none by meshes where the mesh has no finer one.
///
/// # Errors
/// A case that cannot be summed up.
pub(in crate::sweep) fn runs_beside(case: &Case, drawn: &[String]) -> Result<Vec<Changed>, StudyError> {
    let mut all = vec![(Beside::Median, Vec::new())];
    if !drawn.iter().any(|key| key.starts_with("time") && key != "time.end") {
        all.extend(steps(case)?);
    }
    for variant in Variants::of(case).all {
        if variant.change.shows() == ErrorOf::Mesh && variant.change.finer() {
            let key = |at: &str| at.trim_start_matches('/').replace('/', ".");
            let keys: Vec<(String, Value)> = variant.edits.iter().map(|e| (key(&e.at), e.value.clone())).collect();
            if !keys.iter().any(|(key, _)| drawn.contains(key)) {
                all.push((Beside::Mesh(variant.change.to_string()), keys));
            }
        }
    }
    Ok(all)
}

/// Runs with twice and four times the step; with half of it where twice the step is not stable.
fn steps(case: &Case) -> Result<Vec<Changed>, StudyError> {
    let prepared = match PreparedCase::of(case.problem().clone(), 1) {
        Ok(prepared) => prepared,
        // The samples say why.
        Err(StudyError::Setup(_)) => return Ok(Vec::new()),
        Err(why) => return Err(why),
    };
    let problem = &prepared.problem;
    let limit = limit_at_start(problem.run_spec().planned(&*prepared.scene, Stop::NEVER)).step;
    let may_run = |step: Step| match step {
        Step::Fixed(h) => h <= prepared.end() && h < limit,
        Step::Adaptive(tolerance) => tolerance.relative < 1.0,
    };
    let own = problem.time.step;
    let mut times: Vec<i32> = [1, 2].into_iter().filter(|times| may_run(coarser(own, *times))).collect();
    if times.is_empty() {
        times.push(-1);
    }
    let (order, adaptive) = (problem.method.order(), own.fixed().is_none());
    let run = |times: i32| {
        let keys = match coarser(own, times) {
            Step::Fixed(h) => vec![("time.step", h)],
            Step::Adaptive(Tolerance { relative, absolute }) => {
                vec![("time.tolerance.relative", relative), ("time.tolerance.absolute", absolute)]
            }
        };
        let keys = keys.into_iter().map(|(key, x)| (key.to_owned(), json!(x))).collect();
        (Beside::Step { times, order, adaptive }, keys)
    };
    Ok(times.into_iter().map(run).collect())
}

/// What step and mesh add to a number, beside its scatter.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// the number at the medians
    pub median: Option<f64>,
    /// error by the step, in the unit of the number
    pub step: Option<f64>,
    /// error by the mesh: the sum of those of its counts
    pub mesh: Option<f64>,
    /// the largest of scatter (its standard deviation), step and mesh, as far as they are known
    pub largest: Option<&'static str>,
}

impl Errors {
    /// From the runs beside a sample; `of` is the number of a run that reached its end.
    pub(super) fn of(beside: &[SweepRow], of: impl Fn(&SweepRow) -> Option<f64>, deviation: f64) -> Self {
        let Some(median) = beside.iter().find(|row| row.job.beside == Some(Beside::Median)).and_then(&of) else {
            return Errors::default();
        };
        let errors = Errors {
            median: Some(median),
            step: step(beside, &of, median),
            mesh: mesh(beside, &of, median),
            largest: None,
        };
        let parts = [("scatter", Some(deviation)), ("step", errors.step), ("mesh", errors.mesh)];
        let known = parts.into_iter().filter_map(|(name, size)| Some((name, size?)));
        let largest = known.filter(|(_, size)| *size > 0.0).max_by(|a, b| a.1.total_cmp(&b.1));
        Errors { largest: largest.map(|(name, _)| name), ..errors }
    }
}

/// The error by the step, as `solve --verify` finds it from values.
fn step(beside: &[SweepRow], of: &dyn Fn(&SweepRow) -> Option<f64>, own: f64) -> Option<f64> {
    let mut runs = Runs { own, ..Runs::default() };
    let mut shrinks = None;
    for row in beside {
        if let Some(Beside::Step { times, order, adaptive }) = row.job.beside {
            shrinks = Some(if adaptive { Shrinks::with_tolerance(order) } else { Shrinks::with_steps(order) });
            match times {
                1 => runs.coarser[0] = of(row),
                2 => runs.coarser[1] = of(row),
                _ => runs.finer = of(row),
            }
        }
    }
    shrinks?.worth(runs).error
}

/// The error by the mesh: of each count from the run with twice as many, as if it fell with their square.
fn mesh(beside: &[SweepRow], of: &dyn Fn(&SweepRow) -> Option<f64>, own: f64) -> Option<f64> {
    let finer = beside.iter().filter(|row| matches!(row.job.beside, Some(Beside::Mesh(_))));
    let errors =
        finer.map(|row| Shrinks::with_steps(2).worth(Runs { own, finer: Some(of(row)?), ..Runs::default() }).error);
    let errors: Option<Vec<f64>> = errors.collect();
    errors.filter(|errors| !errors.is_empty()).map(|errors| errors.iter().sum())
}
