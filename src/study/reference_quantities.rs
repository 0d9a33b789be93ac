//! Quantities of a reference: their values, and what they are worth.
//!
//! A peak lies between two steps, and a mean is a sum over steps, so that a solution with few long steps has exact
//! frames and poor quantities. The explicit solutions therefore make short steps. All solutions measure at every step,
//! and beside that at some of them: that shows what the steps cost. Added to it is what the
//! scheme costs: the difference of two solutions, or what steps of twice and four times the size show.

use super::accuracy::measure_of;
use super::error::StudyError;
use super::prepared_case::PreparedCase;
use super::ranking::ReferenceQuantity;
use super::worth::{KnownError, Runs, Shrinks, Worth};
use crate::case::spec::{OutputSpec, RowEvery};
use crate::drive::event::Fired;
use crate::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, Point, UpcomingStep, Wants};
use crate::output::gauges::MeasuredQuantity;
use crate::output::largest::LargestValues;

/// Steps at which is measured: one in so many, from this one on. Those after the first have no step in common, so that
/// a peak that one of them meets, or two beside each other, do not look exact.
const STEPS: [[u64; 2]; 4] = [[1, 0], [2, 1], [4, 2], [4, 0]];
/// Share of the largest difference to them that counts as an error: a parabola whose peak is midway between two steps
/// is off there by an eighth of its difference between one of them and the next.
const OF_LARGEST: f64 = 1.0 / 8.0;
/// Order in the step of what is measured at steps, and of Newmark's trapezoidal rule.
const ORDER: u32 = 2;

/// Whether any number but the motion is asked for, or stands in the report.
///
/// # Errors
/// A quantity that is not there.
pub(super) fn are_wanted(prepared: &PreparedCase) -> Result<bool, StudyError> {
    let measured = LargestValues::of_quantities(&*prepared.scene, &prepared.problem.output, prepared.end(), None);
    let measured = measured.map_err(|why| StudyError::Usage(why.to_string()))?.quantities();
    Ok(measured.iter().any(is_compared))
}

/// Whether a quantity has a value that runs are compared by.
fn is_compared(quantity: &MeasuredQuantity) -> bool {
    quantity.wanted && !quantity.is_motion()
}

/// The quantities of a run of a reference.
#[derive(Clone, Debug, Default)]
pub(super) struct SolvedQuantities {
    own: Vec<MeasuredQuantity>,
    /// measured at the steps of [`STEPS`] after the first
    thinned: Vec<Vec<MeasuredQuantity>>,
    /// [s] mean step
    step: f64,
}

/// The observers that measure them.
pub(super) struct Measuring<'a>(Vec<Thinned<'a>>);

/// One that sees one step of so many.
struct Thinned<'a> {
    values: LargestValues<'a>,
    /// one of [`STEPS`]
    steps: [u64; 2],
    /// [s] end of the run: its account is that of the last step
    end: f64,
}

impl<'a> Measuring<'a> {
    /// Observers for all [`STEPS`].
    ///
    /// # Errors
    /// A quantity that is not there.
    pub(super) fn new(prepared: &'a PreparedCase) -> Result<Self, StudyError> {
        let output = OutputSpec { history_every: RowEvery::Steps(1), ..prepared.problem.output.clone() };
        let of = |steps: [u64; 2]| {
            let values = LargestValues::of_quantities(&*prepared.scene, &output, prepared.end(), None);
            let values = values.map_err(|why| StudyError::Usage(why.to_string()))?;
            Ok(Thinned { values, steps, end: prepared.end() })
        };
        STEPS.into_iter().map(of).collect::<Result<_, _>>().map(Measuring)
    }

    pub(super) fn observers(&mut self) -> impl Iterator<Item = &mut dyn Observer> {
        self.0.iter_mut().map(|one| one as &mut dyn Observer)
    }

