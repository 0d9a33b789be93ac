//! What the engine refuses, as exceptions of `canopy_fem.errors`.

use canopy_fem::case::CaseError as BadCase;
use canopy_fem::drive::{Failure, RunError};
use canopy_fem::mesh::MeshError;
use canopy_fem::output::folder::FolderError;
use canopy_fem::simulation::{RecordError, SetupError, SimulationError as Refusal};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

pyo3::import_exception!(canopy_fem.errors, CaseError);
pyo3::import_exception!(canopy_fem.errors, Diverged);
pyo3::import_exception!(canopy_fem.errors, Ended);
pyo3::import_exception!(canopy_fem.errors, SimulationError);
pyo3::import_exception!(canopy_fem.errors, InternalError);

/// Runs `work` without the interpreter; a panic becomes an `InternalError`.
///
/// # Errors
/// A panic.
pub(crate) fn engine<R: Send>(py: Python<'_>, work: impl FnOnce() -> R + Send) -> PyResult<R> {
    py.detach(|| catch_unwind(AssertUnwindSafe(work))).map_err(|panic| panicked(&*panic))
}

/// The exception of a panic.
pub(crate) fn panicked(panic: &(dyn Any + Send)) -> PyErr {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    InternalError::new_err(format!("the engine has a defect: {}; please report it", text.unwrap_or("a panic")))
}

/// Panics in the engine's place, so that tests can see what becomes of it.
#[pyfunction]
pub(crate) fn _panic(py: Python<'_>) -> PyResult<()> {
    engine(py, || std::panic::panic_any("a test asked for this panic"))
}

/// The exception of a bad case, with its faults.
pub(crate) fn of_case(py: Python<'_>, error: BadCase) -> PyErr {
    if let BadCase::Read { path, source } = &error {
        return PyErr::from(std::io::Error::new(source.kind(), format!("{path}: {source}")));
    }
    let faults = error.faults().iter().map(|fault| {
        let entry = PyDict::new(py);
        entry.set_item("pointer", &fault.pointer)?;
        entry.set_item("value", &fault.value)?;
        entry.set_item("allowed", &fault.allowed)?;
        entry.set_item("hint", &fault.hint)?;
        Ok(entry.unbind())
    });
    match faults.collect::<PyResult<Vec<Py<PyDict>>>>() {
        Ok(faults) => CaseError::new_err((error.to_string(), faults)),
        Err(error) => error,
    }
}

/// The exception of a mesh that cannot be made, read or written.
pub(crate) fn of_mesh(error: &MeshError) -> PyErr {
    match error {
        MeshError::File { .. } | MeshError::Target { .. } => PyOSError::new_err(error.to_string()),
        _ => CaseError::new_err(error.to_string()),
    }
}

/// The exception of a failed run or step, with its report.
pub(crate) fn of_failure(py: Python<'_>, message: String, failure: &Failure) -> PyErr {
    match crate::values::from_json(py, failure) {
        Ok(report) => Diverged::new_err((message, report.unbind())),
        Err(error) => error,
    }
}

/// The exception of what a simulation refuses.
pub(crate) fn of_simulation(py: Python<'_>, error: Refusal) -> PyErr {
    let text = error.to_string();
    match &error {
        Refusal::Failed(failure) => of_failure(py, text, failure),
        Refusal::Ended { .. } => Ended::new_err(text),
        Refusal::Setup(SetupError::Threads(_)) => PyOSError::new_err(text),
        Refusal::Run(RunError::OutOfRange { .. }) => PyValueError::new_err(text),
        Refusal::Setup(_) | Refusal::Run(_) => CaseError::new_err(text),
        Refusal::Shape { .. }
        | Refusal::NotFinite { .. }
        | Refusal::NotPositive { .. }
        | Refusal::NoSpring { .. }
        | Refusal::NoNode { .. }
        | Refusal::NoLoad(_)
        | Refusal::Snapshot(_) => PyValueError::new_err(text),
        _ => SimulationError::new_err(text),
    }
}

/// The exception of a run that cannot be recorded.
pub(crate) fn of_record(py: Python<'_>, error: RecordError) -> PyErr {
    match error {
        RecordError::Case(error) => of_case(py, error),
        RecordError::Simulation(error) => of_simulation(py, error),
        RecordError::Setup(error) => of_simulation(py, Refusal::Setup(error)),
        RecordError::Folder(FolderError::HoldsResults { folder, found, resumable }) => {
            let resume = if resumable { " resume=True to go on from their checkpoint," } else { "" };
            let ways = format!("give replace=True to replace them,{resume} or another folder");
            PyOSError::new_err(format!("{folder} already holds results ({found}); {ways}"))
        }
        other => PyOSError::new_err(other.to_string()),
    }
}
