//! Models of the cloth in a study that compares them: what the cheaper one costs in accuracy.
//!
//! All runs are measured against the solution with membranes. The solution of the net, as accurate as that, differs
//! from it by the error of the model, which no step makes smaller.

use serde::{Deserialize, Serialize};

use super::error::StudyError;
use super::frames::Distance;
use super::prepared_case::PreparedCase;
use super::reference::{Reference, ReferenceReport};
use crate::case::fingerprint::Fingerprint;
use crate::case::schema::ClothModel;
use crate::case::{Case, Problem};

/// A model of the cloth in a study that compares them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelReport {
    /// the model
    pub model: ClothModel,
    /// what the case is with it
    pub fingerprint: Fingerprint,
    /// what the model costs in accuracy; `None` for the membranes themselves
    pub error: Option<ModelError>,
}

/// How far the solution of a model is from that with membranes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelError {
    /// [-] root mean square over frames and nodes, over that of the motion of the membranes
    pub error: f64,
    /// [-] largest distance over the largest motion
    pub error_max: f64,
    /// the solution of the model
    pub solution: ReferenceReport,
}

/// The data of a run of a case, with its cloth as a model if one is given.
///
/// # Errors
/// Cloth that the model cannot stand for.
pub(super) fn problem_of(case: &Case, model: Option<ClothModel>) -> Result<Problem, StudyError> {
    Ok(match model {
        Some(model) => case.as_model(model)?,
        None => case.problem().clone(),
    })
}

/// A case with its cloth as a model, and its solution.
pub(super) struct Solved {
    pub model: Option<ClothModel>,
    pub prepared: PreparedCase,
    pub reference: Reference,
}

impl Solved {
    /// How far the solution of another model is from this one.
    ///
    /// # Errors
    /// Solutions whose distance is no number.
    pub fn error_of(&self, other: &Solved) -> Result<ModelError, StudyError> {
        let motion = self.reference.account.motion;
        let distance = Distance::between(&other.reference.frames, &self.reference.frames).over(motion);
        let [error, error_max] = distance.ok_or(StudyError::NothingMoves)?;
        Ok(ModelError { error, error_max, solution: other.reference.account.clone() })
    }

    /// What is told of it.
    pub fn report(&self, model: ClothModel, error: Option<ModelError>) -> ModelReport {
        ModelReport { model, fingerprint: self.prepared.fingerprint.clone(), error }
    }
}
