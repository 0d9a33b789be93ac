//! Why a command failed, and its exit status.

use super::init::InitError;
use super::mesh::MeshCliError;
use crate::assembly::ExportError;
use crate::case::CaseError;
use crate::case::fingerprint::FingerprintError;
use crate::drive::RunError;
use crate::drive::observer::ObserveError;
use crate::integrate::registry::MethodError;
use crate::output::folder::FolderError;
use crate::output::modes::ModesWriteError;
use crate::output::recorder::RecorderError;
use crate::output::resume::ResumeError;
use crate::plot::PlotError;
use crate::simulation::{RecordError, SetupError, SimulationError};
use crate::study::StudyError;
use crate::study::gradient::GradientError;

/// Any failure of a command.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CliError {
    /// The case is bad.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The scene of the case cannot be built.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The folder for the results cannot be used.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// Results cannot be prepared.
    #[error(transparent)]
    Recorder(#[from] RecorderError),
    /// The earlier run cannot be resumed.
    #[error(transparent)]
    Resume(#[from] ResumeError),
    /// The case has no checksum for checkpoints.
    #[error(transparent)]
    Fingerprint(#[from] FingerprintError),
    /// Results cannot be written.
    #[error(transparent)]
    Observe(#[from] ObserveError),
    /// The run could not start or write.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The simulation refuses a request.
    #[error(transparent)]
    Simulation(SimulationError),
    /// Matrices cannot be written.
    #[error("--dump-matrices: {0}")]
    Export(#[from] ExportError),
    /// A mesh cannot be made, read or written.
    #[error(transparent)]
    Mesh(#[from] MeshCliError),
    /// Results cannot be read or drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// A method cannot be chosen.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// A study failed.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A run has no derivatives.
    #[error(transparent)]
    Gradient(#[from] GradientError),
    /// Results cannot be printed.
    #[error("the results cannot be printed: {0}")]
    Json(serde_json::Error),
    /// An example case cannot be written.
    #[error(transparent)]
    Init(#[from] InitError),
}

impl From<SimulationError> for CliError {
    fn from(error: SimulationError) -> Self {
        match error {
            SimulationError::Setup(error) => error.into(),
            SimulationError::Run(error) => error.into(),
            other => CliError::Simulation(other),
        }
    }
}

impl From<RecordError> for CliError {
    fn from(error: RecordError) -> Self {
        match error {
            RecordError::Case(error) => error.into(),
            RecordError::Setup(error) => error.into(),
            RecordError::Simulation(error) => error.into(),
            RecordError::Folder(error) | RecordError::Modes(ModesWriteError::Folder(error)) => error.into(),
            RecordError::Resume(error) => error.into(),
            RecordError::Recorder(error) => error.into(),
            RecordError::Observe(error) | RecordError::Modes(ModesWriteError::Observe(error)) => error.into(),
            RecordError::Fingerprint(error) => error.into(),
            RecordError::Export(error) => error.into(),
        }
    }
}

impl CliError {
    /// 1 for input/output and internal failures, 2 for bad usage and bad cases.
    pub fn exit_code(&self) -> u8 {
        match self {
            CliError::Case(error) => error.exit_status(),
            CliError::Setup(SetupError::Threads(_)) => 1,
            CliError::Setup(_) => 2,
            CliError::Folder(FolderError::System { .. }) => 1,
            CliError::Folder(_) => 2,
            CliError::Mesh(e) => e.exit_status(),
            CliError::Plot(e) => e.exit_status(),
            CliError::Study(e) => e.exit_status(),
            CliError::Gradient(e) => e.exit_status(),
            CliError::Method(_) => 2,
            CliError::Init(InitError::Write { .. }) => 1,
            CliError::Init(_) => 2,
            CliError::Run(run) if !matches!(run, RunError::Observe(_)) => 2,
            CliError::Resume(e) | CliError::Recorder(RecorderError::Resume(e)) if !e.is_system() => 2,
            CliError::Resume(_) | CliError::Fingerprint(_) => 1,
            CliError::Recorder(_)
            | CliError::Observe(_)
            | CliError::Run(_)
            | CliError::Export(_)
            | CliError::Json(_)
            | CliError::Simulation(_) => 1,
        }
    }
}
