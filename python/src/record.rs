//! Whole runs with their files.

use crate::case::Case;
use crate::errors::of_record;
use crate::interrupt::watched;
use crate::values::from_json;
use canopy_fem::drive::observer::{AcceptedStep, ObserveError, Observer, UpcomingStep, Wants};
use canopy_fem::simulation::{self, EarlierResults, RecordSettings, StaticSettings};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
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

/// Runs a case and writes its files; the summary as a dictionary, and warnings.
#[pyfunction]
#[pyo3(signature = (case, out, *, earlier, threads, keep_going, progress))]
pub(crate) fn record<'py>(
    py: Python<'py>,
    case: &Case,
    out: PathBuf,
    earlier: &str,
    threads: usize,
    keep_going: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Vec<String>)> {
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
            let how = RecordSettings { earlier, threads, keep_going, ..RecordSettings::new(&out) };
            let mut clock = Clock(&time);
            let observers: &mut [&mut dyn Observer] = if progress.is_some() { &mut [&mut clock] } else { &mut [] };
            simulation::record(&case, how, observers, stop)
        },
        |py| match &progress {
            Some(function) if told.elapsed() >= TOLD_EVERY => {
                told = Instant::now();
                function.call1(py, (f64::from_bits(time.load(Ordering::Relaxed)), end)).map(|_| ())
            }
            _ => Ok(()),
        },
    )?;
    let recorded = done.map_err(|error| of_record(py, error))?;
    let warnings = recorded.warnings.iter().map(ToString::to_string).collect();
    Ok((from_json(py, &recorded.summary)?, warnings))
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
