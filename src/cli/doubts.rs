//! What shows only when the scene is built: a case that does not fit its solver, a step above the critical one, frames for
//! which the disk has no room. `check` and `solve` say the same.

use std::path::Path;

use crate::analysis::critical::{Confidence, CriticalStep, Effort, Spectrum, has_limit, plainly_stable, remedy};
use crate::analysis::rates::Rates;
use crate::case::spec::Problem;
use crate::case::{CaseError, Source};
use crate::figures::figures;
use crate::integrate::implicit::{SolverSpec, refusal};
use crate::integrate::registry::Family;
use crate::model::state::{State, StateRef};
use crate::model::stop::Stop;
use crate::output::space::{frame_bytes, free_bytes};
use crate::scene::{Scene, place_of};
use crate::solve::{LinearChoice, LinearError};

/// [-] strain that rounding of coordinates makes
const ROUNDING: f64 = 1e-9;

/// Refuses a solver that cannot solve this scene's equations.
pub(super) fn check_solver(problem: &Problem, scene: &dyn Scene, source: Source) -> Result<(), CaseError> {
    let SolverSpec { newton, .. } = problem.solver;
    let why = unfit(scene, problem.solver);
    match why.filter(|_| problem.method.info.family == Family::Implicit) {
        Some(why) => {
            let all = [LinearChoice::Auto, LinearChoice::Cholesky, LinearChoice::Lu, LinearChoice::Cg];
            let fit = |linear: &LinearChoice| unfit(scene, SolverSpec { newton, linear: *linear }).is_none();
            let allowed: Vec<String> = all.iter().filter(|l| fit(l)).flat_map(serde_json::to_string).collect();
            let allowed = format!("{} for this scene and strategy", allowed.join(", "));
            Err(source.refuse(&problem.case_json, "/solver/linear", &allowed, why.to_string()))
        }
        None => Ok(()),
    }
}

fn unfit(scene: &dyn Scene, SolverSpec { newton, linear }: SolverSpec) -> Option<LinearError> {
    match linear {
        // Only networks have a graph.
        LinearChoice::Cg | LinearChoice::Cholesky if scene.abilities().graph.is_none() => Some(LinearError::NotByNodes),
        _ => refusal(scene.symmetric(), newton.strategy, linear),
    }
}

/// The largest stable step of a case's method at the start. Only methods that have a limit pay for it, and on large scenes only
/// those whose step is near it.
pub(super) fn limit_at_start(problem: &Problem, scene: &dyn Scene, stop: Stop<'_>) -> CriticalStep {
    limit_at(problem, scene, scene.initial_state().as_ref(), stop)
}

fn limit_at(problem: &Problem, scene: &dyn Scene, at: StateRef<'_>, stop: Stop<'_>) -> CriticalStep {
    if !has_limit(&problem.method) {
        return CriticalStep::none();
    }
    // Adaptive steps find the limit themselves; it is still a figure of the scene.
    let step = problem.time.step.fixed().unwrap_or(0.0);
    let plain = problem.time.step.fixed().and_then(|h| plainly_stable(scene, at, &problem.method, h));
    let effort = Effort { sharpen_below: 2.0 * step, stop, ..Effort::START };
    plain.unwrap_or_else(|| {
        let found = Spectrum::with(scene, at, effort).critical_step(&problem.method);
        // What a search that was cut short has found is no limit.
        if stop.asked() { CriticalStep::none() } else { found }
    })
}

/// A warning where springs that are slack at the start hide a limit below the step, or all of them are slack, so that the limit
/// at the start is not of the springs at all.
pub(super) fn slack_doubt(problem: &Problem, scene: &dyn Scene, limit: CriticalStep, stop: Stop<'_>) -> Option<String> {
    if stop.asked() || !has_limit(&problem.method) {
        return None;
    }
    let step = problem.time.step.fixed()?.min(problem.time.end);
    let start = scene.initial_state();
    let slack = slack(scene, start.as_ref())?;
    // Drawn out as a whole until the slackest spring is taut: the others carry some tension then, which stiffens them a little across.
    let longer = |x: &f64| x * slack.stretch;
    let taut = State { x: start.x.iter().map(longer).collect(), ..start.clone() };
    let taut = limit_at(problem, scene, taut.as_ref(), stop).step;
    let name = problem.method.info.name;
    let hidden = taut < limit.step && (step > taut || slack.count == slack.of);
    hidden.then(|| {
        format!(
            "{} springs are slack at the start, so the critical step of {name} there, {} s, holds only until they go taut; with all of them \
             taut it is about {} s, and the step is {} s",
            if slack.count == slack.of { format!("all {}", slack.of) } else { format!("{} of {}", slack.count, slack.of) },
            figures(limit.step, 3),
            figures(taut, 3),
            figures(step, 4)
        )
    })
}

/// Springs that are shorter than at rest and do not push back.
struct Slack {
    count: usize,
    of: usize,
    /// [-] what the slackest must be lengthened by to be taut
    stretch: f64,
}

/// `None` where none is slack.
fn slack(scene: &dyn Scene, at: StateRef<'_>) -> Option<Slack> {
    let n = scene.edges().len();
    let (mut tension, mut strain) = (vec![0.0; n], vec![0.0; n]);
    scene.edge_tension(at, &mut tension, &mut strain);
    // An edge without a spring has no tension, not even 0.
    let of = tension.iter().filter(|tension| !tension.is_nan()).count();
    let strains = tension.iter().zip(&strain).filter(|(tension, strain)| **tension == 0.0 && **strain < -ROUNDING);
    let (count, least) = strains.fold((0, 0.0_f64), |(n, least), (_, strain)| (n + 1, least.min(*strain)));
    (count > 0 && least > -1.0).then(|| Slack { count, of, stretch: (1.0 + ROUNDING) / (1.0 + least) })
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
             step; {}",
            remedy(&limit, step)
        ));
    }
    (step > limit.step).then(|| {
        let Rates { frequency, damping, .. } = limit.rates;
        format!(
            "the step of {} s is {} the critical step of {name} on this scene, about {} s at the start \
             ({}; set around {}, where w = {} rad/s, damping rate {} 1/s); expect it to diverge: {}",
            figures(step, 4),
            excess(step / limit.step),
            figures(limit.step, 3),
            worth(limit),
            place_of(scene, limit.dof),
            figures(frequency, 4),
            figures(damping, 4),
            remedy(&limit, step)
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
