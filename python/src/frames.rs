//! Frames of runs that are in one file.

use canopy_fem::mesh::frames::{FrameFault, frames_of};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::PathBuf;

/// Times [s] of the frames in the .vtkhdf file of a run, as far as they are written.
#[pyfunction]
pub(crate) fn frame_times(py: Python<'_>, file: PathBuf) -> PyResult<Vec<f64>> {
    let frames = crate::errors::engine(py, || frames_of(&file))?;
    let fault = |fault| match fault {
        FrameFault::System(error) => {
            PyErr::from(std::io::Error::new(error.kind(), format!("{}: {error}", file.display())))
        }
        FrameFault::Content(what) => PyValueError::new_err(format!("{} {what}", file.display())),
    };
    Ok(frames.map_err(fault)?.into_iter().map(|(t, _)| t).collect())
}
