//! Derivatives of the quantities of a run with respect to numbers of its case, exact for the steps that the run makes.
//!
//! Every number of a case is a parameter, by its key. The derivatives are those of the tangent-linear run
//! ([`crate::sensitivity`]), which goes along with the run once for all quantities and parameters. What each spring and
//! each node has is a parameter too: these derivatives are those of the adjoint run, which goes back over the run once
//! for all of them. Neither tells what the steps themselves do to the numbers: `solve --verify` tells that.

mod elements;
mod error;
mod keys;
mod making;
mod reverse;
mod run;
mod verify;

pub use elements::{Element, ElementDerivatives, LargestDerivative};
pub use error::GradientError;
pub use keys::KeyValue;

use crate::case::{Case, Problem};
use crate::model::stop::Stop;
use crate::scene::Scene;
use crate::sensitivity::{Switches, Varied};
use crate::simulation::build_scene;
use crate::sweep::unit_of;
use elements::{ByElements, ByElementsSpec, EachOf, by_elements};
use keys::{Variant, resolve};
use run::{Followed, follow};
use serde::{Deserialize, Serialize};

/// What is asked for.
#[derive(Clone, Copy)]
pub struct GradientSpec<'a> {
    /// the case; its quantities are those of which derivatives are found
    pub case: &'a Case,
    /// keys of the case, and `each.stiffness` and the like for [what each spring or node has](ElementDerivatives)
    pub by: &'a [String],
    /// steps that the adjoint run keeps at once, snapshots included: at least 2, and at least 20 and as many as 256 MiB
    /// hold where none is given. With fewer than the run has, parts of it are made again
    pub states: Option<u64>,
    /// threads of a scene above 2,000 nodes
    pub threads: usize,
    /// whether each derivative is compared with differences of whole runs
    pub verify: bool,
    /// set when the user interrupts
    pub interrupt: Stop<'a>,
}

/// The derivatives of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GradientReport {
    /// name of the case
    pub case: String,
    /// its method
    pub method: String,
    /// steps of the run
    pub steps: u64,
    /// steps that were made again to meet them in reverse order
    pub again: u64,
    /// factorisations of the run
    pub run_factorizations: u64,
    /// factorisations of the tangent-linear run and of the adjoint run
    pub factorizations: u64,
    /// quantities
    pub quantities: Vec<QuantityGradient>,
}

/// A quantity with its derivatives.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct QuantityGradient {
    /// its name
    pub name: String,
    /// its unit
    pub unit: String,
    /// its value
    pub value: Option<f64>,
    /// [s] when a peak is reached
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_time: Option<f64>,
    /// derivatives by numbers of the case, the most important first
    pub derivatives: Vec<Derivative>,
    /// derivatives by what each spring or node has
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub each: Vec<ElementDerivatives>,
}

/// A derivative of a quantity with respect to a number of the case.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Derivative {
    /// the number, by its key
    pub by: String,
    /// its unit; empty where it is not known
    pub by_unit: String,
    /// its value
    pub at: f64,
    /// the derivative, in the unit of the quantity over that of the number
    pub value: f64,
    /// [-] relative change of the quantity over that of the number; null where one of them is 0
    pub elasticity: Option<f64>,
    /// whether the quantity has another derivative on each side, as where the largest of several values changes places
    pub one_sided: bool,
    /// these two, below and above the number, of a quantity that is the value in one step
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sides: Option<[f64; 2]>,
    /// [-] share of stages of steps in which a law switches within the differences by this number
    pub switching: f64,
    /// the derivative by differences of whole runs, if these are asked for
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_runs: Option<f64>,
}

/// Finds the derivatives.
///
/// # Errors
/// A key that is no number of the scene, a quantity or a method without derivative, or a run that fails.
pub fn gradient(spec: &GradientSpec<'_>) -> Result<GradientReport, GradientError> {
    let (mut keys, mut each) = (Vec::new(), Vec::new());
    for name in spec.by {
        match EachOf::named(name) {
            None => keys.push(name.clone()),
            Some(of) => {
                let of = of?;
                if !each.contains(&of) {
                    each.push(of);
                }
            }
        }
    }
    let numbers = resolve(spec.case, &keys)?;
    let mut problem = spec.case.problem().clone();
    let scene = build_scene(problem.take_system(), spec.threads)?;
    let by_numbers = if numbers.is_empty() && !each.is_empty() {
        None
    } else {
        Some(by_numbers(spec, &problem, &*scene, &numbers)?)
    };
    if each.is_empty() {
        return Ok(by_numbers.unwrap_or_default());
    }
    let asked = ByElementsSpec { problem: &problem, of: &each, states: spec.states, interrupt: spec.interrupt };
    // The first run has passed its events.
    let scene = build_scene(spec.case.problem().clone().take_system(), spec.threads)?;
    let found = by_elements(asked, &*scene)?;
    Ok(joined(by_numbers.unwrap_or_else(|| empty(&problem, &found)), found))
}

