//! Forces that a Python function computes.

use crate::arrays::{of_rows, rows};
use canopy_fem::simulation::NodalForce;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Where an exception of a force waits until the step has ended.
#[derive(Default)]
pub(crate) struct Raised {
    error: Mutex<Option<PyErr>>,
    /// whether there is one, for the engine to give up on the step
    pub flag: Arc<AtomicBool>,
}

impl Raised {
    fn slot(&self) -> MutexGuard<'_, Option<PyErr>> {
        self.error.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether an exception waits.
    pub(crate) fn is_set(&self) -> bool {
        self.flag.load(Ordering::Relaxed)
    }

    /// Keeps an exception until the step has ended.
    pub(crate) fn keep(&self, error: PyErr) {
        *self.slot() = Some(error);
        self.flag.store(true, Ordering::Relaxed);
    }

    /// Takes the waiting exception.
    pub(crate) fn take(&self) -> Option<PyErr> {
        if self.flag.swap(false, Ordering::Relaxed) { self.slot().take() } else { None }
    }
}

/// A force `function(t, x, v)` -> (n, 3).
pub(crate) struct PythonForce {
    /// what the program calls it
    pub name: String,
    /// the function; none once the collector of Python's garbage has it
    pub function: Mutex<Option<Py<PyAny>>>,
    /// whether it depends on velocities
    pub velocity_dependent: bool,
    /// where its exceptions go
    pub raised: Arc<Raised>,
}

impl PythonForce {
    /// The function.
    ///
    /// # Errors
    /// It is gone.
    pub(crate) fn function<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let function = self.function.lock().unwrap_or_else(PoisonError::into_inner);
        let gone = || PyRuntimeError::new_err(format!("the function of force \"{}\" is gone", self.name));
        Ok(function.as_ref().ok_or_else(gone)?.bind(py).clone())
    }

    fn call(&self, py: Python<'_>, t: f64, x: &[[f64; 3]], v: &[[f64; 3]]) -> PyResult<Vec<[f64; 3]>> {
        let nodes = (t, of_rows(py, x.to_vec())?, of_rows(py, v.to_vec())?);
        let force = self.function(py)?.call1(nodes)?;
        let what = format!("the result of force \"{}\"", self.name);
        let force = rows(&force, &what, Some(x.len()))?;
        match force.iter().position(|row| row.iter().any(|value| !value.is_finite())) {
            Some(row) => Err(PyValueError::new_err(format!("{what}: row {row} is not finite at t = {t} s"))),
            None => Ok(force),
        }
    }
}

impl NodalForce for PythonForce {
    fn add(&self, t: f64, x: &[[f64; 3]], v: &[[f64; 3]], f: &mut [[f64; 3]]) {
        let raised = &self.raised;
        // The step may have failed already.
        let force = (!raised.is_set()).then(|| Python::attach(|py| self.call(py, t, x, v)));
        let force = force.and_then(|made| made.map_err(|error| raised.keep(error)).ok());
        match force {
            Some(force) => {
                for (sum, force) in f.as_flattened_mut().iter_mut().zip(force.as_flattened()) {
                    *sum += force;
                }
            }
            // Forces that are not finite make the step fail, and its state is dropped.
            None => f.as_flattened_mut().fill(f64::NAN),
        }
    }

    fn velocity_dependent(&self) -> bool {
        self.velocity_dependent
    }
}
