//! One run, and what a table tells of it.

use crate::fixture::figure::after;
use canopy_fem::case::Case;
use canopy_fem::drive::observer::{AcceptedStep, ObserveError, Observer, Wants};
use canopy_fem::drive::{Outcome, Status};
use canopy_fem::process::cpu_seconds;
use canopy_fem::simulation::Simulation;
use serde_json::Value;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

/// The case of a table's row.
pub fn case_of(json: &Value) -> Case {
    Case::from_text(json.to_string(), "row", PathBuf::new(), &[]).unwrap_or_else(|fault| panic!("{json}\n{fault}"))
}

/// Adds a slack law to a rule of springs, unless they act both ways.
pub fn with_slack(mut rule: Value, law: &str) -> Value {
    if law != "both ways" {
        rule["slack"] = law.into();
    }
    rule
}

/// [s] Processor time after which a run is stopped.
fn limit() -> f64 {
    after("--limit").map_or(60.0, |word| word.parse().expect("--limit wants seconds"))
}

/// [s] processor time of this process
fn cpu() -> f64 {
    cpu_seconds().expect("a system that tells the processor time")
}

/// What `work` gives, and its processor time [s]. It is told to stop at the limit; `None` if it has not at twice that.
pub fn within<T: Send + 'static>(work: impl FnOnce(&AtomicBool) -> T + Send + 'static) -> Option<(T, f64)> {
    let stop = Arc::new(AtomicBool::new(false));
    let (send, receive) = mpsc::channel();
    let (flag, limit, began) = (stop.clone(), limit(), cpu());
    std::thread::spawn(move || {
        // Nobody waits any longer for one that is late.
        _ = send.send(work(&flag));
    });
    loop {
        match receive.recv_timeout(Duration::from_millis(50)) {
            Ok(made) => return Some((made, cpu() - began)),
            Err(RecvTimeoutError::Disconnected) => return None,
            Err(RecvTimeoutError::Timeout) if cpu() - began > 2.0 * limit => return None,
            Err(RecvTimeoutError::Timeout) => stop.store(cpu() - began > limit, Ordering::Relaxed),
        }
    }
}

/// How a run has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum End {
    Completed,
    /// diverged, with the method's energy as the cause
    EnergyMade,
    /// diverged, for another cause
    Diverged,
    /// an implicit step was not solved
    NotSolved,
    /// stopped at the limit
    TooLong,
    /// no answer at twice the limit
    Stuck,
}

impl End {
    pub fn words(self) -> &'static str {
        match self {
            End::Completed => "completed",
            End::EnergyMade => "energy made",
            End::Diverged => "diverged",
            End::NotSolved => "not solved",
            End::TooLong => "too long",
            End::Stuck => "stuck",
        }
    }
}

/// For a table: how many factorisations were made by LU, if any.
pub fn by_lu(count: u64) -> String {
    if count > 0 { format!(" ({count} LU)") } else { String::new() }
}

/// A run in numbers.
#[derive(Debug)]
pub struct Row {
    pub end: End,
    /// of the failure or the warning
    pub words: String,
    /// [s] reached
    pub t: f64,
    pub steps: u64,
    /// Newton iterations of a step: mean and most
    pub mean: f64,
    pub most: u32,
    pub factors: u64,
    /// those of them by LU
    pub lu: u64,
    /// [s]
    pub seconds: f64,
    /// [-] largest energy made by the method over all that was present or supplied
    pub made: f64,
    /// [-] error of the account
    pub error: f64,
    /// [-] error of M (v1 - v0)/h = f(x1, v1) over the largest force, in the worst step of backward Euler
    pub unbalanced: f64,
}

impl Row {
    /// For a table: iterations (mean, most), factorisations and time, or why it has ended.
    pub fn cell(&self) -> String {
        let Row { end, t, mean, most, factors, seconds, .. } = self;
        let lu = by_lu(self.lu);
        match end {
            End::Completed => format!("{mean:.1}, {most}; {factors}{lu}; {seconds:.2} s"),
            _ => format!("**{}** at {t:.3} s; {mean:.1}, {most}; {factors}{lu}; {seconds:.1} s", end.words()),
        }
    }
}

/// What is seen on the way.
#[derive(Default)]
struct Watch {
    most: u32,
    /// of backward Euler: whether its equation is checked, 1/m of every degree of freedom, and its worst error
    inverse_mass: Option<Vec<f64>>,
    unbalanced: f64,
}

impl Observer for Watch {
    fn wants(&self, _: canopy_fem::drive::observer::UpcomingStep) -> Wants {
        if self.inverse_mass.is_some() { Wants::default() } else { Wants::ACCOUNT }
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.most = self.most.max(step.newton_iterations);
        let (Some(inverse), Some([from, to])) = (&self.inverse_mass, step.ends()) else { return Ok(()) };
        // What Newton's tolerance is a share of: dashpots may pull far more than is left of their forces.
        let dashpots = [from, to].into_iter().flat_map(|point| &point.forces.dissipative);
        let (mut largest, mut error) = (dashpots.fold(0.0, |most: f64, f| most.max(f.abs())), 0.0_f64);
        for (i, inverse) in inverse.iter().enumerate().filter(|(_, inverse)| **inverse > 0.0) {
            let inertia = (to.state.v[i] - from.state.v[i]) / (step.h() * inverse);
            let force = to.forces.total[i];
            largest = largest.max(force.abs()).max(inertia.abs()).max(9.81 / inverse);
            error = error.max((inertia - force).abs());
        }
        self.unbalanced = self.unbalanced.max(error / largest);
        Ok(())
    }
}

/// Runs a case to its end or to the limit. The equation of backward Euler is checked if `check`.
pub fn row(json: &Value, check: bool) -> Row {
    let case = case_of(json);
    let ended = within(move |stop| {
        let mut simulation = Simulation::from_case(case.problem(), 1).unwrap_or_else(|fault| panic!("{fault}"));
        let inverse_mass = check.then(|| simulation.scene().inverse_mass().to_vec());
        let mut watch = Watch { inverse_mass, ..Watch::default() };
        let outcome = simulation.run(&mut [&mut watch], stop).unwrap_or_else(|fault| panic!("{fault}"));
        (outcome, watch)
    });
    match ended {
        Some(((outcome, watch), seconds)) => told(outcome, &watch, seconds),
        None => Row {
            end: End::Stuck,
            words: "no answer".to_owned(),
            t: 0.0,
            steps: 0,
            mean: f64::NAN,
            most: 0,
            factors: 0,
            lu: 0,
            seconds: f64::NAN,
            made: f64::NAN,
            error: f64::NAN,
            unbalanced: f64::NAN,
        },
    }
}

fn told(outcome: Outcome, watch: &Watch, seconds: f64) -> Row {
    let warned = outcome.doubt.clone().or_else(|| outcome.energy_doubt());
    let words = outcome.failure.map(|failure| failure.cause).or(warned).unwrap_or_default();
    let end = match outcome.status {
        Status::Completed => End::Completed,
        Status::Interrupted => End::TooLong,
        Status::NotConverged => End::NotSolved,
        Status::Diverged if words.contains("itself has made") => End::EnergyMade,
        Status::Diverged => End::Diverged,
    };
    Row {
        end,
        words,
        t: outcome.t_end,
        steps: outcome.steps,
        mean: outcome.counters.newton_iterations as f64 / outcome.steps.max(1) as f64,
        most: watch.most,
        factors: outcome.counters.factorizations,
        lu: outcome.counters.lu_factorizations,
        seconds,
        made: outcome.energy_made,
        error: outcome.energy_error,
        unbalanced: watch.unbalanced,
    }
}