/// The numbers of a case that keys name, as [`crate::simulation::Simulation::follow_derivatives`] takes them.
///
/// # Errors
/// A key that is no number of the scene, or a case or a scene that cannot be made with values beside it.
pub fn parameters(case: &Case, by: &[String], threads: usize) -> Result<Vec<Varied>, GradientError> {
    varied(case, &resolve(case, by)?, threads)
}

/// Scenes with values beside those of numbers: first all cases, so that a bad one is told before scenes are built.
fn varied(case: &Case, numbers: &[KeyValue], threads: usize) -> Result<Vec<Varied>, GradientError> {
    let variants = numbers.iter().map(|number| Variant::of(case, number, number.h())).collect::<Result<Vec<_>, _>>()?;
    let of = |(number, variant): (&KeyValue, Variant)| {
        Ok(Varied { name: number.key.clone(), scenes: variant.scenes(threads)?, h: number.h() })
    };
    numbers.iter().zip(variants).map(of).collect()
}

/// The report without derivatives by numbers.
fn empty(problem: &Problem, ByElements { run, .. }: &ByElements) -> GradientReport {
    let quantity = |found: &reverse::Reversed| QuantityGradient {
        name: found.of.name.clone(),
        unit: found.of.unit.to_owned(),
        value: found.of.value,
        peak_time: found.of.peak_time,
        ..QuantityGradient::default()
    };
    GradientReport {
        case: problem.name.clone(),
        method: problem.method.info.name.to_owned(),
        steps: run.steps,
        run_factorizations: run.run_factorizations,
        quantities: run.quantities.iter().map(quantity).collect(),
        ..GradientReport::default()
    }
}

/// A report with the derivatives by springs and nodes.
fn joined(mut report: GradientReport, ByElements { run, derivatives }: ByElements) -> GradientReport {
    report.again = run.again;
    report.factorizations += run.factorizations;
    for (quantity, each) in report.quantities.iter_mut().zip(derivatives) {
        quantity.each = each;
    }
    report
}

/// The derivatives by numbers of the case.
fn by_numbers(
    spec: &GradientSpec<'_>,
    problem: &Problem,
    scene: &dyn Scene,
    numbers: &[KeyValue],
) -> Result<GradientReport, GradientError> {
    let followed = follow(problem, scene, varied(spec.case, numbers, spec.threads)?, spec.interrupt)?;
    let by_runs = if spec.verify { Some(verify::by_runs(spec, numbers)?) } else { None };
    Ok(report(&problem.name, problem.method.info.name, numbers, followed, by_runs.as_deref()))
}

/// `by_runs`: of each number, each quantity.
fn report(
    case: &str,
    method: &str,
    numbers: &[KeyValue],
    followed: Followed,
    by_runs: Option<&[Vec<Option<f64>>]>,
) -> GradientReport {
    let Followed { quantities, switches, steps, run_factorizations, factorizations } = followed;
    let share = |Switches { stages, of }: &Switches| if *of > 0 { *stages as f64 / *of as f64 } else { 0.0 };
    let quantity = |(place, of): (usize, crate::output::gauges::derivatives::QuantityDerivatives)| {
        let derivative = |(number, (key, slope)): (usize, (&KeyValue, _))| {
            let crate::sensitivity::difference::Slope { value, switches: one_sided, sides } = slope;
            let elasticity = of.value.filter(|of| *of != 0.0 && key.value != 0.0).map(|of| value * key.value / of);
            Derivative {
                by: key.key.clone(),
                by_unit: unit_of(&key.key),
                at: key.value,
                value,
                elasticity,
                one_sided,
                sides: Some(sides).filter(|[below, above]| one_sided && below != above),
                switching: switches.get(number).map_or(0.0, share),
                by_runs: by_runs.and_then(|all| *all.get(number)?.get(place)?),
            }
        };
        let mut derivatives: Vec<Derivative> =
            numbers.iter().zip(of.slopes.iter().copied()).enumerate().map(derivative).collect();
        // What has no elasticity comes last, in the order of the keys.
        let size = |of: &Derivative| of.elasticity.map_or(-1.0, f64::abs);
        derivatives.sort_by(|a, b| size(b).total_cmp(&size(a)));
        let (name, unit, value, peak_time) = (of.name, of.unit.to_owned(), of.value, of.peak_time);
        QuantityGradient { name, unit, value, peak_time, derivatives, each: Vec::new() }
    };
    GradientReport {
        case: case.to_owned(),
        method: method.to_owned(),
        steps,
        again: 0,
        run_factorizations,
        factorizations,
        quantities: quantities.into_iter().enumerate().map(quantity).collect(),
    }
}