    /// What was measured in a run with a mean step of `step` [s].
    pub(super) fn done(self, step: f64) -> SolvedQuantities {
        let mut all = self.0.iter().map(|one| one.values.quantities());
        SolvedQuantities { own: all.next().unwrap_or_default(), thinned: all.collect(), step }
    }
}

impl Observer for Thinned<'_> {
    fn started(&mut self, at: &Point, ledger: Energies) -> Result<(), ObserveError> {
        self.values.started(at, ledger)
    }

    fn wants(&self, _step: UpcomingStep) -> Wants {
        Wants::end_if(true)
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        let [every, from] = self.steps;
        let last = step.t + 0.5 * step.h() > self.end;
        if last || step.step % every == from { self.values.accepted(step) } else { Ok(()) }
    }

    fn event(&mut self, event: &Fired) -> Result<(), ObserveError> {
        self.values.event(event)
    }

    fn failed(&mut self) -> Result<(), ObserveError> {
        self.values.failed()
    }

    fn finished(&mut self, last: &Point) -> Result<(), ObserveError> {
        self.values.finished(last)
    }
}

fn value(all: &[MeasuredQuantity], name: &str) -> Option<f64> {
    all.iter().find(|quantity| quantity.name == name)?.value
}

impl SolvedQuantities {
    /// Those of the finer of two solutions by explicit pairs.
    pub(super) fn beside(&self, coarse: &Self) -> Vec<ReferenceQuantity> {
        self.known(|quantity, own, _| {
            let other = value(&coarse.own, &quantity.name);
            let (error, known) = (other.map(|other| (other - own).abs()), KnownError::Difference);
            Worth { error, known, extrapolated: None }
        })
    }

    /// Those of a solution with steps half as long as those of `near`, which are half as long as those of `far`.
    pub(super) fn after(&self, near: Option<&Self>, far: Option<&Self>) -> Vec<ReferenceQuantity> {
        self.known(|quantity, own, shrinks| {
            let coarser = [near, far].map(|run| value(&run?.own, &quantity.name));
            shrinks.worth(Runs { own, coarser, ..Runs::default() })
        })
    }

    /// All quantities, of which `scheme` says what the scheme costs.
    fn known(&self, scheme: impl Fn(&MeasuredQuantity, f64, Shrinks) -> Worth) -> Vec<ReferenceQuantity> {
        let of = |quantity: &MeasuredQuantity| {
            let MeasuredQuantity { name, unit, .. } = quantity;
            let (name, unit) = (name.clone(), (*unit).to_owned());
            let Some(own) = quantity.value else {
                return ReferenceQuantity { name, unit, ..ReferenceQuantity::default() };
            };
            let least = if quantity.is_time() { self.step } else { 0.0 };
            let shrinks = Shrinks { least, ..Shrinks::with_steps(ORDER) };
            let thinned: Vec<Option<f64>> = self.thinned.iter().map(|all| value(all, &quantity.name)).collect();
            let coarser = [0, 1].map(|i| thinned.get(i).copied().flatten());
            let steps = shrinks.worth(Runs { own, coarser, ..Runs::default() });
            let largest = thinned.iter().flatten().map(|other| (other - own).abs()).fold(0.0, f64::max);
            let of_steps = steps.error.map(|error| error.max(OF_LARGEST * largest).max(quantity.missed));
            let Worth { error, known, extrapolated } = scheme(quantity, own, shrinks);
            let error_by = if steps.error.is_none() { steps.known } else { known };
            let value = extrapolated.unwrap_or(own);
            let scale = Some(measure_of(value, quantity.largest)).filter(|size| *size > 0.0);
            let error = error.zip(of_steps).map(|(scheme, steps)| (scheme + steps) / scale.unwrap_or(1.0));
            ReferenceQuantity { name, unit, value: Some(value), scale, error, error_by }
        };
        self.own.iter().filter(|quantity| is_compared(quantity)).map(of).collect()
    }
}
