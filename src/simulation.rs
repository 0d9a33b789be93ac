//! A case made ready to run: the scene and the method bound to each other.

use crate::case::spec::{Problem, SystemSpec};
use crate::force::batch::Threads;
use crate::integrate::stepper::{NeedsNetwork, Stepper};
use crate::scene::{BuildError, Pendulum, Scene, build_network};

/// Why a good case cannot be made ready.
#[derive(Debug, thiserror::Error)]
pub enum SetupError {
    /// The specification contradicts itself.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The method does not fit the scene.
    #[error("{method}: {source}")]
    Method {
        /// the method's name
        method: &'static str,
        /// why
        source: NeedsNetwork,
    },
    /// The operating system gave no threads.
    #[error("threads cannot be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// Builds the scene of a case for `threads` threads.
///
/// # Errors
/// A specification that contradicts itself, or no threads.
pub fn build_scene(system: SystemSpec, threads: usize) -> Result<Box<dyn Scene>, SetupError> {
    Ok(match system {
        SystemSpec::Network(spec) => Box::new(build_network(*spec, Threads::new(threads)?)?),
        SystemSpec::Pendulum(spec) => Box::new(Pendulum::new(spec)),
    })
}

/// Binds the method of a case to its scene.
///
/// # Errors
/// When the method needs a network and the scene is none.
pub fn bind<'a>(problem: &Problem, scene: &'a dyn Scene) -> Result<Stepper<'a>, SetupError> {
    let method = &problem.method;
    Stepper::bind(method.scheme(problem.solver), scene.abilities())
        .map_err(|source| SetupError::Method { method: method.info.name, source })
}
