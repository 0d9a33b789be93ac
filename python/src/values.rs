//! Small values that the engine returns.

use canopy_fem::drive::observer;
use canopy_fem::simulation::StepInfo;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The energy account of a state; kinetic + elastic + gravity - external_work + dissipated + numerical keeps its value.
/// By numerical a run is judged: with smaller steps h it falls as h to the order of the method.
#[pyclass(module = "canopy_fem", frozen, get_all)]
#[derive(Clone, Copy)]
pub struct Energies {
    /// [J] kinetic energy
    pub kinetic: f64,
    /// [J] energy of springs, membranes and bending
    pub elastic: f64,
    /// [J] gravity energy, from displacements
    pub gravity: f64,
    /// [J] work of the air and the loads since t = 0
    pub external_work: f64,
    /// [J] taken by dashpots and Rayleigh damping since t = 0
    pub dissipated: f64,
    /// [J] the remainder: energy that the scheme lost (above 0) or made (below 0)
    pub numerical: f64,
}

impl Energies {
    /// The columns, by name.
    pub(crate) fn entries(&self) -> [(&'static str, f64); 6] {
        let Energies { kinetic, elastic, gravity, external_work, dissipated, numerical } = *self;
        [
            ("kinetic", kinetic),
            ("elastic", elastic),
            ("gravity", gravity),
            ("external_work", external_work),
            ("dissipated", dissipated),
            ("numerical", numerical),
        ]
    }
}

#[pymethods]
impl Energies {
    #[new]
    fn new(kinetic: f64, elastic: f64, gravity: f64, external_work: f64, dissipated: f64, numerical: f64) -> Self {
        Energies { kinetic, elastic, gravity, external_work, dissipated, numerical }
    }

    /// For copies and pickles.
    fn __getnewargs__(&self) -> (f64, f64, f64, f64, f64, f64) {
        let [kinetic, elastic, gravity, external_work, dissipated, numerical] = self.entries().map(|(_, value)| value);
        (kinetic, elastic, gravity, external_work, dissipated, numerical)
    }

    /// The account as a dictionary of numbers [J].
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        self.entries().into_iter().try_for_each(|(name, value)| all.set_item(name, value))?;
        Ok(all)
    }

    fn __repr__(&self) -> String {
        let all: Vec<String> = self.entries().iter().map(|(name, value)| format!("{name}={value:?}")).collect();
        format!("Energies({})", all.join(", "))
    }
}

impl From<observer::Energies> for Energies {
    fn from(row: observer::Energies) -> Self {
        let observer::Energies { kinetic, elastic, gravity, external_work, dissipated, numerical } = row;
        Energies { kinetic, elastic, gravity, external_work, dissipated, numerical }
    }
}

/// A step that was made.
#[pyclass(module = "canopy_fem", frozen, get_all)]
#[derive(Clone, Copy)]
pub struct Step {
    /// accepted steps so far
    pub step: u64,
    /// [s] time at its end
    pub time: f64,
    /// energy account at its end
    pub energies: Energies,
}

#[pymethods]
impl Step {
    #[new]
    fn new(step: u64, time: f64, energies: &Bound<'_, Energies>) -> Self {
        Step { step, time, energies: *energies.get() }
    }

    /// For copies and pickles.
    fn __getnewargs__(&self) -> (u64, f64, Energies) {
        (self.step, self.time, self.energies)
    }

    fn __repr__(&self) -> String {
        format!("Step(step={}, time={:?})", self.step, self.time)
    }
}

impl From<StepInfo> for Step {
    fn from(StepInfo { step, time, energies }: StepInfo) -> Self {
        Step { step, time, energies: energies.into() }
    }
}

/// What can be written as JSON, as dictionaries, lists, numbers and texts. JSON has no infinity: it becomes `None`.
///
/// # Errors
/// When it cannot be written as JSON.
pub(crate) fn from_json<'py>(py: Python<'py>, value: &impl serde::Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    py.import("json")?.call_method1("loads", (text,))
}
