//! What is wrong with a case, or doubtful about a run, and shows only on the built scene or at the end.

use crate::analysis::cloth::StrainedCloth;
use crate::case::spec::Problem;
use crate::case::{CaseError, Source};
use crate::drive::observer::LedgerRow;
use crate::drive::{Outcome, Status};
use crate::format_number::figures;
use crate::integrate::implicit::{SolverSpec, refusal};
use crate::integrate::registry::Family;
use crate::output::canopy_doubts::canopy_doubts;
use crate::output::crossings::CrossingReport;
use crate::output::summary::Summary;
use crate::scene::Scene;
use crate::solve::{LinearChoice, LinearError};
use crate::warning::{Warning, WarningCode};

/// [-] Share of the energy above which dissipation by a braked body leads to a warning: less than half of the speed is
/// left.
const LOST: f64 = 0.8;

/// Refuses a solver that cannot solve this scene's equations.
///
/// # Errors
/// A fault at `/solver/linear` with the choices that fit.
pub fn check_solver(problem: &Problem, scene: &dyn Scene, source: &Source) -> Result<(), CaseError> {
    let SolverSpec { newton, .. } = problem.solver;
    let why = unsuitable_solver(scene, problem.solver);
    match why.filter(|_| problem.method.info.family == Family::Implicit) {
        Some(why) => {
            let all = [LinearChoice::Auto, LinearChoice::Cholesky, LinearChoice::Lu, LinearChoice::Cg];
            let fit =
                |linear: &LinearChoice| unsuitable_solver(scene, SolverSpec { newton, linear: *linear }).is_none();
            let allowed: Vec<String> = all.iter().filter(|l| fit(l)).flat_map(serde_json::to_string).collect();
            let allowed = format!("{} for this scene and strategy", allowed.join(", "));
            Err(source.clone().refuse(&problem.case_json, "/solver/linear", &allowed, why.to_string()))
        }
        None => Ok(()),
    }
}

fn unsuitable_solver(scene: &dyn Scene, SolverSpec { newton, linear }: SolverSpec) -> Option<LinearError> {
    match linear {
        // Only networks have a spring graph.
        LinearChoice::Cg | LinearChoice::Cholesky if scene.interfaces().graph.is_none() => {
            Some(LinearError::NotByNodes)
        }
        _ => refusal(scene.symmetric(), newton.strategy, linear),
    }
}

/// Warnings about a finished run that its case does not acknowledge; `strained` is the most strained part of cloth.
pub fn doubts_at_end(
    problem: &Problem,
    outcome: &Outcome,
    summary: &Summary,
    strained: Option<StrainedCloth>,
) -> Vec<Warning> {
    let strained = strained.filter(|_| outcome.failure.is_none()).map(strained_cloth);
    let crossings = summary.crossings.as_ref().and_then(CrossingReport::warning);
    let found = [energy_made(outcome), energy_dissipated(problem, outcome), strained, crossings];
    problem.sort_out(found.into_iter().flatten().chain(canopy_doubts(&summary.peaks, outcome.t_end))).1
}

/// Warning for strains that no cloth bears.
fn strained_cloth(strained: StrainedCloth) -> Warning {
    let text = format!(
        "{}; cloth tears at about half of that: check pressures, and stiffness, modulus and thickness of the cloth",
        strained.text()
    );
    Warning::new(WarningCode::StrainedCloth, text)
}

/// Warning for a completed run whose scheme made much energy itself.
fn energy_made(outcome: &Outcome) -> Option<Warning> {
    let made = outcome.energy_doubt().filter(|_| outcome.status == Status::Completed)?;
    Some(Warning::new(WarningCode::EnergyMade, format!("{made}; do not trust this run")))
}

/// Warning for a run in which damping that brakes the rotation of a free body took nearly all energy.
fn energy_dissipated(problem: &Problem, outcome: &Outcome) -> Option<Warning> {
    let mut found = problem.warnings.iter().chain(&problem.acknowledged);
    let lost = found.any(|w| w.code == WarningCode::BrakedRotation).then(|| dissipated_share(&outcome.ledger))?;
    (lost > LOST).then(|| {
        let text = format!(
            "damping has taken {} % of the kinetic and elastic energy, and it brakes the rotation of a body without supports: the motion that is left may be an effect of the damping; take \"axial\" dashpots",
            figures(100.0 * lost, 3)
        );
        Warning::new(WarningCode::EnergyDissipated, text)
    })
}

/// [-] Dissipated energy over the kinetic and elastic energy that there would be without dissipation.
fn dissipated_share(at: &LedgerRow) -> f64 {
    at.dissipated / (at.dissipated + at.kinetic + at.elastic)
}
