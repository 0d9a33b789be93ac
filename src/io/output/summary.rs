//! `summary.json`: the summary of a run, for programs and people.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::at_rest::LargestValue;
use super::atomic::{Durability, replace};
use super::crossings::CrossingReport;
use super::csv::write_fault;
use super::gauges::{MeasuredQuantity, Peak};
use super::quantity::QuantityReports;
use super::stages::StageReport;
use crate::analysis::growing::GrowingMotion;
use crate::case::spec::Problem;
use crate::drive::event::{Fired, Landing};
use crate::drive::lost_payload::LostPayload;
use crate::drive::observer::{Energies, ObserveError};
use crate::drive::{Failure, Outcome, Status};
use crate::integrate::Counters;
use crate::model::added_mass::AddedMass;
use crate::model::group_totals::GroupTotals;
use crate::model::system::System;
use crate::process::{self, Cost};
use crate::solve::{LinearChoice, LinearStats, Prediction};
use crate::startup::Startup;
use crate::statics::{Finding, Stability};

/// Why a linear solver was used.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LinearReport {
    /// `cholesky`, `lu` or `cg`
    pub solver: String,
    /// the reason for the choice, in a sentence
    pub reason: String,
    /// counted work of a solve with each solver, for the last matrix; null if there was no choice
    pub predicted: Option<Prediction>,
}

impl LinearReport {
    fn new(linear: &LinearStats, choice: LinearChoice) -> Self {
        LinearReport { solver: linear.name.to_owned(), reason: reason(linear, choice), predicted: linear.prediction }
    }
}

fn reason(linear: &LinearStats, choice: LinearChoice) -> String {
    let asked = match choice {
        LinearChoice::Auto => None,
        LinearChoice::Cholesky => Some("cholesky"),
        LinearChoice::Lu => Some("lu"),
        LinearChoice::Cg => Some("cg"),
    };
    if asked == Some(linear.name) {
        return "the case asks for it".to_owned();
    }
    match (linear.prediction, linear.name) {
        (Some(Prediction { cg_iterations, cholesky_work, cg_work, .. }), "cg") => format!(
            "by counted work: {cg_iterations} iterations a solve, {:.0} % of what Cholesky would cost",
            100.0 * cg_work / cholesky_work
        ),
        (Some(Prediction { far_apart: true, .. }), _) => {
            "parts of the scene are too stiff beside the rest for conjugate gradients".to_owned()
        }
        // No iteration was allowed: to start a solve and make one already costs more.
        (Some(Prediction { cg_iterations: 0, cg_converged: false, .. }), _) => {
            "by counted work: it costs less than conjugate gradients that make one iteration".to_owned()
        }
        (Some(Prediction { cg_iterations, cg_converged: false, .. }), _) => {
            format!("by counted work: conjugate gradients need more than {cg_iterations} iterations a solve")
        }
        (_, "lu") => "the tangent is not symmetric, and used as it is".to_owned(),
        _ => "the tangent is symmetric, and made anew in every iteration".to_owned(),
    }
}

/// An equilibrium, in the summary of `canopy-fem static`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EquilibriumReport {
    /// [N] Euclidean norm of the sums of forces that are left on free degrees of freedom
    pub residual: f64,
    /// [N] what it is compared with: the largest norm of loads, internal forces, reactions and tensions at the nodes
    pub residual_scale: f64,
    /// [J] elastic energy and that of weight; null where other loads act, which have no potential in the account
    pub potential_energy: Option<f64>,
    /// levels of the loads that were solved
    pub load_steps: u32,
    /// what small disturbances do; null where it was not judged, as with a tangent that is not symmetric
    pub stability: Option<Stability>,
    /// parts that no force keeps in place, and motions that grow
    pub findings: Vec<Finding>,
    /// largest displacement, tension, stress and reaction, and the smallest safety factor, as far as there are such
    #[serde(default)]
    pub largest: Vec<LargestValue>,
    /// [N] sum of the reactions of all supports; 0 where there is no equilibrium
    #[serde(default)]
    pub reaction_sum: [f64; 3],
    /// [-] edges whose springs carry nothing
    #[serde(default)]
    pub slack_springs: usize,
    /// [Hz] of the vibration modes that were asked for, ascending; 0 for a motion that grows
    pub frequencies: Vec<f64>,
    /// whether the tangent K is symmetric there; if not, the modes are those of its symmetric part. Null without modes
    #[serde(default)]
    pub modes_symmetric: Option<bool>,
    /// motions that grow by themselves, the fastest first: modes without damping; with a K that is not symmetric, what
    /// these modes make together with all of K and damping
    #[serde(default)]
    pub growing: Vec<GrowingMotion>,
}

