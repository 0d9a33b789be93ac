//! Runs of a rollout at the same times, in arrays, with what a program sets on the way.

use crate::actions::{Action, Acts, Place, Sites};
use crate::case::{Case, own_scene, scene_of};
use crate::errors::of_record;
use crate::interrupt::pooled;
use crate::record::{TOLD_EVERY, checked_threads};
use crate::rollout::{Rollout, run_spec};
use canopy_fem::case::spec::Problem;
use canopy_fem::case::{Case as EngineCase, CaseError};
use canopy_fem::output::samples::{SampleArrays, SampleSpec, Samples};
use canopy_fem::scene::Scene;
use canopy_fem::simulation::{RecordError, Simulation, SimulationError};
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyReadwriteArrayDyn};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// What all runs begin with.
#[derive(Default)]
struct Initial {
    /// [m], [m/s] of all runs, `[runs * n_nodes][3]`
    positions: Option<Vec<[f64; 3]>>,
    velocities: Option<Vec<[f64; 3]>>,
    /// one for all runs or one each
    snapshots: Vec<Vec<u8>>,
}

impl Initial {
    fn begin(&self, simulation: &mut Simulation, run: usize) -> Result<(), SimulationError> {
        if let Some(bytes) = self.snapshots.get(if self.snapshots.len() == 1 { 0 } else { run }) {
            simulation.restore(bytes)?;
        }
        if self.positions.is_none() && self.velocities.is_none() {
            return Ok(());
        }
        let n = simulation.node_count();
        let own = |given: Option<&Vec<[f64; 3]>>, now: Vec<[f64; 3]>| match given {
            Some(all) => all.get(run * n..(run + 1) * n).map(<[_]>::to_vec).unwrap_or_default(),
            None => now,
        };
        let (x, v) = (simulation.positions(), simulation.velocities());
        simulation.set_state(&own(self.positions.as_ref(), x), &own(self.velocities.as_ref(), v))
    }
}

/// A run that is to be made.
struct Job<'o> {
    run: usize,
    arrays: SampleArrays<'o>,
}

/// What all runs share.
struct Plan<'a> {
    cases: &'a [Arc<EngineCase>],
    /// the scene, where all runs have the same
    scene: Option<Arc<dyn Scene>>,
    /// where actions act in it
    sites: Option<Sites>,
    variants: &'a [Vec<(String, String)>],
    times: &'a [f64],
    /// whether the runs end with the last of the times
    ends: bool,
    nodes: &'a [u32],
    /// names of the columns of the gauges; empty where none are kept
    channels: &'a [String],
    initial: &'a Initial,
    actions: &'a [Action],
}

/// Why there is no run.
enum Fault {
    Record(RecordError),
    Python(PyErr),
}

impl From<RecordError> for Fault {
    fn from(error: RecordError) -> Self {
        Fault::Record(error)
    }
}

impl From<SimulationError> for Fault {
    fn from(error: SimulationError) -> Self {
        Fault::Record(error.into())
    }
}

impl From<CaseError> for Fault {
    fn from(error: CaseError) -> Self {
        Fault::Record(error.into())
    }
}

