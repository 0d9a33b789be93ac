//! Models in a study that compares them: cloth as a net or as membranes, scaled or real masses. What the cheaper one
//! costs in accuracy.
//!
//! All runs are measured against the solution with membranes, or with real masses. The solution of the net, or with
//! scaled masses, is as accurate as that. It differs by the error of the model, which no step makes smaller.

use serde::{Deserialize, Serialize};

pub use super::compared_model::Model;
use super::error::StudyError;
use super::frames::Distance;
use super::prepared_case::PreparedCase;
use super::reference::{Reference, ReferenceReport};
use crate::case::fingerprint::Fingerprint;
use crate::case::schema::ClothModel;
use crate::case::{Case, Problem};

/// The models that a study of a case compares, the one that errors are measured against first; none if it has one only.
pub(super) fn compared(case: &Case, cloth: &[ClothModel]) -> Result<Vec<Model>, StudyError> {
    match (case.has_scaled_masses(), cloth) {
        (true, []) => Ok(vec![Model::RealMass, Model::ScaledMass]),
        (true, _) => {
            let why = "models of cloth are compared with real masses: leave time.mass_scaling out, or models";
            Err(StudyError::Usage(why.to_owned()))
        }
        (false, cloth) => Ok([ClothModel::Membrane, ClothModel::Net]
            .into_iter()
            .filter(|model| cloth.contains(model))
            .map(Model::from)
            .collect()),
    }
}

/// A model in a study that compares them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelReport {
    /// the model
    pub model: Model,
    /// what the case is with it
    pub fingerprint: Fingerprint,
    /// what the model costs in accuracy; `None` for the model that others are compared with
    pub error: Option<ModelError>,
}

/// How far the solution of a model is from that of the model it is compared with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelError {
    /// [-] root mean square over frames and nodes, over that of the motion
    pub error: f64,
    /// [-] largest distance over the largest motion
    pub error_max: f64,
    /// the solution of the model
    pub solution: ReferenceReport,
}

/// The data of a run of a case as a model, if one is given.
///
/// # Errors
/// Cloth that the model cannot stand for.
pub(super) fn problem_of(case: &Case, model: Option<Model>) -> Result<Problem, StudyError> {
    Ok(match model {
        Some(Model::Net) => case.as_model(ClothModel::Net)?,
        Some(Model::Membrane) => case.as_model(ClothModel::Membrane)?,
        Some(Model::RealMass) => case.problem().clone().with_real_masses(),
        Some(Model::ScaledMass) | None => case.problem().clone(),
    })
}

/// A case as a model, and its solution.
pub(super) struct Solved {
    pub model: Option<Model>,
    pub prepared: PreparedCase,
    pub reference: Reference,
}

impl Solved {
    /// How far the solution of another model is from this one.
    ///
    /// # Errors
    /// Solutions whose distance is no number.
    pub(crate) fn error_of(&self, other: &Solved) -> Result<ModelError, StudyError> {
        let motion = self.reference.account.motion;
        let distance = Distance::between(&other.reference.frames, &self.reference.frames).over(motion);
        let [error, error_max] = distance.ok_or(StudyError::NothingMoves)?;
        Ok(ModelError { error, error_max, solution: other.reference.account.clone() })
    }

    /// What is told of it.
    pub(crate) fn report(&self, model: Model, error: Option<ModelError>) -> ModelReport {
        ModelReport { model, fingerprint: self.prepared.fingerprint.clone(), error }
    }
}