/// An event of a run, in its summary.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EventReport {
    /// [s] when
    pub time: f64,
    /// its name
    pub name: String,
    /// what happened: `release`, `cut`, `stage 1`, `a spring breaks`, `landing`
    pub what: String,
    /// [m] where the payload, or what the event looks at, was
    pub place: [f64; 3],
    /// [m/s] its velocity
    pub velocity: [f64; 3],
    /// [m/s] its speed against the air
    pub air_speed: f64,
}

impl EventReport {
    fn all(fired: &[Fired]) -> Vec<Self> {
        let report = |fired: &Fired| EventReport {
            time: fired.t,
            name: fired.name.clone(),
            what: fired.what.clone(),
            place: fired.place,
            velocity: fired.velocity,
            air_speed: fired.air_speed,
        };
        fired.iter().map(report).collect()
    }
}

/// A finished run.
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
    /// [s] time of the last accepted state
    pub t_end: f64,
    /// [s] processor time of the run with its start, all threads and all parts: of the whole process, where it makes
    /// one run; null if the system does not report it
    pub cpu_seconds: Option<f64>,
    /// [s] time on the clock, with its start, all parts
    pub wall_seconds: f64,
    /// [byte] largest resident memory; null if the system does not report it
    pub peak_memory_bytes: Option<u64>,
    /// [s] time before the first step, by phases, of this part of the run; it is in `cpu_seconds` and `wall_seconds`
    #[serde(default)]
    pub startup: Startup,
    /// counted work of the run
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
    /// why it was used; null for a run without one
    pub linear: Option<LinearReport>,
    /// [s] largest stable step of the method at the start; null if unlimited or not known
    pub critical_step: Option<f64>,
    /// [-] max abs(numerical) over the largest energy exchanged; where rounding explains it, over the energies that
    /// were rounded
    pub energy_error: f64,
    /// the energy account at the end
    pub final_ledger: Energies,
    /// what mass scaling has added; not given without mass scaling
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_scaling: Option<AddedMass>,
    /// largest values of the gauges; not given without gauges
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub peaks: Vec<Peak>,
    /// what the gauges reached in each stage; not given without canopies and events
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stages: Vec<StageReport>,
    /// the numbers of the report and those that are asked for, by name; not given for an equilibrium
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub quantities: QuantityReports,
    /// cloth that passes through cloth; not given where it is not searched for
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crossings: Option<CrossingReport>,
    /// named parts of the mesh, by name; not given without groups
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub groups: BTreeMap<String, GroupTotals>,
    /// what happened, in the order of time; not given without events
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<EventReport>,
    /// names of events that did not happen; not given without such
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub never_fired: Vec<String>,
    /// the landing; not given unless the case has `time.until` and the ground was reached
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub landing: Option<Landing>,
    /// the break after which the payload hung on no canopy any more; not given where it still does
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub payload_lost: Option<LostPayload>,
    /// whether the run ended because its scene was at rest; not given unless the case has `time.until_rest`
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_rest: Option<bool>,
    /// the equilibrium that was found; not given for a run in time
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub equilibrium: Option<EquilibriumReport>,
    /// what went wrong; null for a run that did not fail
    pub failure: Option<Failure>,
    /// groups that its `node`, `spring` and `triangle` belong to, at most two each, the smallest first; not given
    /// without any
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub failure_groups: BTreeMap<String, Vec<String>>,
    /// [s] time of the checkpoint the run was last resumed from; null for a run in one piece
    pub resumed_from: Option<f64>,
    /// the case as it was run
    pub case: serde_json::Value,
    /// checksum of the resolved case, including the files that it names: equal for two folders with the same run
    #[serde(default)]
    pub case_digest: String,
    /// version of the program
    pub version: String,
}

