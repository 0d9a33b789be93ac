//! What shows only when the scene is built: a case that does not fit its solver, a step above the critical one, frames for
//! which the disk has no room. `check` and `solve` say the same.

use std::path::Path;

use super::fields;
use crate::analysis::limit::critical_step;
use crate::analysis::rates::{Rates, rates};
use crate::case::spec::Problem;
use crate::case::{CaseError, Source};
use crate::figures::figures;
use crate::integrate::registry::Family;
use crate::output::space::{frame_bytes, free_bytes};
use crate::scene::Scene;
use crate::solve::{LinearChoice, LinearError};

/// Refuses a solver that cannot solve this scene's equations.
pub(super) fn check_solver(problem: &Problem, scene: &dyn Scene, source: Source) -> Result<(), CaseError> {
    let implicit = problem.method.info.family == Family::Implicit;
    if implicit && problem.solver.linear == LinearChoice::Cholesky && !scene.symmetric() {
        let why = LinearError::NotSymmetric.to_string();
        return Err(source.refuse(&problem.case_json, "/solver/linear", "\"lu\" or \"auto\" for this scene", why));
    }
    Ok(())
}

/// The largest stable step of a case's method and what sets it, at the start.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limit {
    /// [s] the step; infinite for a method without limit
    pub step: f64,
    /// what it was found from; of a method without limit not asked for
    pub rates: Rates,
}

impl Limit {
    /// Costs a few hundred tangents, so only methods that have a limit pay for it.
    pub fn of(problem: &Problem, scene: &dyn Scene) -> Self {
        // A method without limit has none on any oscillator.
        let some = Rates { frequency: 1.0, ..Rates::default() };
        if critical_step(&problem.method, some).is_infinite() {
            return Limit { step: f64::INFINITY, rates: Rates::default() };
        }
        let rates = rates(scene, scene.initial_state().as_ref());
        Limit { step: critical_step(&problem.method, rates), rates }
    }
}

/// A warning for a step that is too large, with both numbers.
pub(super) fn step_doubt(problem: &Problem, scene: &dyn Scene, limit: Limit) -> Option<String> {
    let name = problem.method.info.name;
    // Adaptive steps find the limit themselves.
    let step = problem.time.step.fixed()?.min(problem.time.end);
    if limit.step == 0.0 {
        return Some(format!(
            "{name} has no stable step on this scene, where nothing damps the fastest motion: its energy grows at every \
             step; take another method, such as velocity-verlet"
        ));
    }
    (step > limit.step).then(|| {
        let node = scene.name_of(limit.rates.frequency_dof).0;
        let Rates { frequency, damping, .. } = limit.rates;
        format!(
            "the step of {} s is {} times the critical step of {name} on this scene, about {} s at the start \
             (fastest motion {} rad/s around node {node}, damping rate {} 1/s); expect it to diverge: take --step {} or \
             --method newmark",
            figures(step, 4),
            figures(step / limit.step, 3),
            figures(limit.step, 3),
            figures(frequency, 4),
            figures(damping, 4),
            // The estimate lies up to a few percent above the true limit.
            figures(0.9 * limit.step, 2)
        )
    })
}

/// A warning for frames that will not fit on the disk of `out`.
pub(super) fn disk_doubt(problem: &Problem, scene: &dyn Scene, out: &Path) -> Option<String> {
    let every = problem.output.frames_every;
    let frames = 1.0 + every.map_or(1.0, |every| (problem.time.end / every).ceil());
    let bytes = frame_bytes(scene, fields(&problem.output.fields)) as f64;
    let free = free_bytes(out)? as f64;
    (frames * bytes > free).then(|| {
        format!(
            "the frames need about {} ({} of {} each), but only {} are free where {} is; raise output.frames.every",
            size(frames * bytes),
            figures(frames, 6),
            size(bytes),
            size(free),
            out.display()
        )
    })
}

/// A number of bytes in the unit that suits it.
fn size(bytes: f64) -> String {
    let units = [(1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")];
    let unit = units.into_iter().find(|(unit, _)| bytes >= *unit).unwrap_or((1.0, "bytes"));
    format!("{} {}", figures(bytes / unit.0, 3), unit.1)
}
