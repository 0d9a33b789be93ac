//! Cases.

use crate::errors::{of_case, of_record, of_simulation};
use crate::interrupt::watched;
use crate::values::from_json;
use canopy_fem::case::spec::{Problem, SystemSpec};
use canopy_fem::case::{self, Source, fingerprint::Fingerprint};
use canopy_fem::integrate::registry::{Family, methods as registry};
use canopy_fem::output::samples::Samples;
use canopy_fem::scene::Scene;
use canopy_fem::simulation::{RecordError, build_scene, check_solver};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// A case that was read and has no faults.
#[pyclass(module = "canopy_fem._core", frozen)]
pub struct Case {
    /// shared with runs
    pub case: Arc<case::Case>,
    /// its scene for one thread, once runs of it were asked for
    scene: Mutex<Option<Arc<dyn Scene>>>,
}

type Overrides = Vec<(String, String)>;

#[pymethods]
impl Case {
    /// Reads a case file; one that is `at_rest` needs no `time` section.
    #[staticmethod]
    #[pyo3(signature = (path, overrides, *, at_rest=false))]
    fn from_file(py: Python<'_>, path: PathBuf, overrides: Overrides, at_rest: bool) -> PyResult<Self> {
        let read = if at_rest { case::Case::from_file_at_rest } else { case::Case::from_file };
        Self::of(py, move || read(&path, &overrides))
    }

    /// Reads a case from its text; paths in it are relative to `base`.
    #[staticmethod]
    #[pyo3(signature = (text, name, base, overrides, *, at_rest=false))]
    fn from_text(
        py: Python<'_>,
        text: String,
        name: String,
        base: PathBuf,
        overrides: Overrides,
        at_rest: bool,
    ) -> PyResult<Self> {
        let read = if at_rest { case::Case::from_text_at_rest } else { case::Case::from_text };
        Self::of(py, move || read(text, &name, base, &overrides))
    }

    /// The same case with other values.
    fn with_overrides(&self, py: Python<'_>, overrides: Overrides) -> PyResult<Self> {
        let known = self.case.clone();
        Self::of(py, move || known.with(&overrides))
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.case.problem().name
    }

    /// Name of its method.
    #[getter]
    fn method(&self) -> &str {
        self.case.problem().method.info.name
    }

    /// [s] its end
    #[getter]
    fn end(&self) -> f64 {
        self.case.problem().time.end
    }

    /// [s] its fixed step; `None` if steps are adaptive
    #[getter]
    fn step(&self) -> Option<f64> {
        self.case.problem().time.step.fixed()
    }

    /// Warnings that it does not acknowledge.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.case.warnings().iter().map(ToString::to_string).collect()
    }

    /// The case as it is run, overrides included, as JSON.
    #[getter]
    fn text(&self) -> PyResult<String> {
        serde_json::to_string(&self.case.problem().case_json).map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// What its scene, method, steps and output come to, files included, as a checksum.
    #[getter]
    fn digest(&self) -> PyResult<String> {
        let made = Fingerprint::of(self.case.problem());
        made.map(|made| made.digest()).map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// Its number of nodes.
    #[getter]
    fn node_count(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.scene(py)?.reference().len())
    }

    /// The columns of its gauges and of its canopies, "name quantity", and their units.
    #[getter]
    fn channels(&self, py: Python<'_>) -> PyResult<Vec<(String, &'static str)>> {
        let channels = Samples::channels(&*self.scene(py)?, &self.case.problem().output);
        let channels = channels.map_err(|error| of_simulation(py, error.into()))?;
        Ok(channels.into_iter().map(|of| (format!("{} {}", of.gauge, of.quantity), of.unit)).collect())
    }

    /// The case as it is run, overrides included.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        from_json(py, &self.case.problem().case_json)
    }
}

impl Case {
    fn of(py: Python<'_>, read: impl FnOnce() -> Result<case::Case, case::CaseError> + Send) -> PyResult<Self> {
        let case = watched(py, |_| read(), |_| Ok(()))?.map_err(|error| of_case(py, error))?;
        Ok(Case { case: Arc::new(case), scene: Mutex::default() })
    }

    /// Its scene for one thread, which is kept: any number of runs may begin from it.
    pub(crate) fn scene(&self, py: Python<'_>) -> PyResult<Arc<dyn Scene>> {
        let made = watched(
            py,
            |_| {
                let mut kept = self.scene.lock().unwrap_or_else(PoisonError::into_inner);
                match &*kept {
                    Some(scene) => Ok(scene.clone()),
                    None => scene_of(&self.case, 1).map(|scene| kept.insert(scene).clone()),
                }
            },
            |_| Ok(()),
        )?;
        made.map_err(|error| of_record(py, error))
    }
}

/// Builds the scene of a case for a number of threads.
///
/// # Errors
/// A specification that contradicts itself, and a solver that does not fit the scene.
pub(crate) fn scene_of(case: &case::Case, threads: usize) -> Result<Arc<dyn Scene>, RecordError> {
    let problem = case.problem();
    built(problem, problem.system.clone(), case.source(), threads)
}

/// The same for a case that goes with its run: nothing is copied.
///
/// # Errors
/// As [`scene_of`].
pub(crate) fn own_scene(case: case::Case) -> Result<(Problem, Arc<dyn Scene>), RecordError> {
    let (mut problem, source) = case.split();
    let system = problem.take_system();
    let scene = built(&problem, system, &source, 1)?;
    Ok((problem, scene))
}

fn built(
    problem: &Problem,
    system: SystemSpec,
    source: &Source,
    threads: usize,
) -> Result<Arc<dyn Scene>, RecordError> {
    let scene = build_scene(system, threads)?;
    check_solver(problem, &*scene, source)?;
    Ok(scene.into())
}

/// The JSON Schema of a case, as a dictionary.
#[pyfunction]
pub(crate) fn schema(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    from_json(py, &case::json_schema())
}

/// The methods: a list of dictionaries with name, order, needs, stability and source.
#[pyfunction]
pub(crate) fn methods(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let entry = |method: &canopy_fem::integrate::registry::MethodInfo| {
        let needs = match method.family {
            Family::Explicit => "forces",
            Family::MatrixFree => "springs",
            Family::Implicit => "tangent",
        };
        let entry = PyDict::new(py);
        entry.set_item("name", method.name)?;
        entry.set_item("order", method.order.to_string())?;
        entry.set_item("needs", needs)?;
        entry.set_item("stability", method.stability.to_string())?;
        entry.set_item("source", method.source)?;
        Ok(entry)
    };
    registry().iter().map(entry).collect()
}
