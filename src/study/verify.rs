//! What the numbers of a run are worth: the same run with longer steps beside it, and the step for an accuracy.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use super::error::StudyError;
use super::frames::{Distance, Frames};
use super::prepared_case::PreparedCase;
use super::whole_run::{WholeRun, WholeRunSpec};
use super::worth::{KnownError, Runs, Shrinks, Worth};
use crate::drive::clock::{Step, Tolerance};
use crate::format_number::figures;
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
        let of = |quantity: &MeasuredQuantity| {
            let least = if quantity.is_time { step } else { 0.0 };
            let shrinks = Shrinks { least, ..shrinks };
            let worth = match quantity.value {
                Some(value) => shrinks.worth(self.runs(value, &|run| run.value(&quantity.name))),
                None => self.motion(own.frames, shrinks),
            };
            (quantity.name.clone(), worth)
        };
        let peak = |peak: &Peak| match completed(self.coarser[0]) || completed(self.finer) {
            true => shrinks.worth(self.runs(peak.value, &|run| run.peak(peak))),
            false => Worth::default(),
        };
        Worths {
            quantities: own.quantities.iter().map(of).collect(),
            peaks: own.peaks.iter().map(peak).collect(),
        }
    }

    fn runs(&self, own: f64, of: &dyn Fn(&WholeRun) -> Option<f64>) -> Runs {
        let value = |run: Option<&WholeRun>| run.and_then(of);
        Runs { own, coarser: self.coarser.map(value), finer: value(self.finer) }
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
                let worth = shrinks.worth(Runs { own: 0.0, coarser: [None; 2], finer: Some(finer) });
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

/// How a run's step is changed: doubled `times` times; tolerances times ten.
fn coarser(step: Step, times: i32) -> Step {
    match step {
        Step::Fixed(h) => Step::Fixed(h * 2.0_f64.powi(times)),
        Step::Adaptive(Tolerance { relative, absolute }) => {
            let factor = 10.0_f64.powi(times);
            Step::Adaptive(Tolerance { relative: relative * factor, absolute: absolute * factor })
        }
    }
}

/// A step in words.
pub fn described(step: Step) -> String {
    match step {
        Step::Fixed(h) => format!("step {} s", figures(h, 4)),
        Step::Adaptive(tolerance) => format!("tolerance {:e}", tolerance.relative),
    }
}

/// Makes runs beside others.
pub struct Verifier<'a> {
    /// the case with its scene
    pub prepared: &'a PreparedCase,
    /// whether the motion is asked for
    pub motion: bool,
    /// [s] longest stable step of the method; infinite without one
    pub limit: f64,
    /// set when the user interrupts
    pub interrupt: &'a AtomicBool,
    /// called with each run before it begins
    pub tell: &'a dyn Fn(&str),
}

/// What a verification has made.
#[derive(Debug, Default)]
pub struct Verified {
    /// what the numbers are worth
    pub worths: Worths,
    /// the runs, in words: "step 0.004 s", with what went wrong
    pub beside: Vec<String>,
}

