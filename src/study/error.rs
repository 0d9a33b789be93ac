//! Why a study cannot go on.

use std::path::PathBuf;

use super::compared_model::Model;
use crate::case::fingerprint::FingerprintError;
use crate::case::{CaseError, ClothModelError};
use crate::format_number::figures;
use crate::integrate::registry::MethodError;
use crate::plot::PlotError;
use crate::scene::BuildError;
use crate::simulation::SetupError;

/// Why a study cannot go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// The case or a variant of it is bad.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The cloth has no other model.
    #[error("models: {0}")]
    ClothModel(#[from] ClothModelError),
    /// A model has no solution to compare.
    #[error("{}: {source}", model.words())]
    OfModel {
        /// the model
        model: Model,
        /// why
        source: Box<StudyError>,
    },
    /// The scene cannot be built.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The case cannot be summed up.
    #[error(transparent)]
    Fingerprint(#[from] FingerprintError),
    /// A method that is not there, or a parameter out of range.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// What was asked for cannot be done.
    #[error("{0}")]
    Usage(String),
    /// There is no solution to measure against.
    #[error(
        "there is no reference to measure errors against\n  by explicit pairs: {explicit}\n  by extrapolated newmark: {implicit}"
    )]
    NoReference {
        /// why not by explicit pairs
        explicit: ReferenceFailure,
        /// why not by implicit steps
        implicit: ReferenceFailure,
    },
    /// Errors are relative to a motion that is not there.
    #[error("nothing moves in this case, so that errors relative to the motion cannot be told")]
    NothingMoves,
    /// No step is within an accuracy.
    #[error(
        "no run was within {accuracy}: at the finest that was tried, {tried}, {best}; take a wider accuracy, name other \
         quantities with --quantity, or take another method (canopy-fem check)"
    )]
    NotWithin {
        /// the accuracy
        accuracy: String,
        /// the finest run
        tried: String,
        /// the quantity that is farthest from it
        best: String,
    },
    /// Ctrl-C.
    #[error("interrupted; run the same command again to go on")]
    Interrupted,
    /// Ctrl-C before there is a plan.
    #[error(
        "interrupted while references were made, of which nothing is kept; the same command makes them again from the start"
    )]
    InterruptedReference,
    /// The folder holds another study.
    #[error("{folder} holds another study: {difference}; take another --out, or replace it with --force")]
    OtherStudy {
        /// the folder
        folder: PathBuf,
        /// what differs
        difference: String,
    },
    /// The folder holds another stability study.
    #[error("{folder} already holds a study ({found}); give --force to replace it, or another folder with --out")]
    HoldsStudy {
        /// the folder
        folder: PathBuf,
        /// the first file found
        found: &'static str,
    },
    /// No plan.
    #[error("{folder} holds no plan of a study; make it first: canopy-fem {command} CASE --plan --out DIR")]
    NoPlan {
        /// the folder
        folder: PathBuf,
        /// the command of the study
        command: &'static str,
    },
    /// A value of a sweep makes a bad case.
    #[error("--vary {values}: {source}")]
    Varied {
        /// the keys of the run with their values
        values: String,
        /// what is wrong with the case
        source: CaseError,
    },
    /// A file of the study cannot be used.
    #[error("{path}: {what}; remove it, and what it held is computed again")]
    BadFile {
        /// the file
        path: PathBuf,
        /// the fault
        what: String,
    },
    /// The system's answer.
    #[error("{path}: {source}")]
    System {
        /// the file
        path: PathBuf,
        /// the answer
        source: std::io::Error,
    },
    /// A picture cannot be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// The page cannot be made.
    #[error("the page cannot be made: {0}")]
    Page(String),
}

impl StudyError {
    /// If mass scaling adds nothing: what is told of a study that goes on without it.
    pub(super) fn nothing_to_scale(&self) -> Option<String> {
        match self {
            StudyError::OfModel { source, .. } => source.nothing_to_scale(),
            StudyError::Setup(SetupError::Build(BuildError::NothingToScale { step, needed })) => Some(format!(
                "no node needs more than {} of its mass for steps of {} s, so that all runs have the real masses",
                figures(*needed, 2),
                figures(*step, 4)
            )),
            _ => None,
        }
    }

    /// 1 for the system, 2 for what a person can set right, 130 for an interrupt.
    pub fn exit_status(&self) -> u8 {
        match self {
            StudyError::Case(error) | StudyError::Varied { source: error, .. } => error.exit_status(),
            StudyError::System { .. } | StudyError::Fingerprint(_) | StudyError::Page(_) => 1,
            StudyError::Setup(SetupError::Threads(_)) => 1,
            StudyError::Plot(e) => e.exit_status(),
            StudyError::OfModel { source, .. } => source.exit_status(),
            StudyError::NotWithin { .. } => 3,
            StudyError::Interrupted | StudyError::InterruptedReference => 130,
            _ => 2,
        }
    }
}

/// Why one way to a reference is no way.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReferenceFailure {
    /// It would take too long.
    #[error("it would take about {} s, {} s are allowed; raise --budget, or shorten the run with --end", figures(*seconds, 2), figures(*allowance, 2))]
    TooLong {
        /// [s] nominal cost
        seconds: f64,
        /// [s] what it may cost
        allowance: f64,
    },
    /// A run failed.
    #[error("{0}")]
    Failed(String),
    /// Two solutions do not agree.
    #[error(
        "two solutions differ by {0:.1e} of the motion: it multiplies errors, or is too fast for what is affordable; shorten the run with --end, or raise --budget"
    )]
    NotAgreed(f64),
}
