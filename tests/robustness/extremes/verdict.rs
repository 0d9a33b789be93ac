//! Runs a case with a guard against panics and hangs, and judges how it ended.

use crate::failure::is_true;
use canopy_fem::case::spec::SystemSpec;
use canopy_fem::case::{Case, CaseError, Problem};
use canopy_fem::drive::observer::Energies;
use canopy_fem::drive::{Outcome, Status};
use canopy_fem::simulation::{FollowSpec, follow};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::mpsc;
use std::time::Duration;

/// What a run of at most fifty steps on a few dozen nodes may take, by far.
const HANG: Duration = Duration::from_secs(30);

/// Steps that a hostile case may have: the whole table is run with every method.
const MOST_STEPS: u64 = 50;

/// A numerical gain beyond this many times the energy otherwise exchanged is nonsense, by the project's own rule.
const GAIN: f64 = 10.0;

/// The program warns of an energy error above this when the scheme has made energy (`cli/solve`).
const WARNED: f64 = 0.1;

/// How an attempt ended, in the user's words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Completed,
    /// completed, but with a warning that the scheme has made energy
    Doubted,
    Diverged,
    NotConverged,
    Refused,
}

/// How an attempt ended.
pub enum End {
    /// at reading, or when the scheme was to start
    Refused(String),
    Ran(Box<Ran>),
    Panicked(String),
    Hung,
}

impl End {
    /// What a user reads.
    pub fn words(&self) -> String {
        match self {
            End::Refused(words) | End::Panicked(words) => words.clone(),
            End::Ran(ran) => match &ran.outcome.failure {
                Some(f) => format!("step {}: {}; {}", f.step, f.cause, f.advice),
                None => format!("energy error {:.1e}", ran.outcome.energy_error),
            },
            End::Hung => "hung".to_owned(),
        }
    }
}

/// A run and what it left.
pub struct Ran {
    pub problem: Problem,
    pub outcome: Outcome,
    pub reference: Vec<[f64; 3]>,
    pub positions: Vec<[f64; 3]>,
    pub velocities: Vec<[f64; 3]>,
    /// account at the start
    first: Energies,
    /// [J] the most energy that was there or went in or out, the scheme's own gains apart
    otherwise: f64,
    /// [J] largest numerical gain
    gain: f64,
}

/// Reads and runs a case on a thread of its own.
pub fn attempt(json: &serde_json::Value, sets: &[(String, String)]) -> End {
    attempt_within(HANG, json, sets)
}

/// The same for a case that may take longer than most.
pub fn attempt_within(patience: Duration, json: &serde_json::Value, sets: &[(String, String)]) -> End {
    let (text, sets) = (json.to_string(), sets.to_vec());
    let (send, receive) = mpsc::channel();
    std::thread::spawn(move || {
        let end = catch_unwind(AssertUnwindSafe(|| run(text, &sets)));
        let end = end.unwrap_or_else(|panic| {
            let words = panic.downcast_ref::<String>().cloned();
            End::Panicked(words.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned())).unwrap_or_default())
        });
        // Nobody listens any more after a hang.
        let _ = send.send(end);
    });
    receive.recv_timeout(patience).unwrap_or(End::Hung)
}

fn run(text: String, sets: &[(String, String)]) -> End {
    let case = match Case::from_text(text, "hostile.json", PathBuf::new(), sets) {
        Ok(case) => case,
        Err(error @ CaseError::Faults { .. }) => return End::Refused(error.to_string()),
        Err(error) => panic!("the table is wrong: {error}"),
    };
    let problem = case.into_problem();
    let (mut reference, mut positions, mut velocities) = (Vec::new(), Vec::new(), Vec::new());
    let (mut first, mut otherwise, mut gain) = (None, 0.0_f64, 0.0_f64);
    let outcome = follow(&problem, FollowSpec::default(), |seen| {
        reference.clear();
        reference.extend_from_slice(seen.reference);
        positions.clear();
        positions.extend_from_slice(seen.positions);
        velocities.clear();
        velocities.extend_from_slice(seen.velocities);
        let (row, start) = (seen.ledger, *first.get_or_insert(seen.ledger));
        let exchanged = [row.external_work, row.gravity - start.gravity, row.dissipated, start.kinetic + start.elastic];
        otherwise = exchanged.iter().fold(otherwise, |most, e| most.max(e.abs()));
        gain = gain.max(-row.numerical);
    });
    match outcome {
        Ok(outcome) => {
            let first = first.expect("the start is shown");
            End::Ran(Box::new(Ran { problem, outcome, reference, positions, velocities, first, otherwise, gain }))
        }
        Err(error) => End::Refused(error.to_string()),
    }
}