impl Plan<'_> {
    /// Makes a run, with the scene of all or one of its own.
    fn run(&self, job: Job<'_>, stop: &AtomicBool) -> Result<Rollout, Fault> {
        let base = &self.cases[if self.cases.len() == 1 { 0 } else { job.run }];
        match (&self.scene, self.variants.get(job.run)) {
            (Some(scene), _) => self.run_in(job, base.problem(), (scene.for_run().into(), scene), stop),
            (None, Some(overrides)) => {
                let (problem, scene) = own_scene(base.with(overrides)?)?;
                self.run_in(job, &problem, (scene.clone(), &scene), stop)
            }
            (None, None) => {
                let scene = scene_of(base, 1)?;
                self.run_in(job, base.problem(), (scene.clone(), &scene), stop)
            }
        }
    }

    /// The same in a scene of its own, which shows what `scene` does.
    fn run_in(
        &self,
        Job { run, arrays }: Job<'_>,
        problem: &Problem,
        (own, scene): (Arc<dyn Scene>, &Arc<dyn Scene>),
        stop: &AtomicBool,
    ) -> Result<Rollout, Fault> {
        let n = scene.reference().len();
        if let Some((place, &node)) = self.nodes.iter().enumerate().find(|(_, node)| **node as usize >= n) {
            return Err(SimulationError::NoNode { what: "nodes: place", place, node, nodes: n }.into());
        }
        self.has_nodes(run, &arrays, n)?;
        let sites = match &self.sites {
            Some(sites) => Cow::Borrowed(sites),
            None => Cow::Owned(Action::sites(self.actions, &**scene).map_err(Fault::Python)?),
        };
        let mut simulation = Simulation::of_own(own, run_spec(problem))?;
        self.initial.begin(&mut simulation, run)?;
        let acts = self.actions.iter().zip(&*sites).map(|(action, site)| action.of_scene(site, &simulation));
        let acts = acts.collect::<PyResult<Vec<Acts<'_>>>>().map_err(Fault::Python)?;
        let end = simulation.end();
        let spec =
            SampleSpec { times: self.times, nodes: self.nodes, output: &problem.output, end, ends_run: self.ends };
        let mut samples = Samples::new(&*simulation.scene(), spec, arrays).map_err(SimulationError::from)?;
        if self.scene.is_none() {
            self.has_gauges(run, &samples)?;
        }
        let mut force = vec![[0.0; 3]; n];
        let mut act = |simulation: &mut Simulation, time: usize| {
            acts.iter().try_for_each(|acts| acts.set(simulation, run * self.times.len() + time, &mut force))
        };
        let act: Option<&mut canopy_fem::simulation::Act<'_>> = if acts.is_empty() { None } else { Some(&mut act) };
        let outcome = simulation.run_sampled(&mut samples, problem.time.until_rest, act, stop)?;
        Ok(Rollout::ended(outcome))
    }

    /// Checks that a run has the nodes of the first one.
    fn has_nodes(&self, run: usize, arrays: &SampleArrays<'_>, n: usize) -> Result<(), Fault> {
        let times = self.times.len();
        let kept = [&arrays.positions, &arrays.velocities].into_iter().find(|all| !all.is_empty());
        match kept.filter(|all| self.nodes.is_empty() && all.len() != 3 * times * n) {
            Some(all) => {
                let first = all.len() / (3 * times);
                let text = format!("run {run} has {n} nodes, and the first has {first}: name the nodes to keep");
                Err(Fault::Python(PyValueError::new_err(text)))
            }
            None => Ok(()),
        }
    }

    /// The same for its gauges, if they are kept.
    fn has_gauges(&self, run: usize, samples: &Samples<'_, '_>) -> Result<(), Fault> {
        let own: Vec<String> = samples.columns().iter().map(|of| format!("{} {}", of.gauge, of.quantity)).collect();
        if self.channels.is_empty() || own == self.channels {
            return Ok(());
        }
        let text = format!("run {run} has other gauges than the first: {}", own.join(", "));
        Err(Fault::Python(PyValueError::new_err(text)))
    }
}

/// The parts of an array that belong to each run.
fn parts(array: &mut [f64], runs: usize) -> Vec<&mut [f64]> {
    let mut left = array;
    let size = left.len() / runs.max(1);
    let mut all = Vec::with_capacity(runs);
    for _ in 0..runs {
        let (part, rest) = left.split_at_mut(size);
        all.push(part);
        left = rest;
    }
    all
}

