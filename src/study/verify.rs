//! What the numbers of a run are worth: the same run with longer steps beside it, and the step for an accuracy.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use super::accuracy::Accuracy;
use super::beside::{Beside, Numbers, Worths};
use super::error::StudyError;
use super::prepared_case::PreparedCase;
use super::whole_run::{WholeRun, WholeRunSpec};
use super::worth::{KnownError, Shrinks};
use crate::drive::clock::{Step, Tolerance};
use crate::format_number::figures;

/// How a run's step is changed: doubled `times` times; tolerances times ten.
pub fn coarser(step: Step, times: i32) -> Step {
    match step {
        Step::Fixed(h) => Step::Fixed(h * 2.0_f64.powi(times)),
        Step::Adaptive(Tolerance { relative, absolute }) => {
            // Ten times 1e-6 is told as 1e-5.
            let times_ten = |tolerance: f64| {
                let product = tolerance * 10.0_f64.powi(times);
                format!("{product:.12e}").parse().unwrap_or(product)
            };
            Step::Adaptive(Tolerance { relative: times_ten(relative), absolute: times_ten(absolute) })
        }
    }
}

/// Most frames of a run that are kept where its motion is not asked for.
const FRAMES: f64 = 50.0;

/// [s] Interval of the frames by which the motions of the runs of a case are compared: its own, or a longer one where
/// the motion is not asked for.
pub fn compared_every(prepared: &PreparedCase, asked: bool) -> f64 {
    if asked { prepared.every } else { prepared.every.max(prepared.end() / FRAMES) }
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
    /// [s] interval of the frames by which motions are compared
    pub frames: f64,
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
    fn run(&self, step: Step, most_work: u64) -> Result<WholeRun, StudyError> {
        (self.tell)(&described(step));
        let problem = &self.prepared.problem;
        WholeRunSpec {
            scene: &*self.prepared.scene,
            problem,
            every: self.prepared.every,
            end: self.prepared.end(),
            method: &problem.method,
            step,
            frames: Some(self.frames),
            most_work,
            enough: None,
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

    /// Makes runs with twice and four times the step beside a run; where twice the step is not stable or fails, one
    /// with half of it.
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
            let run = self.run(step, u64::MAX)?;
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

/// Whether a run is within an accuracy.
enum Judged {
    Within,
    /// by what it misses it, in words
    Missed(String),
}

/// A run within an accuracy.
pub struct Within {
    /// the cheapest run within it that was found
    pub run: WholeRun,
    /// what its numbers are worth
    pub worths: Worths,
    /// all runs that were made, in words
    pub made: Vec<String>,
    /// [s] processor time of all of them
    pub seconds: f64,
}

/// How many times a step is halved, or a tolerance divided by ten, below that of the case at most.
const FINEST: i32 = 6;

/// The runs of a search, by how many times the step of the case was doubled. `None`: the run was not made, as its step
/// is too long; a run that did not come to its end was.
type Ladder = BTreeMap<i32, Option<WholeRun>>;

impl Verifier<'_> {
    /// Goes from the case's own step to longer ones while that saves work, or to shorter ones until all wanted
    /// quantities are within the accuracy. Every number is judged by three runs where they come to their ends.
    ///
    /// # Errors
    /// An interrupt, another unit, or no such step.
    pub fn within(&self, accuracy: &Accuracy) -> Result<Within, StudyError> {
        let (mut ladder, mut made, mut missed) = (Ladder::new(), Vec::new(), String::new());
        let mut found = None;
        for times in (-FINEST..=0).rev() {
            match self.judged(times, u64::MAX, accuracy, &mut ladder, &mut made)? {
                Judged::Within => {
                    found = Some(times);
                    break;
                }
                Judged::Missed(words) => missed = words,
            }
        }
        let Some(mut best) = found else {
            let tried = described(coarser(self.prepared.problem.time.step, -FINEST));
            return Err(StudyError::NotWithin { accuracy: accuracy.to_string(), tried, best: missed });
        };
        let work = |ladder: &Ladder, times: i32| match ladder.get(&times) {
            Some(Some(run)) if run.completed() => run.work(),
            _ => u64::MAX,
        };
        // Longer steps that need as much work are of no use.
        for times in best + 1.. {
            let most = work(&ladder, best);
            if work(&ladder, times) >= most && ladder.contains_key(&times) {
                break;
            }
            match self.judged(times, most, accuracy, &mut ladder, &mut made)? {
                Judged::Within if work(&ladder, times) < most => best = times,
                _ => break,
            }
        }
        let worths = self.worths(best, &ladder);
        let seconds = ladder.values().flatten().map(|run| run.seconds).sum();
        match ladder.remove(&best).flatten() {
            Some(run) => Ok(Within { run, worths, made, seconds }),
            None => Err(StudyError::Interrupted),
        }
    }

    /// Makes the runs that judge one, each with at most this work, and says whether it is within the accuracy.
    fn judged(
        &self,
        times: i32,
        most: u64,
        accuracy: &Accuracy,
        ladder: &mut Ladder,
        made: &mut Vec<String>,
    ) -> Result<Judged, StudyError> {
        for times in times..=times + 2 {
            if ladder.contains_key(&times) {
                continue;
            }
            let step = coarser(self.prepared.problem.time.step, times);
            let run = if self.may_run(step) { Some(self.run(step, most)?) } else { None };
            if let Some(run) = &run {
                let ended = if run.completed() { "" } else { " (not to its end)" };
                made.push(described(step) + ended);
            }
            ladder.insert(times, run);
        }
        match ladder.get(&times) {
            Some(Some(run)) if run.completed() => match self.missed(run, &self.worths(times, ladder), accuracy)? {
                None => Ok(Judged::Within),
                Some(words) => Ok(Judged::Missed(words)),
            },
            _ => Ok(Judged::Missed("the run does not come to its end".to_owned())),
        }
    }

    /// What the numbers of a run of a ladder are worth.
    fn worths(&self, times: i32, ladder: &Ladder) -> Worths {
        let completed = |times: i32| ladder.get(&times).and_then(Option::as_ref).filter(|run| run.completed());
        let near = completed(times + 1);
        let beside = Beside {
            coarser: [near, near.and_then(|_| completed(times + 2))],
            finer: completed(times - 1).filter(|_| near.is_none()),
        };
        completed(times).map_or_else(Worths::default, |run| {
            let mean = run.t_end / run.steps.max(1) as f64;
            beside.worth(run.numbers(), self.shrinks(run.step), run.step.fixed().unwrap_or(mean))
        })
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
