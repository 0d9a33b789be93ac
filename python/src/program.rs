//! The program `canopy-fem`, whose engine is the module's.

use pyo3::prelude::*;
use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The exit status that Rust gives a program that panicked.
const PANICKED: u8 = 101;

/// Runs the program with the arguments after its name, and gives its exit status. For a process of its own: it catches
/// signals from then on, and a second Ctrl-C ends the process.
#[pyfunction]
pub(crate) fn _program(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    // The hook for panics has told of one.
    py.detach(|| catch_unwind(AssertUnwindSafe(|| canopy_fem::cli::run(arguments))).unwrap_or(PANICKED))
}
