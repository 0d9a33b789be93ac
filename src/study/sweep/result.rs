//! What came of a run of a sweep.

use serde::{Deserialize, Serialize};

use crate::integrate::Counters;
use crate::model::added_mass::AddedMass;
use crate::output::gauges::Peak;
use crate::output::quantity::QuantityReports;
use crate::row::RowStatus;

/// What came of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SweepResult {
    /// how it ended
    pub status: RowStatus,
    /// why, and what to do, if not well
    pub note: String,
    /// [m] largest displacement of a node at the end
    pub displacement_end: Option<f64>,
    /// [m/s] largest speed of a node
    pub max_speed: Option<f64>,
    /// [-] largest strain of a spring
    pub max_strain: Option<f64>,
    /// [-] largest numerical energy over the largest energy exchanged
    pub energy_error: Option<f64>,
    /// [s] processor time
    pub cpu_seconds: Option<f64>,
    /// accepted steps
    pub steps: u64,
    /// attempts of adaptive steps that were dropped
    pub rejected_steps: u64,
    /// [s] time it came to
    pub t_end: f64,
    /// counted work
    #[serde(flatten)]
    pub counters: Counters,
    /// largest values of the gauges
    pub peaks: Vec<Peak>,
    /// quantities that are asked for, by name
    #[serde(default, skip_serializing_if = "QuantityReports::is_empty")]
    pub quantities: QuantityReports,
    /// what mass scaling has added
    #[serde(default)]
    pub mass_scaling: Option<AddedMass>,
}
