//! What `check --json` prints: the same as the text, for programs.

use serde_json::{Value, json};
use std::collections::BTreeMap;

use super::CliError;
use super::check_contact::ContactLimit;
use crate::analysis::critical::Confidence;
use crate::analysis::later::LaterLimit;
use crate::analysis::taut::WhileSlack;
use crate::case::Case;
use crate::case::spec::Problem;
use crate::drive::observer::ObserveError;
use crate::mesh::canopy::CanopySizes;
use crate::model::group_totals::GroupTotals;
use crate::scene::{Scene, place_of};
use crate::study::forecast::{Candidate, Forecast};
use crate::study::recommendations::ModelAnswer;

/// What `check --expand` prints: a case that runs by itself.
pub(super) fn expanded(case: &Case) -> Result<String, CliError> {
    let text = case.expanded().and_then(|json| serde_json::to_string_pretty(&json)).map_err(unwritten)?;
    Ok(text + "\n")
}

fn unwritten(error: serde_json::Error) -> ObserveError {
    ObserveError::Write { path: "standard output".to_owned(), source: error.into() }
}

/// Everything that `check` finds.
pub(super) struct Report<'a> {
    pub problem: &'a Problem,
    pub scene: &'a dyn Scene,
    pub candidates: &'a [Candidate],
    /// whether the case's step is stable, in a word
    pub stable: &'static str,
    /// the critical step after an event, if it is smaller
    pub later: Option<LaterLimit>,
    /// of the case's method, as long as springs that are slack at the start stay so
    pub while_slack: Option<WhileSlack>,
    /// what may touch what
    pub contacts: Vec<Value>,
    /// which contact allows explicit methods the shortest step
    pub contact_limit: Option<ContactLimit>,
    pub forecast: Forecast,
    pub totals: Totals,
    /// of the mesh, by name
    pub groups: BTreeMap<String, GroupTotals>,
    /// what a study has measured of them
    pub models: Vec<ModelAnswer>,
    pub warnings: Vec<String>,
    pub acknowledged: Vec<String>,
}

/// What the scene has in all.
pub(super) struct Totals {
    /// [kg] mass
    pub mass: f64,
    /// sizes of the canopies among the groups, by the names of their triangles' groups
    pub canopies: BTreeMap<String, CanopySizes>,
}

impl Report<'_> {
    /// JSON text that ends with a line break.
    pub(super) fn to_json(&self) -> Result<String, CliError> {
        let Report { problem, scene, candidates, contacts, contact_limit, forecast, totals, groups, models, .. } = self;
        let Report { warnings, acknowledged, .. } = self;
        let tolerance = problem.time.step.tolerance();
        let unknowns = scene.inverse_mass().iter().filter(|m| **m > 0.0).count();
        let mut report = json!({
            "name": problem.name,
            "method": problem.method.info.name,
            "step": problem.time.step.fixed(),
            "tolerance": tolerance,
            "end": problem.time.end,
            "unknowns": unknowns,
            "nodes": scene.reference().len(),
            "mass": totals.mass,
            "mass_scaling": scene.added_mass(),
            "canopies": totals.canopies,
            "groups": groups,
            "symmetric": scene.symmetric(),
            "critical_steps": candidates.iter().map(|c| limit(c, *scene)).collect::<Vec<_>>(),
            "stable": self.stable,
            "while_slack": self.while_slack.map(|slack| json!({
                "slack": slack.count,
                "springs": slack.of,
                "critical_step": Some(slack.limit.step).filter(|step| step.is_finite()),
            })),
            "later_critical_step": self.later.map(|LaterLimit { t, limit }| json!({
                "from": t, "critical_step": limit.step, "set_by": place_of(*scene, limit.dof)
            })),
            "contacts": contacts,
            "contact_limit": contact_limit,
            "models": models,
            "taken": problem.taken,
            "warnings": warnings,
            "acknowledged": acknowledged,
            "version": env!("CARGO_PKG_VERSION"),
        });
        let costs = serde_json::to_value(forecast).map_err(unwritten)?;
        if let (Value::Object(report), Value::Object(costs)) = (&mut report, costs) {
            report.extend(costs);
        }
        Ok(serde_json::to_string_pretty(&report).map_err(unwritten)? + "\n")
    }
}

fn limit(candidate: &Candidate, scene: &dyn Scene) -> Value {
    let Some(limit) = candidate.limit else {
        return json!({"method": candidate.method.info.name, "critical_step": null, "known_by": null});
    };
    let known_by = match limit.confidence {
        Confidence::Certified { .. } => "certified",
        Confidence::Estimate => "estimate",
        Confidence::NoLimit if candidate.method.info.linear.linear_only => "no limit on linear scenes",
        Confidence::NoLimit => "no limit",
    };
    let finite = limit.step.is_finite();
    json!({
        "method": candidate.method.info.name,
        "critical_step": finite.then_some(limit.step),
        "known_by": known_by,
        "set_by": (finite && limit.step > 0.0).then(|| place_of(scene, limit.dof)),
    })
}
