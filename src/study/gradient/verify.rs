//! Derivatives by differences of whole runs, to compare with.

use super::GradientSpec;
use super::error::GradientError;
use super::keys::{KeyValue, Variant};
use super::run::follow;
use crate::sensitivity::difference::derivative;
use crate::simulation::build_scene;

/// [-] Residual of implicit steps of these runs: that of the case may be as large as what is compared.
const SOLVED: f64 = 1e-12;
/// [-] Share of a number by which these runs differ: smaller than that at a state, as a run bends with its numbers far
/// more than forces do, and not so small that the residuals of its steps matter.
const SHARE: f64 = 1e-4;

/// The derivatives by central differences of order four, of each number and each quantity; `None` where a run has no
/// value.
pub(super) fn by_runs(spec: &GradientSpec<'_>, numbers: &[KeyValue]) -> Result<Vec<Vec<Option<f64>>>, GradientError> {
    let mut all = Vec::with_capacity(numbers.len());
    for number in numbers {
        let h = number.share(SHARE);
        let variant = Variant::of(spec.case, number, h)?;
        let mut values: Vec<Vec<Option<f64>>> = Vec::with_capacity(4);
        for case in &variant.0 {
            let mut problem = case.problem().clone();
            problem.solver.newton.relative = problem.solver.newton.relative.min(SOLVED);
            let scene = build_scene(problem.take_system(), spec.threads)?;
            let made = follow(&problem, &*scene, Vec::new(), spec.interrupt)?;
            values.push(made.quantities.into_iter().map(|quantity| quantity.value).collect());
        }
        let quantities = values.first().map_or(0, Vec::len);
        let of = |quantity: usize| {
            let mut at = values.iter().map(|values| values.get(quantity).copied().flatten());
            let mut next = || at.next().flatten();
            Some(derivative([next()?, next()?, next()?, next()?], h))
        };
        all.push((0..quantities).map(of).collect());
    }
    Ok(all)
}