impl Verifier<'_> {
    fn run(&self, step: Step) -> Result<WholeRun, StudyError> {
        (self.tell)(&described(step));
        let problem = &self.prepared.problem;
        WholeRunSpec {
            prepared: self.prepared,
            method: &problem.method,
            step,
            frames: self.motion,
            most_steps: u64::MAX,
            interrupt: self.interrupt,
        }
        .run()
    }

    /// How errors shrink with this kind of steps.
    fn shrinks(&self, step: Step) -> Shrinks {
        let order = self.prepared.problem.method.order();
        match step {
            Step::Fixed(_) => Shrinks::with_steps(order),
            Step::Adaptive(_) => Shrinks::with_tolerance(order),
        }
    }

    /// Whether a run with this step is worth a try.
    fn may_run(&self, step: Step) -> bool {
        match step {
            Step::Fixed(h) => h <= self.prepared.end() && h < self.limit,
            Step::Adaptive(tolerance) => tolerance.relative < 1.0,
        }
    }

    /// Makes runs with twice and four times the step beside a run; where twice the step is not stable or fails, one with
    /// half of it.
    ///
    /// # Errors
    /// An interrupt.
    pub fn verify(&self, own: Numbers<'_>, step: Step, mean_step: f64) -> Result<Verified, StudyError> {
        let mut beside = Vec::new();
        let mut made = |times: i32| -> Result<Option<WholeRun>, StudyError> {
            let step = coarser(step, times);
            if !self.may_run(step) {
                return Ok(None);
            }
            let run = self.run(step)?;
            let went = if run.completed() { String::new() } else { format!(" (failed: {})", run.note) };
            beside.push(described(step) + &went);
            Ok(Some(run).filter(WholeRun::completed))
        };
        let near = made(1)?;
        let far = if near.is_some() { made(2)? } else { None };
        let finer = if near.is_some() { None } else { made(-1)? };
        let runs = Beside { coarser: [near.as_ref(), far.as_ref()], finer: finer.as_ref() };
        let worths = runs.worth(own, self.shrinks(step), mean_step);
        Ok(Verified { worths, beside })
    }
}

/// The accuracy that is asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Accuracy {
    /// [-] share of the value
    Relative(f64),
    /// in a unit
    Absolute(f64, String),
}

impl std::str::FromStr for Accuracy {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let end = text.find(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c))).unwrap_or(text.len());
        let (number, unit) = text.split_at(end);
        let expected = || "expected a share such as 1% or 5e-3, or a number with its unit such as 20N".to_owned();
        let number: f64 = number.trim().parse().map_err(|_| expected())?;
        if !(number > 0.0 && number.is_finite()) {
            return Err(format!("{number} is not above 0"));
        }
        match unit.trim() {
            "%" if number < 100.0 => Ok(Accuracy::Relative(number / 100.0)),
            "" if number < 1.0 => Ok(Accuracy::Relative(number)),
            "" | "%" => Err(format!("{text} is not below the whole value; {}", expected())),
            unit => Ok(Accuracy::Absolute(number, unit.to_owned())),
        }
    }
}

impl std::fmt::Display for Accuracy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Accuracy::Relative(share) => write!(f, "{} %", figures(100.0 * share, 3)),
            Accuracy::Absolute(number, unit) => write!(f, "{} {unit}", figures(*number, 4)),
        }
    }
}

/// [-] Share of the largest magnitude of a series below which a value of it is small.
const SMALL: f64 = 0.01;

impl Accuracy {
    /// The error that a quantity may have. A value that is small beside the largest of its series, as of a vibration that
    /// has died away, is measured by a hundredth of that.
    ///
    /// # Errors
    /// Another unit.
    pub fn allows(&self, quantity: &MeasuredQuantity) -> Result<f64, StudyError> {
        match self {
            Accuracy::Relative(share) => {
                Ok(share * quantity.value.map_or(1.0, |value| value.abs().max(SMALL * quantity.largest)))
            }
            Accuracy::Absolute(number, unit) if *unit == quantity.unit => Ok(*number),
            Accuracy::Absolute(_, unit) => Err(StudyError::Usage(format!(
                "--within {self}: {} is in {}, not in {unit}; name the quantities that are meant with --quantity",
                quantity.name, quantity.unit
            ))),
        }
    }
}

/// A run within an accuracy.
pub struct Within {
    /// the run with the longest step that was found
    pub run: WholeRun,
    /// what its numbers are worth
    pub worths: Worths,
    /// all runs that were made, from coarse to fine, in words
    pub made: Vec<String>,
    /// [s] processor time of all of them
    pub seconds: f64,
}

/// Coarsest run of a search: steps a run.
const COARSEST: f64 = 32.0;
/// How many times a step is halved, or a tolerance divided by ten, below that of the case at most.
const FINEST: i32 = 6;
/// Widest tolerance of a search.
const WIDEST: f64 = 1e-1;

