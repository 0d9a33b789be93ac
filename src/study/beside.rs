//! What the numbers of a run are worth beside runs of the same method with other steps.

use std::collections::BTreeMap;

use super::frames::{Distance, Frames};
use super::whole_run::WholeRun;
use super::worth::{EQUAL, KnownError, Runs, Shrinks, Worth};
use crate::model::quantity::Statistic;
use crate::output::gauges::{MeasuredQuantity, Peak};
use crate::output::summary::Summary;

/// The numbers of a run.
#[derive(Clone, Copy)]
pub struct Numbers<'a> {
    /// its quantities
    pub quantities: &'a [MeasuredQuantity],
    /// the peaks of its gauges
    pub peaks: &'a [Peak],
    /// its frames, where its motion is asked for
    pub frames: Option<&'a Frames>,
}

impl WholeRun {
    /// Its numbers.
    pub fn numbers(&self) -> Numbers<'_> {
        Numbers { quantities: &self.quantities, peaks: &self.peaks, frames: self.frames.as_ref() }
    }

    fn peak(&self, like: &Peak) -> Option<f64> {
        let same = |peak: &&Peak| peak.name == like.name && peak.quantity == like.quantity;
        Some(self.peaks.iter().find(same)?.value).filter(|_| self.completed())
    }
}

/// What all numbers of a run are worth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Worths {
    /// of the quantities, by name
    pub quantities: BTreeMap<String, Worth>,
    /// of the peaks, in their order
    pub peaks: Vec<Worth>,
}

/// Factor on what a peak misses between two steps, which is that of a parabola.
const BETWEEN: f64 = 1.25;
/// Fewest steps of a run that shows the order of its method.
const FEWEST: u64 = 8;
/// [-] Error of the motion over the motion itself beyond which values at the end agree by chance only.
const ELSEWHERE: f64 = 0.25;

/// Runs of the same method beside a run.
#[derive(Clone, Copy, Default)]
pub struct Beside<'a> {
    /// with twice and four times the step, or ten and a hundred times the tolerance
    pub coarser: [Option<&'a WholeRun>; 2],
    /// with half the step, or a tenth of the tolerance
    pub finer: Option<&'a WholeRun>,
}

impl Beside<'_> {
    /// What the numbers of a run are worth. `step` [s] is its step, or its mean.
    pub fn worth(&self, own: Numbers<'_>, shrinks: Shrinks, step: f64) -> Worths {
        let completed = |run: Option<&WholeRun>| run.filter(|run| run.completed()).is_some();
        let shrinks = Shrinks { shows: self.coarser[1].is_none_or(|run| run.steps >= FEWEST), ..shrinks };
        let motion = self.motion(own.frames, shrinks);
        let elsewhere = motion.known == KnownError::Contradiction || motion.error.is_some_and(|by| by > ELSEWHERE);
        let of = |quantity: &MeasuredQuantity| {
            let least = if quantity.is_time() { step } else { BETWEEN * quantity.missed };
            let shrinks = Shrinks { least: least.max(EQUAL * quantity.largest), ..shrinks };
            let worth = match quantity.value {
                Some(_) if elsewhere && quantity.statistic == Statistic::Last => {
                    Worth { known: KnownError::Contradiction, ..Worth::default() }
                }
                Some(value) => {
                    let runs = self.runs(value, &|run| run.value(&quantity.name));
                    shrinks.worth(Runs { apart: self.apart(quantity), ..runs })
                }
                None if quantity.is_motion() => motion,
                None => Worth::default(),
            };
            (quantity.name.clone(), worth)
        };
        let peak = |peak: &Peak| match completed(self.coarser[0]) || completed(self.finer) {
            true => {
                Shrinks { least: BETWEEN * peak.missed, ..shrinks }.worth(self.runs(peak.value, &|run| run.peak(peak)))
            }
            false => Worth::default(),
        };
        Worths { quantities: own.quantities.iter().map(of).collect(), peaks: own.peaks.iter().map(peak).collect() }
    }

    fn runs(&self, own: f64, of: &dyn Fn(&WholeRun) -> Option<f64>) -> Runs {
        let value = |run: Option<&WholeRun>| run.and_then(of);
        Runs { own, coarser: self.coarser.map(value), finer: value(self.finer), ..Runs::default() }
    }

    /// The largest differences from run to run of a value at the end, over the last tenth of the runs.
    fn apart(&self, own: &MeasuredQuantity) -> [f64; 2] {
        let of = |run: Option<&'_ WholeRun>| run.and_then(|run| run.late(&own.name)).unwrap_or_default().to_vec();
        let [near, far] = self.coarser.map(of);
        let largest = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        [largest(&own.late, &near).max(largest(&own.late, &of(self.finer))), largest(&near, &far)]
    }

    /// [-] of the motion
    fn motion(&self, own: Option<&Frames>, shrinks: Shrinks) -> Worth {
        let frames = |run: Option<&'_ WholeRun>| run.filter(|run| run.completed()).and_then(|run| run.frames.clone());
        let between = |a: Option<&Frames>, b: Option<&Frames>| {
            let (a, b) = a.zip(b)?;
            Some(Distance::between(a, b).over(a.motion)?[0])
        };
        let [near, far] = self.coarser.map(frames);
        match (between(own, near.as_ref()), between(own, frames(self.finer).as_ref())) {
            (Some(distance), _) => shrinks.of_distances(distance, between(near.as_ref(), far.as_ref())),
            (None, Some(finer)) => {
                let worth = shrinks.worth(Runs { finer: Some(finer), ..Runs::default() });
                Worth { extrapolated: None, ..worth }
            }
            (None, None) => Worth::default(),
        }
    }
}

impl Worths {
    /// Adds the errors to a summary.
    pub fn add_to(&self, summary: &mut Summary) {
        for (peak, worth) in summary.peaks.iter_mut().zip(&self.peaks) {
            peak.error = worth.error;
            let last = self.quantities.get(&format!("{}.{}.last", peak.name, peak.quantity));
            peak.last_error = last.and_then(|worth| worth.error);
        }
        for (name, worth) in &self.quantities {
            let report = summary.quantities.entry(name.clone()).or_default();
            report.error = worth.error;
            worth.known.words().clone_into(&mut report.error_by);
            report.extrapolated = worth.extrapolated;
            if report.unit.is_empty() {
                "-".clone_into(&mut report.unit);
            }
        }
    }
}
