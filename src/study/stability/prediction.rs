//! What theory says of a method on a scene.

use crate::analysis::critical::{Confidence, CriticalStep, has_limit, outside_filter};
use crate::integrate::registry::MethodChoice;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// The predicted largest stable step at t = 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prediction {
    /// [s] predicted largest stable step; null where there is none or it is not known
    pub step: Option<f64>,
    /// what it is worth
    pub known_by: KnownBy,
    /// [s] steps above are proved to be unstable; null where nothing is proved
    pub at_most: Option<f64>,
    /// node that moves most in the motion that sets it
    pub node: Option<u32>,
    /// fastest spring at that node
    pub spring: Option<u32>,
    /// [rad/s] frequency of that motion
    pub frequency: Option<f64>,
    /// [1/s] damping rate of that motion
    pub damping: Option<f64>,
}

/// How a prediction is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum KnownBy {
    /// proved not to lie above the limit
    Certified,
    /// found by iteration on the linearised step
    Estimate,
    /// the method has no limit on linear scenes, or the scene sets none at t = 0
    Unlimited,
    /// not known: forces outside Kang's filter
    Unknown,
}

impl KnownBy {
    /// As it is written in the table.
    pub fn word(self) -> &'static str {
        match self {
            KnownBy::Certified => "certified",
            KnownBy::Estimate => "estimate",
            KnownBy::Unlimited => "no limit",
            KnownBy::Unknown => "not known",
        }
    }
}

impl Prediction {
    pub(super) fn of(scene: &dyn Scene, method: &MethodChoice, critical: CriticalStep) -> Self {
        let none = |known_by| Prediction {
            step: None,
            known_by,
            at_most: None,
            node: None,
            spring: None,
            frequency: None,
            damping: None,
        };
        if outside_filter(method, scene) {
            return none(KnownBy::Unknown);
        }
        if !has_limit(method) || critical.step.is_infinite() {
            return none(KnownBy::Unlimited);
        }
        let (known_by, at_most) = match critical.confidence {
            Confidence::Certified { at_most } => (KnownBy::Certified, Some(at_most).filter(|s| s.is_finite())),
            Confidence::Estimate | Confidence::NoLimit => (KnownBy::Estimate, None),
        };
        Prediction {
            step: Some(critical.step),
            known_by,
            at_most,
            node: Some(scene.name_of(critical.dof).0),
            spring: scene.fastest_spring(critical.dof),
            frequency: Some(critical.rates.frequency),
            damping: Some(critical.rates.damping),
        }
    }
}
