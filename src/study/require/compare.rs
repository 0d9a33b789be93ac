//! How far a run is from the full model, and what it saves.

use serde::{Deserialize, Serialize};

use super::change::ErrorOf;
use super::run::{RequireResult, RequireRow};
use crate::accuracy::{Accuracy, measure_of};
use crate::drive::clock::Step;
use crate::error::StudyError;
use crate::integrate::registry::MethodChoice;
use crate::output::gauges::MeasuredQuantity;
use crate::planned_runs::CaseJob;
use crate::row::RowStatus;
use crate::worth::{Runs, Shrinks};

/// A quantity of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Number {
    /// its name
    pub name: String,
    /// its unit
    pub unit: String,
    /// its value, if the run came to it
    pub value: Option<f64>,
    /// largest magnitude of its series; 0 where it has none
    pub largest: f64,
}

impl From<MeasuredQuantity> for Number {
    fn from(of: MeasuredQuantity) -> Self {
        // JSON has no other numbers.
        let largest = if of.largest.is_finite() { of.largest } else { 0.0 };
        let value = of.value.filter(|value| value.is_finite());
        Number { name: of.name, unit: of.unit.to_owned(), value, largest }
    }
}

/// How far a quantity is from that of the full model.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Difference {
    /// the quantity
    pub name: String,
    /// its value
    pub value: Option<f64>,
    /// its value minus that of the full model, in its unit
    pub difference: Option<f64>,
    /// [-] the same as a share of the value; none of a value that is 0 throughout
    pub share: Option<f64>,
    /// whether that is within the accuracy
    pub within: bool,
}

/// A run beside the full model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// its identifier
    pub id: String,
    /// what is changed, in words
    pub described: String,
    /// the error that a single change shows
    pub shows: Option<ErrorOf>,
    /// whether the discretisation is finer
    pub finer: bool,
    /// how it ended
    pub status: RowStatus,
    /// why, if not well
    pub note: String,
    /// [s] processor time
    pub cpu_seconds: Option<f64>,
    /// [s] counted work at nominal costs
    pub work: Option<f64>,
    /// [-] share of the full model's counted work that it saves
    pub saved: Option<f64>,
    /// every quantity of the full model
    pub differences: Vec<Difference>,
    /// whether all of them are within the accuracy; none for a run without a result
    pub harmless: Option<bool>,
}

impl Comparison {
    /// A run beside that of the full model.
    ///
    /// # Errors
    /// An accuracy in another unit than that of a quantity.
    pub fn of(row: &RequireRow, full: &RequireResult, accuracy: &Accuracy) -> Result<Self, StudyError> {
        let RequireRow { job, result } = row;
        let difference = |number: &Number| {
            let value = result.number(&number.name).and_then(|own| own.value);
            let scale = number.value.map_or(1.0, |value| measure_of(value, number.largest));
            let difference = value.zip(number.value).map(|(value, full)| value - full);
            let share = difference.map(|difference| if difference == 0.0 { 0.0 } else { difference / scale });
            let share = share.filter(|share| share.is_finite());
            let allowed = accuracy.allowed(&number.name, &number.unit, scale)?;
            let within = difference.is_some_and(|difference| difference.abs() <= allowed);
            Ok(Difference { name: number.name.clone(), value, difference, share, within })
        };
        let differences = full.numbers.iter().map(difference).collect::<Result<Vec<_>, StudyError>>()?;
        let judged = result.completed() && full.completed() && !differences.is_empty();
        Ok(Comparison {
            id: job.id.clone(),
            described: job.described(),
            shows: job.variants.first().map(|variant| variant.change.shows()).filter(|_| job.variants.len() == 1),
            finer: job.finer(),
            status: result.status,
            note: result.note.clone(),
            cpu_seconds: result.cpu_seconds,
            work: result.work,
            saved: result.work.zip(full.work).map(|(own, full)| 1.0 - own / full.max(f64::MIN_POSITIVE)),
            harmless: judged.then(|| differences.iter().all(|difference| difference.within)),
            differences,
        })
    }

    fn share(&self, name: &str) -> Option<f64> {
        self.differences.iter().find(|difference| difference.name == name)?.share
    }
}

/// An error of the full model in a quantity, and which run shows it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Shown {
    /// the quantity
    pub name: String,
    /// [-] the error as a share of the value; with its sign where it is that of a change
    pub share: f64,
    /// the change that shows it
    pub by: String,
}

/// The errors of the full model side by side.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct Errors {
    /// of the step, from runs with half and twice of it
    pub step: Vec<Shown>,
    /// of the mesh: the largest change by a finer one
    pub mesh: Vec<Shown>,
    /// of the model: the largest change by what may be left out
    pub harmless: Vec<Shown>,
    /// the largest change by what may not be left out
    pub harmful: Vec<Shown>,
}

impl Errors {
    /// Of the full model, from single changes of it.
    pub(super) fn of(full: &RequireResult, all: &[Comparison], method: &MethodChoice, step: Step) -> Self {
        let names = || full.numbers.iter().map(|number| number.name.as_str());
        let largest = |of: &dyn Fn(&Comparison) -> bool| -> Vec<Shown> {
            let shown = |name: &str| {
                let runs = all.iter().filter(|one| one.harmless.is_some() && of(one));
                let shares = runs.filter_map(|one| Some((one.share(name)?, one)));
                let (share, by) = shares.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
                Some(Shown { name: name.to_owned(), share, by: by.described.clone() })
            };
            names().filter_map(shown).collect()
        };
        let of = |shows: ErrorOf| move |one: &Comparison| one.shows == Some(shows);
        let model = |harmless: bool| {
            move |one: &Comparison| one.shows == Some(ErrorOf::Model) && one.harmless == Some(harmless)
        };
        Errors {
            step: names().filter_map(|name| step_error(name, all, method, step)).collect(),
            mesh: largest(&|one| of(ErrorOf::Mesh)(one) && one.finer),
            harmless: largest(&model(true)),
            harmful: largest(&model(false)),
        }
    }
}

/// The error of a quantity by the step: from the finer run, else from the coarser one.
fn step_error(name: &str, all: &[Comparison], method: &MethodChoice, step: Step) -> Option<Shown> {
    let run = |finer: bool| {
        let steps = all.iter().filter(move |one| one.shows == Some(ErrorOf::Step) && one.finer == finer);
        steps.filter(|one| one.harmless.is_some()).find_map(|one| Some((one.share(name)?, one)))
    };
    let (fine, coarse) = (run(true), run(false));
    let shrinks = match step {
        Step::Fixed(_) => Shrinks::with_steps(method.order()),
        Step::Adaptive(_) => Shrinks::with_tolerance(method.order()),
    };
    let (_, by) = fine.or(coarse)?;
    // Shares are distances from the full model, which is at 0.
    let share = |of: Option<(f64, &Comparison)>| of.map(|(share, _)| share);
    let coarser = [share(coarse).filter(|_| fine.is_none()), None];
    let error = shrinks.worth(Runs { coarser, finer: share(fine), ..Runs::default() }).error?;
    Some(Shown { name: name.to_owned(), share: error, by: by.described.clone() })
}
