//! What must hold of any bytes as a case file: refused with all faults in their places, or a scene that can be analysed
//! and run.
//!
//! Bytes after a NUL are `--set` assignments, one a line.

use crate::failure::is_true;
use canopy_fem::analysis::limit::critical_step;
use canopy_fem::analysis::spectrum::Spectrum;
use canopy_fem::case::fingerprint::Fingerprint;
use canopy_fem::case::spec::{Problem, SystemSpec};
use canopy_fem::case::{Case, CaseError, Location};
use canopy_fem::drive::clock::Step;
use canopy_fem::drive::observer::{AcceptedStep, Energies, ObserveError, Observer, Point};
use canopy_fem::drive::{self, Outcome, Status};
use canopy_fem::simulation::{bind, build_scene};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// Counts above this are taken modulo it, so that one input stays quick; those no case may have stay, to be refused.
const MOST: u64 = 48;
/// [-] `canopy_fem::mesh::source::MAX_NODES`
const NEVER: u64 = 50_000_000;
/// Scenes of more nodes are read, but not run.
const MOST_NODES: usize = 200;
/// Steps of a run.
const STEPS: f64 = 6.0;
/// Adaptive steps after which a run is stopped.
const MOST_ADAPTIVE: f64 = 12.0;
/// Newton iterations of a step.
const MOST_ITERATIONS: u32 = 25;

/// Reads and runs; `base` is where mesh files are.
///
/// # Errors
/// What does not hold.
pub fn judge(bytes: &[u8], base: &Path) -> Result<(), String> {
    let mut parts = bytes.splitn(2, |b| *b == 0);
    let text = smaller(parts.next().unwrap_or_default());
    let sets = assignments(&smaller(parts.next().unwrap_or_default()));
    match Case::from_bytes(text, "fuzz.json", base.to_owned(), &sets) {
        Ok(case) => good(case),
        Err(error) => refused(&error),
    }
}

/// `key=value` a line, of what is text.
fn assignments(bytes: &[u8]) -> Vec<(String, String)> {
    let text = String::from_utf8_lossy(bytes);
    text.lines().filter_map(|line| line.split_once('=')).map(|(k, v)| (k.to_owned(), v.to_owned())).collect()
}

/// The bytes with every whole number that may be a count made small. Entries of lists are none.
fn smaller(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(bytes.len());
    let mut rest = bytes;
    while let Some((&first, tail)) = rest.split_first() {
        let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
        if digits < 2 {
            out.push(first);
            rest = tail;
            continue;
        }
        let (number, after) = rest.split_at(digits);
        let before = out.trim_ascii_end().last();
        let part = matches!(out.last(), Some(b'.' | b'e' | b'E' | b'+' | b'-'));
        let real = matches!(after.first(), Some(b'.' | b'e' | b'E'));
        let value = std::str::from_utf8(number).ok().and_then(|n| n.parse::<u64>().ok()).unwrap_or(u64::MAX);
        if part || real || matches!(before, Some(b'[' | b',')) || value <= MOST || value > NEVER {
            out.extend_from_slice(number);
        } else {
            out.extend_from_slice((value % MOST).to_string().as_bytes());
        }
        rest = after;
    }
    out
}

fn refused(error: &CaseError) -> Result<(), String> {
    let words = error.to_string();
    if let CaseError::Faults { text, faults, .. } = error {
        if faults.is_empty() {
            return Err(format!("refused without a fault: {words}"));
        }
        for fault in faults {
            if fault.allowed.trim().is_empty() || fault.heading().trim().is_empty() {
                return Err(format!("a fault says nothing: {fault:?}"));
            }
            if let Some(Location::Text { range, line, column }) = &fault.place {
                let lines = text.split('\n').count();
                if text.get(range.clone()).is_none() || *line == 0 || *line > lines || *column == 0 {
                    return Err(format!("a fault is nowhere: {fault:?}"));
                }
            }
        }
        if words.contains("defect of the program") {
            return Err(words);
        }
    }
    if words.split_whitespace().count() < 4 {
        return Err(format!("refused with \"{words}\""));
    }
    Ok(())
}

