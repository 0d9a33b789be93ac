//! What is wrong with a case, or doubtful about a run, and shows only on the built scene or at the end.

use crate::analysis::contact::contact_warning;
use crate::analysis::critical::CriticalStep;
use crate::analysis::warnings::{Planned, mass_warning, step_warning};
use crate::case::spec::Problem;
use crate::case::{CaseError, Source};
use crate::drive::observer::Energies;
use crate::drive::{Outcome, Status};
use crate::format_number::figures;
use crate::integrate::implicit::{SolverSpec, refusal};
use crate::integrate::registry::Family;
use crate::output::canopy_doubts::canopy_doubts;
use crate::output::crossings::CrossingReport;
use crate::output::space::{frame_bytes, free_bytes};
use crate::output::summary::Summary;
use crate::scene::Scene;
use crate::solve::{LinearChoice, LinearError};
use crate::warning::{Warning, WarningCode};
use std::path::Path;

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

/// Warnings about a case on its built scene, also those that it acknowledges: a step above the critical one or above
/// what contact allows, much added mass, frames that do not fit on the disk of `out`, if there are files. `limit` is
/// the critical step at the start, with all springs taut.
pub fn doubts_at_start(
    planned: Planned<'_>,
    problem: &Problem,
    limit: CriticalStep,
    out: Option<&Path>,
) -> Vec<Warning> {
    let Planned { scene, .. } = planned;
    let disk = out.and_then(|out| disk_warning(problem, scene, out));
    let found = [mass_warning(scene), step_warning(planned, limit), contact_warning(planned), disk];
    found.into_iter().flatten().collect()
}

/// Warning for frames that will not fit on the disk of `out`.
fn disk_warning(problem: &Problem, scene: &dyn Scene, out: &Path) -> Option<Warning> {
    let every = problem.output.frames_every;
    let frames = 1.0 + every.map_or(1.0, |every| (problem.time.end / every).ceil());
    let fields = (&problem.output).into();
    let bytes = frame_bytes(scene, fields, problem.output.format.precision) as f64;
    let free = free_bytes(out)? as f64;
    (frames * bytes > free).then(|| {
        let text = format!(
            "the frames need about {} ({} of {} each), but only {} are free where {} is; raise output.frames.every",
            size(frames * bytes),
            figures(frames, 6),
            size(bytes),
            size(free),
            out.display()
        );
        Warning::new(WarningCode::DiskSpace, text)
    })
}

/// A number of bytes in the unit that suits it.
fn size(bytes: f64) -> String {
    let units = [(1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")];
    let unit = units.into_iter().find(|(unit, _)| bytes >= *unit).unwrap_or((1.0, "bytes"));
    format!("{} {}", figures(bytes / unit.0, 3), unit.1)
}

/// Warnings about a finished run that its case does not acknowledge; `strained` is the most strained part of cloth.
pub fn doubts_at_end(
    problem: &Problem,
    outcome: &Outcome,
    summary: &Summary,
    strained: Option<String>,
) -> Vec<Warning> {
    let strained = strained.filter(|_| outcome.failure.is_none()).map(strained_cloth);
    let crossings = summary.crossings.as_ref().and_then(CrossingReport::warning);
    let found = [energy_made(outcome), energy_dissipated(problem, outcome), strained, crossings];
    problem.sort_out(found.into_iter().flatten().chain(canopy_doubts(&summary.peaks, outcome.t_end))).1
}

/// Warning for strains that no cloth bears.
fn strained_cloth(strained: String) -> Warning {
    let check = "check pressures, and stiffness, modulus and thickness of the cloth";
    let text = format!("{strained}; cloth tears at about half of that: {check}");
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
fn dissipated_share(at: &Energies) -> f64 {
    at.dissipated / (at.dissipated + at.kinetic + at.elastic)
}
