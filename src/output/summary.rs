//! `summary.json`: how a run went, for programs and people. Keys are the contract's.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Deserializer, Serialize};

use super::atomic::{Durability, replace};
use super::csv::write_fault;
use crate::drive::observer::{LedgerRow, ObserveError};

/// How a run ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// reached the end
    #[default]
    Completed,
    /// the state exploded or stopped being finite
    Diverged,
    /// an implicit step could not be solved
    NotConverged,
    /// the user stopped it
    Interrupted,
}

/// A finished run. A number that is not finite is written as null, and null is read back as not a number.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// how it ended
    pub status: Status,
    /// name of the method in a case
    pub method: String,
    /// its parameters, defaults filled in
    pub method_parameters: BTreeMap<String, f64>,
    /// accepted steps
    pub steps: u64,
    /// steps that were dropped and tried again smaller
    pub rejected_steps: u64,
    /// [s] time of the last good state
    #[serde(deserialize_with = "null_as_nan")]
    pub t_end: f64,
    /// [s] processor time of the run, all threads; null where the system does not tell
    pub cpu_seconds: Option<f64>,
    /// [s] time on the clock
    #[serde(deserialize_with = "null_as_nan")]
    pub wall_seconds: f64,
    /// [byte] largest resident memory; null where the system does not tell
    pub peak_memory_bytes: Option<u64>,
    /// what the run did, counted
    #[serde(flatten)]
    pub counters: Counters,
    /// free degrees of freedom
    pub unknowns: u64,
    /// entries of W; null for a run without a matrix
    pub matrix_nonzeros: Option<u64>,
    /// entries of its factor; null for a run without one
    pub factor_nonzeros: Option<u64>,
    /// solver that was used; null for a run without one
    pub linear_solver: Option<String>,
    /// [s] largest stable step of the method at the start; null if unlimited or not known
    pub critical_step: Option<f64>,
    /// [-] max abs(numerical) over the largest energy exchanged
    #[serde(deserialize_with = "null_as_nan")]
    pub energy_error: f64,
    /// the energy account at the end
    pub final_ledger: FinalLedger,
    /// what went wrong; null for a run that did not fail
    pub failure: Option<Failure>,
    /// the case as it was run
    pub case: serde_json::Value,
    /// version of the program
    pub version: String,
}

/// What a run did, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counters {
    /// force passes
    pub force_evaluations: u64,
    /// assemblies of W
    pub tangent_assemblies: u64,
    /// numerical factorisations
    pub factorizations: u64,
    /// linear solves
    pub linear_solves: u64,
    /// Newton iterations
    pub newton_iterations: u64,
}

/// The energy account at the end of a run; see [`LedgerRow`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FinalLedger {
    /// [J] kinetic energy
    #[serde(deserialize_with = "null_as_nan")]
    pub kinetic: f64,
    /// [J] energy of the springs
    #[serde(deserialize_with = "null_as_nan")]
    pub elastic: f64,
    /// [J] gravity energy
    #[serde(deserialize_with = "null_as_nan")]
    pub gravity: f64,
    /// [J] work of the air and the loads
    #[serde(deserialize_with = "null_as_nan")]
    pub external_work: f64,
    /// [J] taken by damping
    #[serde(deserialize_with = "null_as_nan")]
    pub dissipated: f64,
    /// [J] the remainder
    #[serde(deserialize_with = "null_as_nan")]
    pub numerical: f64,
}

impl From<LedgerRow> for FinalLedger {
    fn from(row: LedgerRow) -> Self {
        let LedgerRow { kinetic, elastic, gravity, external_work, dissipated, numerical } = row;
        Self { kinetic, elastic, gravity, external_work, dissipated, numerical }
    }
}

/// What went wrong. Nodes and springs are in the user's numbering.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// [s] when the trouble was found
    #[serde(deserialize_with = "null_as_nan")]
    pub time: f64,
    /// step that failed, counted from 1
    pub step: u64,
    /// worst node, if one can be named
    pub node: Option<u64>,
    /// worst spring, if one can be named
    pub spring: Option<u64>,
    /// force term at fault, if one can be named
    pub term: Option<String>,
    /// what happened
    pub cause: String,
    /// what to try
    pub advice: String,
    /// [s] when a value stopped being finite or left 1e4 times the scene's size, if the run was let go on
    pub blow_up_time: Option<f64>,
}

impl Summary {
    /// The summary as JSON text that ends with a line's end.
    ///
    /// # Errors
    /// When `case` cannot be written as JSON.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        // serde_json writes a float that is not finite as null.
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// Writes `path` atomically and makes it durable.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), ObserveError> {
        let text = self.to_json().map_err(|e| write_fault(path, e.into()))?;
        replace(path, text.as_bytes(), Durability::Synced).map_err(|e| write_fault(path, e))
    }
}

fn null_as_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(deserializer)?.unwrap_or(f64::NAN))
}