fn good(case: Case) -> Result<(), String> {
    if case.warnings().iter().any(|w| w.text.split_whitespace().count() < 4) {
        return Err(format!("warnings without a sentence: {:?}", case.warnings()));
    }
    let again = case.with(&[]).map_err(|error| format!("good once, then {error}"))?;
    if again.problem().system != case.problem().system {
        return Err("the same case makes two systems".to_owned());
    }
    let mut problem = case.into_problem();
    Fingerprint::of(&problem).map_err(|error| error.to_string())?;
    let nodes = match &problem.system {
        SystemSpec::Network(spec) => spec.mesh.nodes.len(),
        SystemSpec::Pendulum(_) => 1,
    };
    if nodes > MOST_NODES {
        return Ok(());
    }
    analysed(&problem)?;
    if let Step::Fixed(step) = problem.time.step {
        problem.time.end = problem.time.end.min(STEPS * step);
    }
    problem.solver.newton.max_iterations = problem.solver.newton.max_iterations.min(MOST_ITERATIONS);
    run(&problem, nodes)
}

/// What `check` asks of a scene.
fn analysed(problem: &Problem) -> Result<(), String> {
    let Ok(scene) = build_scene(problem.system.clone(), 1) else { return Ok(()) };
    let scene = &*scene;
    if let Err(error) = bind(problem, scene) {
        return if error.to_string().split_whitespace().count() < 4 { Err(error.to_string()) } else { Ok(()) };
    }
    let rates = Spectrum::of(scene, scene.initial_state().as_ref()).rates();
    if !(rates.frequency >= 0.0 && rates.damping >= 0.0) {
        return Err(format!("{rates:?}"));
    }
    let step = critical_step(&problem.method, rates);
    if step.is_nan() || step < 0.0 {
        return Err(format!("a critical step of {step} s from {rates:?}"));
    }
    Ok(())
}

fn run(problem: &Problem, nodes: usize) -> Result<(), String> {
    let Ok(scene) = build_scene(problem.system.clone(), 1) else { return Ok(()) };
    let Ok(mut stepper) = bind(problem, &*scene) else { return Ok(()) };
    let stop = AtomicBool::new(false);
    let mut look = Look { finite: true, stop: &stop };
    let outcome = drive::run(&*scene, &mut stepper, &problem.run_spec(), &mut [&mut look], &stop);
    let finite = look.finite;
    let outcome = match outcome {
        Ok(outcome) => outcome,
        Err(error) if error.to_string().split_whitespace().count() >= 4 => return Ok(()),
        Err(error) => return Err(format!("cannot start: \"{error}\"")),
    };
    if !finite {
        return Err(format!("{:?} with values that are not finite", outcome.status));
    }
    account(&outcome)?;
    match (outcome.status, &outcome.failure) {
        (Status::Completed, None) if outcome.t_end == problem.time.end => Ok(()),
        (Status::Interrupted, None) if outcome.steps as f64 >= MOST_ADAPTIVE => Ok(()),
        (Status::Diverged | Status::NotConverged, Some(failure)) => is_true(failure, &outcome, nodes),
        (status, failure) => Err(format!("{status:?} at {} s with {failure:?}", outcome.t_end)),
    }
}

/// Looks at every state, and stops a run of many adaptive steps.
struct Look<'a> {
    finite: bool,
    stop: &'a AtomicBool,
}

impl Look<'_> {
    fn at(&mut self, at: &Point) {
        let state = &at.state;
        self.finite &= state.t.is_finite() && state.x.iter().chain(&state.v).all(|x| x.is_finite());
    }
}

impl Observer for Look<'_> {
    fn started(&mut self, at: &Point, _ledger: Energies) -> Result<(), ObserveError> {
        self.at(at);
        Ok(())
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.at(step.end.expect("wanted"));
        self.stop.store(step.step as f64 >= MOST_ADAPTIVE, Ordering::Relaxed);
        Ok(())
    }
}

fn account(outcome: &Outcome) -> Result<(), String> {
    let row = outcome.ledger;
    let energies = [row.kinetic, row.elastic, row.gravity, row.external_work, row.dissipated, row.numerical];
    if energies.iter().chain([&outcome.energy_error]).all(|e| e.is_finite()) {
        return Ok(());
    }
    Err(format!("the account is not finite: {row:?}, error {}", outcome.energy_error))
}
