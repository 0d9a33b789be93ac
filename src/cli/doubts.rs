//! What shows only when the scene is built: a case that does not fit its solver, a step above the critical one, frames for
//! which the disk has no room. `check` and `solve` say the same.

use std::path::Path;

use crate::analysis::critical::{Confidence, CriticalStep, Effort, Spectrum, has_limit, plainly_stable};
use crate::analysis::rates::Rates;
use crate::case::spec::Problem;
use crate::case::{CaseError, Source};
use crate::figures::figures;
use crate::integrate::implicit::{SolverSpec, refusal};
use crate::integrate::registry::Family;
use crate::output::space::{frame_bytes, free_bytes};
use crate::scene::{Scene, place_of};
use crate::solve::{LinearChoice, LinearError};

/// Refuses a solver that cannot solve this scene's equations.
pub(super) fn check_solver(problem: &Problem, scene: &dyn Scene, source: Source) -> Result<(), CaseError> {
    let SolverSpec { newton, linear } = problem.solver;
    let why = match linear {
        // Only networks have a graph.
        LinearChoice::Cg if scene.abilities().graph.is_none() => Some(LinearError::NotByNodes),
        _ => refusal(scene.symmetric(), newton.strategy, linear),
    };
    match why.filter(|_| problem.method.info.family == Family::Implicit) {
        Some(why) => {
            let allowed = "\"lu\" or \"auto\" for this scene";
            Err(source.refuse(&problem.case_json, "/solver/linear", allowed, why.to_string()))
        }
        None => Ok(()),
    }
}

/// The largest stable step of a case's method at the start. Only methods that have a limit pay for it, and on large scenes only
/// those whose step is near it.
pub(super) fn limit_at_start(problem: &Problem, scene: &dyn Scene) -> CriticalStep {
    if !has_limit(&problem.method) {
        return CriticalStep::none();
    }
    let state = scene.initial_state();
    // Adaptive steps find the limit themselves; it is still a figure of the scene.
    let step = problem.time.step.fixed().unwrap_or(0.0);
    let plain = problem.time.step.fixed().and_then(|h| plainly_stable(scene, state.as_ref(), &problem.method, h));
    let effort = Effort { sharpen_below: 2.0 * step, ..Effort::START };
    plain.unwrap_or_else(|| Spectrum::with(scene, state.as_ref(), effort).critical_step(&problem.method))
}

/// What a critical step is worth in a word.
pub(super) fn worth(limit: CriticalStep) -> &'static str {
    match limit.confidence {
        Confidence::Certified { .. } => "certified",
        Confidence::Estimate | Confidence::NoLimit => "an estimate",
    }
}

/// A warning for a step that is too large, with both numbers.
pub(super) fn step_doubt(problem: &Problem, scene: &dyn Scene, limit: CriticalStep) -> Option<String> {
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
        let Rates { frequency, damping, .. } = limit.rates;
        format!(
            "the step of {} s is {} the critical step of {name} on this scene, about {} s at the start \
             ({}; set around {}, where w = {} rad/s, damping rate {} 1/s); expect it to diverge: take --step {} or \
             --method newmark",
            figures(step, 4),
            excess(step / limit.step),
            figures(limit.step, 3),
            worth(limit),
            place_of(scene, limit.dof),
            figures(frequency, 4),
            figures(damping, 4),
            figures(limit.safe(), 2)
        )
    })
}

/// How far a step is above its limit.
fn excess(ratio: f64) -> String {
    if ratio < 1.005 { "just above".to_owned() } else { format!("{} times", figures(ratio, 3)) }
}

/// A warning for frames that will not fit on the disk of `out`.
pub(super) fn disk_doubt(problem: &Problem, scene: &dyn Scene, out: &Path) -> Option<String> {
    let every = problem.output.frames_every;
    let frames = 1.0 + every.map_or(1.0, |every| (problem.time.end / every).ceil());
    let fields = problem.output.fields.as_slice().into();
    let bytes = frame_bytes(scene, fields, problem.output.format.precision) as f64;
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
