//! Many runs at once, in memory.

use crate::arrays::{of_list, of_rows, read_only};
use crate::case::{Case, scene_of};
use crate::errors::of_record;
use crate::interrupt::pooled;
use crate::record::checked_threads;
use crate::values::{Energies, from_json};
use canopy_fem::case::Case as EngineCase;
use canopy_fem::case::spec::Problem;
use canopy_fem::drive::at_rest::AtRest;
use canopy_fem::drive::observer::{self, AcceptedStep, ObserveError, Observer, Point, UpcomingStep, Wants};
use canopy_fem::drive::{Failure, Outcome, Status};
use canopy_fem::scene::Scene;
use canopy_fem::simulation::{RecordError, RunSpec, Simulation, SimulationError};
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// A run of a rollout: what was seen of it, and how it ended.
#[pyclass(module = "canopy_fem", frozen)]
#[derive(Serialize, Deserialize)]
pub struct Rollout {
    seen: Seen,
    outcome: End,
}

/// How a run ended.
#[derive(Serialize, Deserialize)]
struct End {
    status: Status,
    steps: u64,
    /// [s]
    t_end: f64,
    ledger: observer::Energies,
    energy_error: f64,
    failure: Option<Failure>,
}

impl Rollout {
    /// Of which nothing was kept here.
    pub(crate) fn ended(outcome: Outcome) -> Self {
        Rollout { seen: Seen::default(), outcome: outcome.into() }
    }
}

impl From<Outcome> for End {
    fn from(outcome: Outcome) -> Self {
        let Outcome { status, steps, t_end, ledger, energy_error, failure, .. } = outcome;
        End { status, steps, t_end, ledger, energy_error, failure }
    }
}

/// What is kept of a run.
#[derive(Default, Serialize, Deserialize)]
struct Seen {
    /// [s] `[n_times]`
    t: Vec<f64>,
    /// [m], [m/s] `[n_times * n_nodes][3]`
    positions: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    nodes: usize,
}

#[pymethods]
impl Rollout {
    /// [s] times of the states that were kept, (k,)
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        of_list(py, self.seen.t.clone())
    }

    /// [m] positions then, (k, n, 3)
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        of_rows(py, self.seen.positions.clone())?.reshape([self.seen.t.len(), self.seen.nodes, 3]).map(read_only)
    }

    /// [m/s] velocities then, (k, n, 3)
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        of_rows(py, self.seen.velocities.clone())?.reshape([self.seen.t.len(), self.seen.nodes, 3]).map(read_only)
    }

    /// "completed", "diverged" or "not-converged"
    #[getter]
    fn status<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        from_json(py, &self.outcome.status)
    }

    /// accepted steps
    #[getter]
    fn steps(&self) -> u64 {
        self.outcome.steps
    }

    /// [s] time of the last state
    #[getter]
    fn t_end(&self) -> f64 {
        self.outcome.t_end
    }

    /// energy account at the end
    #[getter]
    fn energies(&self) -> Energies {
        self.outcome.ledger.into()
    }

    /// [-] energy that the scheme made or lost, over the largest energy exchanged
    #[getter]
    fn energy_error(&self) -> f64 {
        self.outcome.energy_error
    }

    /// what went wrong, as a dictionary; None if nothing did
    #[getter]
    fn failure<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.outcome.failure.as_ref().map(|failure| from_json(py, failure)).transpose()
    }

    /// For copies and pickles.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let bytes = postcard::to_stdvec(self).map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok((py.import("canopy_fem._core")?.getattr("_rollout_of")?, (PyBytes::new(py, &bytes),)))
    }

    fn __repr__(&self) -> String {
        let End { status, steps, t_end, .. } = &self.outcome;
        format!("<Rollout: {status:?} at t = {t_end} s after {steps} steps, {} states>", self.seen.t.len())
    }
}

/// Keeps states of some nodes.
struct Keeper<'a> {
    scene: &'a dyn Scene,
    /// all if empty
    nodes: &'a [u32],
    /// [s]
    every: Option<f64>,
    /// number of the next multiple of `every`
    next: f64,
    positions: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    seen: Seen,
}

impl Keeper<'_> {
    fn keep(&mut self, at: &Point) {
        let Keeper { scene, nodes, positions, velocities, seen, .. } = self;
        scene.trace(at.state.as_ref(), positions, velocities);
        let wanted = |all: &[[f64; 3]]| -> Vec<[f64; 3]> {
            if nodes.is_empty() { all.to_vec() } else { nodes.iter().map(|&node| all[node as usize]).collect() }
        };
        seen.t.push(at.state.t);
        seen.positions.extend(wanted(positions));
        seen.velocities.extend(wanted(velocities));
    }

    /// Whether a step that ends at `t` [s] reaches the next multiple, up to rounding.
    fn due(&self, t: f64) -> bool {
        self.every.is_some_and(|every| t >= self.next * every * (1.0 - 1e-12))
    }
}

