//! Derivatives of the state of a simulation by numbers of its case.

use crate::arrays::of_rows;
use crate::case::Case;
use crate::errors::{CaseError, engine, of_case, of_simulation};
use canopy_fem::simulation::{Simulation, SimulationError};
use canopy_fem::study::gradient::{GradientError, parameters};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Why there are none.
enum Refused {
    Parameters(GradientError),
    Simulation(SimulationError),
}

/// Makes a simulation go along with the derivatives by some keys of its case.
pub(crate) fn follow(
    py: Python<'_>,
    sim: &mut Simulation,
    case: &Case,
    (by, threads): (&[String], usize),
) -> PyResult<()> {
    let case = case.case.clone();
    let made = engine(py, || {
        let parameters = parameters(&case, by, threads).map_err(Refused::Parameters)?;
        sim.follow_derivatives(parameters).map_err(Refused::Simulation)
    })?;
    made.map_err(|refused| match refused {
        Refused::Parameters(GradientError::Case(error) | GradientError::Beside { source: error, .. }) => {
            of_case(py, error)
        }
        Refused::Parameters(error) => CaseError::new_err(error.to_string().replace("--by ", "sensitivity: ")),
        Refused::Simulation(error @ (SimulationError::Derivatives { .. } | SimulationError::Sensitivity(_))) => {
            CaseError::new_err(error.to_string())
        }
        Refused::Simulation(error) => of_simulation(py, error),
    })
}

/// The derivatives, by key: of positions and of velocities, each (n, 3).
pub(crate) fn found<'py>(py: Python<'py>, sim: &Simulation) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for (name, [positions, velocities]) in sim.derivatives() {
        all.set_item(name, (of_rows(py, positions)?, of_rows(py, velocities)?))?;
    }
    Ok(all)
}
