//! Whole runs with their files.

use crate::arrays::of_list;
use crate::case::Case;
use crate::errors::of_record;
use crate::interrupt::watched;
use crate::values::{Energies, from_json};
use canopy_fem::drive::observer::{self, AcceptedStep, ObserveError, Observer, UpcomingStep, Wants};
use canopy_fem::output::rows::HistoryRow;
use canopy_fem::output::tables::Tables;
use canopy_fem::simulation::{self, EarlierResults, MemorySettings, RecordSettings, StaticSettings, record_in_memory};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Time between two calls of a progress function.
pub(crate) const TOLD_EVERY: Duration = Duration::from_millis(100);

/// Keeps the time of the newest step where another thread reads it.
struct Clock<'a>(&'a AtomicU64);

impl Observer for Clock<'_> {
    fn wants(&self, _next: UpcomingStep) -> Wants {
        Wants::ACCOUNT
    }

    fn accepted(&mut self, step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        self.0.store(step.t.to_bits(), Ordering::Relaxed);
        Ok(())
    }
}

/// Summary, warnings, and the tables of a run without files.
type Told<'py> = (Bound<'py, PyAny>, Vec<String>, Option<Bound<'py, PyDict>>);

/// Runs a case and writes its files, or gives its tables if there is no folder for them; the summary as a dictionary,
/// warnings, and the tables.
#[pyfunction]
#[pyo3(signature = (case, out, *, earlier, threads, keep_going, progress))]
pub(crate) fn record<'py>(
    py: Python<'py>,
    case: &Case,
    out: Option<PathBuf>,
    earlier: &str,
    threads: usize,
    keep_going: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Told<'py>> {
    let earlier = match earlier {
        "keep" => EarlierResults::Keep,
        "replace" => EarlierResults::Replace,
        "resume" => EarlierResults::Resume,
        other => return Err(PyValueError::new_err(format!("earlier results cannot be \"{other}\""))),
    };
    let threads = checked_threads(threads)?;
    let case = case.case.clone();
    let (time, end) = (AtomicU64::new(0), case.problem().time.end);
    let mut told = Instant::now();
    let done = watched(
        py,
        |stop| {
            let mut clock = Clock(&time);
            let observers: &mut [&mut dyn Observer] = if progress.is_some() { &mut [&mut clock] } else { &mut [] };
            match &out {
                Some(out) => {
                    let how = RecordSettings { earlier, threads, keep_going, ..RecordSettings::new(out) };
                    simulation::record(&case, how, observers, stop).map(|recorded| (recorded, None))
                }
                None => {
                    let done = record_in_memory(&case, MemorySettings { threads, keep_going }, observers, stop);
                    done.map(|(recorded, tables)| (recorded, Some(tables)))
                }
            }
        },
        |py| match &progress {
            Some(function) if told.elapsed() >= TOLD_EVERY => {
                told = Instant::now();
                function.call1(py, (f64::from_bits(time.load(Ordering::Relaxed)), end)).map(|_| ())
            }
            _ => Ok(()),
        },
    )?;
    let (recorded, tables) = done.map_err(|error| of_record(py, error))?;
    let warnings = recorded.warnings.iter().map(ToString::to_string).collect();
    let tables = tables.map(|tables| columns(py, &tables)).transpose()?;
    Ok((from_json(py, &recorded.summary)?, warnings, tables))
}

/// The columns of the tables, by the names of tables and columns; probes and channels of gauges by their numbers.
fn columns<'py>(py: Python<'py>, tables: &Tables) -> PyResult<Bound<'py, PyDict>> {
    let Tables { history, followed, probes, gauges, channels } = tables;
    let all = PyDict::new(py);
    let numbers = |of: &dyn Fn(&HistoryRow) -> f64| of_list(py, history.iter().map(of).collect());
    let table = PyDict::new(py);
    table.set_item("t", numbers(&|row| row.t))?;
    table.set_item("step", of_list(py, history.iter().map(|row| row.step).collect()))?;
    for (column, (name, _)) in Energies::from(observer::Energies::default()).entries().into_iter().enumerate() {
        table.set_item(name, numbers(&|row| Energies::from(row.ledger).entries()[column].1))?;
    }
    table.set_item("newton_iterations", of_list(py, history.iter().map(|row| row.newton_iterations).collect()))?;
    table.set_item("residual", numbers(&|row| row.residual))?;
    table.set_item("max_speed", numbers(&|row| row.max_speed))?;
    table.set_item("max_strain", numbers(&|row| row.max_strain))?;
    all.set_item("history", table)?;
    let table = PyDict::new(py);
    table.set_item("t", of_list(py, probes.iter().map(|row| row.t).collect()))?;
    table.set_item("name", of_list(py, probes.iter().map(|row| row.probe as u64).collect()))?;
    table.set_item("node", of_list(py, probes.iter().map(|row| row.node).collect()))?;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        table.set_item(name, of_list(py, probes.iter().map(|row| row.position[axis]).collect()))?;
    }
    for (axis, name) in ["vx", "vy", "vz"].into_iter().enumerate() {
        table.set_item(name, of_list(py, probes.iter().map(|row| row.velocity[axis]).collect()))?;
    }
    all.set_item("probes", table)?;
    let table = PyDict::new(py);
    table.set_item("t", of_list(py, gauges.iter().map(|row| row.t).collect()))?;
    table.set_item("channel", of_list(py, gauges.iter().map(|row| row.channel as u64).collect()))?;
    table.set_item("value", of_list(py, gauges.iter().map(|row| row.value).collect()))?;
    all.set_item("gauges", table)?;
    all.set_item("followed", followed)?;
    all.set_item("channels", channels.iter().map(|[name, quantity]| (name, quantity)).collect::<Vec<_>>())?;
    Ok(all)
}

/// Finds the equilibrium of a case and writes its files; the summary as a dictionary, and warnings.
#[pyfunction]
#[pyo3(signature = (case, out, *, replace, threads, at, load_steps, modes))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
pub(crate) fn record_static<'py>(
    py: Python<'py>,
    case: &Case,
    out: PathBuf,
    replace: bool,
    threads: usize,
    at: f64,
    load_steps: u32,
    modes: usize,
) -> PyResult<(Bound<'py, PyAny>, Vec<String>)> {
    let earlier = if replace { EarlierResults::Replace } else { EarlierResults::Keep };
    let threads = checked_threads(threads)?;
    if !(at >= 0.0 && at.is_finite()) {
        return Err(PyValueError::new_err(format!("at is {at}: give a time of at least 0, in seconds")));
    }
    if load_steps == 0 {
        return Err(PyValueError::new_err("load_steps is 0: give 1 or more"));
    }
    let case = case.case.clone();
    let how = StaticSettings { out: &out, earlier, threads, at, load_steps, modes };
    let done = watched(py, |stop| simulation::record_static(&case, how, stop), |_| Ok(()))?;
    let found = done.map_err(|error| of_record(py, error))?;
    if let Some(error) = found.without_modes {
        return Err(PyValueError::new_err(error.to_string()));
    }
    let findings = found.equilibrium.findings.iter().map(|finding| finding.text.clone());
    let warnings = found.warnings.iter().map(ToString::to_string).chain(findings).collect();
    Ok((from_json(py, &found.summary)?, warnings))
}

/// A number of threads that a computer can have.
///
/// # Errors
/// None, or more than 1024.
pub(crate) fn checked_threads(threads: usize) -> PyResult<usize> {
    match threads {
        1..=1024 => Ok(threads),
        _ => Err(PyValueError::new_err(format!("threads is {threads}: give 1 to 1024"))),
    }
}