impl Observer for Keeper<'_> {
    fn started(&mut self, at: &Point, _ledger: observer::Energies) -> Result<(), ObserveError> {
        self.keep(at);
        Ok(())
    }

    fn wants(&self, next: UpcomingStep) -> Wants {
        Wants::end_if(self.due(next.t))
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        if let (true, Some(end), Some(every)) = (self.due(step.t), step.end, self.every) {
            self.keep(end);
            self.next = (step.t / every * (1.0 + 1e-12)).floor() + 1.0;
        }
        Ok(())
    }

    fn finished(&mut self, last: &Point) -> Result<(), ObserveError> {
        if self.seen.t.last().is_none_or(|t| *t != last.state.t) {
            self.keep(last);
        }
        Ok(())
    }
}

/// What to keep of every run.
#[derive(Clone, Copy)]
struct Kept<'a> {
    nodes: &'a [u32],
    every: Option<f64>,
}

/// As a case runs to its end with its files.
pub(crate) fn run_spec(problem: &Problem) -> RunSpec {
    RunSpec { ends_by_event: problem.time.to_ground, ..problem.run_spec() }
}

fn run(case: &EngineCase, kept: Kept<'_>, stop: &AtomicBool) -> Result<Rollout, RecordError> {
    let problem = case.problem();
    let scene = scene_of(case, 1)?;
    let n = scene.reference().len();
    if let Some((place, &node)) = kept.nodes.iter().enumerate().find(|(_, node)| **node as usize >= n) {
        return Err(SimulationError::NoNode { what: "nodes: place", place, node, nodes: n }.into());
    }
    let mut simulation = Simulation::from_scene(&*scene, run_spec(problem))?;
    let scene = simulation.scene();
    let Kept { nodes, every } = kept;
    let seen = Seen { nodes: if nodes.is_empty() { n } else { nodes.len() }, ..Seen::default() };
    let (positions, velocities) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
    let mut keeper = Keeper { scene: &*scene, nodes, every, next: 1.0, positions, velocities, seen };
    let mut rest = problem.time.until_rest.map(|rest| AtRest::new(&*scene, rest, problem.time.end));
    let mut all: Vec<&mut dyn Observer> = vec![&mut keeper];
    all.extend(rest.as_mut().map(|rest| rest as &mut dyn Observer));
    let outcome = simulation.run(&mut all, stop)?;
    Ok(Rollout { seen: keeper.seen, outcome: outcome.into() })
}

/// The run of a rollout that a pickle holds.
#[pyfunction]
pub(crate) fn _rollout_of(bytes: &[u8]) -> PyResult<Rollout> {
    postcard::from_bytes(bytes).map_err(|error| PyValueError::new_err(format!("these bytes are no rollout: {error}")))
}

/// Runs cases on a pool of threads, one case a thread.
#[pyfunction]
#[pyo3(signature = (cases, *, threads, nodes, every))]
pub(crate) fn rollout(
    py: Python<'_>,
    cases: Vec<Bound<'_, Case>>,
    threads: usize,
    nodes: Option<Vec<u32>>,
    every: Option<f64>,
) -> PyResult<Vec<Rollout>> {
    let threads = checked_threads(threads)?.min(cases.len().max(1));
    if every.is_some_and(|every| !(every > 0.0 && every.is_finite())) {
        return Err(PyValueError::new_err("every must be a time [s] above 0"));
    }
    if nodes.as_ref().is_some_and(Vec::is_empty) {
        return Err(PyValueError::new_err("nodes is empty: name nodes, or give None for all"));
    }
    let cases: Vec<Arc<EngineCase>> = cases.iter().map(|case| case.get().case.clone()).collect();
    let (nodes, next) = (nodes.unwrap_or_default(), AtomicUsize::new(0));
    let kept = Kept { nodes: &nodes, every };
    let work = |stop: &AtomicBool| {
        let mut done = Vec::new();
        while let Some((number, case)) = take(&next, &cases, stop) {
            done.push((number, run(case, kept, stop)));
        }
        done
    };
    let done = pooled(py, threads, work, |_| Ok(()))?;
    let mut done: Vec<(usize, Result<Rollout, RecordError>)> = done.into_iter().flatten().collect();
    done.sort_by_key(|(number, _)| *number);
    done.into_iter().map(|(_, result)| result.map_err(|error| of_record(py, error))).collect()
}

fn take<'a, T>(next: &AtomicUsize, cases: &'a [T], stop: &AtomicBool) -> Option<(usize, &'a T)> {
    let number = next.fetch_add(1, Ordering::Relaxed);
    cases.get(number).filter(|_| !stop.load(Ordering::Relaxed)).map(|case| (number, case))
}