impl Verifier<'_> {
    /// Goes from coarse to fine until all wanted quantities are within the accuracy, by three runs.
    ///
    /// # Errors
    /// An interrupt, another unit, or no such step.
    pub fn within(&self, accuracy: &Accuracy) -> Result<Within, StudyError> {
        let own = self.prepared.problem.time.step;
        let coarse = match own {
            Step::Fixed(h) => (self.prepared.end() / COARSEST / h).log2().floor() as i32,
            Step::Adaptive(tolerance) => (WIDEST / tolerance.relative).log10().floor() as i32,
        };
        let (mut runs, mut made, mut seconds): (Vec<WholeRun>, Vec<String>, f64) = (Vec::new(), Vec::new(), 0.0);
        let mut best = String::new();
        for times in (-FINEST..=coarse.max(-FINEST)).rev() {
            let step = coarser(own, times);
            if !self.may_run(step) {
                continue;
            }
            let run = self.run(step)?;
            seconds += run.seconds;
            made.push(if run.completed() { described(step) } else { format!("{} (failed)", described(step)) });
            if !run.completed() {
                // What coarser runs showed says nothing about this side of the failure.
                runs.clear();
                continue;
            }
            let worths = self.worth_of(&run, &runs);
            let missed = self.missed(&run, &worths, accuracy)?;
            if runs.len() >= 2 && missed.is_none() {
                return Ok(Within { run, worths, made, seconds });
            }
            best = missed.unwrap_or(best);
            runs.push(run);
        }
        let tried = made.last().cloned().unwrap_or_default();
        Err(StudyError::NotWithin { accuracy: accuracy.to_string(), tried, best })
    }

    /// What the numbers of a run are worth beside coarser ones, the coarsest first.
    pub fn worth_of(&self, run: &WholeRun, coarser: &[WholeRun]) -> Worths {
        let mut last = coarser.iter().rev();
        let beside = Beside { coarser: [last.next(), last.next()], finer: None };
        let mean = run.t_end / run.steps.max(1) as f64;
        beside.worth(run.numbers(), self.shrinks(run.step), run.step.fixed().unwrap_or(mean))
    }

    /// The quantity that is farthest from the accuracy, in words; none if all are within it.
    fn missed(&self, run: &WholeRun, worths: &Worths, accuracy: &Accuracy) -> Result<Option<String>, StudyError> {
        let mut worst: Option<(f64, String)> = None;
        for quantity in run.quantities.iter().filter(|quantity| quantity.wanted) {
            let allowed = accuracy.allows(quantity)?;
            let worth = worths.quantities.get(&quantity.name).copied().unwrap_or_default();
            let (times, words) = match worth.error {
                Some(error) => (error / allowed, format!("± {} {}", figures(error, 2), quantity.unit)),
                None if worth.known == KnownError::Contradiction => (f64::INFINITY, "not settled".to_owned()),
                None => (f64::INFINITY, "not known".to_owned()),
            };
            // 0 of 0 is within it.
            let within = times <= 1.0 || worth.error == Some(0.0);
            if !within && worst.as_ref().is_none_or(|(most, _)| times > *most) {
                worst = Some((times, format!("{} {words}", quantity.name)));
            }
        }
        Ok(worst.map(|(_, words)| words))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accuracies_as_typed() {
        assert_eq!("1%".parse(), Ok(Accuracy::Relative(0.01)));
        assert_eq!("5e-3".parse(), Ok(Accuracy::Relative(5e-3)));
        assert_eq!("20N".parse(), Ok(Accuracy::Absolute(20.0, "N".to_owned())));
        assert_eq!("0.1 m/s".parse(), Ok(Accuracy::Absolute(0.1, "m/s".to_owned())));
        assert_eq!("0.5 m/s^2".parse(), Ok(Accuracy::Absolute(0.5, "m/s^2".to_owned())));
        for wrong in ["", "%", "N", "0", "-1%", "2", "100%", "soon"] {
            assert!(wrong.parse::<Accuracy>().is_err(), "{wrong}");
        }
    }
}