/// Runs cases on a pool of threads, and writes them into arrays (runs, times, …); how they ended.
#[pyfunction]
#[pyo3(signature = (cases, *, variants, times, ends, nodes, channels, arrays, runs, actions, initial, threads, progress))]
#[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
pub(crate) fn rollout_batch(
    py: Python<'_>,
    cases: Vec<Bound<'_, Case>>,
    variants: Vec<Vec<(String, String)>>,
    times: Vec<f64>,
    ends: bool,
    nodes: Vec<u32>,
    channels: Vec<String>,
    arrays: &Bound<'_, PyDict>,
    runs: usize,
    actions: Vec<(String, Place, PyReadonlyArrayDyn<'_, f64>)>,
    initial: &Bound<'_, PyDict>,
    threads: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<Vec<Rollout>> {
    let initial = initial_of(initial)?;
    let actions = actions.into_iter().map(Action::read).collect::<PyResult<Vec<_>>>()?;
    let mut written: Vec<(String, PyReadwriteArrayDyn<'_, f64>)> = Vec::new();
    for (name, array) in arrays {
        let array = array.cast_into::<PyArrayDyn<f64>>()?;
        let write = array.try_readwrite().map_err(|error| PyValueError::new_err(format!("out: {error}")))?;
        written.push((name.extract()?, write));
    }
    let threads = checked_threads(threads)?.min(runs.max(1));
    let scene = match (&*cases, variants.is_empty()) {
        ([case], true) => Some(case.get().scene(py)?),
        _ => None,
    };
    let cases: Vec<Arc<EngineCase>> = cases.iter().map(|case| case.get().case.clone()).collect();
    let sites = scene.as_ref().map(|scene| Action::sites(&actions, &**scene)).transpose()?;
    let plan = Plan {
        cases: &cases,
        scene,
        sites,
        variants: &variants,
        times: &times,
        ends,
        nodes: &nodes,
        channels: &channels,
        initial: &initial,
        actions: &actions,
    };
    let jobs = Mutex::new(jobs_of(&mut written, runs)?.into_iter());
    let (made, mut told) = (AtomicUsize::new(0), (Instant::now(), 0));
    let work = |stop: &AtomicBool| {
        let mut done = Vec::new();
        let next = || jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
        while let Some(job) = next().filter(|_| !stop.load(Ordering::Relaxed)) {
            let (run, result) = (job.run, plan.run(job, stop));
            made.fetch_add(1, Ordering::Relaxed);
            done.push((run, result));
        }
        done
    };
    let done = pooled(py, threads, work, |py| {
        let now = made.load(Ordering::Relaxed);
        match &progress {
            Some(progress) if now > told.1 && told.0.elapsed() > TOLD_EVERY => {
                told = (Instant::now(), now);
                progress.call1(py, (now, runs)).map(drop)
            }
            _ => Ok(()),
        }
    });
    let mut done: Vec<(usize, Result<Rollout, Fault>)> = done?.into_iter().flatten().collect();
    progress.map(|progress| progress.call1(py, (runs, runs))).transpose()?;
    done.sort_by_key(|(run, _)| *run);
    let ended = done.into_iter().map(|(_, result)| {
        result.map_err(|fault| match fault {
            Fault::Record(error) => of_record(py, error),
            Fault::Python(error) => error,
        })
    });
    ended.collect()
}

/// The arrays of each run.
fn jobs_of<'o>(written: &'o mut [(String, PyReadwriteArrayDyn<'_, f64>)], runs: usize) -> PyResult<Vec<Job<'o>>> {
    let mut jobs: Vec<Job<'o>> = (0..runs).map(|run| Job { run, arrays: SampleArrays::default() }).collect();
    for (name, array) in written {
        let all = array.as_slice_mut().map_err(|error| PyValueError::new_err(format!("out: {name}: {error}")))?;
        for (Job { arrays, .. }, part) in jobs.iter_mut().zip(parts(all, runs)) {
            let place = match name.as_str() {
                "positions" => &mut arrays.positions,
                "velocities" => &mut arrays.velocities,
                "gauges" => &mut arrays.gauges,
                "energies" => &mut arrays.energies,
                "peaks" => &mut arrays.peaks,
                "peak_times" => &mut arrays.peak_times,
                _ => return Err(PyKeyError::new_err(name.clone())),
            };
            *place = part;
        }
    }
    Ok(jobs)
}

fn initial_of(given: &Bound<'_, PyDict>) -> PyResult<Initial> {
    let rows = |name: &str| -> PyResult<Option<Vec<[f64; 3]>>> {
        let Some(array) = given.get_item(name)? else { return Ok(None) };
        let array: PyReadonlyArrayDyn<'_, f64> = array.extract()?;
        let all = array.as_slice().map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok(Some(all.as_chunks::<3>().0.to_vec()))
    };
    let snapshots = given.get_item("snapshots")?.map(|all| all.extract()).transpose()?.unwrap_or_default();
    Ok(Initial { positions: rows("positions")?, velocities: rows("velocities")?, snapshots })
}