/// What must hold however a run ends.
pub fn judge(end: &End) -> Result<Kind, String> {
    match end {
        End::Panicked(words) => Err(format!("panicked: {words}")),
        End::Hung => Err("still at it when patience ended".to_owned()),
        End::Refused(words) if words.trim().is_empty() => Err("refused without a word".to_owned()),
        End::Refused(_) => Ok(Kind::Refused),
        End::Ran(ran) => ran.judge(),
    }
}

impl Ran {
    fn judge(&self) -> Result<Kind, String> {
        if self.outcome.steps > MOST_STEPS {
            return Err(format!("the table is wrong: {} steps", self.outcome.steps));
        }
        if !self.positions.iter().chain(&self.velocities).flatten().all(|x| x.is_finite()) {
            return Err("the last good state is not finite".to_owned());
        }
        let row = self.outcome.ledger;
        let energies = [row.kinetic, row.elastic, row.gravity, row.external_work, row.dissipated, row.numerical];
        if !energies.iter().chain([&self.outcome.energy_error]).all(|e| e.is_finite()) {
            return Err(format!("the account is not finite: {row:?}, error {}", self.outcome.energy_error));
        }
        match (self.outcome.status, &self.outcome.failure) {
            (Status::Completed, None) => self.completed(),
            (Status::Diverged, Some(failure)) => {
                is_true(failure, &self.outcome, self.reference.len()).map(|()| Kind::Diverged)
            }
            (Status::NotConverged, Some(failure)) => {
                is_true(failure, &self.outcome, self.reference.len()).map(|()| Kind::NotConverged)
            }
            (status, failure) => Err(format!("{status:?} with {failure:?}")),
        }
    }

    fn completed(&self) -> Result<Kind, String> {
        let end = self.problem.time.end;
        if self.outcome.t_end != end {
            return Err(format!("completed at {} s, the end is {end} s", self.outcome.t_end));
        }
        let allowed = GAIN * self.otherwise + self.rounding();
        if self.gain > allowed && self.outcome.energy_made > WARNED {
            return Ok(Kind::Doubted);
        }
        if self.gain > allowed {
            return Err(format!(
                "completed with a numerical gain of {:.3e} J where {:.3e} J were exchanged otherwise and rounding explains \
                 {:.3e} J (from {:.3e} J)",
                self.gain,
                self.otherwise,
                self.rounding(),
                self.first.kinetic + self.first.elastic
            ));
        }
        Ok(Kind::Completed)
    }

    /// [J] Energy that positions rounded to their last digits put into the springs, and sums of energies lose.
    fn rounding(&self) -> f64 {
        let spec = match &self.problem.system {
            SystemSpec::Network(spec) => spec,
            SystemSpec::Pendulum(p) => {
                // An angle that moves by less than its last digit is not moved by its weight, which is then at work in
                // the account.
                let moment = p.mass * p.gravity * p.length;
                return 8.0 * f64::EPSILON * moment * p.angle.abs().max(1.0) * (1 + self.outcome.steps) as f64;
            }
        };
        let largest = self.positions.iter().chain(&self.reference).flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
        let off = 4.0 * f64::EPSILON * largest;
        let springs =
            spec.springs.iter().flat_map(|g| g.stiffness.of(g.edges.len())).map(|k| k * off * off).sum::<f64>();
        springs * (1 + self.outcome.steps) as f64 + 1e-12 * self.outcome.ledger.kinetic
    }
}
