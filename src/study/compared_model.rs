//! A model that a study compares with another.

use serde::{Deserialize, Serialize};

use crate::case::schema::ClothModel;

/// A model that a study compares with another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// cloth as springs
    Net,
    /// cloth as membranes
    Membrane,
    /// the masses of the case
    RealMass,
    /// those with what mass scaling adds, for explicit methods
    ScaledMass,
}

impl Model {
    /// The model whose solution errors are measured against.
    pub fn reference(self) -> Self {
        match self {
            Model::Net | Model::Membrane => Model::Membrane,
            Model::RealMass | Model::ScaledMass => Model::RealMass,
        }
    }

    /// The words in reports.
    pub fn words(self) -> &'static str {
        match self {
            Model::Net => "net",
            Model::Membrane => "membrane",
            Model::RealMass => "real masses",
            Model::ScaledMass => "scaled masses",
        }
    }
}

impl From<ClothModel> for Model {
    fn from(cloth: ClothModel) -> Self {
        match cloth {
            ClothModel::Net => Model::Net,
            ClothModel::Membrane => Model::Membrane,
        }
    }
}