impl Summary {
    /// The summary of a finished run. `critical_step` [s] is infinite for a method without limit.
    pub fn new(problem: &Problem, system: &dyn System, outcome: &Outcome, critical_step: f64, cost: Cost) -> Self {
        let linear = outcome.linear;
        Summary {
            status: outcome.status,
            method: problem.method.info.name.to_owned(),
            method_parameters: problem.method.parameters().map(|(name, value)| (name.to_owned(), value)).collect(),
            steps: outcome.steps,
            rejected_steps: outcome.rejected_steps,
            t_end: outcome.t_end,
            cpu_seconds: cost.cpu,
            wall_seconds: cost.wall.as_secs_f64(),
            peak_memory_bytes: process::peak_memory_bytes(),
            startup: Startup::default(),
            counters: outcome.counters,
            unknowns: system.inverse_mass().iter().filter(|m| **m > 0.0).count() as u64,
            matrix_nonzeros: linear.map(|l| l.matrix_nonzeros as u64),
            factor_nonzeros: linear.and_then(|l| l.factor_nonzeros).map(|n| n as u64),
            linear_solver: linear.map(|l| l.name.to_owned()),
            linear: linear.map(|l| LinearReport::new(&l, problem.solver.linear)),
            critical_step: Some(critical_step).filter(|s| s.is_finite()),
            energy_error: outcome.energy_error,
            final_ledger: outcome.ledger,
            mass_scaling: None,
            peaks: Vec::new(),
            stages: Vec::new(),
            quantities: QuantityReports::new(),
            crossings: None,
            groups: BTreeMap::new(),
            events: EventReport::all(&outcome.fired),
            never_fired: outcome.unmet.clone(),
            landing: outcome.fired.iter().find_map(|fired| fired.landing),
            payload_lost: None,
            at_rest: problem.time.until_rest.map(|_| outcome.ended_early && !outcome.landed()),
            equilibrium: None,
            failure: outcome.failure.clone(),
            failure_groups: BTreeMap::new(),
            resumed_from: None,
            case: problem.case_json.clone(),
            case_digest: String::new(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }

    /// The same with what was measured on the way.
    #[must_use]
    pub fn with_quantities(self, measured: &[MeasuredQuantity]) -> Self {
        Summary { quantities: MeasuredQuantity::reports(measured), ..self }
    }

    /// Reads a summary; `None` if there is none or it cannot be read.
    pub fn read(path: &Path) -> Option<Self> {
        serde_json::from_slice(&crate::input_file::read(path).ok()?).ok()
    }

    /// The summary as JSON text that ends with a line break.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Conjugate gradients that may make no iteration have not shown how many they need.
    #[test]
    fn what_was_not_tried_is_not_told() {
        for (cg_iterations, far_apart, expected) in [
            (0, false, "one iteration"),
            (7, false, "more than 7 iterations a solve"),
            (7, true, "too stiff beside the rest"),
        ] {
            let prediction = Some(Prediction {
                cholesky_work: 1.0,
                cg_work: 2.0,
                cg_iterations,
                cg_converged: false,
                far_apart,
                factor_nonzeros: 9.0,
                factor_operations: 9.0,
            });
            let stats = LinearStats {
                name: "cholesky",
                matrix_nonzeros: 9,
                factor_nonzeros: None,
                factor_operations: None,
                indefinite: 0,
                prediction,
            };
            let text = reason(&stats, LinearChoice::Auto);
            assert!(text.contains(expected) && !text.contains(" 0 "), "{text}");
        }
    }
}
