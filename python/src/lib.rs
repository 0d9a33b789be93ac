//! The Python module of canopy-fem: thin classes around the engine's door for programs
//! (`canopy_fem::simulation`), for `python/canopy_fem`, which gives them their conveniences. The engine itself has no
//! `unsafe`; what pyo3 needs of it is in pyo3.
//!
//! Every call gives the interpreter free while the engine works. Panics become `InternalError`.

mod actions;
mod arrays;
mod batch;
mod case;
mod errors;
mod forces;
mod frames;
mod interrupt;
mod logs;
mod mesh;
mod network;
mod pool;
mod program;
mod record;
mod rollout;
mod select;
mod sensitivity;
mod simulation;
mod values;

use pyo3::prelude::*;

/// The compiled part of canopy_fem. Use the names of canopy_fem itself.
///
/// It needs no global lock, so a free-threaded interpreter stays so: classes are frozen, what they share is behind
/// locks, arrays are copied or borrowed by the flags of the crate numpy, and the engine's statics are constants.
#[pymodule(gil_used = false)]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    logs::install();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<case::Case>()?;
    module.add_class::<mesh::Mesh>()?;
    module.add_class::<network::Network>()?;
    module.add_class::<simulation::Simulation>()?;
    module.add_class::<values::Step>()?;
    module.add_class::<values::Energies>()?;
    module.add_class::<rollout::Rollout>()?;
    module.add_function(wrap_pyfunction!(case::schema, module)?)?;
    module.add_function(wrap_pyfunction!(case::methods, module)?)?;
    module.add_function(wrap_pyfunction!(mesh::generate, module)?)?;
    module.add_function(wrap_pyfunction!(mesh::_mesh_of, module)?)?;
    module.add_function(wrap_pyfunction!(rollout::_rollout_of, module)?)?;
    module.add_function(wrap_pyfunction!(frames::frame_times, module)?)?;
    module.add_function(wrap_pyfunction!(record::record, module)?)?;
    module.add_function(wrap_pyfunction!(record::record_static, module)?)?;
    module.add_function(wrap_pyfunction!(rollout::rollout, module)?)?;
    module.add_function(wrap_pyfunction!(batch::rollout_batch, module)?)?;
    module.add_function(wrap_pyfunction!(errors::_panic, module)?)?;
    module.add_function(wrap_pyfunction!(logs::_listen, module)?)?;
    module.add_function(wrap_pyfunction!(program::_program, module)?)?;
    Ok(())
}
