//! Why there is no simulation, and why one does not go on.

use crate::assembly::ExportError;
use crate::case::CaseError;
use crate::case::fingerprint::FingerprintError;
use crate::drive::observer::ObserveError;
use crate::drive::{Failure, RunError};
use crate::integrate::stepper::Unfit;
use crate::output::folder::FolderError;
use crate::output::modes::ModesWriteError;
use crate::output::quantity::UnknownQuantity;
use crate::output::recorder::RecorderError;
use crate::output::resume::ResumeError;
use crate::scene::{BuildError, Load};
use crate::sensitivity::SensitivityError;

/// Why a good case cannot be made ready.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
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
        source: Unfit,
    },
    /// The operating system gave no threads.
    #[error("threads cannot be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// Why a simulation cannot go on, or refuses what it is given.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// The scene or the method cannot be made ready.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The run cannot start, or an observer cannot write.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A step diverged or could not be solved. The state is that before the step.
    #[error("step {} ending at t = {} s failed: {}; {}", .0.step, .0.time, .0.cause, .0.advice)]
    Failed(Box<Failure>),
    /// The end of the run is reached.
    #[error("the simulation has reached its end at t = {t} s")]
    Ended {
        /// [s] time
        t: f64,
    },
    /// A gauge measures what the scene does not have.
    #[error(transparent)]
    Gauge(#[from] UnknownQuantity),
    /// An attempted step waits for [`Simulation::accept`] or [`Simulation::drop_attempt`]; or there is none.
    #[error("{}", if *.pending { "an attempted step is neither accepted nor dropped" } else { "no step was attempted" })]
    Attempt {
        /// whether there is one
        pending: bool,
    },
    /// A size of step for a simulation whose case says what steps it makes.
    #[error("the simulation makes the steps of its case: steps of other sizes need a simulation with free steps")]
    NotFree,
    /// A slice does not have a row for each node.
    #[error("{what} has {found} rows, the scene {needed} nodes")]
    Shape {
        /// e.g. "positions"
        what: &'static str,
        /// rows given
        found: usize,
        /// nodes of the scene
        needed: usize,
    },
    /// A number is not finite.
    #[error("{what}: row {row} is not finite")]
    NotFinite {
        /// e.g. "positions"
        what: &'static str,
        /// row of the slice
        row: usize,
    },
    /// A factor of a rest length is 0 or less.
    #[error("a rest length cannot be multiplied by {factor}: the factor must be above 0")]
    NotPositive {
        /// [-] the factor
        factor: f64,
    },
    /// An edge that does not exist, or has no spring.
    #[error("edge {edge} has no spring")]
    NoSpring {
        /// number of the edge
        edge: u32,
    },
    /// A node that does not exist.
    #[error("{what} {place} has node {node}, the scene has {nodes}")]
    NoNode {
        /// e.g. "pair"
        what: &'static str,
        /// its place in the slice
        place: usize,
        /// the node
        node: u32,
        /// nodes of the scene
        nodes: usize,
    },
    /// A load that the scene does not have.
    #[error("the scene has no load {0:?}")]
    NoLoad(Load),
    /// The scene has no such thing: a pendulum has no forces from outside, a network without air no wind.
    #[error("this scene has no {0}")]
    Unsupported(&'static str),
    /// The first external force and other rest lengths change the scene, which the program still holds from
    /// [`Simulation::scene`].
    #[error("the scene is in use: drop what `Simulation::scene` has returned before this change")]
    SceneInUse,
    /// Derivatives by numbers of the case that are not known.
    #[error("derivatives of the state: {why}")]
    Derivatives {
        /// why
        why: String,
    },
    /// The scene, a parameter or the method has no derivative.
    #[error(transparent)]
    Sensitivity(#[from] SensitivityError),
    /// The bytes are no snapshot of this version of the library.
    #[error("the snapshot cannot be read: {0}")]
    Snapshot(String),
    /// A panic in an earlier step has left the simulation without its scheme.
    #[error("the simulation was interrupted in the middle of a step; restore a snapshot into a new one")]
    Broken,
}

impl From<BuildError> for SimulationError {
    fn from(error: BuildError) -> Self {
        SimulationError::Setup(SetupError::Build(error))
    }
}

/// Why a run has no files.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The solver of the case does not fit its scene.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The scene cannot be built.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The run cannot start.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The folder cannot be used.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// There is no checkpoint of this case.
    #[error(transparent)]
    Resume(#[from] ResumeError),
    /// Results cannot be prepared.
    #[error(transparent)]
    Recorder(#[from] RecorderError),
    /// Results cannot be written.
    #[error(transparent)]
    Observe(#[from] ObserveError),
    /// Modes cannot be written.
    #[error(transparent)]
    Modes(#[from] ModesWriteError),
    /// Matrices cannot be written.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// The files that the case names have no checksum.
    #[error(transparent)]
    Fingerprint(#[from] FingerprintError),
}
